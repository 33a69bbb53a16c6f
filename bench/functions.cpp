// Every function that a control loop calls, in one thread, on random states.
#include "axode/catalog.hpp"
#include "axode/derivatives.hpp"
#include "bench/subjects.hpp"

namespace {

using namespace axode;
using namespace axode::bench;

/// Measures f(model, workspace, q, v, a, out), where `out` has an Entry for each frame.
template <class Entry, class F>
void measure_frames(const std::string& function, const std::string& variant, const F& f) {
  measure(function, variant, [f](benchmark::State& state, const Model& model) {
    Workspace<> workspace(model);
    States states(model);
    std::vector<Entry> out(static_cast<std::size_t>(std::max(model.n_frames(), model.n_screws())));
    repeat(state, out.data(), [&] {
      const std::size_t s = states.next();
      f(model, workspace, states.q[s], states.v[s], states.a[s], std::span(out));
    });
  });
}

/// Measures a function for derivatives of the dynamics. Its directions, or its weights, are random numbers.
void measure_derivative(const catalog::Function<double>& function, const std::vector<Model>& subjects) {
  measure(
      std::string(function.name), "fast",
      [&function](benchmark::State& state, const Model& model) {
        Workspace<> workspace(model);
        States states(model);
        std::vector<double> out(function.size(model, 0));
        repeat(state, out.data(), [&] {
          const std::size_t s = states.next();
          const auto &a = states.a[s], &x = states.jerk[s];
          benchmark::DoNotOptimize(function.call(model, workspace,
                                                 {.q = states.q[s],
                                                  .v = states.v[s],
                                                  .a = a,
                                                  .tau = a,
                                                  .p = {},
                                                  .dq = x,
                                                  .dv = x,
                                                  .da = x,
                                                  .dtau = x,
                                                  .w = x},
                                                 out));
        });
      },
      subjects);
}
void measure_all_derivatives() {
  for (const catalog::Function<double>& function : catalog::functions<Fast>())
    if (function.tape && !function.derivative_of.empty()) measure_derivative(function, models());
  measure_derivative(*catalog::find<Fast>("inverse_dynamics_second_derivatives"), small_models());
}

template <class Rep> void measure_representation(const std::string& name) {
  measure_function("inverse_dynamics", name,
                   [](const Model& m, auto& w, auto& q, auto& v, auto& a, auto out) {
                     inverse_dynamics<Rep>(m, w, q, v, a, out.first(v.size()));
                   });
  measure_function("forward_dynamics", name,
                   [](const Model& m, auto& w, auto& q, auto& v, auto& a, auto out) {
                     benchmark::DoNotOptimize(forward_dynamics<Rep>(m, w, q, v, a, out.first(v.size())));
                   });
  measure_function("mass_matrix", name, [](const Model& m, auto& w, auto& q, auto&, auto&, auto out) {
    mass_matrix<Rep>(m, w, q, out);
  });
  measure_function("inverse_mass_matrix", name, [](const Model& m, auto& w, auto& q, auto&, auto&, auto out) {
    benchmark::DoNotOptimize(inverse_mass_matrix<Rep>(m, w, q, out));
  });
}

/// Measures the twists of all frames, and their rates.
template <class Rep> void measure_motion(const std::string& name) {
  const auto frames = [](const Model& m) { return static_cast<std::size_t>(m.n_frames()); };
  measure_frames<Twist<Rep>>("twists", name,
                             [frames](const Model& m, auto& w, auto& q, auto& v, auto&, auto out) {
                               twists<Rep>(m, w, q, v, out.first(frames(m)));
                             });
  measure_frames<TwistRate<Rep>>("accelerations", name,
                                 [frames](const Model& m, auto& w, auto& q, auto& v, auto& a, auto out) {
                                   accelerations<Rep>(m, w, q, v, a, out.first(frames(m)));
                                 });
}
/// Measures the Jacobians of all bodies in one call.
template <class Rep> void measure_jacobians(const std::string& name) {
  measure("body_jacobians", name, [](benchmark::State& state, const Model& model) {
    Workspace<> workspace(model);
    States states(model);
    std::vector<Place<>> bodies;
    for (int i = 1; i <= model.n_bodies(); ++i) bodies.emplace_back(i);
    std::vector<Twist<Rep>> J(bodies.size() * static_cast<std::size_t>(model.nv()));
    repeat(state, J.data(), [&] { jacobians<Rep>(model, workspace, states.q[states.next()], bodies, J); });
  });
}

const bool registered = [] {
  measure_representation<Fast>("fast");
  measure_representation<BodyFixed>("body");
  measure_representation<Spatial>("spatial");
  measure_representation<Hybrid>("hybrid");
  measure_representation<Mixed>("mixed");
  measure_all_derivatives();
  measure_function(
      "forward_dynamics", "momentum_form", [](const Model& m, auto& w, auto& q, auto& v, auto& a, auto out) {
        benchmark::DoNotOptimize(momentum_form(m, w, q, v, a, out.first(v.size()), out.last(v.size())));
      });
  measure_frames<Twist<Spatial>>("joint_jacobians", "fast",
                                 [](const Model& m, auto& w, auto& q, auto&, auto&, auto out) {
                                   joint_screws(m, w, q, out.first(static_cast<std::size_t>(m.n_screws())));
                                 });
  measure_jacobians<BodyFixed>("body");
  measure_jacobians<Spatial>("spatial");
  measure_jacobians<Hybrid>("hybrid");
  measure_jacobians<Mixed>("mixed");
  measure_frames<SE3<>>("poses", "fast", [](const Model& m, auto& w, auto& q, auto&, auto&, auto out) {
    poses(m, w, q, out.first(static_cast<std::size_t>(m.n_frames())));
  });
  measure_motion<BodyFixed>("body");
  measure_motion<Spatial>("spatial");
  measure_motion<Hybrid>("hybrid");
  measure_motion<Mixed>("mixed");
  return true;
}();

}  // namespace
