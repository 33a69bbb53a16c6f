#pragma once
#include <Eigen/Core>
#include <initializer_list>
#include <span>
#include <vector>

#include "axode/constraints/loop_system/row_cholesky.hpp"
#include "axode/dynamics/gear_losses.hpp"
#include "axode/integration/schemes/energy_norm.hpp"
#include "axode/model/tree.hpp"

namespace axode {

/// Losses of joints: Coulomb friction, damping, and losses of gears. A velocity v_c with the friction limit
/// f_c (N m or N) either slides in one direction under the constant force -f_c sign(v_c), or it sticks, v_c =
/// 0, under any force up to f_c (D9.1). The direction of sliding is a part of the state: it is constant
/// within a step, so that forces are smooth there, and changes at the end of a step.
///
/// The friction forces x of sticking velocities change the accelerations from a to a + Φ x with Φ = ∂a/∂τ. By
/// Gauss' principle they minimise x·(Φ x/2 + a) under |x_c| ≤ f_c (D9.4): either the resulting acceleration
/// of c is 0, or x_c is at its bound and opposes this acceleration.
///
/// The loss of a gear is dry friction whose bound depends on the force that the gear transmits, and hence on
/// the accelerations. If joints have gears with losses, the class ResistingForces finds the forces of
/// sticking velocities and of moving gears together.
class DryFriction {
 public:
  using Span = std::span<const double>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Takes the friction limits of the joints from the tree, and gears with losses. If `enabled` is false, no
  /// joint has friction.
  DryFriction(const Tree<double>& tree, std::span<const Gear> gears, bool enabled);

  /// Whether any joint has dry friction or a gear with losses. If not, this object has nothing to do, and
  /// losses are left to forward_dynamics() and inverse_dynamics().
  bool active() const { return !joints_.empty(); }
  /// The indices of the velocities that stick.
  const std::vector<int>& sticking() const { return sticking_; }
  /// The indices of the velocities whose friction depends on the accelerations: those that stick, and those
  /// of joints whose gears have losses.
  const std::vector<int>& resisting() const { return resisting_; }
  bool has_gears() const { return has_gears_; }

  /// Starts at the velocities v: every joint with dry friction slides in the direction of its velocity, and
  /// joints at rest stick until start_sliding() lets them slide.
  void start(Span v);
  /// Adds the forces at v by damping of all joints, and by dry friction of sliding joints, to the joint
  /// forces tau (nv numbers).
  void add_losses(Span v, std::span<double> tau) const;
  /// Finds the friction forces that depend on the accelerations, those of the velocities in resisting(), and
  /// adds their effect to the accelerations a (nv numbers), which must have been computed without them.
  /// `compliance` has the columns of Φ = ∂a/∂τ for the velocities in resisting(); `own` has, for each of
  /// them, the acceleration that a unit force on it causes in the tree without loops; `norm` gives the size
  /// of a, to which tolerances refer. `drive` has the part of the drive forces that passes through gears (nv
  /// numbers), and is not read if there are no gears with losses. Returns -1 or, if accelerations are not
  /// unique, the index of the velocity of a gear that locks itself too strongly.
  [[nodiscard]] int apply_friction(const Matrix& compliance, Span own, const EnergyNorm& norm, Span v,
                                   Span drive, std::span<double> a);
  /// Adds the losses of moving gears to the residuals r = ID(q, v, a) - τ (nv numbers) of the equations of
  /// motion, where ID is inverse dynamics and τ has all other joint forces (D9.13). `drive` has the part of
  /// the drive forces that passes through gears.
  void add_gear_losses(Span v, Span a, Span drive, std::span<double> r);
  /// Changes derivatives of the residuals r = ID(q, v, a) - τ to those of the residuals with the losses of
  /// the last add_gear_losses(). `derivatives` are nv × nv matrices [entry of r, direction]: first ∂r/∂a, and
  /// then derivatives by q or v. They must not yet contain the derivatives of drive forces and damping.
  void scale_derivatives(std::initializer_list<std::span<double>> derivatives) const;

  /// Changes derivatives of the accelerations, nv × nv matrices [acceleration, direction], to those under the
  /// condition that sticking velocities remain 0 (D9.7). The first of `derivatives` is ∂a/∂τ.
  void constrain_derivatives(std::initializer_list<std::span<double>> derivatives);

  /// The largest acceleration of a sticking velocity that apply_friction() has found since reset_violation(),
  /// relative to its tolerance (D9.6): more than 1 if friction cannot hold a joint.
  double violation() const { return violation_; }
  void reset_violation() { violation_ = 0; }
  /// Whether a sliding velocity changes its sign within a step of length h (s). The velocity in the step is
  /// taken as the cubic with v_0 and acceleration a_0 at the start of the step, and v_1 and a_1 at its end.
  bool reverses(Span v_0, Span a_0, Span v_1, Span a_1, double h) const;
  /// The time (s), to first order, until the first of the sliding velocities is 0; only those that decrease
  /// in magnitude count. It is negative if such a velocity has reversed already, and 0 if no sliding velocity
  /// decreases.
  double time_to_stop(Span v, Span a) const;

  /// Sets the velocities of sticking joints to 0. A sliding joint whose velocity is 0 or reversed, or will be
  /// within the time `within` (s) at its present acceleration, also gets the velocity 0; if it decelerates,
  /// it sticks from now on. Returns whether a joint began to stick.
  bool stop_sliding(std::span<double> v, Span a, double within);
  /// Lets those sticking joints slide from now on whose accelerations in a, as apply_friction() has computed
  /// them, are not 0. A joint slides in the direction of its acceleration.
  void start_sliding(Span a);

 private:
  struct Joint {
    int velocity;
    double friction;
    int direction;     ///< direction of sliding, 1 or -1; 0 while the joint sticks
    double force;      ///< the friction force while the joint sticks
    Gear gear = {};    ///< without losses if the joint has no such gear
    double slope = 0;  ///< derivative of the loss of a moving gear by the force that it transmits
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
  /// Factorises the rows and columns of A_ that belong to forces inside their bounds. Their diagonal is
  /// increased by 1e-12 `size`, where `size` is the magnitude of the entries of Φ, because Φ may be singular.
  void factorize(double size);
  /// Computes the friction forces x of sticking joints, beginning with the previous ones, and the
  /// accelerations a_0 + Φ x of the sticking velocities. `size` is the magnitude of the entries of Φ without
  /// loops.
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
