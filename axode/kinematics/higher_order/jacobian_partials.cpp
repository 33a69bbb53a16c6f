#include "axode/kinematics/higher_order/jacobian_partials.hpp"

#include <limits>

#include "axode/kinematics/check_arguments.hpp"
#include "axode/kinematics/higher_order/screw_partials.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

/// The number nv^(order + 1) of columns of the tensor, or the largest std::size_t if this overflows.
std::size_t tensor_size(std::size_t nv, int order) {
  constexpr std::size_t largest = std::numeric_limits<std::size_t>::max();
  if (nv == 0) return 0;
  std::size_t size = nv;
  for (int k = 0; k < order; ++k) size = size > largest / nv ? largest : size * nv;
  return size;
}

}  // namespace

template <RecursionRepresentation Rep, class T>
void jacobian_partials(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                       const std::type_identity_t<Place<T>>& given, int order,
                       std::type_identity_t<std::span<Twist<Rep, T>>> J,
                       const std::function<bool()>& should_continue) {
  check_state(model, workspace, q);
  const Place<T> place = found(model, given);
  if (order < 0) throw std::invalid_argument("order is " + std::to_string(order) + "; expected 0 or more");
  check_size("J", J.size(), tensor_size(static_cast<std::size_t>(model.nv()), order), "nv^(order + 1)");
  check_separate("J", J, "q", q);
  for (Twist<Rep, T>& column : J) column = {};

  const ScrewPath<T> path(model.tree<T>(), q.data(), place);
  if (path.screws.empty()) return;
  const auto nv = static_cast<std::size_t>(model.nv());
  ScrewPartials<Rep, T>(path, order)
      .each(should_continue, [&](const std::vector<int>& alpha, int a, const Screw<T>& X) {
        std::size_t at = 0;
        for (std::size_t k = alpha.size(); k-- > 0;)
          at = at * nv + static_cast<std::size_t>(path.screws[static_cast<std::size_t>(alpha[k])].c);
        J[at * nv + static_cast<std::size_t>(path.screws[static_cast<std::size_t>(a)].c)] +=
            Twist<Rep, T>{X.w, X.v};
      });
}

template <RecursionRepresentation Rep, class T>
void jacobian_derivative_along(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                               const std::type_identity_t<Place<T>>& given, int order, Numbers<T> directions,
                               std::type_identity_t<std::span<Twist<Rep, T>>> J,
                               const std::function<bool()>& should_continue) {
  check_state(model, workspace, q);
  const Place<T> place = found(model, given);
  if (order < 0) throw std::invalid_argument("order is " + std::to_string(order) + "; expected 0 or more");
  check_size("directions", directions.size(),
             static_cast<std::size_t>(order) * static_cast<std::size_t>(model.nv()), "order nv");
  check_size("J", J.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_separate("J", J, "q", q);
  check_separate("J", J, "directions", directions);
  for (Twist<Rep, T>& column : J) column = {};
  const ScrewPath<T> path(model.tree<T>(), q.data(), place);
  DirectionalDerivatives<T> derivatives(path, order, directions.data(), model.nv(), should_continue);
  for (int a = 0; a < static_cast<int>(path.screws.size()) && !derivatives.stopped(); ++a) {
    const Screw<T> X = derivatives.template of<Rep>(a);
    J[path.screws[a].c] += Twist<Rep, T>{X.w, X.v};
  }
}

template decltype(jacobian_partials<AXODE_REP, AXODE_T>) jacobian_partials<AXODE_REP, AXODE_T>;
template decltype(jacobian_derivative_along<AXODE_REP, AXODE_T>)
    jacobian_derivative_along<AXODE_REP, AXODE_T>;

}  // namespace axode
