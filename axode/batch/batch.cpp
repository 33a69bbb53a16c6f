#include "axode/batch.hpp"

#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <new>
#include <string>
#include <tuple>
#include <vector>

#include "axode/batch/kernels.hpp"
#include "axode/dynamics.hpp"

namespace axode::batch {
namespace {

enum class InstructionSet { sse2, avx2, avx512 };

InstructionSet best_instruction_set() {
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
    return InstructionSet::avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return InstructionSet::avx2;
  return InstructionSet::sse2;
}
InstructionSet chosen_instruction_set() {
  static const InstructionSet chosen = best_instruction_set();
  return chosen;
}

template <class S> const Kernels<S>& kernels() {
  switch (chosen_instruction_set()) {
    case InstructionSet::avx512: return kernels_avx512(S());
    case InstructionSet::avx2: return kernels_avx2(S());
    case InstructionSet::sse2: break;
  }
  return kernels_sse2(S());
}

/// The number of states, from q.
template <class S> std::size_t check_states(const Model& model, std::span<const S> q, int threads) {
  if (threads < 1)
    throw std::invalid_argument("threads is " + std::to_string(threads) + "; expected 1 or more");
  const std::size_t nq = static_cast<std::size_t>(model.nq());
  if (nq == 0) {
    if (!q.empty()) check_size("q", q.size(), 0, "nq N");
    return 0;
  }
  if (q.size() % nq != 0)
    throw std::invalid_argument("q has " + std::to_string(q.size()) +
                                " entries; expected a multiple of nq = " + std::to_string(nq));
  if (!model.tree<double>().quaternion_bodies.empty())
    for (std::size_t k = 0; k < q.size() / nq; ++k) {
      try {
        check_configuration(model, q.subspan(k * nq, nq));
      } catch (const std::invalid_argument& error) {
        throw std::invalid_argument("state " + std::to_string(k) + ": " + error.what());
      }
    }
  return q.size() / nq;
}

/// Scratch memory from a cache line on.
class Memory {
 public:
  explicit Memory(std::size_t bytes)
      : data_(static_cast<std::byte*>(::operator new (bytes, std::align_val_t{64}))) {}
  std::byte* data() const { return data_.get(); }

 private:
  struct Free {
    void operator()(std::byte* p) const { ::operator delete (p, std::align_val_t{64}); }
  };
  std::unique_ptr<std::byte, Free> data_;
};

/// work(first, count) for the first state of every group of `group` out of N, the last group with fewer states.
/// As many tasks as there are cores to use, each with a work() of its own, take the groups in portions. They
/// run wherever the caller's tasks would, where the threads are awake.
template <class Make> void each_group(std::size_t N, std::size_t group, int threads, const Make& make_work) {
  const std::size_t groups = (N + group - 1) / group;
  const std::size_t tasks =
      std::min(groups, static_cast<std::size_t>(std::min(threads, tbb::info::default_concurrency())));
  const std::size_t portion = std::max<std::size_t>(1, groups / (8 * std::max<std::size_t>(1, tasks)));
  std::atomic<std::size_t> next = 0;
  const auto run = [&](std::size_t) {
    auto work = make_work();
    for (std::size_t begin; (begin = next.fetch_add(portion)) < groups;)
      for (std::size_t g = begin; g < std::min(begin + portion, groups); ++g)
        work(g * group, std::min(group, N - g * group));
  };
  if (tasks < 2)
    run(0);
  else
    tbb::parallel_for(std::size_t{0}, tasks, run, tbb::simple_partitioner());
}

/// An argument with `rows` entries for each state. Where a group of states is not full, its last one is
/// repeated in a copy.
template <class E> struct Argument {
  const char* name;
  const char* meaning;
  std::span<E> all;
  std::size_t rows;
  std::vector<std::remove_const_t<E>> copy = {};

  void check(std::size_t N) const { check_size(name, all.size(), rows * N, meaning); }
  E* at(std::size_t first, std::size_t count, std::size_t lanes) {
    E* begin = all.data() + first * rows;
    if (count == lanes) return begin;
    copy.resize(rows * lanes);
    if constexpr (std::is_const_v<E>)
      for (std::size_t l = 0; l < lanes; ++l)
        std::copy_n(begin + std::min(l, count - 1) * rows, rows,
                    copy.begin() + static_cast<std::ptrdiff_t>(l * rows));
    return copy.data();
  }
  void take_back(std::size_t first, std::size_t count, std::size_t lanes) {
    if (count < lanes) std::copy_n(copy.data(), count * rows, all.data() + first * rows);
  }
};

/// kernel(tree, memory, inputs..., output) on all N states, the first argument being q. Returns for every
/// state whether a kernel doubts it; kernels that return nothing doubt nothing.
template <class S, class Kernel, class E, class... In>
std::vector<char> run_lanes(const Model& model, int threads, const Kernel& kernel, Argument<E> out,
                            Argument<In>... in) {
  const Tree<S>& tree = model.tree<S>();
  const std::size_t lanes = static_cast<std::size_t>(kernels<S>().lanes), N = out.all.size() / out.rows;
  std::vector<char> doubtful(N, 0);
  each_group(N, lanes, threads, [&] {
    return [&, memory = Memory(kernels<S>().bytes(tree)), out, ins = std::tuple(in...)](
               std::size_t first, std::size_t count) mutable {
      const auto call = [&](auto&... each) {
        return kernel(tree, memory.data(), each.at(first, count, lanes)..., out.at(first, count, lanes));
      };
      if constexpr (std::is_void_v<decltype(std::apply(call, ins))>) {
        std::apply(call, ins);
      } else {
        const unsigned doubts = std::apply(call, ins);
        for (std::size_t l = 0; l < count; ++l) doubtful[first + l] = doubts >> l & 1;
      }
      out.take_back(first, count, lanes);
    };
  });
  return doubtful;
}

/// The states that a kernel doubts, or that no kernel takes, one by one: solve(workspace, state) as for a
/// single state.
template <class S, class F>
Outcome solve_each(const Model& model, const std::vector<char>& doubtful, const F& solve) {
  Outcome outcome;
  if (std::find(doubtful.begin(), doubtful.end(), 1) == doubtful.end()) return outcome;
  Workspace<S> workspace(model);
  for (std::size_t k = 0; k < doubtful.size(); ++k) {
    if (!doubtful[k]) continue;
    const Solvability solvability = solve(workspace, k);
    if (!solvability.ok() && outcome.singular_states++ == 0)
      outcome.first = k, outcome.solvability = solvability;
  }
  return outcome;
}

bool coupled(const Model& model) { return !model.tree<double>().coupled_bodies.empty(); }
std::size_t size(int n) { return static_cast<std::size_t>(n); }

}  // namespace

template <class S>
void inverse_dynamics(const Model& model, std::span<const S> q, Numbers<S> v, Numbers<S> a,
                      std::type_identity_t<std::span<S>> tau, int threads) {
  const std::size_t N = check_states(model, q, threads), nv = size(model.nv());
  const Argument<const S> in_v{"v", "nv N", v, nv}, in_a{"a", "nv N", a, nv};
  const Argument<S> out{"tau", "nv N", tau, nv};
  in_v.check(N), in_a.check(N), out.check(N);
  if (N > 0 && nv > 0)
    run_lanes<S>(model, threads, kernels<S>().inverse_dynamics, out,
                 Argument<const S>{"q", "nq N", q, size(model.nq())}, in_v, in_a);
}

template <class S>
Outcome forward_dynamics(const Model& model, std::span<const S> q, Numbers<S> v, Numbers<S> tau,
                         std::type_identity_t<std::span<S>> a, int threads) {
  const std::size_t N = check_states(model, q, threads), nq = size(model.nq()), nv = size(model.nv());
  const Argument<const S> in_v{"v", "nv N", v, nv}, in_tau{"tau", "nv N", tau, nv};
  const Argument<S> out{"a", "nv N", a, nv};
  in_v.check(N), in_tau.check(N), out.check(N);
  std::vector<char> doubtful(N, coupled(model));
  if (N > 0 && !coupled(model))
    doubtful = run_lanes<S>(model, threads, kernels<S>().forward_dynamics, out,
                            Argument<const S>{"q", "nq N", q, nq}, in_v, in_tau);
  return solve_each<S>(model, doubtful, [&](Workspace<S>& workspace, std::size_t k) {
    return axode::forward_dynamics(model, workspace, q.subspan(k * nq, nq), v.subspan(k * nv, nv),
                                   tau.subspan(k * nv, nv), a.subspan(k * nv, nv));
  });
}

template <class S>
void mass_matrix(const Model& model, std::span<const S> q, std::type_identity_t<std::span<S>> M,
                 int threads) {
  const std::size_t N = check_states(model, q, threads), nq = size(model.nq()),
                    nv2 = size(model.nv() * model.nv());
  const Argument<S> out{"M", "nv nv N", M, nv2};
  out.check(N);
  if (N == 0) return;
  if (!coupled(model)) {
    run_lanes<S>(model, threads, kernels<S>().mass_matrix, out, Argument<const S>{"q", "nq N", q, nq});
    return;
  }
  each_group(N, 1, threads, [&] {
    return [&, workspace = Workspace<S>(model)](std::size_t k, std::size_t) mutable {
      axode::mass_matrix(model, workspace, q.subspan(k * nq, nq), M.subspan(k * nv2, nv2));
    };
  });
}

template <class S>
Outcome inverse_mass_matrix(const Model& model, std::span<const S> q,
                            std::type_identity_t<std::span<S>> M_inverse, int threads) {
  const std::size_t N = check_states(model, q, threads), nq = size(model.nq()),
                    nv2 = size(model.nv() * model.nv());
  const Argument<S> out{"M_inverse", "nv nv N", M_inverse, nv2};
  out.check(N);
  std::vector<char> doubtful(N, coupled(model));
  if (N > 0 && !coupled(model))
    doubtful = run_lanes<S>(model, threads, kernels<S>().inverse_mass_matrix, out,
                            Argument<const S>{"q", "nq N", q, nq});
  return solve_each<S>(model, doubtful, [&](Workspace<S>& workspace, std::size_t k) {
    return axode::inverse_mass_matrix(model, workspace, q.subspan(k * nq, nq),
                                      M_inverse.subspan(k * nv2, nv2));
  });
}

template <class S>
void poses(const Model& model, std::span<const S> q, std::type_identity_t<std::span<SE3<S>>> C, int threads) {
  const std::size_t N = check_states(model, q, threads);
  const Argument<SE3<S>> out{"C", "n_frames N", C, size(model.n_frames())};
  out.check(N);
  if (N > 0)
    run_lanes<S>(model, threads, kernels<S>().poses, out,
                 Argument<const S>{"q", "nq N", q, size(model.nq())});
}

template <class S>
void joint_screws(const Model& model, std::span<const S> q,
                  std::type_identity_t<std::span<Twist<Spatial, S>>> J, int threads) {
  const std::size_t N = check_states(model, q, threads);
  const Argument<Twist<Spatial, S>> out{"J", "n_screws N", J, size(model.n_screws())};
  out.check(N);
  if (N > 0)
    run_lanes<S>(model, threads, kernels<S>().joint_screws, out,
                 Argument<const S>{"q", "nq N", q, size(model.nq())});
}

const char* instruction_set() {
  switch (chosen_instruction_set()) {
    case InstructionSet::avx512: return "AVX-512";
    case InstructionSet::avx2: return "AVX2";
    case InstructionSet::sse2: break;
  }
  return "SSE2";
}

template void inverse_dynamics(const Model&, std::span<const double>, Numbers<double>, Numbers<double>,
                               std::span<double>, int);
template void inverse_dynamics(const Model&, std::span<const float>, Numbers<float>, Numbers<float>,
                               std::span<float>, int);
template Outcome forward_dynamics(const Model&, std::span<const double>, Numbers<double>, Numbers<double>,
                                  std::span<double>, int);
template Outcome forward_dynamics(const Model&, std::span<const float>, Numbers<float>, Numbers<float>,
                                  std::span<float>, int);
template void mass_matrix(const Model&, std::span<const double>, std::span<double>, int);
template void mass_matrix(const Model&, std::span<const float>, std::span<float>, int);
template Outcome inverse_mass_matrix(const Model&, std::span<const double>, std::span<double>, int);
template Outcome inverse_mass_matrix(const Model&, std::span<const float>, std::span<float>, int);
template void poses(const Model&, std::span<const double>, std::span<SE3<double>>, int);
template void poses(const Model&, std::span<const float>, std::span<SE3<float>>, int);
template void joint_screws(const Model&, std::span<const double>, std::span<Twist<Spatial, double>>, int);
template void joint_screws(const Model&, std::span<const float>, std::span<Twist<Spatial, float>>, int);

}  // namespace axode::batch
