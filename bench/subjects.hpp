#pragma once
#include <benchmark/benchmark.h>

#include <random>
#include <span>
#include <string>
#include <vector>

#include "axode/axode.hpp"

/// What the benchmarks are run on: mechanisms and their states. A benchmark is called
/// <function>/<model>/<variant>; the variants of one function and model are compared.
namespace axode::bench {

/// The project's arm; robots of $AXODE_ROBOTS (default ../shared/robots), where they are, legged ones with a
/// free base and with couplings undone; chains of hinges with axes in general position; a binary tree of 63
/// hinges.
const std::vector<Model>& models();
/// Those with so few velocities that cubes of their number fit into a cache.
const std::vector<Model>& small_models();

/// More states than a cache line holds, so that no branch or value is predicted from the run before.
struct States {
  static constexpr std::size_t count = 64;
  std::vector<std::vector<double>> q, v, a, jerk;

  explicit States(const Model& model);
  std::size_t next() { return k_ = (k_ + 1) % count; }

 private:
  std::size_t k_ = 0;
};

/// A mechanism with loops, and the same for a peer whose loops are balls alone: a rod without mass is a body there, last of
/// all, that weighs next to nothing.
struct ClosedMechanism {
  Model model, of_balls;
};

/// The Gough platform, the leg, and the leg with a rod that is a body in both.
const std::vector<ClosedMechanism>& closed_mechanisms();
/// A four-bar linkage, the Gough platform, the leg with a rod, and a cart on three wheels.
const std::vector<ClosedMechanism>& loop_mechanisms();

/// Closed configurations near that of the drawing, velocities that keep them closed, and drive forces; with the
/// coordinates of the rod, which has no drives.
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

/// Runs f() and keeps what it wrote.
template <class Out, class F> void repeat(benchmark::State& state, Out* out, const F& f) {
  for (auto _ : state) {
    f();
    benchmark::DoNotOptimize(out);
    benchmark::ClobberMemory();
  }
}

/// f(model, workspace, q, v, a, out) on every model; out has a number for each pair of velocities.
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
