#pragma once
#include <array>
#include <span>
#include <string_view>
#include <utility>

#include "axode/integration/exact/simulate_contact_exact.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/integration/simulation.hpp"

/// All methods of integration by the names that the command-line tool and the Python package use.
namespace axode {

/// The arguments of a simulation by any method; each method reads those that it needs.
struct MotionRequest {
  const Model& model;
  std::span<const double> q, v;
  double until;
  double step;             ///< step length; for an adaptive method that of the first step, or 0 to choose it
                           ///< automatically
  Tolerances tolerances;   ///< tolerances of an adaptive method
  double spectral_radius;  ///< spectral radius of generalised-α
  const SimulationOptions& options;
  /// The collision shapes, for methods with contact; null: those of the model, without meshes.
  const ContactShapes* shapes = nullptr;
};

struct Method {
  bool adapts;  ///< whether steps are adapted to tolerances; other methods need a step length
  Trajectory (*simulate)(const MotionRequest& x);
  double usual_step = 0;  ///< step length if none is given, s; 0 if there is no default
  bool touches = false;   ///< whether collision shapes touch
};

namespace detail {

inline Trajectory simulate_adapting(const MotionRequest& x) {
  Tolerances tolerances = x.tolerances;
  tolerances.first_step = x.step;
  return simulate(x.model, x.q, x.v, x.until, tolerances, x.options);
}
template <int order> Trajectory simulate_explicit(const MotionRequest& x) {
  return simulate_fixed(x.model, x.q, x.v, x.until, x.step, runge_kutta(order), x.options);
}
template <int order> Trajectory simulate_symplectic(const MotionRequest& x) {
  return axode::simulate_symplectic(x.model, x.q, x.v, x.until, x.step, order, x.options);
}
template <int order> Trajectory simulate_rattle(const MotionRequest& x) {
  return axode::simulate_rattle(x.model, x.q, x.v, x.until, x.step, order, x.options);
}
template <bool stabilized> Trajectory simulate_stiff(const MotionRequest& x) {
  return axode::simulate_stiff(x.model, x.q, x.v, x.until, x.step, x.spectral_radius, x.options, stabilized);
}

inline Trajectory simulate_momenta(const MotionRequest& x) {
  return axode::simulate_momenta(x.model, x.q, x.v, x.until, x.step, runge_kutta(4), x.options);
}
inline ContactShapes shapes_of(const MotionRequest& x) {
  return x.shapes ? *x.shapes : ContactShapes(x.model);
}
inline Trajectory simulate_contact(const MotionRequest& x) {
  return axode::simulate_contact(x.model, shapes_of(x), x.q, x.v, x.until, x.step, x.options);
}
inline Trajectory simulate_contact_adapting(const MotionRequest& x) {
  Tolerances tolerances = x.tolerances;
  tolerances.first_step = x.step;
  return axode::simulate_contact(x.model, shapes_of(x), x.q, x.v, x.until, tolerances, x.options);
}
inline Trajectory simulate_contact_exact(const MotionRequest& x) {
  Tolerances tolerances = x.tolerances;
  tolerances.first_step = x.step;
  return axode::simulate_contact_exact(x.model, shapes_of(x), x.q, x.v, x.until, tolerances, x.options);
}
inline Trajectory simulate_half_explicit(const MotionRequest& x) {
  return axode::simulate_half_explicit(x.model, x.q, x.v, x.until, x.step, x.options);
}

}  // namespace detail

inline constexpr std::array<std::pair<std::string_view, Method>, 16> methods{
    {{"dopri5", {true, detail::simulate_adapting}},
     {"rk4", {false, detail::simulate_explicit<4>}},
     {"euler", {false, detail::simulate_explicit<1>}},
     {"generalized_alpha", {false, detail::simulate_stiff<true>}},
     {"midpoint", {false, detail::simulate_symplectic<2>}},
     {"suzuki4", {false, detail::simulate_symplectic<4>}},
     {"kahan_li6", {false, detail::simulate_symplectic<6>}},
     {"rk4_momenta", {false, detail::simulate_momenta}},
     {"rattle", {false, detail::simulate_rattle<2>}},
     {"rattle_suzuki4", {false, detail::simulate_rattle<4>}},
     {"rattle_kahan_li6", {false, detail::simulate_rattle<6>}},
     {"contact", {false, detail::simulate_contact, 1e-3, true}},
     {"contact_adaptive", {true, detail::simulate_contact_adapting, 0, true}},
     {"contact_exact", {true, detail::simulate_contact_exact, 0, true}},
     {"half_explicit", {false, detail::simulate_half_explicit}},
     {"generalized_alpha_index3", {false, detail::simulate_stiff<false>}}}};

/// The default method: `contact` if the mechanism's description has settings of contact, `dopri5` otherwise.
inline std::string_view usual_method(const Model& model) {
  return model.description().contact ? "contact" : "dopri5";
}

/// The kinds of coordinates in which a motion is integrated, by name.
inline constexpr std::array<std::pair<std::string_view, Coordinates>, 4> coordinate_kinds{
    {{"relative", Coordinates::relative},
     {"absolute", Coordinates::absolute},
     {"absolute_SO3xR3", Coordinates::absolute_SO3xR3},
     {"absolute_by_joint", Coordinates::absolute_by_joint}}};

/// The name of a kind of coordinates.
constexpr std::string_view to_string(Coordinates coordinates) {
  for (const auto& [name, kind] : coordinate_kinds)
    if (kind == coordinates) return name;
  return {};
}

}  // namespace axode
