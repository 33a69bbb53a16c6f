#include "axode/derivatives/rates.hpp"

#include "axode/derivatives/displacement/accelerations.hpp"
#include "axode/derivatives/displacement/force_series.hpp"
#include "axode/derivatives/displacement/scratch.hpp"
#include "axode/derivatives/second_order/more_second_order_recursions.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {

template <class T>
InverseDynamicsRates<T>::InverseDynamicsRates(const Model& model, int order) : model_(model) {
  catalog::check_counts<"inverse_dynamics_rates">(model, catalog::Caller::workspace);
  if (order < 0)
    throw std::invalid_argument("order is " + std::to_string(order) +
                                "; it must not be negative (0 is the force)");
  series_ = std::make_unique<ForceSeries<T>>(model_.tree<T>(), order);
}
template <class T> InverseDynamicsRates<T>::~InverseDynamicsRates() = default;
template <class T> InverseDynamicsRates<T>::InverseDynamicsRates(InverseDynamicsRates&&) noexcept = default;
template <class T>
InverseDynamicsRates<T>& InverseDynamicsRates<T>::operator=(InverseDynamicsRates&&) noexcept = default;

template <class T> int InverseDynamicsRates<T>::order() const { return series_->order(); }

template <class T>
void InverseDynamicsRates<T>::evaluate(Numbers<T> q, Numbers<T> rates, std::type_identity_t<std::span<T>> tau,
                                       const std::type_identity_t<Loads<T>>& loads) {
  check_configuration(model_, q);
  check_loads(model_, loads);
  const std::size_t nv = static_cast<std::size_t>(model_.nv()),
                    order = static_cast<std::size_t>(this->order());
  check_size("rates", rates.size(), (order + 2) * nv, "(order + 2) nv");
  check_size("tau", tau.size(), (order + 1) * nv, "(order + 1) nv");
  check_separate("tau", tau, "rates", std::span<const T>(rates));
  series_->run(model_.tree<T>(), q.data(), rates.data(), loads, tau.data());
}

template <class T>
Solvability forward_dynamics_rates(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                   Numbers<T> forces, std::type_identity_t<std::span<T>> rates,
                                   const std::type_identity_t<Loads<T>>& loads) {
  catalog::check_counts<"forward_dynamics_rates">(model);
  check_state(model, workspace, q, v);
  check_loads(model, loads);
  check_size("rates", rates.size(), forces.size(), "as many as forces");
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  const std::size_t rows = nv == 0 ? 0 : forces.size() / nv;
  if (rows * nv != forces.size())
    throw std::invalid_argument("forces has " + std::to_string(forces.size()) +
                                " numbers; they come in rows of nv = " + std::to_string(nv));
  if (rows == 0) return {};
  const Tree<T>& tree = model.tree<T>();
  Arena arena = workspace.arena(model.topology());
  AccelerationsAndColumns<T> solver(arena);
  Solvability verdict = solver.run(tree, q.data(), v.data(), forces.data(), loads);
  std::vector<T> motion((rows + 1) * nv), found(rows * nv);  // v, a, jerk, ...
  std::copy(v.begin(), v.end(), motion.begin());
  std::copy_n(solver.a, nv, motion.begin() + static_cast<std::ptrdiff_t>(nv));
  for (std::size_t k = 1; k < rows && verdict.ok(); ++k) {
    ForceSeries<T> series(tree, static_cast<int>(k));
    series.run(tree, q.data(), motion.data(), loads, found.data());
    T* const next = motion.data() + (k + 1) * nv;
    for (std::size_t c = 0; c < nv; ++c) next[c] = forces[k * nv + c] - found[k * nv + c];
    solver.solve_one(tree, next);
  }
  std::copy(motion.begin() + static_cast<std::ptrdiff_t>(nv), motion.end(), rates.begin());
  return solved(verdict, static_cast<std::ptrdiff_t>(rates.size()), rates.data());
}

template <class Rep, class T>
void second_order_inverse_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                   Numbers<T> rates, std::type_identity_t<std::span<T>> tau,
                                   const std::type_identity_t<Loads<T>>& loads) {
  catalog::check_counts<"inverse_dynamics_rates">(model, catalog::Caller::workspace);
  check_state(model, workspace, q);
  check_loads(model, loads);
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  check_size("rates", rates.size(), 4 * nv, "4 nv");
  check_size("tau", tau.size(), 3 * nv, "3 nv");
  check_separate("tau", tau, "rates", std::span<const T>(rates));
  static_assert(
      sizeof(typename SecondOrderRecursion<Rep, T>::Body) <=
      sizeof(typename SecondOrderRecursion<BodyFixed, T>::Body));  // a workspace has memory for these
  Arena arena = workspace.arena(model.topology());
  SecondOrderRecursion<Rep, T>(arena).run(model.tree<T>(), q.data(), rates.data(), loads, tau.data());
}

template class InverseDynamicsRates<AXODE_T>;
template AXODE_ENTRY decltype(second_order_inverse_dynamics<BodyFixed, AXODE_T>)
    second_order_inverse_dynamics<BodyFixed, AXODE_T>;
template AXODE_ENTRY decltype(second_order_inverse_dynamics<Spatial, AXODE_T>)
    second_order_inverse_dynamics<Spatial, AXODE_T>;
template AXODE_ENTRY decltype(second_order_inverse_dynamics<Hybrid, AXODE_T>)
    second_order_inverse_dynamics<Hybrid, AXODE_T>;
template AXODE_ENTRY decltype(second_order_inverse_dynamics<Mixed, AXODE_T>)
    second_order_inverse_dynamics<Mixed, AXODE_T>;
template AXODE_ENTRY decltype(forward_dynamics_rates<AXODE_T>) forward_dynamics_rates<AXODE_T>;

}  // namespace axode
