#pragma once
#include <Eigen/Core>
#include <initializer_list>
#include <span>
#include <vector>

#include "axode/constraints/loop_system/row_cholesky.hpp"
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
class DryFriction {
 public:
  using Span = std::span<const double>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// If `enabled` is false, no joint has friction.
  DryFriction(const Tree<double>& tree, bool enabled);

  /// Whether any joint has dry friction. If not, the functions for dynamics compute the losses.
  bool active() const { return !joints_.empty(); }
  /// The indices of the velocities that stick.
  const std::vector<int>& sticking() const { return sticking_; }

  /// Every joint slides in the direction of its velocity; joints at rest stick until start_sliding().
  void start(Span v);
  /// Adds the forces of damping, and of friction in sliding joints, to tau.
  void add_losses(Span v, std::span<double> tau) const;
  /// Changes a to the accelerations under the sticking forces. `compliance` has the columns of Φ of the
  /// velocities in sticking(), and `own` has their diagonal entries for the tree without loops; `norm`
  /// measures a.
  void apply_sticking_forces(const Matrix& compliance, Span own, const EnergyNorm& norm, std::span<double> a);

  /// Changes derivatives of the accelerations, [component, direction], to the derivatives under the condition
  /// that sticking velocities remain 0 (D9.7). The first of `derivatives` is ∂a/∂τ.
  void constrain_derivatives(std::initializer_list<std::span<double>> derivatives);

  /// The largest acceleration of a sticking velocity in apply_sticking_forces() since reset_violation(),
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
  /// Sticking velocities that have an acceleration after apply_sticking_forces() slide from now on.
  void start_sliding(Span a);

 private:
  struct Joint {
    int velocity;
    double friction;
    int direction;  ///< direction of sliding, 1 or -1; 0 while the joint sticks
    double force;   ///< the friction force while the joint sticks
  };
  static std::size_t at(Eigen::Index c) { return static_cast<std::size_t>(c); }
  Joint& sticking_joint(Eigen::Index i) { return joints_[sticking_joints_[at(i)]]; }
  void list_sticking();
  void factorize(double size);  ///< factorises the part of A of the forces inside their bounds; `size` is the
                                ///< size of Φ without loops
  /// Computes the sticking forces x, with the previous ones as the first guess, and the accelerations a = Φ x
  /// + a_0 of the sticking velocities.
  void find_forces(double size);

  const Tree<double>* tree_;
  std::vector<Joint> joints_;
  std::vector<int> sticking_;
  std::vector<std::size_t> sticking_joints_;  ///< indices of the joints, in the order of sticking()
  double violation_ = 0;

  Matrix A_;  ///< Φ of the sticking velocities
  Eigen::VectorXd a_0_, a_, tolerance_, step_;
  std::vector<char> bound_;
  std::vector<Eigen::Index> free_;
  RowCholesky<double> factor_;
};

}  // namespace axode
