#pragma once
#include <Eigen/Core>
#include <initializer_list>
#include <span>
#include <vector>

#include "axode/constraints/row_cholesky.hpp"
#include "axode/integration/schemes/energy_norm.hpp"
#include "axode/model/tree.hpp"

namespace axode {

/// Losses of joints, of which Coulomb friction is any force in -f Sgn(v_c): a velocity v_c slides one way under a force that
/// is constant, or sticks, v_c = 0, under whatever force up to f holds it. Which way is part of the state of a
/// motion: it is kept through a step, so that forces are smooth there, and changes at the end of one.
///
/// Forces x of those that stick make the accelerations a + Φ x with Φ = ∂a/∂τ. They are those of Gauss' principle, the least
/// of x·(Φ x/2 + a) with |x_c| ≤ f_c: either a_c = 0, or x_c is at its bound against a_c.
class DryFriction {
 public:
  using Span = std::span<const double>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Without joints where losses are not felt.
  DryFriction(const Tree<double>& tree, bool enabled);

  /// Whether any joint has dry friction; otherwise losses are left to the dynamics.
  bool active() const { return !joints_.empty(); }
  /// Velocities that stick.
  const std::vector<int>& sticking() const { return sticking_; }

  /// Every joint slides the way it moves; those at rest stick until release().
  void start(Span v);
  /// Damping, and friction of what slides.
  void add_losses(Span v, std::span<double> tau) const;
  /// Takes a to the accelerations with what sticks held; `compliance` are the columns of Φ that belong to sticking(), `own` what
  /// each would be on its diagonal without loops; `norm` measures a.
  void apply_sticking_forces(const Matrix& compliance, Span own, const EnergyNorm& norm, std::span<double> a);

  /// Takes derivatives of accelerations, [component, direction] and ∂a/∂τ first, to those with what sticks held.
  void constrain_derivatives(std::initializer_list<std::span<double>> derivatives);

  /// The largest acceleration of what sticks that hold() has found since watch(), by what is told from none: more than 1 where
  /// a joint cannot be held.
  double violation() const { return violation_; }
  void reset_violation() { violation_ = 0; }
  /// Whether what slides has turned between two ends of a step of length h, at its end or before.
  bool reverses(Span v_0, Span a_0, Span v_1, Span a_1, double h) const;
  /// When, to first order, the next that slides comes to rest from v and a, forwards or, where it has turned, backwards; 0 where
  /// none does.
  double time_to_stop(Span v, Span a) const;

  /// v_c = 0 of what sticks, and of what came to rest less than a time ago or will sooner than that, which sticks now; whether
  /// there is any.
  bool stop_sliding(std::span<double> v, Span a, double within);
  /// What could not be held by the last hold(), which found a, slides from now on.
  void start_sliding(Span a);

 private:
  struct Joint {
    int velocity;
    double friction;
    int direction;  ///< in which it slides, 1 or -1; 0: it sticks
    double force;   ///< under which it sticks
  };
  static std::size_t at(Eigen::Index c) { return static_cast<std::size_t>(c); }
  Joint& sticking_joint(Eigen::Index i) { return joints_[sticking_joints_[at(i)]]; }
  void list_sticking();
  void factorize(double size);  ///< A, of that size without loops, of what is free
  /// Forces of what sticks, from those of before, and a = Φ x + a_0 there.
  void find_forces(double size);

  const Tree<double>* tree_;
  std::vector<Joint> joints_;
  std::vector<int> sticking_;
  std::vector<std::size_t> sticking_joints_;  ///< which of the joints, in the order of sticking()
  double violation_ = 0;

  Matrix A_;  ///< of what sticks
  Eigen::VectorXd a_0_, a_, tolerance_, step_;
  std::vector<char> bound_;
  std::vector<Eigen::Index> free_;
  RowCholesky<double> factor_;
};

}  // namespace axode
