#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/constraints/loops/loop_table.hpp"
#include "axode/kinematics/higher_order/motion_series.hpp"
#include "axode/scalar/taylor.hpp"

namespace axode {

/// The Jacobian A of the loop equations A v = 0 and its time derivatives A', A'', ... along a motion of the
/// spanning tree, by power series in time of the joint screws and of the frames of the loops (D3.13, D3.14).
class LoopSeries {
 public:
  static constexpr int largest_order = 7;

  /// Prepares the derivatives of A up to an order of at most largest_order.
  LoopSeries(const Model& model, int order);

  int order() const { return motion_.order(); }

  /// Computes the Jacobian A of the loop equations and its time derivatives up to A^(order), from q and
  /// `rates`, which are v, v', ... (order + 1 rows of nv numbers). The last row of `rates` has no effect.
  void run(const double* q, const double* rates) noexcept;

  /// The time derivative A^(k) of the Jacobian of the loop equations that the last run() computed,
  /// loops().rows × nv.
  const Eigen::MatrixXd& derivative(int k) const { return A_[static_cast<std::size_t>(k)]; }
  /// Computes the time derivative (A v)^(k) of the loop equations A v = 0, without its term A v^(k).
  Eigen::VectorXd known_terms(const double* rates, int k) const;

 private:
  using Series = Taylor<double, largest_order + 1>;

  /// about() returns the power series in time of a joint screw about a fixed point O, from the coefficients X
  /// of its power series about the position at t = 0 of the origin of its root body (the first body on the
  /// path from the ground). `shift` is the constant vector from O to this position. frame_series() returns
  /// the power series of the frame of a loop joint, with the position relative to O.
  Screw<Series> about(const Vec3<>& shift, const Screw<>* X) const;
  SE3<Series> frame_series(const Loop::End& end, const Vec3<>& shift);

  Model model_;
  LoopTable table_;
  MotionSeries<double> motion_;
  PoseSeries<double> pose_;
  std::vector<Vec3<>> origin_;  ///< origin of each root body, at the index of the body; 0 for the ground
  std::vector<Eigen::MatrixXd> A_;
};

}  // namespace axode
