#include <algorithm>
#include <tuple>
#include <vector>

#include "axode/catalog.hpp"
#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/constrained_derivatives.hpp"
#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/constraints/constrained_operational_space.hpp"
#include "axode/derivatives.hpp"
#include "axode/dynamics.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode::catalog {
namespace {

using Rep = AXODE_REP;
using T = AXODE_T;
using Out = std::span<T>;
using Given = std::span<const T>;

constexpr bool fast = std::same_as<Rep, Fast>;
/// Rep, or a placeholder if Rep is Fast, for functions that must have one of the four representations.
using R4 = std::conditional_t<fast, BodyFixed, Rep>;
/// The representation that a function of this choice takes as its template argument, if any.
template <Choice choice>
using Chosen = std::conditional_t<choice == Choice::none, std::tuple<>,
                                  std::tuple<std::conditional_t<choice == Choice::recursion, Rep, R4>>>;

// Functions that C++ has under another name or with other parameters.

template <class...> SE3<T> pose(const Model& m, Workspace<T>& w, Given q, const Place<T>& place) {
  SE3<T> C;
  poses(m, w, q, std::span(&place, 1), std::span(&C, 1));
  return C;
}
template <class In>
void jacobian_rate(const Model& m, Workspace<T>& w, Given q, Given v, const Place<T>& place,
                   std::span<Twist<In, T>> dJ) {
  jacobian_derivative_along<In>(m, w, q, place, 1, v, dJ);
}
/// Throws std::invalid_argument if `left` is above 1e-8. `left` is the part of the required forces that no
/// drive can produce, as a ratio of norms. In single precision nothing is checked, because `left` cannot be
/// distinguished from rounding errors.
void check(T left) {
  if constexpr (std::same_as<T, double>) check_driven(left, "make these accelerations");
}
template <class...>
void inverse_dynamics(const Model& m, LoopWorkspace<T>& w, Given q, Given v, Given a, Out tau,
                      const Loads<T>& loads) {
  check(inverse_dynamics(m, w, q, v, a, tau, {}, {}, loads));
}
template <class...>
Solvability forward_dynamics(const Model& m, LoopWorkspace<T>& w, Given q, Given v, Given tau, Out a,
                             const Loads<T>& loads) {
  return forward_dynamics(m, w, q, v, tau, a, {}, loads);
}
template <class In>
void joint_wrenches(const Model& m, LoopWorkspace<T>& w, Given q, Given v, Given a,
                    std::span<Wrench<In, T>> W, const Loads<T>& loads, WrenchPoint at) {
  check(joint_wrenches<In>(m, w, q, v, a, W, {}, loads, at));
}

template <class...>
Solvability momentum_form(const Model& m, Workspace<T>& w, Given q, Given p, Given tau,
                          const std::array<Out, 2>& rates, const Loads<T>& loads) {
  return momentum_form(m, w, q, p, tau, rates[0], rates[1], loads);
}

/// The memory of n results of equal size. It converts to the type of the parameter through which a function
/// returns its results. For n = 1 this is a span of entries such as numbers or twists, and for n > 1 a struct
/// or array of n spans.
template <std::size_t n> struct Results {
  std::array<Out, n> each;

  template <class E>
    requires(n == 1)
  operator std::span<E>() const {  // NOLINT(google-explicit-constructor): an argument
    static_assert(sizeof(E) % sizeof(T) == 0);
    return {reinterpret_cast<E*>(each[0].data()), each[0].size() / (sizeof(E) / sizeof(T))};
  }
  template <class S>
    requires(n > 1)
  operator S() const {  // NOLINT(google-explicit-constructor): an argument
    return std::apply([](const auto&... one) { return S{Results<1>{one}...}; }, each);
  }
};

/// The argument for an input.
template <Input input> const auto& argument(const Arguments<T>& given) {
  if constexpr (is_of_numbers(input)) return given.*member_of<T>(input);
  if constexpr (input == Input::loads) return given.loads;
  if constexpr (input == Input::place) return given.place;
  if constexpr (input == Input::base) return given.base;
  if constexpr (input == Input::form) return given.form;
  if constexpr (input == Input::at) return given.at;
}

/// Calls F, the library's function of the row `id` of the catalogue. The arguments of F are the model, the
/// workspace, the inputs in the order of the row, and the results. The loads (external wrenches) are one of
/// the inputs of some functions. The results then come before the loads if F has its parameters in this
/// order; otherwise they come last. A single result such as a pose is the return value of F instead.
template <Id id, class F, class W>
Solvability call(const Model& m, W& w, const Arguments<T>& given, Out out) {
  constexpr const Words& words = id.words();
  constexpr std::size_t n = words.symbols.size(), inputs = words.takes.size();
  constexpr auto loads = static_cast<std::size_t>(
      std::find(words.takes.begin(), words.takes.end(), Input::loads) - words.takes.begin());
  const auto run = [&](const auto&... x) -> Solvability {
    const auto called = [&] { return F()(Chosen<words.choice>(), m, w, x...); };
    using Returned = decltype(called());
    static_assert(words.may_fail == std::same_as<Returned, Solvability>, "a function that may fail says so");
    if constexpr (words.may_fail) {
      return called();
    } else {
      if constexpr (words.shape.empty())
        std::span<Returned>(Results<1>{out})[0] = called();
      else
        called();
      return {};
    }
  };
  return [&]<std::size_t... b, std::size_t... l, std::size_t... r>(
      std::index_sequence<b...>, std::index_sequence<l...>, std::index_sequence<r...>) {
    constexpr const List<Input, 8>& takes = id.words().takes;
    const Results<n> results{out.subspan(r * (out.size() / n), out.size() / n)...};
    if constexpr (words.shape.empty())
      return run(argument<takes[b]>(given)..., argument<takes[loads + l]>(given)...);
    else if constexpr (std::is_invocable_v<F, Chosen<words.choice>, const Model&, W&,
                                           decltype(argument<takes[b]>(given))..., const Results<n>&,
                                           decltype(argument<takes[loads + l]>(given))...>)
      return run(argument<takes[b]>(given)..., results, argument<takes[loads + l]>(given)...);
    else
      return run(argument<takes[b]>(given)..., argument<takes[loads + l]>(given)..., results);
  }
  (std::make_index_sequence<loads>(), std::make_index_sequence<inputs - loads>(),
   std::make_index_sequence<n>());
}

/// Makes a row of the catalogue with pointers that call the function F.
template <Id id, class F> Function<T> row(const F&) {
  Function<T> made{id.words(), call<id, F, Workspace<T>>, nullptr};
  if constexpr (id.words().counts.loops.word == Word::counted)
    made.call_with_loops = call<id, F, LoopWorkspace<T>>;
  return made;
}

std::vector<Function<T>> make() {
  return {
#define AXODE_ROW(function, ...)                                                                      \
  row<#function>([]<class... In>(std::tuple<In...>, auto&&... x) -> decltype(function<In...>(x...)) { \
    return function<In...>(x...);                                                                     \
  }),
#include "axode/table/rows.hpp"
  };
}

const std::vector<Function<T>>& all() {
  static const std::vector<Function<T>> functions = [] {
    std::vector<Function<T>> made = make();
    if (fast) std::erase_if(made, [](const Function<T>& f) { return f.choice == Choice::representation; });
    return made;
  }();
  return functions;
}

}  // namespace

template <> std::span<const Function<T>> functions<Rep, T>() { return all(); }
template <> const Function<T>* find<Rep, T>(std::string_view name) {
  const auto found =
      std::find_if(all().begin(), all().end(), [&](const Function<T>& f) { return f.name == name; });
  return found == all().end() ? nullptr : &*found;
}

}  // namespace axode::catalog
