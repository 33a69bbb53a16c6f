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

/// More states than a cache line holds, so that no branch or value is predicted from the run before.
struct States {
  static constexpr std::size_t count = 64;
  std::vector<std::vector<double>> q, v, a, jerk;

  explicit States(const Model& model);
  std::size_t next() { return k_ = (k_ + 1) % count; }

 private:
  std::size_t k_ = 0;
};

/// Registers f(benchmark state, model) under <function>/<model>/<variant> for every model.
template <class F> void measure(const std::string& function, const std::string& variant, const F& f) {
  for (const Model& model : models())
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

}  // namespace axode::bench
