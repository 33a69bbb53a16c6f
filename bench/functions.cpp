// Every function that a control loop calls, in one thread, on states drawn at random.
#include <cmath>

#include "axode/derivatives.hpp"
#include "bench/subjects.hpp"

namespace {

using namespace axode;
using namespace axode::bench;

/// f(model, workspace, q, v, a, out) with an Entry for each frame.
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

/// f(model, workspace, state, q, v, a, three matrices or more in one piece of memory).
template <class F>
void measure_derivatives(const std::string& function, const F& f, int powers,
                         const std::vector<Model>& subjects = models()) {
  measure(
      function, "fast",
      [f, powers](benchmark::State& state, const Model& model) {
        Workspace<> workspace(model);
        States states(model);
        const std::size_t nv = static_cast<std::size_t>(model.nv());
        std::vector<double> out(4 * static_cast<std::size_t>(std::pow(nv, powers)));
        const std::span<double> all(out);
        const auto part = [&](std::size_t k) { return all.subspan(k * (out.size() / 4), out.size() / 4); };
        repeat(state, out.data(), [&] {
          const std::size_t s = states.next();
          f(model, workspace, states.q[s], states.v[s], states.a[s], states.jerk[s], part);
        });
      },
      subjects);
}
void measure_all_derivatives() {
  measure_derivatives(
      "inverse_dynamics_derivatives",
      [](const Model& m, auto& w, auto& q, auto& v, auto& a, auto&, auto part) {
        inverse_dynamics_derivatives(m, w, q, v, a, {part(0), part(1), part(2)});
      },
      2);
  measure_derivatives(
      "forward_dynamics_derivatives",
      [](const Model& m, auto& w, auto& q, auto& v, auto& tau, auto&, auto part) {
        benchmark::DoNotOptimize(forward_dynamics_derivatives(m, w, q, v, tau, {part(0), part(1), part(2)}));
      },
      2);
  measure_derivatives(
      "inverse_dynamics_jvp",
      [](const Model& m, auto& w, auto& q, auto& v, auto& a, auto& x, auto part) {
        inverse_dynamics_jvp(m, w, q, v, a, x, x, x, part(0));
      },
      1);
  measure_derivatives(
      "inverse_dynamics_vjp",
      [](const Model& m, auto& w, auto& q, auto& v, auto& a, auto& x, auto part) {
        inverse_dynamics_vjp(m, w, q, v, a, x, {part(0), part(1), part(2)});
      },
      1);
  measure_derivatives(
      "forward_dynamics_jvp",
      [](const Model& m, auto& w, auto& q, auto& v, auto& tau, auto& x, auto part) {
        benchmark::DoNotOptimize(forward_dynamics_jvp(m, w, q, v, tau, x, x, x, part(0)));
      },
      1);
  measure_derivatives(
      "forward_dynamics_vjp",
      [](const Model& m, auto& w, auto& q, auto& v, auto& tau, auto& x, auto part) {
        benchmark::DoNotOptimize(forward_dynamics_vjp(m, w, q, v, tau, x, {part(0), part(1), part(2)}));
      },
      1);
  measure_derivatives(
      "inverse_dynamics_hessian",
      [](const Model& m, auto& w, auto& q, auto& v, auto& a, auto& x, auto part) {
        inverse_dynamics_hessian(m, w, q, v, a, x, {part(0), part(1), part(2), part(3)});
      },
      2);
  measure_derivatives(
      "forward_dynamics_hessian",
      [](const Model& m, auto& w, auto& q, auto& v, auto& tau, auto& x, auto part) {
        benchmark::DoNotOptimize(
            forward_dynamics_hessian(m, w, q, v, tau, x, {part(0), part(1), part(2), part(3)}));
      },
      2);
  measure_derivatives(
      "inverse_dynamics_second_derivatives",
      [](const Model& m, auto& w, auto& q, auto& v, auto& a, auto&, auto part) {
        inverse_dynamics_second_derivatives(m, w, q, v, a, {part(0), part(1), part(2), part(3)});
      },
      3, small_models());
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

/// Twists of all frames, and their rates.
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
/// Those of every body in one call.
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
