// 4,096 states in one call. The result is the time for one state, on one core and on two.
#include "axode/batch.hpp"
#include "bench/subjects.hpp"

namespace {

using namespace axode;
using namespace axode::bench;

constexpr std::size_t N = 4096;

template <class T> struct Block {
  std::size_t nv;
  std::vector<T> q, v, a, out;

  Block(const Model& model, std::size_t numbers_out)
      : nv(static_cast<std::size_t>(model.nv())), out(numbers_out * N) {
    const States states(model);
    for (std::size_t k = 0; k < N; ++k) {
      const std::size_t s = k % States::count;
      q.insert(q.end(), states.q[s].begin(), states.q[s].end());
      v.insert(v.end(), states.v[s].begin(), states.v[s].end());
      a.insert(a.end(), states.a[s].begin(), states.a[s].end());
    }
  }
};

/// Measures f(model, block, threads) for every model whose results fit into memory.
template <class T, class F> void measure_batch(const std::string& function, bool matrix, const F& f) {
  for (const int threads : {1, 2})
    measure(function,
            "batch_" + std::string(std::is_same_v<T, double> ? "double" : "float") + "_" +
                std::to_string(threads) + "_threads",
            [f, matrix, threads](benchmark::State& state, const Model& model) {
              const std::size_t nv = static_cast<std::size_t>(model.nv());
              Block<T> block(model, matrix ? nv * nv : nv);
              repeat(state, block.out.data(), [&] { f(model, block, threads); });
              state.counters["states"] = N;
            });
}

template <class T> void measure_all() {
  measure_batch<T>("inverse_dynamics", false, [](const Model& m, Block<T>& b, int threads) {
    static_cast<void>(batch::run<T>(m, "inverse_dynamics", {.q = b.q, .v = b.v, .a = b.a}, b.out, threads));
  });
  measure_batch<T>("forward_dynamics", false, [](const Model& m, Block<T>& b, int threads) {
    benchmark::DoNotOptimize(
        batch::run<T>(m, "forward_dynamics", {.q = b.q, .v = b.v, .tau = b.a}, b.out, threads));
  });
  measure_batch<T>("mass_matrix", true, [](const Model& m, Block<T>& b, int threads) {
    static_cast<void>(batch::run<T>(m, "mass_matrix", {.q = b.q}, b.out, threads));
  });
  measure_batch<T>("inverse_mass_matrix", true, [](const Model& m, Block<T>& b, int threads) {
    benchmark::DoNotOptimize(batch::run<T>(m, "inverse_mass_matrix", {.q = b.q}, b.out, threads));
  });
}

const bool registered = [] {
  measure_all<double>();
  measure_all<float>();
  return true;
}();

}  // namespace
