#pragma once
#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// The group in which a body moves freely.
enum class BodyGroup {
  SE3,     ///< q = (quaternion x y z w, position of the centre of mass), v = body-fixed twist there
  SO3xR3,  ///< q as for SE3; v has the velocity of the centre of mass in inertial axes, and the angular one
           ///< in body axes
};

/// The largest absolute value; NaN if any number is NaN.
inline double largest_of(std::span<const double> numbers) {
  double most = 0;
  for (const double x : numbers)
    if (!(std::abs(x) <= most)) most = std::isnan(most) ? most : std::abs(x);
  return most;
}

/// A mechanism in absolute coordinates: every body moves freely, and every joint, like every loop, is a
/// constraint between two bodies.
///   M v' - ad_vᵀ M v = f + Bᵀ λ,   Φ(q) = 0,   B v = 0
/// with a constant M. The residual of a joint is the relative pose of its bodies after the motion in the
/// subgroup of the joint has been removed (D6.1).
///
/// The coordinates are those of all bodies, with positions relative to the centre of mass of the first body
/// in the reference configuration, and one coordinate for every rotor. A rotor is bound to one velocity of a
/// joint. Every velocity with armature has a rotor, so that M is constant; every angle of a revolute or
/// planar joint has one as well, without inertia if there is no armature. The coordinate of such a rotor is
/// the angle with its whole turns, which poses do not determine; the schemes integrate it like the
/// coordinates of the bodies.
///
/// There are three kinds of rows. Each joint has six rows, in the axes of the joint; a row of a free
/// direction is 0, unless a coupled joint binds its rate to that of its leader. Each rotor has one row; it
/// has a position level only if its velocity is the rate of a coordinate. The rows of the loops come last.
///
/// The multipliers of the tree joints are not unknowns: the free velocities are eliminated body by body, as
/// in the articulated-body algorithm. O(n + m d + m² d + m³) for m rows of loops on paths of d joints.
class AbsoluteSystem {
 public:
  using Vector = std::vector<double>;
  using Span = std::span<const double>;

  AbsoluteSystem(const Model& model, BodyGroup group);

  /// The group of the coordinates: a tree whose bodies all hang on the ground, each on a joint with the group
  /// of its motion.
  const Tree<double>& group() const { return group_tree_; }
  int nq() const { return group_tree_->nq; }
  int nv() const { return group_tree_->nv; }
  /// The number of rows. Rolling contacts and rotors without a position have rows at the velocity level only.
  int rows(ConstraintLevel level) const { return first_loop(level) + loops_.size(level); }

  /// Converts coordinates and velocities of the joints to those of the bodies, and back; angles keep their
  /// whole turns.
  void from_joint_state(Span q_joints, Span v_joints, Vector& q, Vector& v);
  void to_joint_state(Span q, Span v, Vector& q_joints, Vector& v_joints);
  /// Sets q and v to poses and twists of all bodies in the user's frames, beginning with the ground. Rotors
  /// move with their joints; their angles are those nearest to the reference angles.
  void set_poses_and_twists(std::span<const SE3<>> C, std::span<const Twist<BodyFixed>> V, Vector& q,
                            Vector& v);
  /// Sets the coordinates that determine whole turns of angles and the signs of quaternions.
  void set_reference_angles(Span q_joints) { reference_q_.assign(q_joints.begin(), q_joints.end()); }

  /// Computes the residuals Φ(q), and below B v, at any q. If the rows are those of the velocity level, Φ is
  /// 0 in rows without a position level.
  void position_residual(Span q, Vector& out, ConstraintLevel level = ConstraintLevel::position);
  void velocity_residual(Span q, Span v, Vector& out);
  /// Whether there are rows without a position level. set_nonholonomic_rates() sets these entries of `out`,
  /// among all rows of the velocity level, to scale · (B v) at q.
  bool has_nonholonomic_rows() const {
    return rows(ConstraintLevel::velocity) > rows(ConstraintLevel::position);
  }
  void set_nonholonomic_rates(Span q, Span v, double scale, Vector& out);
  /// Adds the constraint forces Bᵀ λ to f, with the rows B at q.
  void add_constraint_forces(Span q, Span lambda, Vector& f);
  /// Computes the momentum p = M v.
  void momentum(Span v, Vector& p) const;
  /// The kinetic energy plus the potential energy of gravity, J.
  double energy(Span q, Span v);
  /// Computes the forces f of gravity, loads and drives; tau are the drive forces of the joints.
  void forces(Span q, Span v, Span tau, const Loads<double>& loads, Vector& f);

  /// Evaluates the kinematics at q and factorises the system with the constraint rows of a level. If the
  /// loops are closed at q, factorize_with_rank() decides in addition which rows of loops are redundant;
  /// solve() uses this rank from then on.
  Solvability factorize(Span q, ConstraintLevel level = ConstraintLevel::velocity);
  /// Factorises the system with a resistance of the joints (nv of the model), by which an implicit step
  /// accounts for springs and dampers: a velocity c of the joints that changes by x_c adds a force of
  /// -resistance_c x_c. It acts like an armature.
  Solvability factorize(Span q, Span resistance);
  Solvability factorize_with_rank(Span q);
  /// Solves M x - Bᵀ λ = r and B x = rhs, with the least λ if rows are redundant.
  void solve(Span r, Span rhs, Vector& x, Vector& lambda);
  /// How far the rows were from redundant in the last solve(), see LoopSystem::weakest_row().
  double weakest_row() const { return loops_.weakest_row(); }
  /// Computes the right side of B v' = rhs that is equivalent to (B v)' = 0, at v and at the q of the last
  /// factorisation.
  void bias(Span v, Vector& rhs);

 private:
  using BodyTwist = Twist<BodyFixed, double>;
  using BodyWrench = Wrench<BodyFixed, double>;
  struct Bound {
    loops::SubgroupClosure closure;  ///< the free directions of the joint, in its frame
    int along = -1;                  ///< the free direction if the joint has one velocity
  };
  static std::size_t index(int k) { return static_cast<std::size_t>(k); }
  const Tree<double>& tree() const { return model_.tree<double>(); }
  /// A rotor of a velocity of a joint. Rotors with a position level come first; they belong to joints with
  /// one velocity and to the angles of planar joints.
  struct Rotor {
    int joint, velocity;
    std::size_t along;  ///< the direction of the joint
  };
  int n_rotors() const { return static_cast<int>(rotors_.size()); }
  int n_rotors(ConstraintLevel level) const {
    return level == ConstraintLevel::velocity ? n_rotors() : n_placed_rotors_;
  }
  int first_loop(ConstraintLevel level) const { return 6 * n_ + n_rotors(level); }
  int parent(int i) const { return tree()->parent[i]; }
  static Tree<double> group_of(int n, int rotors, BodyGroup group);
  static Vec3<> angular(const double* x) { return {x[0], x[1], x[2]}; }
  static Vec3<> linear(const double* x) { return {x[3], x[4], x[5]}; }
  /// The motion X of the predecessor, expressed in the frame of a body whose pose relative to the predecessor
  /// is D.
  static BodyTwist carried(const SE3<>& D, const BodyTwist& X) {
    return axode::twist<BodyFixed>(Ad_inv(D, screw(X)));
  }
  static SE3<> about(const Vec3<>& O, const SE3<>& C) { return {C.R, C.r - O}; }

  SE3<> pose(Span q, int i) const;
  void put_pose(const SE3<>& C, int i, Vector& q) const;
  BodyTwist twist(const SE3<>& C, Span v, int i) const;
  void put_twist(const SE3<>& C, const BodyTwist& V, int i, Vector& v) const;
  BodyWrench wrench(const SE3<>& C, Span f, int i) const;
  void add_wrench(const SE3<>& C, const BodyWrench& W, int i, Vector& f) const;
  void find_poses(Span q);
  void find_twists(Span v);
  SE3<> joint_pose(int i) const;
  BodyTwist joint_twist(int i) const;
  void joint_coordinates(int i, const double* near, double* q_i) const;
  double angle(int i) const;
  double known_angle(int c) const;
  Solvability factorize(Span q, ConstraintLevel level, const double* armature);
  /// Evaluates the rows of the joints and rotors for the relative motions X of all joints.
  template <class Motion> void bind(const Motion& X, Vector& rows) const;
  double rate(int i, const BodyTwist& X) const { return six(X.w, X.v)[index(bound_[index(i)].along)]; }
  BodyWrench co_screw(int i, double tau) const;
  static double rate(const Rotor& rotor, const BodyTwist& X) { return six(X.w, X.v)[rotor.along]; }
  static BodyWrench co_screw(std::size_t along, double tau);
  BodyWrench joint_force(int i, Span tau) const;
  void add_joint_wrench(int i, const BodyWrench& W, Vector& f) const;
  const Vec3<>& loop_origin(const LoopPath& path) const;
  loops::LoopFrames<double> loop_frames(const LoopPath& path) const;
  template <class Joint> Six<double> loop_rates(const LoopPath& path, const Joint& joint) const;
  double coupled_rate(const LoopCoupling& coupling, const std::vector<BodyTwist>& X) const;

  Model model_;
  BodyGroup kind_;
  int n_;
  std::vector<Bound> bound_;
  std::vector<Rotor> rotors_;
  int n_placed_rotors_ = 0;
  std::vector<int> leader_;    ///< the leader of each joint; 0: the joint is not coupled
  std::vector<int> joint_of_;  ///< the joint of each velocity
  std::vector<Vec3<>> com_;
  Tree<double> group_tree_;
  LoopSystem<double> loops_;
  RowRank rank_;
  ConstraintLevel factorized_level_ = ConstraintLevel::velocity;
  Vector reference_q_;
  std::vector<SE3<>> factorized_C_;
  std::vector<SE3<>> C_;
  std::vector<BodyTwist> V_, X_;
  std::vector<Twist<Spatial>> known_, V_s_;
  std::vector<TwistRate<Spatial>> dV_s_;
  std::vector<Wrench<Spatial>> on_, through_;
  Vector x_, tau_, p_, armature_;
  Eigen::VectorXd b_;
};

}  // namespace axode
