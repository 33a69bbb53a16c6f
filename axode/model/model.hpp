#pragma once
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "axode/model/kinds/joint_kinds.hpp"
#include "axode/model/loops.hpp"
#include "axode/model/springs.hpp"
#include "axode/model/tree.hpp"

namespace axode {

/// A body that moves (or the ground, index 0), in the frame in which the user placed it.
struct Body {
  std::string name;
  int predecessor = 0;
  SE3<> A;                 ///< reference pose in the inertial frame, C_i(0)
  SE3<> B;                 ///< reference pose in the predecessor's frame
  SE3<> S_prev, S_self;    ///< joint frame on the predecessor and on the body, B = S_prev S_self⁻¹
  std::vector<Screw<>> X;  ///< joint screw(s) in the body frame, a column for each velocity; Y_i = Ad_A X_i
  Inertia<> M;             ///< inertia in the body frame, with everything that is fixed to the body
};

/// The joint that moves a body. Joint i moves body i.
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
  std::optional<Leader> leader;  ///< leader of a coupled joint, with chains of couplings resolved
  std::vector<Dof> dof;          ///< one for each degree of freedom
  bool passive = false;          ///< whether the joint has no drive
};

/// A gear with losses between the drive of a joint and the joint. It transmits the force F = τ - I a - x,
/// where x are the losses of the joint: damping, dry friction, and a part of |F|. See (D9.8).
struct Gear {
  int velocity;
  double rotor;            ///< the armature I of this joint alone, kg m² or kg
  double loss, loss_back;  ///< the part of |F| that is lost while the drive drives, and while it is driven
};

/// A named frame: the ground, a body, a body fixed to another, or a frame of interest.
struct Frame {
  std::string name;
  int body = 0;  ///< body that the frame moves with
  SE3<> pose;    ///< pose in the frame of that body
};

/// An immutable tree of bodies. Copies are cheap and share the data; threads may share a model.
class Model {
 public:
  // A model that was moved from keeps its data: there is no empty model.
  Model(const Model&) = default;
  Model& operator=(const Model&) = default;

  const std::string& name() const { return data_->description.name; }
  /// The number of moving bodies, which is also the number of joints. Body 0 is the ground; bodies 1 to
  /// n_bodies() follow in depth-first order, children as declared.
  int n_bodies() const { return data_->tree->n; }
  int nq() const { return data_->tree->nq; }
  int nv() const { return data_->tree->nv; }
  int n_frames() const { return data_->tree->n_frames(); }
  /// The number of joint screws: one for each degree of freedom of every joint, coupled ones included. Those
  /// of joint i start at first_screw(i).
  int n_screws() const { return data_->tree->n_screws; }
  int first_screw(int i) const { return data_->tree->first_screw[i]; }
  const Vec3<>& gravity() const { return data_->tree.g; }

  const Body& body(int i) const { return data_->bodies[i]; }    ///< i = 0 is the ground
  const Joint& joint(int i) const { return data_->joints[i]; }  ///< i from 1; the joint that moves body i
  /// Frames 0 to n_bodies() are the ground and the bodies; the others follow.
  const Frame& frame(int f) const { return data_->frames[f]; }
  std::span<const Body> bodies() const { return data_->bodies; }
  /// The joints of bodies 1, 2, ...
  std::span<const Joint> joints() const { return std::span(data_->joints).subspan(1); }
  std::span<const Frame> frames() const { return data_->frames; }

  /// Springs, dampers and stops, which act in simulations.
  const Springs& springs() const { return data_->springs; }
  /// Loop joints, rods, contacts and couplings. Functions whose documentation does not mention loops compute
  /// with the spanning tree alone.
  const Loops& loops() const { return data_->loops; }
  /// Motions that joints and rods follow, see axode/constraints/prescribed/prescribed_motion.hpp. Functions
  /// whose documentation does not mention them compute with the mechanism without motions.
  std::span<const MotionDescription> motions() const { return data_->description.motions; }
  /// Drives with states, which act in simulations, see axode/drives.hpp.
  std::span<const DriveDescription> drives() const { return data_->description.drives; }

  /// Gears with losses, in the order of their velocities.
  std::span<const Gear> gears() const { return data_->gears; }

  /// The index of a body, joint or frame by its name. Throws std::invalid_argument, with the unknown name and
  /// the nearest known one, if there is none.
  int body_index(std::string_view name) const;
  int joint_index(std::string_view name) const;
  int frame_index(std::string_view name) const;

  /// The mass Σ m of all moving bodies, kg.
  double total_mass() const;

  /// Defects of the description that did not prevent the build.
  std::span<const Fault> warnings() const { return data_->warnings; }
  /// The description from which the model was built; edit a copy of it to build another model.
  const Description& description() const { return data_->description; }
  const Topology& topology() const { return *data_->tree.topology(); }
  /// The tree that kernels read, for T = double or float. For other scalars use cast<T>(tree<double>()).
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
