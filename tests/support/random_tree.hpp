#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "axode/model.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/recursion/loads.hpp"
#include "tests/lie/random_quantities.hpp"

/// Random mechanisms. A mechanism is first drawn with everything in the construction frame. Then it is
/// described to the library; for each body one of the ways in which the library takes a geometry is chosen at
/// random.
namespace axode::test {

/// A body at q = 0. Its poses, points and tensors are in the construction frame.
struct DrawnBody {
  struct Matter {
    double mass;
    Vec3<> com;
    Sym3<> Theta_c;  ///< about the centre of mass
  };

  std::string name, joint;
  int predecessor = -1;  ///< index of a body, -1 for the ground
  JointKind kind = JointKind::fixed;
  SE3<> A;               ///< the body frame
  SE3<> J;               ///< the joint frame; its z-axis is the axis of the joint; of a free joint it is A
  Vec3<> second_axis{};  ///< of a universal joint
  double pitch = 0;
  std::vector<Dof> dof = {};
  std::optional<Coupling> coupling = {};
  std::optional<Matter> matter = {};
};

struct DrawnFrame {
  std::string name;
  int body = -1;
  SE3<> pose;
};

struct Mechanism {
  Vec3<> gravity;
  std::vector<DrawnBody> bodies;
  std::vector<DrawnFrame> frames = {};

  SE3<> A(int i) const { return i < 0 ? SE3<>{} : bodies[static_cast<std::size_t>(i)].A; }
  std::string name(int i) const { return i < 0 ? "ground" : bodies[static_cast<std::size_t>(i)].name; }
};

/// How random mechanisms are drawn: their size and what may occur in them.
struct TreeRecipe {
  int most_bodies = 60;   ///< the largest number of moving bodies
  double length = 0.3;    ///< the typical length of a body before the factor `scale`, m
  bool composite = true;  ///< whether there are cylindrical and universal joints
  bool couplings = true;
  bool always_mass = false;  ///< every body has a mass
  bool one_free_root = false;
  double springs =
      0.5;  ///< the part of described mechanisms with springs and stops on joints and springs between frames
  bool friction = false;  ///< damping and Coulomb friction on every joint, and not only on some
  double far = 0;         ///< how far the mechanism is from the origin before the factor `scale`, m
  double loops = 0;  ///< the part of mechanisms at a state that are closed by loops, see random_loops.hpp
  double scale = 1;  ///< the factor of all lengths of described mechanisms and of their states

  bool operator==(const TreeRecipe&) const = default;
};

bool has_one_velocity(JointKind kind);

/// Draws a mechanism with all kinds of joints, several bodies joined to the ground, massless bodies, frames
/// and drives.
Mechanism random_mechanism(Random<double>& random, const TreeRecipe& recipe = {});

/// The mechanism after the whole scene, with ground and gravity, was displaced by D.
Mechanism displaced(const SE3<>& D, Mechanism mechanism);

/// The three ways in which the geometry of a body may be given.
enum class Way { construction_frame, body_frame, joint_frames };
inline constexpr std::array ways{Way::construction_frame, Way::body_frame, Way::joint_frames};

/// The description of a body with its geometry given in one way. Its axis has a random length, and its point
/// is any point of the axis.
BodyDescription described(const Mechanism& mechanism, const DrawnBody& body, Way way, Random<double>& random);
/// The description of a mechanism, with the geometry of every body given in a random way.
Description described(const Mechanism& mechanism, Random<double>& random);

/// The tree with springs and stops of every kind on its joints, and springs between its bodies and frames.
/// Without losses these springs and stops conserve energy.
Description with_springs(Description tree, Random<double>& random, bool losses = true);

/// The description of a random tree, with springs for the part of them that the recipe names.
Description random_description(Random<double>& random, const TreeRecipe& recipe = {});

/// As long as this object exists, no random mechanism that this thread draws has more moving bodies than
/// this. The bodies that remain are drawn as they would be without the limit.
class AtMostBodies {
 public:
  explicit AtMostBodies(int bodies);
  ~AtMostBodies();
  AtMostBodies(const AtMostBodies&) = delete;
  AtMostBodies& operator=(const AtMostBodies&) = delete;

  static int limit();  ///< of this thread, the largest integer if there is none

 private:
  int before_;
};
/// The last random mechanism of a thread: the number of moving bodies for which it was drawn, and its
/// description with all that was added to it afterwards.
struct LastMechanism {
  int bodies = 0;
  std::shared_ptr<const Description> description;
};
const LastMechanism& last_mechanism();
void set_last_mechanism(const LastMechanism& mechanism);
void set_last_description(const Description& description);

/// The poses of all frames.
std::vector<SE3<>> poses_of(const Model& model, const std::vector<double>& q);

/// A state of a model and the loads on its frames.
template <class T> struct State {
  std::vector<T> q, v, a;
  std::vector<AppliedWrench<T>> wrenches = {};

  Loads<T> loads() const { return {.wrenches = wrenches}; }
};

template <class To, class From> std::vector<To> cast(const std::vector<From>& numbers) {
  std::vector<To> out;
  out.reserve(numbers.size());
  for (const From& x : numbers) out.push_back(static_cast<To>(x));
  return out;
}

template <class To, class From> State<To> cast(const State<From>& state) {
  State<To> out{cast<To>(state.q), cast<To>(state.v), cast<To>(state.a)};
  for (const AppliedWrench<From>& W : state.wrenches)
    out.wrenches.emplace_back(W.frame, W.representation, axode::cast<To>(W.m), axode::cast<To>(W.f));
  return out;
}

/// n numbers in [-size, size].
std::vector<double> random_numbers(Random<double>& random, int n, double size = 1);

/// A random state: any configuration, velocities and accelerations of the order of one, and up to four loads
/// on any frames in any representations.
State<double> random_state(const Model& model, Random<double>& random);

}  // namespace axode::test
