#pragma once
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "axode/model/description.hpp"
#include "axode/model/loops.hpp"
#include "axode/model/springs.hpp"
#include "axode/model/tree.hpp"

namespace axode {

/// A moving body, or the ground, which has the index 0. Its body frame is the one that the description chose.
struct Body {
  std::string name;
  int predecessor = 0;
  SE3<> A;                 ///< reference pose in the inertial frame, C_i(0)
  SE3<> B;                 ///< reference pose in the predecessor's frame
  SE3<> S_prev, S_self;    ///< joint frame on the predecessor and on the body, B = S_prev S_self⁻¹
  std::vector<Screw<>> X;  ///< joint screws in the body frame, one per degree of freedom; Y_i = Ad_A X_i
  Inertia<> M;             ///< inertia in the body frame; includes all bodies that are fixed to it
};

/// The joint that connects a body to its predecessor. Joint i moves body i.
struct Joint {
  std::string name;
  Subgroup kind{};
  double pitch = 0;
  int iq = 0, nq = 0;  ///< the coordinates are q[iq] to q[iq + nq - 1]; nq = 0 for a coupled joint
  int iv = 0, nv = 0;
  struct Leader {
    int joint;
    double ratio, offset;
  };
  std::optional<Leader> leader;  ///< leader of a coupled joint; it has a coordinate of its own
  std::vector<Dof> dof;          ///< one for each degree of freedom
  bool passive = false;          ///< whether the joint has no drive
};

/// A gear with losses between a joint and its drive. It transmits the force F = τ - I a - x, where τ is the
/// drive force, I the armature, a the acceleration, and x the sum of the damping, the dry friction and the
/// loss of the gear, which is proportional to |F|. See (D9.8).
struct Gear {
  int velocity;
  double rotor;            ///< armature I of this joint without those of joints that follow it, kg m² or kg
  double loss, loss_back;  ///< lost force / |F| while the drive drives and while it is driven back
};

/// A named frame: of the ground, a moving body, a body fixed to another one, or a FrameDescription.
struct Frame {
  std::string name;
  int body = 0;  ///< body that the frame moves with
  SE3<> pose;    ///< pose in the frame of that body
};

/// An immutable mechanism: a tree of bodies, loops, springs and drives. Copies are cheap and thread-safe.
class Model {
 public:
  // There is no move constructor, so that a model from which another one was made by std::move keeps its
  // data. Hence there is no empty model.
  Model(const Model&) = default;
  Model& operator=(const Model&) = default;

  const std::string& name() const { return data_->description.name; }
  /// n_bodies() is the number of moving bodies, which is that of the joints, and nq() and nv() are the
  /// numbers of coordinates and velocities. Body 0 is the ground. Bodies 1 to n_bodies() are numbered in
  /// depth-first order, with the children of a body in the order of the description.
  int n_bodies() const { return data_->tree->n; }
  int nq() const { return data_->tree->nq; }
  int nv() const { return data_->tree->nv; }
  int n_frames() const { return data_->tree->n_frames(); }
  /// The number of joint screws: one for each degree of freedom of every joint. Coupled joints have screws,
  /// too. The screws of joint i have the indices first_screw(i) to first_screw(i + 1) - 1.
  int n_screws() const { return data_->tree->n_screws; }
  int first_screw(int i) const { return data_->tree->first_screw[i]; }
  const Vec3<>& gravity() const { return data_->tree.g; }

  const Body& body(int i) const { return data_->bodies[i]; }    ///< i = 0 is the ground
  const Joint& joint(int i) const { return data_->joints[i]; }  ///< i from 1; the joint that moves body i
  /// Frame f: 0 to n_bodies() are the ground and the bodies; fixed bodies and other named frames follow.
  const Frame& frame(int f) const { return data_->frames[f]; }
  std::span<const Body> bodies() const { return data_->bodies; }
  /// The joints of bodies 1, 2, ...
  std::span<const Joint> joints() const { return std::span(data_->joints).subspan(1); }
  std::span<const Frame> frames() const { return data_->frames; }

  /// Springs, dampers and elastic stops. They act in simulations.
  const Springs& springs() const { return data_->springs; }
  /// Loop joints (with rods, rolling contacts and belts) and couplings. Functions whose documentation does
  /// not mention loops compute with the spanning tree alone.
  const Loops& loops() const { return data_->loops; }
  /// Prescribed motions of joints and rods; functions whose documentation does not mention them ignore them.
  std::span<const MotionDescription> motions() const { return data_->description.motions; }
  /// Drives with states, see axode/drives.hpp. They act in simulations.
  std::span<const DriveDescription> drives() const { return data_->description.drives; }

  /// The gears with losses, sorted by the index of their velocity.
  std::span<const Gear> gears() const { return data_->gears; }

  /// The index of a body, joint or frame. Throws std::invalid_argument, with the nearest name, if none.
  int body_index(std::string_view name) const;
  int joint_index(std::string_view name) const;
  int frame_index(std::string_view name) const;

  /// The mass Σ m of all moving bodies, kg.
  double total_mass() const;

  /// The warnings about the description from which the model was built.
  std::span<const Fault> warnings() const { return data_->warnings; }
  /// The description from which the model was built; edit a copy of it to build another model.
  const Description& description() const { return data_->description; }
  const Topology& topology() const { return *data_->tree.topology(); }
  /// The numerical data for T = double or float. For another scalar T use cast<T>(tree<double>()).
  template <class T> const Tree<T>& tree() const;

 private:
  friend class ModelBuilder;
  struct Data {
    Description description;
    std::vector<Body> bodies;
    std::vector<Joint> joints;
    std::vector<Frame> frames;
    Springs springs;
    Loops loops;
    std::vector<Gear> gears;
    std::vector<Fault> warnings;
    Tree<double> tree;
    Tree<float> tree_float;
  };
  explicit Model(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  std::shared_ptr<const Data> data_;
};

template <> inline const Tree<double>& Model::tree<double>() const { return data_->tree; }
template <> inline const Tree<float>& Model::tree<float>() const { return data_->tree_float; }

}  // namespace axode
