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
using enum Input;
using enum Entry;
using enum Extent;
using W = Workspace<T>;
using G = Arguments<T>;
using Out = std::span<T>;

constexpr bool fast = std::same_as<Rep, Fast>;
/// Rep, or a placeholder if Rep is Fast, for functions that must have one of the four representations.
using R4 = std::conditional_t<fast, BodyFixed, Rep>;

/// The memory `out` of a result as a span of entries E, such as twists or poses.
template <class E> std::span<E> as(Out out) {
  static_assert(sizeof(E) % sizeof(T) == 0);
  return {reinterpret_cast<E*>(out.data()), out.size() / (sizeof(E) / sizeof(T))};
}
template <class E> void put(const E& result, Out out) { as<E>(out)[0] = result; }

/// The memory of result k in the memory `out` of n results of equal size.
Out part(Out out, std::size_t k, std::size_t n) { return out.subspan(k * (out.size() / n), out.size() / n); }

/// A function pointer that calls the function object F and returns its Solvability (whether and why it
/// failed), the default one, success, if F cannot fail.
template <class F, class Scratch> constexpr auto call(const F&) {
  static_assert(std::is_empty_v<F>);
  return [](const Model& m, Scratch& w, const G& g, Out out) -> Solvability {
    if constexpr (std::same_as<decltype(F()(m, w, g, out)), Solvability>) {
      return F()(m, w, g, out);
    } else {
      F()(m, w, g, out);
      return {};
    }
  };
}

/// Makes a row of the table of functions, with a pointer that calls the function object F. If the function
/// takes loops into account, a second pointer, for calls with a LoopWorkspace, calls L, which is F by
/// default.
template <Id id, class F, class L = F> Function<T> row(const F& of_tree, const L& = {}) {
  constexpr const Words& words = id.words();
  constexpr bool counts_loops = words.counts.loops.word == Word::counted;
  static_assert(counts_loops || std::same_as<L, F>, "this row does not count loops");
  static_assert(
      words.may_fail == std::same_as<decltype(of_tree(std::declval<const Model&>(), std::declval<W&>(),
                                                      std::declval<const G&>(), Out())),
                                     Solvability>,
      "a function that may fail says so");
  Function<T> made{words, call<F, W>(of_tree), nullptr};
  if constexpr (counts_loops) made.call_with_loops = call<L, LoopWorkspace<T>>({});
  return made;
}

/// The memory `out` of n results of equal size, which converts to any struct of n spans.
template <class E, std::size_t n> struct Several {
  Out out;
  template <class S> operator S() const {  // NOLINT(google-explicit-constructor): an argument becomes it
    return [this]<std::size_t... k>(std::index_sequence<k...>) { return S{as<E>(part(out, k, n))...}; }
    (std::make_index_sequence<n>());
  }
};

/// The C++ type of the entries of a result, such as twists; `In` is their representation.
template <Entry entry, class In> auto type_of() {
  if constexpr (entry == number) return std::type_identity<T>();
  if constexpr (entry == vector) return std::type_identity<Vec3<T>>();
  if constexpr (entry == pose) return std::type_identity<SE3<T>>();
  if constexpr (entry == twist) return std::type_identity<Twist<In, T>>();
  if constexpr (entry == rate) return std::type_identity<TwistRate<In, T>>();
  if constexpr (entry == wrench) return std::type_identity<Wrench<In, T>>();
  if constexpr (entry == momentum) return std::type_identity<Momentum<In, T>>();
}

/// Makes a row for a function with the parameters model, workspace, arrays and frames that the row names,
/// results and loads, in this order. A result that is a single entry, such as one pose, is returned instead.
template <Id id, class F> Function<T> in_order(const F&) {
  return row<id>([](auto& m, auto& w, auto& g, auto out) {
    constexpr const Words& words = id.words();
    const auto numbers_of_state = [&]<std::size_t... k>(std::index_sequence<k...>) {
      return std::tuple(g.*member_of<T>(id.words().numbers()[k])...);
    }
    (std::make_index_sequence<words.numbers().size()>());
    const auto frame = [&] {
      if constexpr (words.takes_input(base))
        return std::tie(g.place, g.base);
      else if constexpr (words.takes_input(place))
        return std::tie(g.place);
      else
        return std::tuple();
    }();
    const auto call = [&](const auto&... rest) {
      return std::apply([](auto&&... x) { return F()(x...); },
                        std::tuple_cat(std::tie(m, w), numbers_of_state, frame, std::tie(rest...)));
    };
    if constexpr (words.shape.empty()) {
      put(call(), out);
    } else {
      using In = std::conditional_t<words.choice == Choice::representation, R4, Hybrid>;
      using E = typename decltype(type_of<words.entry, In>())::type;
      constexpr std::size_t several = words.symbols.size();
      const auto results = [&] {
        if constexpr (several == 1)
          return as<E>(out);
        else
          return Several<E, several>{out};
      }();
      if constexpr (words.takes_input(loads))
        return call(results, g.loads);
      else
        return call(results);
    }
  });
}

std::vector<Function<T>> make() {
  return {
      in_order<"poses">([](auto&&... x) { return poses(x...); }),
      row<"pose">([](auto& m, auto& w, auto& g, auto out) {
        poses(m, w, g.q, std::span<const Place<T>>(&g.place, 1), as<SE3<T>>(out));
      }),
      in_order<"twists">([](auto&&... x) { return twists<R4>(x...); }),
      in_order<"accelerations">([](auto&&... x) { return accelerations<R4>(x...); }),
      in_order<"jacobian">([](auto&&... x) { return jacobian<R4>(x...); }),
      in_order<"jacobians">([](auto&&... x) { return jacobians<R4>(x...); }),
      row<"jacobian_rate">([](auto& m, auto& w, auto& g, auto out) {
        jacobian_derivative_along<R4>(m, w, g.q, g.place, 1, g.v, as<Twist<R4, T>>(out));
      }),
      in_order<"relative_jacobian">([](auto&&... x) { return relative_jacobian<R4>(x...); }),
      row<"joint_screws">(
          [](auto& m, auto& w, auto& g, auto out) { joint_screws(m, w, g.q, as<Twist<Spatial, T>>(out)); }),
      in_order<"center_of_mass">([](auto&&... x) { return center_of_mass(x...); }),
      in_order<"center_of_mass_jacobian">([](auto&&... x) { return center_of_mass_jacobian(x...); }),
      in_order<"centroidal_momentum_matrix">([](auto&&... x) { return centroidal_momentum_matrix(x...); }),
      in_order<"centroidal_momentum_matrix_rate">(
          [](auto&&... x) { return centroidal_momentum_matrix_rate(x...); }),
      row<"inverse_dynamics">([](auto& m, auto& w, auto& g,
                                 auto out) { inverse_dynamics<Rep>(m, w, g.q, g.v, g.a, out, g.loads); },
                              [](auto& m, auto& w, auto& g, auto out) {
                                const T left = inverse_dynamics(m, w, g.q, g.v, g.a, out, {}, {}, g.loads);
                                // In single precision `left` cannot be distinguished from rounding errors.
                                if constexpr (std::same_as<T, double>)
                                  check_driven(left, "make these accelerations");
                              }),
      row<"forward_dynamics">(
          [](auto& m, auto& w, auto& g, auto out) {
            return forward_dynamics<Rep>(m, w, g.q, g.v, g.tau, out, g.loads);
          },
          [](auto& m, auto& w, auto& g, auto out) {
            return forward_dynamics(m, w, g.q, g.v, g.tau, out, {}, g.loads);
          }),
      row<"joint_wrenches">(
          [](auto& m, auto& w, auto& g, auto out) {
            joint_wrenches<R4>(m, w, g.q, g.v, g.a, as<Wrench<R4, T>>(out), g.loads, g.at);
          },
          [](auto& m, auto& w, auto& g, auto out) {
            const T left = joint_wrenches<R4>(m, w, g.q, g.v, g.a, as<Wrench<R4, T>>(out), {}, g.loads, g.at);
            // In single precision `left` cannot be distinguished from rounding errors.
            if constexpr (std::same_as<T, double>) check_driven(left, "make these accelerations");
          }),
      in_order<"mass_matrix">([](auto&&... x) { return mass_matrix<Rep>(x...); }),
      in_order<"inverse_mass_matrix">([](auto&&... x) { return inverse_mass_matrix<Rep>(x...); }),
      in_order<"mass_matrix_partials">([](auto&&... x) { return mass_matrix_partials(x...); }),
      in_order<"inverse_mass_matrix_partials">(
          [](auto&&... x) { return inverse_mass_matrix_partials(x...); }),
      row<"coriolis_matrix">(
          [](auto& m, auto& w, auto& g, auto out) { coriolis_matrix(m, w, g.q, g.v, g.form, out); }),
      in_order<"coriolis_vector">([](auto&&... x) { return coriolis_vector<Rep>(x...); }),
      in_order<"gravity_torques">([](auto&&... x) { return gravity_torques<Rep>(x...); }),
      row<"generalized_loads">(
          [](auto& m, auto& w, auto& g, auto out) { generalized_loads<Rep>(m, w, g.q, g.v, g.loads, out); }),
      in_order<"christoffel">([](auto&&... x) { return christoffel(x...); }),
      in_order<"kinetic_energy">([](auto&&... x) { return kinetic_energy(x...); }),
      in_order<"potential_energy">([](auto&&... x) { return potential_energy(x...); }),
      in_order<"spring_forces">([](auto&&... x) { return spring_forces(x...); }),
      in_order<"elastic_energy">([](auto&&... x) { return elastic_energy(x...); }),
      row<"load_powers">(
          [](auto& m, auto& w, auto& g, auto out) { load_powers(m, w, g.q, g.v, g.loads, out); }),
      in_order<"centroidal_inertia">([](auto&&... x) { return centroidal_inertia(x...); }),
      in_order<"impulse_response">([](auto&&... x) { return impulse_response<R4>(x...); }),
      row<"inverse_operational_space_inertia">([](auto& m, auto& w, auto& g, auto out) {
        return inverse_operational_space_inertia<R4>(m, w, g.q, g.place, out);
      }),
      row<"operational_space_inertia">([](auto& m, auto& w, auto& g, auto out) {
        return operational_space_inertia<R4>(m, w, g.q, g.place, out);
      }),
      in_order<"regressor">([](auto&&... x) { return regressor(x...); }),
      in_order<"kinetic_energy_regressor">([](auto&&... x) { return kinetic_energy_regressor(x...); }),
      in_order<"potential_energy_regressor">([](auto&&... x) { return potential_energy_regressor(x...); }),
      in_order<"momenta">([](auto&&... x) { return momenta(x...); }),
      in_order<"from_momenta">([](auto&&... x) { return from_momenta(x...); }),
      row<"momentum_form">([](auto& m, auto& w, auto& g, auto out) {
        return momentum_form(m, w, g.q, g.p, g.tau, out.first(out.size() / 2), out.last(out.size() / 2),
                             g.loads);
      }),
      in_order<"body_momenta">([](auto&&... x) { return body_momenta<R4>(x...); }),
      in_order<"spatial_momentum">([](auto&&... x) { return spatial_momentum(x...); }),
      in_order<"centroidal_momentum">([](auto&&... x) { return centroidal_momentum(x...); }),
      in_order<"inverse_dynamics_derivatives">(
          [](auto&&... x) { return inverse_dynamics_derivatives(x...); }),
      in_order<"forward_dynamics_derivatives">(
          [](auto&&... x) { return forward_dynamics_derivatives(x...); }),
      in_order<"momentum_form_derivatives">([](auto&&... x) { return momentum_form_derivatives(x...); }),
      in_order<"gravity_derivatives">([](auto&&... x) { return gravity_derivatives(x...); }),
      in_order<"coriolis_derivatives">([](auto&&... x) { return coriolis_derivatives(x...); }),
      row<"generalized_load_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        generalized_load_derivatives(m, w, g.q, g.v, g.loads, {part(out, 0, 2), part(out, 1, 2)});
      }),
      in_order<"spring_force_derivatives">([](auto&&... x) { return spring_force_derivatives(x...); }),
      in_order<"kinetic_energy_gradient">([](auto&&... x) { return kinetic_energy_gradient(x...); }),
      in_order<"motion_derivatives">([](auto&&... x) { return motion_derivatives<R4>(x...); }),
      row<"motion_jvp">([](auto& m, auto& w, auto& g, auto out) {
        const auto change = motion_jvp<R4>(m, w, g.q, g.v, g.a, g.place, g.dq, g.dv, g.da);
        put(change.X, part(out, 0, 3));
        put(change.V, part(out, 1, 3));
        put(change.dV, part(out, 2, 3));
      }),
      in_order<"inverse_dynamics_geometry_derivatives">(
          [](auto&&... x) { return inverse_dynamics_geometry_derivatives(x...); }),
      in_order<"forward_dynamics_geometry_derivatives">(
          [](auto&&... x) { return forward_dynamics_geometry_derivatives(x...); }),
      in_order<"inverse_dynamics_geometry_vjp">(
          [](auto&&... x) { return inverse_dynamics_geometry_vjp(x...); }),
      in_order<"forward_dynamics_geometry_vjp">(
          [](auto&&... x) { return forward_dynamics_geometry_vjp(x...); }),
      in_order<"frame_geometry_jacobian">([](auto&&... x) { return frame_geometry_jacobian(x...); }),
      row<"jacobian_geometry_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        jacobian_geometry_derivatives(m, w, g.q, g.place, as<Twist<BodyFixed, T>>(out));
      }),
      in_order<"inverse_dynamics_jvp">([](auto&&... x) { return inverse_dynamics_jvp(x...); }),
      in_order<"inverse_dynamics_vjp">([](auto&&... x) { return inverse_dynamics_vjp(x...); }),
      in_order<"forward_dynamics_jvp">([](auto&&... x) { return forward_dynamics_jvp(x...); }),
      in_order<"forward_dynamics_vjp">([](auto&&... x) { return forward_dynamics_vjp(x...); }),
      in_order<"inverse_dynamics_hessian">([](auto&&... x) { return inverse_dynamics_hessian(x...); }),
      in_order<"forward_dynamics_hessian">([](auto&&... x) { return forward_dynamics_hessian(x...); }),
      in_order<"inverse_dynamics_second_derivatives">(
          [](auto&&... x) { return inverse_dynamics_second_derivatives(x...); }),
      in_order<"forward_dynamics_second_derivatives">(
          [](auto&&... x) { return forward_dynamics_second_derivatives(x...); }),
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
