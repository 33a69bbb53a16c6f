#pragma once
#include <Eigen/Core>
#include <cmath>
#include <initializer_list>
#include <span>
#include <vector>

#include "axode/constraints/loop_system/row_cholesky.hpp"
#include "axode/dynamics/gear_losses.hpp"
#include "axode/integration/schemes/energy_norm.hpp"
#include "axode/model/tree.hpp"

namespace axode {

/// Losses of joints: Coulomb friction, damping, and losses of gears. A velocity v_c with the friction limit
/// f_c (N m or N) either slides in one direction under the friction force -f_c sign(v_c), or it sticks, v_c =
/// 0, under a friction force of magnitude up to f_c (D9.1). The direction of sliding is a part of the state,
/// and changes only at the end of a step of integration.
///
/// The friction forces x of sticking velocities change the accelerations from a to a + Φ x with Φ = ∂a/∂τ. By
/// Gauss' principle they minimise x·(Φ x/2 + a) under |x_c| ≤ f_c (D9.4): either the resulting acceleration
/// of velocity c is 0, or x_c is at its bound and opposes this acceleration.
///
/// The loss of a gear is dry friction whose bound depends on the force that the gear transmits, and hence on
/// the accelerations.
class DryFriction {
 public:
  using Span = std::span<const double>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Takes friction limits and gears with losses. If `enabled` is false, no joint has friction.
  DryFriction(const Tree<double>& tree, std::span<const Gear> gears, bool enabled);

  /// Whether any joint has dry friction or a gear with losses; otherwise this object has nothing to do.
  bool active() const { return !joints_.empty(); }
  /// The indices of the velocities that stick.
  const std::vector<int>& sticking() const { return sticking_; }
  /// Indices of velocities that stick, or have gears with losses: their friction depends on accelerations.
  const std::vector<int>& resisting() const { return resisting_; }
  bool has_gears() const { return has_gears_; }
  /// The number of velocities with dry friction or gears with losses, and the index of the k-th of them.
  std::size_t size() const { return joints_.size(); }
  int velocity(std::size_t k) const { return joints_[k].velocity; }
  /// A number that becomes negative when velocity k with dry friction must stop or begin to slide. While it
  /// slides, the number is the velocity in the direction of sliding, plus 1e-12. While it sticks, the number
  /// is the distance (N m or N) of its friction force, as computed last, from the limit; if the force is at
  /// its limit, it is minus the force that would be missing to hold the joint.
  double reserve(std::size_t k, Span v) const;

  /// Starts at the velocities v: each joint with dry friction or a gear with losses slides in the direction
  /// of its velocity, or sticks if its velocity is 0.
  void start(Span v);
  /// Adds the damping of all joints and the dry friction of sliding joints at v to the joint forces tau (nv).
  void add_losses(Span v, std::span<double> tau) const;
  /// Finds the friction forces of sticking velocities and of gears with losses, and adds their effect to a.
  /// On entry a (nv numbers) are the accelerations without these forces; on return the acceleration of a
  /// velocity that friction holds is 0. `compliance` has the columns of Φ = ∂a/∂τ for the velocities that
  /// stick or have gears with losses, and `own` the acceleration of each of these velocities under a unit
  /// force on it if the loops are open. `norm` is the norm √Σ m_c a_c² with estimated inertias m_c; the
  /// tolerance within which the acceleration of a sticking velocity counts as 0 grows with the norm of a.
  /// `drive` has the drive forces that pass through gears (nv numbers); it is read only if a gear has losses.
  /// Returns -1 or, if the forces are not unique or not found, the index of the velocity of a gear, in
  /// general one that is too strongly self-locking (D9.12).
  [[nodiscard]] int apply_friction(const Matrix& compliance, Span own, const EnergyNorm& norm, Span v,
                                   Span drive, std::span<double> a);
  /// Adds the losses of moving gears to the residuals r = ID(q, v, a) - τ (nv numbers) of the equations of
  /// motion, with inverse dynamics ID (D9.13). `drive` has the drive forces that pass through gears.
  void add_gear_losses(Span v, Span a, Span drive, std::span<double> r);
  /// Adds the derivatives of the gear losses, as add_gear_losses() computed them last, to derivatives of the
  /// residuals ID(q, v, a) - τ of the equations of motion, with inverse dynamics ID. `derivatives` are nv ×
  /// nv matrices [residual, variable]: first the derivatives by a, then any number of derivatives by other
  /// variables, such as q or v. On entry they must not contain the derivatives of the forces of drives and
  /// damping, on which the losses do not depend at given q, v and a; the caller adds those derivatives after
  /// the call.
  void scale_derivatives(std::initializer_list<std::span<double>> derivatives) const;

  /// Adapts derivatives of the accelerations to sticking joints: after the call they hold under the condition
  /// that sticking velocities remain 0 (D9.7). `derivatives` are nv × nv matrices [acceleration, direction];
  /// the first one must be ∂a/∂τ.
  void constrain_derivatives(std::initializer_list<std::span<double>> derivatives);

  /// The largest acceleration of a sticking velocity since the last reset, relative to the tolerance within
  /// which it counts as 0 (D9.6): more than 1 if friction cannot hold a joint.
  double violation() const { return violation_; }
  void reset_violation() { violation_ = 0; }
  /// Whether a sliding velocity changes its sign in a step of length h (s). Between the start (v_0, a_0) and
  /// the end (v_1, a_1) of the step, the velocity is taken as the cubic with these velocities and
  /// accelerations.
  bool reverses(Span v_0, Span a_0, Span v_1, Span a_1, double h) const;
  /// The time (s), at constant accelerations a, until the first of the decelerating sliding joints comes to
  /// rest. It is 0 if no sliding joint decelerates, and negative if the velocity of such a joint is already
  /// opposite to the stored direction of sliding of this joint.
  double time_to_stop(Span v, Span a) const;

  /// Stops joints. The velocity of a joint becomes 0 if the joint sticks, or if it slides and its velocity is
  /// 0, is opposite to its stored direction of sliding, or will be 0 within the time `within` (s) at the
  /// accelerations a. A sliding joint that is stopped begins to stick if its acceleration is opposite to this
  /// direction. Returns whether a joint began to stick.
  bool stop_sliding(std::span<double> v, Span a, double within);
  /// Lets each sticking joint slide if its acceleration under friction, its entry of a, is not 0. The joint
  /// slides in the direction of this acceleration.
  void start_sliding(Span a);

 private:
  struct Joint {
    int velocity;
    double friction;
    int direction;      ///< direction of sliding, 1 or -1; 0 while the joint sticks
    double force;       ///< the friction force while the joint sticks
    double margin = 0;  ///< the result of reserve() while the joint sticks
    Gear gear = {};     ///< without losses if the joint has no such gear
    double slope = 0;   ///< derivative of the loss of a moving gear by the force that it transmits

    /// Sets `margin` of a sticking joint to bound - |force| + (2 tolerance - |a|)/own, which is positive if
    /// friction holds the joint, that is, if |a| <= tolerance. `force` is the present friction force, `bound`
    /// its limit, a the acceleration of the joint under this force, and `own` the acceleration of the joint
    /// by a unit force on it. Also a force at its limit has a positive margin then.
    void set_margin(double bound, double a, double tolerance, double own) {
      margin = bound - std::abs(force) + (2 * tolerance - std::abs(a)) / own;
    }
  };
  static std::size_t at(Eigen::Index c) { return static_cast<std::size_t>(c); }
  Joint& sticking_joint(Eigen::Index i) { return joints_[sticking_joints_[at(i)]]; }
  void list_sticking();
  /// The part of the drive force that damping and dry friction leave for the rotor and the gear.
  double through_gear(const Joint& joint, Span v, Span drive) const {
    const std::size_t c = at(joint.velocity);
    return drive[c] - tree_->damping[c] * v[c] - joint.direction * joint.friction;
  }
  int apply_with_gears(const Matrix& compliance, Span own, const EnergyNorm& norm, Span v, Span drive,
                       std::span<double> a);
  /// Factorises the rows and columns of Φ = ∂a/∂τ that belong to the friction forces inside their bounds.
  /// Because Φ may be singular, 1e-12 `size` is added to its diagonal, where `size` is the magnitude of its
  /// entries.
  void factorize(double size);
  /// Computes the friction forces x of sticking joints and their accelerations a_0 + Φ x, with Φ = ∂a/∂τ and
  /// the accelerations a_0 without these forces. The iteration begins with the forces of the previous call.
  /// `size` is the largest acceleration of one of these joints by a unit force on it if the loops are open;
  /// it scales the regularisation of Φ.
  void find_forces(double size);

  const Tree<double>* tree_;
  std::vector<Joint> joints_;
  std::vector<int> sticking_;
  std::vector<std::size_t> sticking_joints_;  ///< indices of the joints, in the order of sticking()
  bool has_gears_ = false;
  std::vector<int> resisting_;
  std::vector<std::size_t> resisting_joints_;  ///< indices of the joints, in the order of resisting()
  std::vector<ResistingJoint> resistances_;
  ResistingForces gear_forces_;
  double violation_ = 0;

  Matrix A_;  ///< rows and columns of Φ = ∂a/∂τ for the sticking velocities
  Eigen::VectorXd a_0_, a_, tolerance_, step_;
  std::vector<char> bound_;
  std::vector<Eigen::Index> free_;
  RowCholesky<double> factor_;
};

}  // namespace axode
