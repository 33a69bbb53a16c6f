#pragma once
#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/scalar/index.hpp"

namespace axode {

/// The configuration group of a body that moves freely.
enum class BodyGroup {
  SE3,       ///< q = (quaternion x y z w, position of the centre of mass); v = body-fixed twist about this
             ///< point
  SO3xR3,    ///< q is that of SE3; v = (angular velocity in body axes, velocity of the centre of mass in
             ///< inertial axes)
  by_joint,  ///< SE3 for a body whose joint on the ground constrains it, so that its motion is in a subgroup
             ///< of
             ///< SE(3), which steps on SE(3) do not leave; SO3xR3 for all others
};

/// The largest absolute value of the numbers, 0 if there are none, and NaN if any number is NaN.
inline double largest_of(std::span<const double> numbers) {
  double most = 0;
  for (const double x : numbers)
    if (!(std::abs(x) <= most)) most = std::isnan(most) ? most : std::abs(x);
  return most;
}

/// A mechanism in absolute coordinates: every body moves freely, and every joint and every loop is a
/// constraint between two bodies,
///   M v' - ad_vᵀ M v = f + Bᵀ λ,   Φ(q) = 0,   B v = 0
/// with the velocities v of the bodies, the constant mass matrix M, applied forces f, the constraint Jacobian
/// B and multipliers λ. The residual Φ of a joint is the relative pose of its bodies after the motion in the
/// subgroup of SE(3) that the joint allows has been removed (D6.1).
///
/// The coordinates are those of all bodies, and then one for each rotor. Positions are relative to a fixed
/// point in space: the centre of mass of the first body if the coordinates of its joint are 0 (or the
/// identity quaternion). A rotor is an additional body with one coordinate. Its velocity is constrained to
/// equal one joint velocity, and its inertia is the armature of this joint velocity. Every joint velocity
/// with armature has a rotor, so that M is constant. Every angle of a revolute or planar joint has a rotor
/// too: the rotor's coordinate counts the whole turns, which poses do not determine.
///
/// B has six rows for each joint, in the axes of the joint, then one row for each rotor, and then those of
/// the loops. A row of an axis about or along which the joint moves freely is 0. In a coupled joint, whose
/// velocity is a constant ratio times that of another joint, this row has the equation of the coupling
/// instead. The constraint of a rotor has no residual Φ if the rotor's velocity is not the rate of a joint
/// coordinate, as in spherical joints.
///
/// One call of factorize() and one of solve() cost O(n + m d + m² d + m³) for n bodies and m loop equations
/// on paths of d joints. They eliminate the velocities that the joints allow body by body, as the
/// articulated-body algorithm does.
class AbsoluteSystem {
 public:
  using Vector = std::vector<double>;
  using Span = std::span<const double>;

  AbsoluteSystem(const Model& model, BodyGroup group);

  /// The configuration group of the absolute coordinates, as a tree in which every body and every rotor (an
  /// additional body whose velocity is constrained to equal one joint velocity) is on the ground.
  const Tree<double>& group() const { return group_tree_; }
  int nq() const { return group_tree_->nq; }
  int nv() const { return group_tree_->nv; }
  /// The number of constraint equations at the position or the velocity level. Nonholonomic constraints, such
  /// as no-slip conditions, have equations at the velocity level only.
  int rows(ConstraintLevel level) const { return first_loop(level) + loops_.size(level); }

  /// Convert coordinates and velocities of the joints to those of the bodies and rotors (additional bodies
  /// whose velocity is constrained to equal one joint velocity), and back. The whole turns of joint angles,
  /// which poses of bodies do not determine, are kept in the coordinates of the rotors.
  void from_joint_state(Span q_joints, Span v_joints, Vector& q, Vector& v);
  void to_joint_state(Span q, Span v, Vector& q_joints, Vector& v_joints);
  /// Computes the absolute coordinates q and velocities v of the bodies and rotors from poses C and
  /// body-fixed twists V of the bodies. Entry 0 of C and V is that of the ground, and entry i that of the
  /// frame of body i as the user placed it, which may differ from the internal frame. The coordinates of
  /// rotors (additional bodies whose velocity is constrained to equal one joint velocity) may be joint
  /// angles, which poses determine only up to whole turns: the angles nearest to those of
  /// set_reference_angles() are taken.
  void set_poses_and_twists(std::span<const SE3<>> C, std::span<const Twist<BodyFixed>> V, Vector& q,
                            Vector& v);
  /// Sets the reference joint coordinates (nq of the model), near which angles (by whole turns) and
  /// quaternions (by sign) are chosen when they are computed from poses.
  void set_reference_angles(Span q_joints) { reference_q_.assign(q_joints.begin(), q_joints.end()); }
  /// Prescribes positions, velocities and accelerations for some equations of the loops, in all later
  /// residuals and biases; those of all other equations are 0 (D12.1).
  void prescribe(std::span<const PrescribedRow<double>> rows) {
    prescribed_.assign(rows.begin(), rows.end());
  }

  /// position_residual() computes the residuals Φ(q) of the constraints, minus the prescribed positions. For
  /// nonholonomic constraints, such as no-slip conditions, which have no residual, `out` has no entries if
  /// `level` is ConstraintLevel::position. If it is ConstraintLevel::velocity, `out` has one entry for each
  /// row of the constraint Jacobian B, and those of nonholonomic constraints are 0. velocity_residual()
  /// computes B v - s' for all rows of B, with the prescribed velocities s'.
  void position_residual(Span q, Vector& out, ConstraintLevel level = ConstraintLevel::position);
  void velocity_residual(Span q, Span v, Vector& out);
  /// Whether some constraints are nonholonomic, that is, have a row of the constraint Jacobian B but no
  /// residual. set_nonholonomic_rates() sets the entries of `out` for these constraints to `scale` times
  /// their rates, the product of their rows with the velocities v. `out` has an entry for each row of B.
  bool has_nonholonomic_rows() const {
    return rows(ConstraintLevel::velocity) > rows(ConstraintLevel::position);
  }
  void set_nonholonomic_rates(Span q, Span v, double scale, Vector& out);
  /// Adds the constraint forces Bᵀ λ to f (nv() numbers), with the constraint Jacobian B at q.
  void add_constraint_forces(Span q, Span lambda, Vector& f);
  /// Computes the momentum p = M v (nv() numbers) with the constant mass matrix M.
  void momentum(Span v, Vector& p) const;
  /// The kinetic energy plus the potential energy of gravity, J.
  double energy(Span q, Span v);
  /// Computes the forces f of gravity, loads and drives on the bodies at (q, v), nv() numbers in absolute
  /// coordinates. `tau` has the drive forces of the joints, one for each velocity of the model. Damping and
  /// dry friction act if loads.joint_losses is set.
  void forces(Span q, Span v, Span tau, const Loads<double>& loads, Vector& f);

  /// factorize() evaluates the kinematics at q and factorises the linear system M x - Bᵀ λ = r, B x = rhs of
  /// solve(), with the mass matrix M and the rows of the constraint Jacobian B at a level. At the velocity
  /// level these are all rows, and at the position level all except those of nonholonomic constraints, such
  /// as no-slip conditions. For a q at which the loops are closed, factorize_with_rank() factorises the
  /// system at the velocity level and determines which loop equations are redundant; solve() sets their
  /// multipliers to 0, also after later factorisations.
  Solvability factorize(Span q, ConstraintLevel level = ConstraintLevel::velocity);
  /// Factorises the linear system M x - Bᵀ λ = r, B x = rhs of solve() with the mass matrix M of the bodies
  /// and rotors and all rows of the constraint Jacobian B, nonholonomic ones included. Resistances (one for
  /// each velocity of the model, kg m² or kg) are added to the system like armatures: the joint exerts the
  /// force -resistance_c x_c for the joint velocity x_c in the solution x.
  Solvability factorize(Span q, Span resistance);
  Solvability factorize_with_rank(Span q);
  /// Solves M x - Bᵀ λ = r and B x = rhs for x and λ, with the mass matrix M and the constraint Jacobian B of
  /// the last factorisation. The multipliers of loop equations that factorize_with_rank() found redundant are
  /// 0. If the other loop equations are dependent, their multipliers λ_k approximate those with the least Σ
  /// d_k² λ_k² (D7.8). d_k² is about the diagonal entry of A M_t⁻¹ Aᵀ for loop equation k, with the Jacobian
  /// A of the loop equations by the joint velocities of the spanning tree and the mass matrix M_t of this
  /// tree.
  void solve(Span r, Span rhs, Vector& x, Vector& lambda);
  /// How far the loop equations were from linear dependence in the last solve(), from 0 (dependent) to 1.
  double weakest_row() const { return loops_.weakest_row(); }
  /// Computes rhs = s'' - B' v of the condition B v' = rhs for the accelerations v', with the constraint
  /// Jacobian B at the q of the last factorisation and prescribed accelerations s''.
  void bias(Span v, Vector& rhs);

 private:
  using BodyTwist = Twist<BodyFixed, double>;
  using BodyWrench = Wrench<BodyFixed, double>;
  struct Bound {
    loops::SubgroupClosure closure;  ///< free directions of the joint, in its frame
    int along = -1;                  ///< index of the free direction if the joint has one velocity, otherwise
                                     ///< -1
  };
  const Tree<double>& tree() const { return model_.tree<double>(); }
  /// A rotor: an additional body with one coordinate, whose velocity is constrained to equal one velocity of
  /// a joint, and whose inertia is the armature of this velocity. Rotors whose velocity is the rate of a
  /// joint coordinate are stored first.
  struct Rotor {
    int joint, velocity;
    std::size_t along;  ///< direction of this velocity, from 0 to 5 for ω_x to v_z in the frame of the joint
  };
  int n_rotors() const { return static_cast<int>(rotors_.size()); }
  int n_rotors(ConstraintLevel level) const {
    return level == ConstraintLevel::velocity ? n_rotors() : n_placed_rotors_;
  }
  int first_loop(ConstraintLevel level) const { return 6 * n_ + n_rotors(level); }
  int parent(int i) const { return tree()->parent[i]; }
  Tree<double> make_group() const;
  /// Whether the group of body i is SE(3), and not SO(3) × R³.
  bool is_on_SE3(int i) const { return on_SE3_[index(i)] != 0; }
  static Vec3<> angular(const double* x) { return {x[0], x[1], x[2]}; }
  static Vec3<> linear(const double* x) { return {x[3], x[4], x[5]}; }
  /// The twist X of the predecessor, in the frame of a body with the pose D relative to the predecessor.
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
  /// Computes the products of the rows of the joints and rotors with the relative motions X of all joints.
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
  int n_;
  std::vector<char> on_SE3_;  ///< n + 1
  std::vector<Bound> bound_;
  std::vector<Rotor> rotors_;
  int n_placed_rotors_ = 0;
  std::vector<int> leader_;    ///< leader of each joint; 0 if the joint is not coupled
  std::vector<int> joint_of_;  ///< joint of each velocity of the model
  std::vector<Vec3<>> com_;
  Tree<double> group_tree_;
  LoopSystem<double> loops_;
  RowRank rank_;
  std::vector<PrescribedRow<double>> prescribed_;
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
