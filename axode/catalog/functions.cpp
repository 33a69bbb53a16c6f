#include <algorithm>
#include <array>

#include "axode/catalog.hpp"
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

constexpr Solvability done{};

template <class F> constexpr auto call(const F&) {
  static_assert(std::is_empty_v<F>);
  return [](const Model& m, W& w, const G& g, Out out) -> Solvability {
    if constexpr (std::same_as<decltype(F()(m, w, g, out)), Solvability>) {
      return F()(m, w, g, out);
    } else {
      F()(m, w, g, out);
      return done;
    }
  };
}

std::vector<Function<T>> make() {
  constexpr bool rows = false, columns = true, heap = true, scratch = false;
  const char* const screws = "rad/s, m/s";
  const char* const rates = "rad/s^2, m/s^2";
  const char* const wrenches = "N m, N";
  const char* const impulses = "N m s, N s";
  const char* const forces = "N m for angles, N for lengths";
  const char* const inertias = "kg m^2, kg m, kg";
  return {
      // clang-format off
      {"poses", "where every frame is, in the inertial frame", "m", {q}, Choice::none, pose, {n_frames}, rows, {"C"},
       Cost::linear, scratch, call([](auto& m, auto& w, auto& g, auto out) { poses(m, w, g.q, as<SE3<T>>(out)); })},
      {"twists", "velocities of all frames", screws, {q, v}, Choice::representation, twist, {n_frames}, rows, {"V"},
       Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { twists<R4>(m, w, g.q, g.v, as<Twist<R4, T>>(out)); })},
      {"accelerations", "time derivatives of the components of the twists, gravity not included", rates, {q, v, a},
       Choice::representation, rate, {n_frames}, rows, {"V'"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         accelerations<R4>(m, w, g.q, g.v, g.a, as<TwistRate<R4, T>>(out));
       })},
      {"jacobian", "J with V = J v, a column for each velocity", "rad, m per unit of the velocity", {q, place},
       Choice::representation, twist, {nv}, columns, {"J"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { jacobian<R4>(m, w, g.q, g.place, as<Twist<R4, T>>(out)); })},
      {"jacobians", "the Jacobians of all frames", "rad, m per unit of the velocity", {q}, Choice::representation, twist,
       {n_frames, nv}, columns, {"J"}, Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { jacobians<R4>(m, w, g.q, as<Twist<R4, T>>(out)); })},
      {"jacobian_rate", "its time derivative", "per s", {q, v, place}, Choice::representation, rate, {nv}, columns, {"J'"},
       Cost::linear, heap,
       call([](auto& m, auto& w, auto& g, auto out) {
         jacobian_derivative_along<R4>(m, w, g.q, g.place, 1, g.v, as<Twist<R4, T>>(out));
       })},
      {"relative_jacobian", "the same for the motion that another frame sees, which takes the place of the inertial one",
       "rad, m per unit of the velocity", {q, place, base}, Choice::representation, twist, {nv}, columns, {"J"},
       Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         relative_jacobian<R4>(m, w, g.q, g.place, g.base, as<Twist<R4, T>>(out));
       })},
      {"joint_screws", "instantaneous joint screws in inertial axes about the inertial origin", "rad, m", {q},
       Choice::none, twist, {n_screws}, columns, {"J"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { joint_screws(m, w, g.q, as<Twist<Spatial, T>>(out)); })},
      {"center_of_mass", "of all moving bodies, in the inertial frame", "m", {q}, Choice::none, vector, {}, rows, {"c"},
       Cost::linear, scratch, call([](auto& m, auto& w, auto& g, auto out) { put(center_of_mass(m, w, g.q), out); })},
      {"center_of_mass_jacobian", "velocity of the centre of mass for a unit of each velocity, in inertial axes",
       "m per unit of the velocity", {q}, Choice::none, vector, {nv}, columns, {"J"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { center_of_mass_jacobian(m, w, g.q, as<Vec3<T>>(out)); })},
      {"centroidal_momentum_matrix",
       "momentum about the centre of mass for a unit of each velocity, in inertial axes", inertias, {q}, Choice::none,
       momentum, {nv}, columns, {"A"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         centroidal_momentum_matrix(m, w, g.q, as<Momentum<Hybrid, T>>(out));
       })},
      {"centroidal_momentum_matrix_rate", "its time derivative", "kg m^2/s, kg m/s, kg/s", {q, v}, Choice::none, wrench,
       {nv}, columns, {"A'"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         centroidal_momentum_matrix_rate(m, w, g.q, g.v, as<Wrench<Hybrid, T>>(out));
       })},

      {"inverse_dynamics", "drive forces tau that make the accelerations a", forces, {q, v, a, loads},
       Choice::recursion, number, {nv}, rows, {"tau"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { inverse_dynamics<Rep>(m, w, g.q, g.v, g.a, out, g.loads); })},
      {"forward_dynamics", "accelerations that the drive forces tau make", rates, {q, v, tau, loads}, Choice::recursion,
       number, {nv}, rows, {"a"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         return forward_dynamics<Rep>(m, w, g.q, g.v, g.tau, out, g.loads);
       })},
      {"joint_wrenches", "wrenches that the joints transmit to their bodies, drive and reaction", wrenches,
       {q, v, a, loads}, Choice::representation, wrench, {n_joints}, rows, {"W"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         joint_wrenches<R4>(m, w, g.q, g.v, g.a, as<Wrench<R4, T>>(out), g.loads);
       })},
      {"mass_matrix", "M(q), armatures included", inertias, {q}, Choice::recursion, number, {nv, nv}, rows, {"M"},
       Cost::quadratic, scratch, call([](auto& m, auto& w, auto& g, auto out) { mass_matrix<Rep>(m, w, g.q, out); })},
      {"inverse_mass_matrix", "its inverse", "1/(kg m^2), 1/(kg m), 1/kg", {q}, Choice::recursion, number, {nv, nv}, rows,
       {"M^-1"}, Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { return inverse_mass_matrix<Rep>(m, w, g.q, out); })},
      {"mass_matrix_partials", "partial derivatives of M, a matrix for each direction of the configuration", inertias, {q},
       Choice::none, number, {nv, nv, nv}, rows, {"dM"}, Cost::cubic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { mass_matrix_partials(m, w, g.q, out); })},
      {"inverse_mass_matrix_partials", "those of its inverse", "1/(kg m^2), 1/(kg m), 1/kg", {q}, Choice::none, number,
       {nv, nv, nv}, rows, {"dM^-1"}, Cost::cubic, heap,
       call([](auto& m, auto& w, auto& g, auto out) { return inverse_mass_matrix_partials(m, w, g.q, out); })},
      {"coriolis_matrix", "C(q, v), in a form of choice", "kg m^2/s, kg m/s, kg/s", {q, v, form}, Choice::none, number,
       {nv, nv}, rows, {"C"}, Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { coriolis_matrix(m, w, g.q, g.v, g.form, out); })},
      {"coriolis_vector", "C(q, v) v", forces, {q, v}, Choice::recursion, number, {nv}, rows, {"C v"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { coriolis_vector<Rep>(m, w, g.q, g.v, out); })},
      {"gravity_torques", "drive forces that hold the system at rest against gravity", forces, {q}, Choice::recursion,
       number, {nv}, rows, {"g"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { gravity_torques<Rep>(m, w, g.q, out); })},
      {"generalized_loads", "generalised forces of the loads", forces, {q, v, loads}, Choice::recursion, number, {nv}, rows,
       {"Q"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { generalized_loads<Rep>(m, w, g.q, g.v, g.loads, out); })},
      {"christoffel", "Christoffel symbols of the first kind, Gamma_ijk, a matrix over (j, k) for each i", inertias, {q},
       Choice::none, number, {nv, nv, nv}, rows, {"Gamma"}, Cost::cubic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { christoffel(m, w, g.q, out); })},
      {"kinetic_energy", "of bodies and armatures", "J", {q, v}, Choice::none, number, {}, rows, {"T"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { out[0] = kinetic_energy(m, w, g.q, g.v); })},
      {"potential_energy", "of gravity, 0 at the inertial origin", "J", {q}, Choice::none, number, {}, rows, {"U"},
       Cost::linear, scratch, call([](auto& m, auto& w, auto& g, auto out) { out[0] = potential_energy(m, w, g.q); })},
      {"spring_forces", "generalised forces of springs, dampers and stops, which act in simulations", forces, {q, v},
       Choice::none, number, {nv}, rows, {"tau"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { spring_forces(m, w, g.q, g.v, out); })},
      {"elastic_energy", "of springs and stops", "J", {q}, Choice::none, number, {}, rows, {"U"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { out[0] = elastic_energy(m, w, g.q); })},
      {"load_powers", "that every load puts into the system", "W", {q, v, loads}, Choice::none, number, {n_loads}, rows,
       {"power"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { load_powers(m, w, g.q, g.v, g.loads, out); })},
      {"centroidal_inertia", "mass and rotational inertia of the whole about its centre of mass, in inertial axes",
       "kg, kg m^2", {q}, Choice::none, inertia, {}, rows, {"M"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { put(centroidal_inertia(m, w, g.q), out); })},
      {"impulse_response", "M^-1 J^T, a column for each velocity: its jump for a unit of impulse on the frame",
       "per N m s, N s", {q, place}, Choice::representation, twist, {nv}, columns, {"Y"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         return impulse_response<R4>(m, w, g.q, g.place, as<Twist<R4, T>>(out));
       })},
      {"mobility", "J M^-1 J^T: the twist that a frame gets from an impulse", "per N m s, N s", {q, place},
       Choice::representation, twist, {six}, columns, {"J M^-1 J^T"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { return mobility<R4>(m, w, g.q, g.place, out); })},
      {"operational_space_inertia",
       "(J M^-1 J^T)^-1: the inertia that a frame shows to a wrench, which has none where it cannot move in all directions", inertias,
       {q, place}, Choice::representation, momentum, {six}, columns, {"Lambda"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         return operational_space_inertia<R4>(m, w, g.q, g.place, out);
       })},
      {"regressor", "Y in Y pi = M a + C v + g, with ten inertial parameters pi for each body", "by parameter", {q, v, a},
       Choice::none, number, {nv, n_parameters}, rows, {"Y"}, Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { regressor(m, w, g.q, g.v, g.a, out); })},
      {"kinetic_energy_regressor", "y in y pi = kinetic energy of the bodies", "by parameter", {q, v}, Choice::none, number,
       {n_parameters}, rows, {"y"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { kinetic_energy_regressor(m, w, g.q, g.v, out); })},
      {"potential_energy_regressor", "y in y pi = potential energy", "by parameter", {q}, Choice::none, number,
       {n_parameters}, rows, {"y"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { potential_energy_regressor(m, w, g.q, out); })},

      {"momenta", "generalised momenta p = M v", impulses, {q, v}, Choice::none, number, {nv}, rows, {"p"}, Cost::linear,
       scratch, call([](auto& m, auto& w, auto& g, auto out) { momenta(m, w, g.q, g.v, out); })},
      {"from_momenta", "velocities v = M^-1 p", screws, {q, p}, Choice::none, number, {nv}, rows, {"v"}, Cost::linear,
       scratch, call([](auto& m, auto& w, auto& g, auto out) { return from_momenta(m, w, g.q, g.p, out); })},
      {"momentum_form", "rates of the state (q, p) under the drive forces tau", "rad/s, m/s; N m, N", {q, p, tau, loads},
       Choice::none, number, {nv}, rows, {"v", "dp"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         return momentum_form(m, w, g.q, g.p, g.tau, out.first(out.size() / 2), out.last(out.size() / 2), g.loads);
       })},
      {"body_momenta", "momenta of all bodies in their frames", impulses, {q, v}, Choice::representation, momentum,
       {n_bodies}, rows, {"Pi"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { body_momenta<R4>(m, w, g.q, g.v, as<Momentum<R4, T>>(out)); })},
      {"spatial_momentum", "of the whole system, about the inertial origin", impulses, {q, v}, Choice::none, momentum, {},
       rows, {"Pi"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { put(spatial_momentum(m, w, g.q, g.v), out); })},
      {"centroidal_momentum", "of the whole system, about its centre of mass, in inertial axes", impulses, {q, v},
       Choice::none, momentum, {}, rows, {"Pi"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { put(centroidal_momentum(m, w, g.q, g.v), out); })},

      {"inverse_dynamics_derivatives", "partial derivatives of inverse dynamics", "of tau per unit of the direction",
       {q, v, a, loads}, Choice::none, number, {nv, nv}, rows, {"dtau/dq", "dtau/dv", "dtau/da"}, Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         inverse_dynamics_derivatives(m, w, g.q, g.v, g.a, {part(out, 0, 3), part(out, 1, 3), part(out, 2, 3)}, g.loads);
       })},
      {"forward_dynamics_derivatives", "partial derivatives of forward dynamics", "of a per unit of the direction",
       {q, v, tau, loads}, Choice::none, number, {nv, nv}, rows, {"da/dq", "da/dv", "da/dtau"}, Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         return forward_dynamics_derivatives(m, w, g.q, g.v, g.tau, {part(out, 0, 3), part(out, 1, 3), part(out, 2, 3)},
                                             g.loads);
       })},
      {"momentum_form_derivatives", "partial derivatives of momentum_form", "of v and p' per unit of the direction",
       {q, p, loads}, Choice::none, number, {nv, nv}, rows, {"dv/dq", "dv/dp", "dp'/dq", "dp'/dp"}, Cost::quadratic,
       scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         return momentum_form_derivatives(
             m, w, g.q, g.p, {part(out, 0, 4), part(out, 1, 4), part(out, 2, 4), part(out, 3, 4)}, g.loads);
       })},
      {"gravity_derivatives", "partial derivatives of gravity_torques", forces, {q}, Choice::none, number, {nv, nv}, rows,
       {"dg/dq"}, Cost::quadratic, scratch, call([](auto& m, auto& w, auto& g, auto out) { gravity_derivatives(m, w, g.q, out); })},
      {"coriolis_derivatives", "partial derivatives of coriolis_vector", "of tau per unit of the direction", {q, v},
       Choice::none, number, {nv, nv}, rows, {"d(C v)/dq", "d(C v)/dv"}, Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         coriolis_derivatives(m, w, g.q, g.v, {part(out, 0, 2), part(out, 1, 2)});
       })},
      {"generalized_load_derivatives", "partial derivatives of generalized_loads", "of tau per unit of the direction",
       {q, v, loads}, Choice::none, number, {nv, nv}, rows, {"dQ/dq", "dQ/dv"}, Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         generalized_load_derivatives(m, w, g.q, g.v, g.loads, {part(out, 0, 2), part(out, 1, 2)});
       })},
      {"spring_force_derivatives", "partial derivatives of spring_forces", "of tau per unit of the direction", {q, v},
       Choice::none, number, {nv, nv}, rows, {"dtau/dq", "dtau/dv"}, Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         spring_force_derivatives(m, w, g.q, g.v, {part(out, 0, 2), part(out, 1, 2)});
       })},
      {"kinetic_energy_gradient", "by configuration and velocities", "J per unit of the direction", {q, v}, Choice::none,
       number, {nv}, rows, {"dT/dq", "dT/dv"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         kinetic_energy_gradient(m, w, g.q, g.v, {part(out, 0, 2), part(out, 1, 2)});
       })},
      {"motion_derivatives", "partial derivatives of the twist of a frame and of its rate, a column for each direction",
       "of V and V' per unit of the direction", {q, v, a, place}, Choice::representation, twist, {nv}, columns,
       {"dV/dq", "dV/dv", "dV'/dq", "dV'/dv"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         const auto columns_of = [&](std::size_t k) { return as<Twist<R4, T>>(part(out, k, 4)); };
         motion_derivatives<R4>(m, w, g.q, g.v, g.a, g.place,
                                {columns_of(0), columns_of(1), columns_of(2), columns_of(3)});
       })},
      {"motion_jvp", "how pose (a body-fixed displacement), twist and its rate change along a direction",
       "of X, V and V' along the direction", {q, v, a, place, dq, dv, da}, Choice::representation, twist, {}, rows,
       {"dX", "dV", "dV'"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         const auto change = motion_jvp<R4>(m, w, g.q, g.v, g.a, g.place, g.dq, g.dv, g.da);
         put(change.X, part(out, 0, 3)), put(change.V, part(out, 1, 3)), put(change.dV, part(out, 2, 3));
       })},
      {"inverse_dynamics_geometry_derivatives", "partial derivatives of the drive forces by displacements of the joints",
       "of tau per rad, m", {q, v, a, loads}, Choice::none, number, {nv, n_bodies, six}, rows, {"dtau/dpi"},
       Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         inverse_dynamics_geometry_derivatives(m, w, g.q, g.v, g.a, out, g.loads);
       })},
      {"forward_dynamics_geometry_derivatives", "partial derivatives of the accelerations by displacements of the joints",
       "of a per rad, m", {q, v, tau, loads}, Choice::none, number, {nv, n_bodies, six}, rows, {"da/dpi"},
       Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         return forward_dynamics_geometry_derivatives(m, w, g.q, g.v, g.tau, out, g.loads);
       })},
      {"inverse_dynamics_geometry_vjp", "gradient of the drive forces weighed with w by displacements of the joints",
       "of w tau per rad, m", {q, v, a, weights, loads}, Choice::none, number, {n_bodies, six}, rows, {"by pi"},
       Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         inverse_dynamics_geometry_vjp(m, w, g.q, g.v, g.a, g.w, out, g.loads);
       })},
      {"forward_dynamics_geometry_vjp", "gradient of the accelerations weighed with w by displacements of the joints",
       "of w a per rad, m", {q, v, tau, weights, loads}, Choice::none, number, {n_bodies, six}, rows, {"by pi"},
       Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         return forward_dynamics_geometry_vjp(m, w, g.q, g.v, g.tau, g.w, out, g.loads);
       })},
      {"frame_geometry_jacobian", "body-fixed twist of a frame for a unit of displacement of each joint", "rad, m per rad, m",
       {q, place}, Choice::none, number, {six, n_bodies, six}, rows, {"J"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) { frame_geometry_jacobian(m, w, g.q, g.place, out); })},
      {"jacobian_geometry_derivatives", "derivatives of the body-fixed Jacobian of a frame by displacements of the joints",
       "of J per rad, m", {q, place}, Choice::none, twist, {n_bodies, six, nv}, columns, {"dJ/dpi"}, Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         jacobian_geometry_derivatives(m, w, g.q, g.place, as<Twist<BodyFixed, T>>(out));
       })},
      {"inverse_dynamics_jvp", "what a direction (dq, dv, da) does to the drive forces", forces,
       {q, v, a, dq, dv, da, loads}, Choice::none, number, {nv}, rows, {"dtau"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         inverse_dynamics_jvp(m, w, g.q, g.v, g.a, g.dq, g.dv, g.da, out, g.loads);
       })},
      {"inverse_dynamics_vjp", "gradient of the drive forces weighed with w", "of w tau per unit of the direction",
       {q, v, a, weights, loads}, Choice::none, number, {nv}, rows, {"by q", "by v", "by a"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         inverse_dynamics_vjp(m, w, g.q, g.v, g.a, g.w, {part(out, 0, 3), part(out, 1, 3), part(out, 2, 3)}, g.loads);
       })},
      {"forward_dynamics_jvp", "what a direction (dq, dv, dtau) does to the accelerations", rates,
       {q, v, tau, dq, dv, dtau, loads}, Choice::none, number, {nv}, rows, {"da"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         return forward_dynamics_jvp(m, w, g.q, g.v, g.tau, g.dq, g.dv, g.dtau, out, g.loads);
       })},
      {"forward_dynamics_vjp", "gradient of the accelerations weighed with w", "of w a per unit of the direction",
       {q, v, tau, weights, loads}, Choice::none, number, {nv}, rows, {"by q", "by v", "by tau"}, Cost::linear, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         return forward_dynamics_vjp(m, w, g.q, g.v, g.tau, g.w, {part(out, 0, 3), part(out, 1, 3), part(out, 2, 3)},
                                     g.loads);
       })},
      {"inverse_dynamics_hessian", "second partial derivatives of the drive forces weighed with w",
       "of w tau per units of the directions", {q, v, a, weights, loads}, Choice::none, number, {nv, nv}, rows,
       {"by q, q", "by q, v", "by v, v", "by a, q"}, Cost::quadratic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         inverse_dynamics_hessian(m, w, g.q, g.v, g.a, g.w,
                                  {part(out, 0, 4), part(out, 1, 4), part(out, 2, 4), part(out, 3, 4)}, g.loads);
       })},
      {"forward_dynamics_hessian", "second partial derivatives of the accelerations weighed with w",
       "of w a per units of the directions", {q, v, tau, weights, loads}, Choice::none, number, {nv, nv}, rows,
       {"by q, q", "by q, v", "by v, v", "by tau, q"}, Cost::cubic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         return forward_dynamics_hessian(m, w, g.q, g.v, g.tau, g.w,
                                         {part(out, 0, 4), part(out, 1, 4), part(out, 2, 4), part(out, 3, 4)}, g.loads);
       })},
      {"inverse_dynamics_second_derivatives", "second partial derivatives of the drive forces, without loads",
       "of tau per units of the directions", {q, v, a}, Choice::none, number, {nv, nv, nv}, rows,
       {"by q, q", "by q, v", "by v, v", "by a, q"}, Cost::cubic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         inverse_dynamics_second_derivatives(m, w, g.q, g.v, g.a,
                                             {part(out, 0, 4), part(out, 1, 4), part(out, 2, 4), part(out, 3, 4)});
       })},
      {"forward_dynamics_second_derivatives", "second partial derivatives of the accelerations, without loads",
       "of a per units of the directions", {q, v, tau}, Choice::none, number, {nv, nv, nv}, rows,
       {"by q, q", "by q, v", "by v, v", "by tau, q"}, Cost::cubic, scratch,
       call([](auto& m, auto& w, auto& g, auto out) {
         return forward_dynamics_second_derivatives(
             m, w, g.q, g.v, g.tau, {part(out, 0, 4), part(out, 1, 4), part(out, 2, 4), part(out, 3, 4)});
       })},
      // clang-format on
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
