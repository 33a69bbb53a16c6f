#pragma once
#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "axode/constraints/loop_system.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// In which group a body moves freely.
enum class BodyGroup {
  SE3,     ///< q = (quaternion x y z w, position of the centre of mass), v = body-fixed twist there
  SO3xR3,  ///< the same q; velocity of the centre of mass in inertial axes, angular velocity in body axes
};

/// The largest size of any; NaN where one is.
inline double largest_of(std::span<const double> numbers) {
  double most = 0;
  for (const double x : numbers)
    if (!(std::abs(x) <= most)) most = std::isnan(most) ? most : std::abs(x);
  return most;
}

/// A mechanism in absolute coordinates: every body moves freely, and every joint binds two of them, as loops do.
///   M v' - ad_vᵀ M v = f + Bᵀ λ,   Φ(q) = 0,   B v = 0
/// with a constant M. The motion within a joint's subgroup is stripped off the relative pose of its bodies; what is left of
/// it closes.
///
/// Coordinates: those of all bodies, seen from where the first body's centre of mass is drawn, for digits; then one for every rotor.
/// A rotor is bound to one velocity of a joint. Every velocity with armature has one, so that M is constant for it too; and
/// every angle of a revolute or planar joint has one, with the mass 0 if there is no armature. The coordinate of that rotor is
/// the angle with its whole turns, which the poses of the bodies do not tell, and every scheme moves it as it moves the bodies.
/// Rows: six for each
/// joint in the joint's axes, of which those of free directions are 0 but where a coupled joint binds its own to the
/// leader's; one for each rotor, without a place where its velocity is not the rate of a coordinate; those of the loops.
///
/// Multipliers of the tree are never solved for: what its joints leave free gives way body by body, as in the articulated
/// bodies algorithm, and what they bind is known. O(n + m d + m² d + m³) for m rows of loops of length d.
class AbsoluteSystem {
 public:
  using Vector = std::vector<double>;
  using Span = std::span<const double>;

  AbsoluteSystem(const Model& model, BodyGroup group);

  /// The group of the coordinates: a tree of nothing but bodies on the ground, each with a joint for its motion.
  const Tree<double>& group() const { return group_tree_; }
  int nq() const { return group_tree_->nq; }
  int nv() const { return group_tree_->nv; }
  /// Vector of rows, of velocities or of places; they differ where something rolls or a rotor has no place.
  int rows(ConstraintLevel level) const { return first_loop(level) + loops_.size(level); }

  /// From the coordinates and velocities of the joints, and back; angles have the whole turns of their rotors.
  void from_joint_state(Span q_joints, Span v_joints, Vector& q, Vector& v);
  void to_joint_state(Span q, Span v, Vector& q_joints, Vector& v_joints);
  /// From the poses and twists of all bodies in the user's frames, the ground's first. Rotors turn with their joints, and their
  /// angles are those nearest to the ones last kept.
  void set_poses_and_twists(std::span<const SE3<>> C, std::span<const Twist<BodyFixed>> V, Vector& q,
                            Vector& v);
  /// Quaternions are given with the signs of these, and put() takes the nearest angles.
  void set_reference_angles(Span q_joints) { reference_q_.assign(q_joints.begin(), q_joints.end()); }

  /// Φ(q), and B v at q, wherever the system is placed. Among rows of velocities Φ is 0 where there is no place.
  void position_residual(Span q, Vector& out, ConstraintLevel level = ConstraintLevel::position);
  void velocity_residual(Span q, Span v, Vector& out);
  /// Whether rows have no place; and scale B v at q in these of all rows of velocities.
  bool has_nonholonomic_rows() const {
    return rows(ConstraintLevel::velocity) > rows(ConstraintLevel::position);
  }
  void set_nonholonomic_rates(Span q, Span v, double scale, Vector& out);
  /// f += Bᵀ λ at q.
  void add_constraint_forces(Span q, Span lambda, Vector& f);
  /// p = M v.
  void momentum(Span v, Vector& p) const;
  /// Kinetic energy, and that of weight, J.
  double energy(Span q, Span v);
  /// f of weight, loads and drives, tau being those of the joints.
  void forces(Span q, Span v, Span tau, const Loads<double>& loads, Vector& f);

  /// Places the system at q, ready to solve with rows of a kind; where loops are closed, hold() decides on
  /// their rank, which solve() obeys from then on.
  Solvability factorize(Span q, ConstraintLevel level = ConstraintLevel::velocity);
  /// The same with joints that yield to x less than they are free to: each resists with a force of -resistance times its part of
  /// S⁺x, as springs and dampers do in an implicit step. It acts like an armature.
  Solvability factorize(Span q, Span resistance);
  Solvability factorize_with_rank(Span q);
  /// M x - Bᵀ λ = r and B x = rhs, least λ for rows that repeat each other.
  void solve(Span r, Span rhs, Vector& x, Vector& lambda);
  /// LoopSystem::weakest_row() of the last solve().
  double weakest_row() const { return loops_.weakest_row(); }
  /// What B v' must be at (q, v), where the system is placed, so that (B v)' = 0.
  void bias(Span v, Vector& rhs);

 private:
  using BodyTwist = Twist<BodyFixed, double>;
  using BodyWrench = Wrench<BodyFixed, double>;
  struct Bound {
    loops::SubgroupClosure closure;  ///< what the joint leaves free, in its frame
    int along = -1;                  ///< the free direction of a joint with one velocity
  };
  static std::size_t index(int k) { return static_cast<std::size_t>(k); }
  const Tree<double>& tree() const { return model_.tree<double>(); }
  /// A rotor of a velocity of a joint. Those of joints with one velocity and of planar angles come first; the others have
  /// velocities and no places.
  struct Rotor {
    int joint, velocity;
    std::size_t along;  ///< which direction of the joint
  };
  int n_rotors() const { return static_cast<int>(rotors_.size()); }
  int n_rotors(ConstraintLevel level) const {
    return level == ConstraintLevel::velocity ? n_rotors() : n_placed_rotors_;
  }
  int first_loop(ConstraintLevel level) const { return 6 * n_ + n_rotors(level); }
  int parent(int i) const { return tree()->parent[i]; }
  static Tree<double> group_of(int n, int rotors, BodyGroup group);

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
  /// The rows of the joints and rotors for relative motions of all joints.
  Solvability factorize(Span q, ConstraintLevel level, const double* armature);
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
  std::vector<int> leader_;    ///< of each joint that is coupled; 0: none
  std::vector<int> joint_of_;  ///< of each velocity of joints, the joint that has it for its own
  std::vector<Vec3<>> com_;
  Tree<double> group_tree_;
  LoopSystem<double> loops_;
  RowRank rank_;
  ConstraintLevel factorized_level_ = ConstraintLevel::velocity;
  Vector reference_q_;
  std::vector<SE3<>> placed_;
  std::vector<SE3<>> C_;
  std::vector<BodyTwist> V_, X_;
  std::vector<Twist<Spatial>> known_, V_s_;
  std::vector<TwistRate<Spatial>> dV_s_;
  std::vector<Wrench<Spatial>> on_, through_;
  Vector x_, tau_, p_, armature_;
  Eigen::VectorXd b_;
};

}  // namespace axode
