#include "axode/kinematics/higher_order/higher_order.hpp"

#include "axode/kinematics/check_arguments.hpp"
#include "axode/kinematics/higher_order/motion_series.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

template <class T> T factorial(int k) {
  T f(1);
  for (int j = 2; j <= k; ++j) f = f * T(j);
  return f;
}

}  // namespace

template <class T> HigherOrderMotion<T>::HigherOrderMotion(const Model& model, int order) : model_(model) {
  if (order < 0)
    throw std::invalid_argument("order is " + std::to_string(order) +
                                "; it must not be negative (0 is velocity)");
  series_ = std::make_unique<MotionSeries<T>>(model.tree<T>(), order);
  pose_ = std::make_unique<PoseSeries<T>>(order);
}
template <class T> HigherOrderMotion<T>::~HigherOrderMotion() = default;
template <class T> HigherOrderMotion<T>::HigherOrderMotion(HigherOrderMotion&&) noexcept = default;
template <class T>
HigherOrderMotion<T>& HigherOrderMotion<T>::operator=(HigherOrderMotion&&) noexcept = default;

template <class T> int HigherOrderMotion<T>::order() const { return series_->order(); }

template <class T> void HigherOrderMotion<T>::evaluate(Numbers<T> q, Numbers<T> rates) {
  check_configuration(model_, q);
  check_size("rates", rates.size(), static_cast<std::size_t>((order() + 1) * model_.nv()), "(order + 1) nv");
  series_->run(model_.tree<T>(), q.data(), rates.data());
}

template <class T>
template <RecursionRepresentation Rep>
TwistRate<Rep, T> HigherOrderMotion<T>::twist_derivative(const Place<T>& given, int k) const {
  const Place<T> place = found(model_, given);
  check_order(k, order());
  const Tree<T>& tree = model_.tree<T>();
  const int i = tree->frame_body[place.frame];
  pose_->run(k, series_->twist(i), series_->pose(i) * tree.frame_offset[place.frame] * place.offset);
  const Screw<T> V_k = factorial<T>(k) * pose_->template coefficient<Rep>(series_->twist(i), k);
  return {V_k.w, V_k.v};
}

template <class T>
template <RecursionRepresentation Rep>
void HigherOrderMotion<T>::jacobian_derivative(const Place<T>& given, int k,
                                               std::span<TwistRate<Rep, T>> J) const {
  const Place<T> place = found(model_, given);
  check_order(k, order());
  check_size("J", J.size(), static_cast<std::size_t>(model_.nv()), "nv");
  const Tree<T>& tree = model_.tree<T>();
  const int body = tree->frame_body[place.frame];
  pose_->run(k, series_->twist(body), series_->pose(body) * tree.frame_offset[place.frame] * place.offset);
  for (TwistRate<Rep, T>& column : J) column = {};
  for (int i = body; i > 0; i = tree->parent[i])
    for (int s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s) {
      const Screw<T> J_k = factorial<T>(k) * pose_->template coefficient<Rep>(series_->screw(s), k);
      J[tree->iv[i] + s - tree->first_screw[i]] += TwistRate<Rep, T>{J_k.w, J_k.v};
    }
}

template class HigherOrderMotion<AXODE_T>;
template AXODE_ENTRY TwistRate<BodyFixed, AXODE_T> HigherOrderMotion<AXODE_T>::twist_derivative<BodyFixed>(
    const Place<AXODE_T>&, int) const;
template AXODE_ENTRY void HigherOrderMotion<AXODE_T>::jacobian_derivative<BodyFixed>(
    const Place<AXODE_T>&, int, std::span<TwistRate<BodyFixed, AXODE_T>>) const;
template AXODE_ENTRY TwistRate<Spatial, AXODE_T> HigherOrderMotion<AXODE_T>::twist_derivative<Spatial>(
    const Place<AXODE_T>&, int) const;
template AXODE_ENTRY void HigherOrderMotion<AXODE_T>::jacobian_derivative<Spatial>(
    const Place<AXODE_T>&, int, std::span<TwistRate<Spatial, AXODE_T>>) const;
template AXODE_ENTRY TwistRate<Hybrid, AXODE_T> HigherOrderMotion<AXODE_T>::twist_derivative<Hybrid>(
    const Place<AXODE_T>&, int) const;
template AXODE_ENTRY void HigherOrderMotion<AXODE_T>::jacobian_derivative<Hybrid>(
    const Place<AXODE_T>&, int, std::span<TwistRate<Hybrid, AXODE_T>>) const;
template AXODE_ENTRY TwistRate<Mixed, AXODE_T> HigherOrderMotion<AXODE_T>::twist_derivative<Mixed>(
    const Place<AXODE_T>&, int) const;
template AXODE_ENTRY void HigherOrderMotion<AXODE_T>::jacobian_derivative<Mixed>(
    const Place<AXODE_T>&, int, std::span<TwistRate<Mixed, AXODE_T>>) const;

}  // namespace axode
