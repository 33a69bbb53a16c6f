#include <algorithm>
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
using G = Given<T>;
using Out = std::span<T>;

constexpr bool fast = std::same_as<Rep, Fast>;
/// A representation to name where a function is left out for Fast.
using R4 = std::conditional_t<fast, BodyFixed, Rep>;

/// Numbers as the entries that they are.
template <class E> std::span<E> as(Out out) {
  static_assert(sizeof(E) % sizeof(T) == 0);
  return {reinterpret_cast<E*>(out.data()), out.size() / (sizeof(E) / sizeof(T))};
}
template <class E> void put(const E& result, Out out) { as<E>(out)[0] = result; }

/// Part k of n results, one after the other.
Out part(Out out, std::size_t k, std::size_t n) { return out.subspan(k * (out.size() / n), out.size() / n); }

/// Calls a function object. The verdict is the one that it returns, or a good one if it returns none.
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

/// A row with its calls. A row that counts loops is called for these with a LoopWorkspace, by the same
/// function object unless another one is given.
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

std::vector<Function<T>> make() {
  return {
      row<"poses">([](auto& m, auto& w, auto& g, auto out) { poses(m, w, g.q, as<SE3<T>>(out)); }),
      row<"pose">([](auto& m, auto& w, auto& g, auto out) {
        poses(m, w, g.q, std::span<const Place<T>>(&g.place, 1), as<SE3<T>>(out));
      }),
      row<"twists">(
          [](auto& m, auto& w, auto& g, auto out) { twists<R4>(m, w, g.q, g.v, as<Twist<R4, T>>(out)); }),
      row<"accelerations">([](auto& m, auto& w, auto& g, auto out) {
        accelerations<R4>(m, w, g.q, g.v, g.a, as<TwistRate<R4, T>>(out));
      }),
      row<"jacobian">([](auto& m, auto& w, auto& g, auto out) {
        jacobian<R4>(m, w, g.q, g.place, as<Twist<R4, T>>(out));
      }),
      row<"jacobians">(
          [](auto& m, auto& w, auto& g, auto out) { jacobians<R4>(m, w, g.q, as<Twist<R4, T>>(out)); }),
      row<"jacobian_rate">([](auto& m, auto& w, auto& g, auto out) {
        jacobian_derivative_along<R4>(m, w, g.q, g.place, 1, g.v, as<Twist<R4, T>>(out));
      }),
      row<"relative_jacobian">([](auto& m, auto& w, auto& g, auto out) {
        relative_jacobian<R4>(m, w, g.q, g.place, g.base, as<Twist<R4, T>>(out));
      }),
      row<"joint_screws">(
          [](auto& m, auto& w, auto& g, auto out) { joint_screws(m, w, g.q, as<Twist<Spatial, T>>(out)); }),
      row<"center_of_mass">([](auto& m, auto& w, auto& g, auto out) { put(center_of_mass(m, w, g.q), out); }),
      row<"center_of_mass_jacobian">(
          [](auto& m, auto& w, auto& g, auto out) { center_of_mass_jacobian(m, w, g.q, as<Vec3<T>>(out)); }),
      row<"centroidal_momentum_matrix">([](auto& m, auto& w, auto& g, auto out) {
        centroidal_momentum_matrix(m, w, g.q, as<Momentum<Hybrid, T>>(out));
      }),
      row<"centroidal_momentum_matrix_rate">([](auto& m, auto& w, auto& g, auto out) {
        centroidal_momentum_matrix_rate(m, w, g.q, g.v, as<Wrench<Hybrid, T>>(out));
      }),
      row<"inverse_dynamics">(
          [](auto& m, auto& w, auto& g, auto out) {
            inverse_dynamics<Rep>(m, w, g.q, g.v, g.a, out, g.loads);
          },
          [](auto& m, auto& w, auto& g, auto out) {
            const T left = inverse_dynamics(m, w, g.q, g.v, g.a, out, {}, {}, g.loads);
            if constexpr (std::same_as<T, double>)  // single precision does not tell it from rounding
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
            if constexpr (std::same_as<T, double>)  // single precision does not tell it from rounding
              check_driven(left, "make these accelerations");
          }),
      row<"mass_matrix">([](auto& m, auto& w, auto& g, auto out) { mass_matrix<Rep>(m, w, g.q, out); }),
      row<"inverse_mass_matrix">(
          [](auto& m, auto& w, auto& g, auto out) { return inverse_mass_matrix<Rep>(m, w, g.q, out); }),
      row<"mass_matrix_partials">(
          [](auto& m, auto& w, auto& g, auto out) { mass_matrix_partials(m, w, g.q, out); }),
      row<"inverse_mass_matrix_partials">(
          [](auto& m, auto& w, auto& g, auto out) { return inverse_mass_matrix_partials(m, w, g.q, out); }),
      row<"coriolis_matrix">(
          [](auto& m, auto& w, auto& g, auto out) { coriolis_matrix(m, w, g.q, g.v, g.form, out); }),
      row<"coriolis_vector">(
          [](auto& m, auto& w, auto& g, auto out) { coriolis_vector<Rep>(m, w, g.q, g.v, out); }),
      row<"gravity_torques">(
          [](auto& m, auto& w, auto& g, auto out) { gravity_torques<Rep>(m, w, g.q, out); }),
      row<"generalized_loads">(
          [](auto& m, auto& w, auto& g, auto out) { generalized_loads<Rep>(m, w, g.q, g.v, g.loads, out); }),
      row<"christoffel">([](auto& m, auto& w, auto& g, auto out) { christoffel(m, w, g.q, out); }),
      row<"kinetic_energy">(
          [](auto& m, auto& w, auto& g, auto out) { out[0] = kinetic_energy(m, w, g.q, g.v); }),
      row<"potential_energy">(
          [](auto& m, auto& w, auto& g, auto out) { out[0] = potential_energy(m, w, g.q); }),
      row<"spring_forces">([](auto& m, auto& w, auto& g, auto out) { spring_forces(m, w, g.q, g.v, out); }),
      row<"elastic_energy">([](auto& m, auto& w, auto& g, auto out) { out[0] = elastic_energy(m, w, g.q); }),
      row<"load_powers">(
          [](auto& m, auto& w, auto& g, auto out) { load_powers(m, w, g.q, g.v, g.loads, out); }),
      row<"centroidal_inertia">(
          [](auto& m, auto& w, auto& g, auto out) { put(centroidal_inertia(m, w, g.q), out); }),
      row<"impulse_response">([](auto& m, auto& w, auto& g, auto out) {
        return impulse_response<R4>(m, w, g.q, g.place, as<Twist<R4, T>>(out));
      }),
      row<"mobility">(
          [](auto& m, auto& w, auto& g, auto out) { return mobility<R4>(m, w, g.q, g.place, out); }),
      row<"operational_space_inertia">([](auto& m, auto& w, auto& g, auto out) {
        return operational_space_inertia<R4>(m, w, g.q, g.place, out);
      }),
      row<"regressor">([](auto& m, auto& w, auto& g, auto out) { regressor(m, w, g.q, g.v, g.a, out); }),
      row<"kinetic_energy_regressor">(
          [](auto& m, auto& w, auto& g, auto out) { kinetic_energy_regressor(m, w, g.q, g.v, out); }),
      row<"potential_energy_regressor">(
          [](auto& m, auto& w, auto& g, auto out) { potential_energy_regressor(m, w, g.q, out); }),
      row<"momenta">([](auto& m, auto& w, auto& g, auto out) { momenta(m, w, g.q, g.v, out); }),
      row<"from_momenta">(
          [](auto& m, auto& w, auto& g, auto out) { return from_momenta(m, w, g.q, g.p, out); }),
      row<"momentum_form">([](auto& m, auto& w, auto& g, auto out) {
        return momentum_form(m, w, g.q, g.p, g.tau, out.first(out.size() / 2), out.last(out.size() / 2),
                             g.loads);
      }),
      row<"body_momenta">([](auto& m, auto& w, auto& g, auto out) {
        body_momenta<R4>(m, w, g.q, g.v, as<Momentum<R4, T>>(out));
      }),
      row<"spatial_momentum">(
          [](auto& m, auto& w, auto& g, auto out) { put(spatial_momentum(m, w, g.q, g.v), out); }),
      row<"centroidal_momentum">(
          [](auto& m, auto& w, auto& g, auto out) { put(centroidal_momentum(m, w, g.q, g.v), out); }),
      row<"inverse_dynamics_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        inverse_dynamics_derivatives(m, w, g.q, g.v, g.a, {part(out, 0, 3), part(out, 1, 3), part(out, 2, 3)},
                                     g.loads);
      }),
      row<"forward_dynamics_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        return forward_dynamics_derivatives(m, w, g.q, g.v, g.tau,
                                            {part(out, 0, 3), part(out, 1, 3), part(out, 2, 3)}, g.loads);
      }),
      row<"momentum_form_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        return momentum_form_derivatives(
            m, w, g.q, g.p, {part(out, 0, 4), part(out, 1, 4), part(out, 2, 4), part(out, 3, 4)}, g.loads);
      }),
      row<"gravity_derivatives">(
          [](auto& m, auto& w, auto& g, auto out) { gravity_derivatives(m, w, g.q, out); }),
      row<"coriolis_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        coriolis_derivatives(m, w, g.q, g.v, {part(out, 0, 2), part(out, 1, 2)});
      }),
      row<"generalized_load_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        generalized_load_derivatives(m, w, g.q, g.v, g.loads, {part(out, 0, 2), part(out, 1, 2)});
      }),
      row<"spring_force_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        spring_force_derivatives(m, w, g.q, g.v, {part(out, 0, 2), part(out, 1, 2)});
      }),
      row<"kinetic_energy_gradient">([](auto& m, auto& w, auto& g, auto out) {
        kinetic_energy_gradient(m, w, g.q, g.v, {part(out, 0, 2), part(out, 1, 2)});
      }),
      row<"motion_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        const auto columns_of = [&](std::size_t k) { return as<Twist<R4, T>>(part(out, k, 4)); };
        motion_derivatives<R4>(m, w, g.q, g.v, g.a, g.place,
                               {columns_of(0), columns_of(1), columns_of(2), columns_of(3)});
      }),
      row<"motion_jvp">([](auto& m, auto& w, auto& g, auto out) {
        const auto change = motion_jvp<R4>(m, w, g.q, g.v, g.a, g.place, g.dq, g.dv, g.da);
        put(change.X, part(out, 0, 3)), put(change.V, part(out, 1, 3)), put(change.dV, part(out, 2, 3));
      }),
      row<"inverse_dynamics_geometry_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        inverse_dynamics_geometry_derivatives(m, w, g.q, g.v, g.a, out, g.loads);
      }),
      row<"forward_dynamics_geometry_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        return forward_dynamics_geometry_derivatives(m, w, g.q, g.v, g.tau, out, g.loads);
      }),
      row<"inverse_dynamics_geometry_vjp">([](auto& m, auto& w, auto& g, auto out) {
        inverse_dynamics_geometry_vjp(m, w, g.q, g.v, g.a, g.w, out, g.loads);
      }),
      row<"forward_dynamics_geometry_vjp">([](auto& m, auto& w, auto& g, auto out) {
        return forward_dynamics_geometry_vjp(m, w, g.q, g.v, g.tau, g.w, out, g.loads);
      }),
      row<"frame_geometry_jacobian">(
          [](auto& m, auto& w, auto& g, auto out) { frame_geometry_jacobian(m, w, g.q, g.place, out); }),
      row<"jacobian_geometry_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        jacobian_geometry_derivatives(m, w, g.q, g.place, as<Twist<BodyFixed, T>>(out));
      }),
      row<"inverse_dynamics_jvp">([](auto& m, auto& w, auto& g, auto out) {
        inverse_dynamics_jvp(m, w, g.q, g.v, g.a, g.dq, g.dv, g.da, out, g.loads);
      }),
      row<"inverse_dynamics_vjp">([](auto& m, auto& w, auto& g, auto out) {
        inverse_dynamics_vjp(m, w, g.q, g.v, g.a, g.w, {part(out, 0, 3), part(out, 1, 3), part(out, 2, 3)},
                             g.loads);
      }),
      row<"forward_dynamics_jvp">([](auto& m, auto& w, auto& g, auto out) {
        return forward_dynamics_jvp(m, w, g.q, g.v, g.tau, g.dq, g.dv, g.dtau, out, g.loads);
      }),
      row<"forward_dynamics_vjp">([](auto& m, auto& w, auto& g, auto out) {
        return forward_dynamics_vjp(m, w, g.q, g.v, g.tau, g.w,
                                    {part(out, 0, 3), part(out, 1, 3), part(out, 2, 3)}, g.loads);
      }),
      row<"inverse_dynamics_hessian">([](auto& m, auto& w, auto& g, auto out) {
        inverse_dynamics_hessian(m, w, g.q, g.v, g.a, g.w,
                                 {part(out, 0, 4), part(out, 1, 4), part(out, 2, 4), part(out, 3, 4)},
                                 g.loads);
      }),
      row<"forward_dynamics_hessian">([](auto& m, auto& w, auto& g, auto out) {
        return forward_dynamics_hessian(m, w, g.q, g.v, g.tau, g.w,
                                        {part(out, 0, 4), part(out, 1, 4), part(out, 2, 4), part(out, 3, 4)},
                                        g.loads);
      }),
      row<"inverse_dynamics_second_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        inverse_dynamics_second_derivatives(
            m, w, g.q, g.v, g.a, {part(out, 0, 4), part(out, 1, 4), part(out, 2, 4), part(out, 3, 4)});
      }),
      row<"forward_dynamics_second_derivatives">([](auto& m, auto& w, auto& g, auto out) {
        return forward_dynamics_second_derivatives(
            m, w, g.q, g.v, g.tau, {part(out, 0, 4), part(out, 1, 4), part(out, 2, 4), part(out, 3, 4)});
      }),
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
