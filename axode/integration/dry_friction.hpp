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

/// Losses of joints with Coulomb friction: a velocity v_c either slides in one direction under the constant
/// force -f sign(v_c), or it sticks, v_c = 0, under any force up to f (D9.1). The direction of sliding is a
/// part of the state: it is constant within a step, so that forces are smooth there, and changes at the end
/// of a step.
///
/// The forces x of sticking velocities change the accelerations to a + Φ x with Φ = ∂a/∂τ. By Gauss'
/// principle they minimise x·(Φ x/2 + a) under |x_c| ≤ f_c (D9.4): either a_c = 0, or x_c is at its bound and
/// opposes a_c.
///
/// The loss of a gear is dry friction whose bound depends on the force that the gear transmits, and so on a.
/// If joints have such gears, x is found by ResistingForces, for sticking velocities and for moving gears.
class DryFriction {
 public:
  using Span = std::span<const double>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// If `enabled` is false, no joint has friction.
  DryFriction(const Tree<double>& tree, std::span<const Gear> gears, bool enabled);

  /// Whether any joint has dry friction or a gear with losses. If not, the functions for dynamics compute the
  /// losses.
  bool active() const { return !joints_.empty(); }
  /// The indices of the velocities that stick.
  const std::vector<int>& sticking() const { return sticking_; }
  /// The indices of the velocities whose friction depends on the accelerations: those that stick, and those
  /// of gears.
  const std::vector<int>& resisting() const { return resisting_; }
  bool has_gears() const { return has_gears_; }

  /// Every joint slides in the direction of its velocity; joints at rest stick until start_sliding().
  void start(Span v);
  /// Adds the forces of damping, and of dry friction in sliding joints, to tau.
  void add_losses(Span v, std::span<double> tau) const;
  /// Changes a to the accelerations under the friction of resisting(). `compliance` has the columns of Φ of
  /// these velocities, and `own` has their diagonal entries for the tree without loops; `norm` measures a.
  /// `drive` has the forces that pass through gears, if there are any. Returns -1 or, if accelerations are
  /// not unique, the velocity of a gear that locks itself too strongly.
  [[nodiscard]] int apply_friction(const Matrix& compliance, Span own, const EnergyNorm& norm, Span v,
                                   Span drive, std::span<double> a);
  /// Adds the losses of moving gears to the residuals r of inverse dynamics at (v, a), from which all other
  /// forces have been subtracted (D9.13).
  void add_gear_losses(Span v, Span a, Span drive, std::span<double> r);
  /// Changes the derivatives of these residuals without drives and damping, [component, direction], to those
  /// with the losses of the last add_gear_losses(). The first of `derivatives` is that by a.
  void scale_derivatives(std::initializer_list<std::span<double>> derivatives) const;

  /// Changes derivatives of the accelerations, [component, direction], to the derivatives under the condition
  /// that sticking velocities remain 0 (D9.7). The first of `derivatives` is ∂a/∂τ.
  void constrain_derivatives(std::initializer_list<std::span<double>> derivatives);

  /// The largest acceleration of a sticking velocity in apply_friction() since reset_violation(),
  /// relative to the tolerance (D9.6): more than 1 if friction cannot hold a joint.
  double violation() const { return violation_; }
  void reset_violation() { violation_ = 0; }
  /// Whether a sliding velocity has reversed within a step of length h with these states at its ends.
  bool reverses(Span v_0, Span a_0, Span v_1, Span a_1, double h) const;
  /// The time, to first order, until the first sliding velocity is 0. It is negative if a velocity has
  /// reversed already, and 0 if no joint slides.
  double time_to_stop(Span v, Span a) const;

  /// Sets sticking velocities to 0. Sliding velocities that have come to rest, or will do so within the time
  /// `within`, stick from now on; returns whether there was one.
  bool stop_sliding(std::span<double> v, Span a, double within);
  /// Sticking velocities that have an acceleration after apply_friction() slide from now on.
  void start_sliding(Span a);

 private:
  struct Joint {
    int velocity;
    double friction;
    int direction;     ///< direction of sliding, 1 or -1; 0 while the joint sticks
    double force;      ///< the friction force while the joint sticks
    Gear gear = {};    ///< without losses if there is no such gear
    double slope = 0;  ///< derivative of the loss of a moving gear by F
  };
  static std::size_t at(Eigen::Index c) { return static_cast<std::size_t>(c); }
  Joint& sticking_joint(Eigen::Index i) { return joints_[sticking_joints_[at(i)]]; }
  void list_sticking();
  /// The drive force less damping and friction. This force accelerates the rotor, passes through the gear and
  /// overcomes its loss.
  double through_gear(const Joint& joint, Span v, Span drive) const {
    const std::size_t c = at(joint.velocity);
    return drive[c] - tree_->damping[c] * v[c] - joint.direction * joint.friction;
  }
  int apply_with_gears(const Matrix& compliance, Span own, const EnergyNorm& norm, Span v, Span drive,
                       std::span<double> a);
  void factorize(double size);  ///< factorises the part of A of the forces inside their bounds; `size` is the
                                ///< size of Φ without loops
  /// Computes the sticking forces x, with the previous ones as the first guess, and the accelerations a = Φ x
  /// + a_0 of the sticking velocities.
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

  Matrix A_;  ///< Φ of the sticking velocities
  Eigen::VectorXd a_0_, a_, tolerance_, step_;
  std::vector<char> bound_;
  std::vector<Eigen::Index> free_;
  RowCholesky<double> factor_;
};

}  // namespace axode
