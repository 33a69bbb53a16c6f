#pragma once
#include <memory>

#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/scalar/instruction_set.hpp"

/// Motion of higher order: jerk, snap and all further time derivatives, also those of Jacobians.
namespace axode {

template <class T> class MotionSeries;
template <class T> class PoseSeries;

/// The motion of all bodies of a model as power series in time. The order is that of the highest rate: 0 for
/// velocities, 1 for accelerations, 2 for jerks, and so on. An object serves one thread and can be evaluated
/// many times without allocation.
template <class T = double> class AXODE_ENTRY HigherOrderMotion {
 public:
  /// Throws std::invalid_argument for a negative order.
  HigherOrderMotion(const Model& model, int order);
  ~HigherOrderMotion();
  HigherOrderMotion(HigherOrderMotion&&) noexcept;
  HigherOrderMotion& operator=(HigherOrderMotion&&) noexcept;

  int order() const;

  /// Computes the poses of all bodies, and the twists of bodies and the joint screws with their time
  /// derivatives up to `order`. They are stored in this object, for twist_derivative() and
  /// jacobian_derivative(). `rates` has v, v', v'', ... in the joints' left-trivialised directions,
  /// (order + 1) rows of nv numbers. O(n order²).
  void evaluate(Numbers<T> q, Numbers<T> rates);

  /// The k-th time derivative, k = 0 to `order`, of the components of the twist of a place (a frame on a
  /// body). Jerk and snap of a point are the linear parts of the hybrid derivatives for k = 2 and 3.
  template <RecursionRepresentation Rep = BodyFixed>
  TwistRate<Rep, T> twist_derivative(const Place<T>& place, int k) const;

  /// The k-th time derivative (0 to `order`) of the Jacobian, nv columns, of a place (a frame on a body).
  template <RecursionRepresentation Rep = BodyFixed>
  void jacobian_derivative(const Place<T>& place, int k, std::span<TwistRate<Rep, T>> J) const;

 private:
  Model model_;
  std::unique_ptr<MotionSeries<T>> series_;
  std::unique_ptr<PoseSeries<T>> pose_;
};

}  // namespace axode
