#pragma once
#include <benchmark/benchmark.h>

#include <random>
#include <span>
#include <string>
#include <vector>

#include "axode/axode.hpp"

/// The mechanisms and states of the benchmarks. The name of a benchmark is <function>/<model>/<variant>; the
/// variants of one function and model are compared.
namespace axode::bench {

/// The project's arm; the robots of $AXODE_ROBOTS (default ../shared/robots), if they exist, with a free base
/// for those with legs and without their couplings; chains of hinges with axes in general position; and a
/// binary tree of 63 hinges.
const std::vector<Model>& models();
/// The models with so few velocities that arrays of nv³ numbers fit into a cache.
const std::vector<Model>& small_models();

/// 64 random states, which a benchmark takes in turn. They are more than a cache line holds, so that the
/// processor predicts no branch and no value from the previous run.
struct States {
  static constexpr std::size_t count = 64;
  std::vector<std::vector<double>> q, v, a, jerk;

  explicit States(const Model& model);
  std::size_t next() { return k_ = (k_ + 1) % count; }

 private:
  std::size_t k_ = 0;
};

/// A mechanism with loops, and the same mechanism for a library that has spherical loops only. There a
/// massless rod is a body of almost no mass, which comes last.
struct ClosedMechanism {
  Model model, of_balls;
};

/// The Gough platform, the leg, and the leg with a rod that is a body in both models.
const std::vector<ClosedMechanism>& closed_mechanisms();
/// A four-bar linkage, the Gough platform, the leg with a rod, and a cart on three wheels.
const std::vector<ClosedMechanism>& loop_mechanisms();

/// Closed configurations near that of the drawing, velocities that keep the loops closed, and drive forces.
/// They include the coordinates of the rod, which has no drives.
struct ClosedStates {
  std::vector<std::vector<double>> q, v, tau;

  explicit ClosedStates(const ClosedMechanism& mechanism);
  std::size_t next() { return k_ = (k_ + 1) % States::count; }

 private:
  std::size_t k_ = 0;
};

/// Registers f(benchmark state, model) under <function>/<model>/<variant> for every model.
template <class F>
void measure(const std::string& function, const std::string& variant, const F& f,
             const std::vector<Model>& subjects = models()) {
  for (const Model& model : subjects)
    benchmark::RegisterBenchmark((function + "/" + model.name() + "/" + variant).c_str(), f, model);
}

/// Runs f() and makes sure that the compiler does not remove its results.
template <class Out, class F> void repeat(benchmark::State& state, Out* out, const F& f) {
  for (auto _ : state) {
    f();
    benchmark::DoNotOptimize(out);
    benchmark::ClobberMemory();
  }
}

/// Measures f(model, workspace, q, v, a, out) for every model; `out` has a number for each pair of
/// velocities.
template <class F>
void measure_function(const std::string& function, const std::string& variant, const F& f,
                      const std::vector<Model>& subjects = models()) {
  measure(
      function, variant,
      [f](benchmark::State& state, const Model& model) {
        Workspace<> workspace(model);
        States states(model);
        const std::size_t nv = static_cast<std::size_t>(model.nv());
        std::vector<double> out(nv * nv);
        repeat(state, out.data(), [&] {
          const std::size_t s = states.next();
          f(model, workspace, states.q[s], states.v[s], states.a[s], std::span(out));
        });
      },
      subjects);
}

}  // namespace axode::bench
