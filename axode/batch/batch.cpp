#include "axode/batch.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "axode/batch/check_states.hpp"
#include "axode/batch/instruction_set.hpp"
#include "axode/batch/kernels.hpp"
#include "axode/batch/portions.hpp"
#include "axode/batch/scratch.hpp"
#include "axode/derivatives.hpp"
#include "axode/dynamics.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/model/finite.hpp"

namespace axode::batch {
namespace {

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

/// kernel.call(tree, arena, inputs..., output) on a group of states in the lanes, the first argument being q. It returns what
/// the kernel does.
template <class S, class F, class E, class... In> class LaneCall {
 public:
  LaneCall(const Tree<S>& tree, const Kernel<S, F>& kernel, Argument<E> out, Argument<In>... in)
      : tree_(tree),
        kernel_(kernel),
        bytes_(kernel.bytes(tree)),
        memory_(scratch<std::byte>(bytes_)),
        out_(std::move(out)),
        in_(std::move(in)...) {}

  auto operator()(std::size_t first, std::size_t count) {
    const auto call = [&](auto&... each) {
      return kernel_.call(tree_, Arena(*tree_.topology(), memory_.get(), bytes_),
                          each.at(first, count, lanes())..., out_.at(first, count, lanes()));
    };
    if constexpr (std::is_void_v<decltype(std::apply(call, in_))>) {
      std::apply(call, in_);
      out_.take_back(first, count, lanes());
    } else {
      const unsigned doubts = std::apply(call, in_);
      out_.take_back(first, count, lanes());
      return doubts;
    }
  }
  static std::size_t lanes() { return static_cast<std::size_t>(best_kernels<S>().lanes); }

 private:
  const Tree<S>& tree_;
  Kernel<S, F> kernel_;
  std::size_t bytes_;
  std::shared_ptr<std::byte> memory_;
  Argument<E> out_;
  std::tuple<Argument<In>...> in_;
};

/// A kernel that succeeds, on all states. Returns how many are done.
template <class S, class F, class E, class... In>
std::size_t run_lanes(const Model& model, int threads, const Monitor& monitor, const Kernel<S, F>& kernel,
                      const Argument<E>& out, const Argument<In>&... in) {
  using Call = LaneCall<S, F, E, In...>;
  return in_portions(out.all.size() / out.rows, Call::lanes(), threads, monitor,
                     [&] { return Call(model.tree<S>(), kernel, out, in...); });
}

bool coupled(const Model& model) { return !model.tree<double>()->coupled_bodies.empty(); }

/// A kernel that returns which states it doubts, on all states. These, and all where joints are coupled, which no kernel
/// takes, are solved one by one: solve(workspace, state) as for a single state.
template <class S, class Solve, class F, class... In>
Outcome solve_lanes(const Model& model, int threads, const Monitor& monitor, const Solve& solve,
                    const Kernel<S, F>& kernel, const Argument<S>& out, const Argument<In>&... in) {
  using Call = LaneCall<S, F, S, In...>;
  enum Verdict : char { solved, singular, not_finite };
  const std::size_t N = out.rows == 0 ? 0 : out.all.size() / out.rows;
  const bool in_lanes = !coupled(model);
  std::vector<Verdict> verdicts(N, solved);
  Outcome outcome;
  outcome.done = in_portions(N, Call::lanes(), threads, monitor, [&] {
    std::optional<Call> made;
    if (in_lanes) made.emplace(model.tree<S>(), kernel, out, in...);
    return [&, call = std::move(made), workspace = std::optional<Workspace<S>>()](std::size_t first,
                                                                                  std::size_t count) mutable {
      const unsigned doubts = call ? (*call)(first, count) : ~0u;
      for (std::size_t l = 0; l < count; ++l) {
        const std::size_t k = first + l;
        if ((doubts >> l & 1) == 0) {
          verdicts[k] = finite(out.all.subspan(k * out.rows, out.rows)) ? solved : not_finite;
        } else {
          if (!workspace) workspace.emplace(model);
          verdicts[k] = solve(*workspace, k).ok() ? solved : singular;
        }
      }
    };
  });
  for (std::size_t k = 0; k < outcome.done; ++k)
    if (verdicts[k] != solved && outcome.singular_states++ == 0) outcome.first = k;
  if (outcome.ok()) return outcome;
  outcome.solvability.not_finite = true;
  if (verdicts[outcome.first] == singular) {
    Workspace<S> workspace(model);
    outcome.solvability = solve(workspace, outcome.first);
  }
  return outcome;
}

std::size_t size(int n) { return static_cast<std::size_t>(n); }

template <class S> struct Velocities {
  const char* name;
  std::span<const S> all;
};

/// How many states there are. All arguments have nv numbers for each, and the result memory of its own.
template <class S, class... In>
std::size_t check_velocities(const Model& model, int threads, const Argument<S>& out, std::span<const S> q,
                             const In&... in) {
  const std::size_t N = check_states(model, q, threads);
  (check_size(in.name, in.all.size(), size(model.nv()) * N, "nv N"), ...);
  out.check(N);
  check_separate(out.name, out.all, "q", q);
  (check_separate(out.name, out.all, in.name, in.all), ...);
  return N;
}

/// A kernel that succeeds on q and arguments of nv numbers, with `rows` results for each state.
template <class S, class F, class... In>
std::size_t on_velocities(const Model& model, int threads, const Monitor& monitor, const Kernel<S, F>& kernel,
                          const Argument<S>& out, std::span<const S> q, const In&... in) {
  const std::size_t N = check_velocities<S>(model, threads, out, q, in...), nv = size(model.nv());
  if (N == 0 || nv == 0) return N;
  return run_lanes<S>(model, threads, monitor, kernel, out,
                      Argument<const S>{"q", "nq N", q, size(model.nq())},
                      Argument<const S>{in.name, "nv N", in.all, nv}...);
}
/// One that may doubt states, where solve(workspace, x..., result) takes its place.
template <class S, class Solve, class F, class... In>
Outcome solve_on_velocities(const Model& model, int threads, const Monitor& monitor, const Solve& solve,
                            const Kernel<S, F>& kernel, const Argument<S>& out, std::span<const S> q,
                            const In&... in) {
  check_velocities<S>(model, threads, out, q, in...);
  const std::size_t nq = size(model.nq()), nv = size(model.nv());
  const auto solve_one = [&](Workspace<S>& workspace, std::size_t k) {
    return solve(workspace, q.subspan(k * nq, nq), in.all.subspan(k * nv, nv)...,
                 out.all.subspan(k * out.rows, out.rows));
  };
  return solve_lanes<S>(model, threads, monitor, solve_one, kernel, out,
                        Argument<const S>{"q", "nq N", q, nq},
                        Argument<const S>{in.name, "nv N", in.all, nv}...);
}

std::size_t squared(int n) { return size(n) * size(n); }
/// Part k of three.
template <class S> std::span<S> third(std::span<S> all, std::size_t k) {
  return all.subspan(k * (all.size() / 3), all.size() / 3);
}

}  // namespace

template <class S> const Kernels<S>& best_kernels() {
  switch (best_instruction_set()) {
    case InstructionSet::avx512: return kernels<batch::avx512, S>();
    case InstructionSet::avx2: return kernels<batch::avx2, S>();
    case InstructionSet::sse2: break;
  }
  return kernels<batch::sse2, S>();
}
template const Kernels<double>& best_kernels();
template const Kernels<float>& best_kernels();

template <class S>
std::size_t inverse_dynamics(const Model& model, std::span<const S> q, Numbers<S> v, Numbers<S> a,
                             std::type_identity_t<std::span<S>> tau, int threads, const Monitor& monitor) {
  return on_velocities<S>(model, threads, monitor, best_kernels<S>().inverse_dynamics,
                          Argument<S>{"tau", "nv N", tau, size(model.nv())}, q, Velocities<S>{"v", v},
                          Velocities<S>{"a", a});
}

template <class S>
Outcome forward_dynamics(const Model& model, std::span<const S> q, Numbers<S> v, Numbers<S> tau,
                         std::type_identity_t<std::span<S>> a, int threads, const Monitor& monitor) {
  return solve_on_velocities<S>(
      model, threads, monitor,
      [&](auto& w, auto q_k, auto v_k, auto tau_k, auto a_k) {
        return axode::forward_dynamics(model, w, q_k, v_k, tau_k, a_k);
      },
      best_kernels<S>().forward_dynamics, Argument<S>{"a", "nv N", a, size(model.nv())}, q,
      Velocities<S>{"v", v}, Velocities<S>{"tau", tau});
}

template <class S>
std::size_t inverse_dynamics_derivatives(const Model& model, std::span<const S> q, Numbers<S> v, Numbers<S> a,
                                         std::type_identity_t<std::span<S>> dtau, int threads,
                                         const Monitor& monitor) {
  return on_velocities<S>(model, threads, monitor, best_kernels<S>().inverse_dynamics_derivatives,
                          Argument<S>{"dtau", "3 nv nv N", dtau, 3 * squared(model.nv())}, q,
                          Velocities<S>{"v", v}, Velocities<S>{"a", a});
}

template <class S>
Outcome forward_dynamics_derivatives(const Model& model, std::span<const S> q, Numbers<S> v, Numbers<S> tau,
                                     std::type_identity_t<std::span<S>> da, int threads,
                                     const Monitor& monitor) {
  return solve_on_velocities<S>(
      model, threads, monitor,
      [&](auto& w, auto q_k, auto v_k, auto tau_k, auto out) {
        return axode::forward_dynamics_derivatives(model, w, q_k, v_k, tau_k,
                                                   {third(out, 0), third(out, 1), third(out, 2)});
      },
      best_kernels<S>().forward_dynamics_derivatives,
      Argument<S>{"da", "3 nv nv N", da, 3 * squared(model.nv())}, q, Velocities<S>{"v", v},
      Velocities<S>{"tau", tau});
}

template <class S>
std::size_t inverse_dynamics_jvp(const Model& model, std::span<const S> q, Numbers<S> v, Numbers<S> a,
                                 Numbers<S> dq, Numbers<S> dv, Numbers<S> da,
                                 std::type_identity_t<std::span<S>> dtau, int threads,
                                 const Monitor& monitor) {
  return on_velocities<S>(model, threads, monitor, best_kernels<S>().inverse_dynamics_jvp,
                          Argument<S>{"dtau", "nv N", dtau, size(model.nv())}, q, Velocities<S>{"v", v},
                          Velocities<S>{"a", a}, Velocities<S>{"dq", dq}, Velocities<S>{"dv", dv},
                          Velocities<S>{"da", da});
}

template <class S>
Outcome forward_dynamics_jvp(const Model& model, std::span<const S> q, Numbers<S> v, Numbers<S> tau,
                             Numbers<S> dq, Numbers<S> dv, Numbers<S> dtau,
                             std::type_identity_t<std::span<S>> da, int threads, const Monitor& monitor) {
  return solve_on_velocities<S>(
      model, threads, monitor,
      [&](auto& w, auto q_k, auto v_k, auto tau_k, auto dq_k, auto dv_k, auto dtau_k, auto out) {
        return axode::forward_dynamics_jvp(model, w, q_k, v_k, tau_k, dq_k, dv_k, dtau_k, out);
      },
      best_kernels<S>().forward_dynamics_jvp, Argument<S>{"da", "nv N", da, size(model.nv())}, q,
      Velocities<S>{"v", v}, Velocities<S>{"tau", tau}, Velocities<S>{"dq", dq}, Velocities<S>{"dv", dv},
      Velocities<S>{"dtau", dtau});
}

template <class S>
std::size_t inverse_dynamics_vjp(const Model& model, std::span<const S> q, Numbers<S> v, Numbers<S> a,
                                 Numbers<S> w, std::type_identity_t<std::span<S>> gradient, int threads,
                                 const Monitor& monitor) {
  return on_velocities<S>(model, threads, monitor, best_kernels<S>().inverse_dynamics_vjp,
                          Argument<S>{"gradient", "3 nv N", gradient, 3 * size(model.nv())}, q,
                          Velocities<S>{"v", v}, Velocities<S>{"a", a}, Velocities<S>{"w", w});
}

template <class S>
Outcome forward_dynamics_vjp(const Model& model, std::span<const S> q, Numbers<S> v, Numbers<S> tau,
                             Numbers<S> w, std::type_identity_t<std::span<S>> gradient, int threads,
                             const Monitor& monitor) {
  return solve_on_velocities<S>(
      model, threads, monitor,
      [&](auto& workspace, auto q_k, auto v_k, auto tau_k, auto w_k, auto out) {
        return axode::forward_dynamics_vjp(model, workspace, q_k, v_k, tau_k, w_k,
                                           {third(out, 0), third(out, 1), third(out, 2)});
      },
      best_kernels<S>().forward_dynamics_vjp,
      Argument<S>{"gradient", "3 nv N", gradient, 3 * size(model.nv())}, q, Velocities<S>{"v", v},
      Velocities<S>{"tau", tau}, Velocities<S>{"w", w});
}

template <class S>
std::size_t mass_matrix(const Model& model, std::span<const S> q, std::type_identity_t<std::span<S>> M,
                        int threads, const Monitor& monitor) {
  const std::size_t N = check_states(model, q, threads), nq = size(model.nq()),
                    nv2 = size(model.nv()) * size(model.nv());
  const Argument<S> out{"M", "nv nv N", M, nv2};
  out.check(N);
  check_separate("M", M, "q", q);
  if (N == 0) return 0;
  if (!coupled(model))
    return run_lanes<S>(model, threads, monitor, best_kernels<S>().mass_matrix, out,
                        Argument<const S>{"q", "nq N", q, nq});
  return in_portions(N, 1, threads, monitor, [&] {
    return [&, workspace = Workspace<S>(model)](std::size_t k, std::size_t) mutable {
      axode::mass_matrix(model, workspace, q.subspan(k * nq, nq), M.subspan(k * nv2, nv2));
    };
  });
}

template <class S>
Outcome inverse_mass_matrix(const Model& model, std::span<const S> q,
                            std::type_identity_t<std::span<S>> M_inverse, int threads,
                            const Monitor& monitor) {
  const std::size_t N = check_states(model, q, threads), nq = size(model.nq()),
                    nv2 = size(model.nv()) * size(model.nv());
  const Argument<S> out{"M_inverse", "nv nv N", M_inverse, nv2};
  out.check(N);
  check_separate("M_inverse", M_inverse, "q", q);
  const auto solve = [&](Workspace<S>& workspace, std::size_t k) {
    return axode::inverse_mass_matrix(model, workspace, q.subspan(k * nq, nq),
                                      M_inverse.subspan(k * nv2, nv2));
  };
  return solve_lanes<S>(model, threads, monitor, solve, best_kernels<S>().inverse_mass_matrix, out,
                        Argument<const S>{"q", "nq N", q, nq});
}

template <class S>
std::size_t poses(const Model& model, std::span<const S> q, std::type_identity_t<std::span<SE3<S>>> C,
                  int threads, const Monitor& monitor) {
  const std::size_t N = check_states(model, q, threads);
  const Argument<SE3<S>> out{"C", "n_frames N", C, size(model.n_frames())};
  out.check(N);
  check_separate("C", C, "q", q);
  if (N == 0) return 0;
  return run_lanes<S>(model, threads, monitor, best_kernels<S>().poses, out,
                      Argument<const S>{"q", "nq N", q, size(model.nq())});
}

template <class S>
std::size_t joint_screws(const Model& model, std::span<const S> q,
                         std::type_identity_t<std::span<Twist<Spatial, S>>> J, int threads,
                         const Monitor& monitor) {
  const std::size_t N = check_states(model, q, threads);
  const Argument<Twist<Spatial, S>> out{"J", "n_screws N", J, size(model.n_screws())};
  out.check(N);
  check_separate("J", J, "q", q);
  if (N == 0) return 0;
  return run_lanes<S>(model, threads, monitor, best_kernels<S>().joint_screws, out,
                      Argument<const S>{"q", "nq N", q, size(model.nq())});
}

template std::size_t inverse_dynamics(const Model&, std::span<const double>, Numbers<double>, Numbers<double>,
                                      std::span<double>, int, const Monitor&);
template Outcome forward_dynamics(const Model&, std::span<const double>, Numbers<double>, Numbers<double>,
                                  std::span<double>, int, const Monitor&);
template std::size_t inverse_dynamics_derivatives(const Model&, std::span<const double>, Numbers<double>,
                                                  Numbers<double>, std::span<double>, int, const Monitor&);
template std::size_t inverse_dynamics_jvp(const Model&, std::span<const double>, Numbers<double>,
                                          Numbers<double>, Numbers<double>, Numbers<double>, Numbers<double>,
                                          std::span<double>, int, const Monitor&);
template std::size_t inverse_dynamics_vjp(const Model&, std::span<const double>, Numbers<double>,
                                          Numbers<double>, Numbers<double>, std::span<double>, int,
                                          const Monitor&);
template Outcome forward_dynamics_derivatives(const Model&, std::span<const double>, Numbers<double>,
                                              Numbers<double>, std::span<double>, int, const Monitor&);
template Outcome forward_dynamics_jvp(const Model&, std::span<const double>, Numbers<double>, Numbers<double>,
                                      Numbers<double>, Numbers<double>, Numbers<double>, std::span<double>,
                                      int, const Monitor&);
template Outcome forward_dynamics_vjp(const Model&, std::span<const double>, Numbers<double>, Numbers<double>,
                                      Numbers<double>, std::span<double>, int, const Monitor&);
template std::size_t mass_matrix(const Model&, std::span<const double>, std::span<double>, int,
                                 const Monitor&);
template Outcome inverse_mass_matrix(const Model&, std::span<const double>, std::span<double>, int,
                                     const Monitor&);
template std::size_t poses(const Model&, std::span<const double>, std::span<SE3<double>>, int,
                           const Monitor&);
template std::size_t joint_screws(const Model&, std::span<const double>, std::span<Twist<Spatial, double>>,
                                  int, const Monitor&);
template std::size_t inverse_dynamics(const Model&, std::span<const float>, Numbers<float>, Numbers<float>,
                                      std::span<float>, int, const Monitor&);
template Outcome forward_dynamics(const Model&, std::span<const float>, Numbers<float>, Numbers<float>,
                                  std::span<float>, int, const Monitor&);
template std::size_t inverse_dynamics_derivatives(const Model&, std::span<const float>, Numbers<float>,
                                                  Numbers<float>, std::span<float>, int, const Monitor&);
template std::size_t inverse_dynamics_jvp(const Model&, std::span<const float>, Numbers<float>,
                                          Numbers<float>, Numbers<float>, Numbers<float>, Numbers<float>,
                                          std::span<float>, int, const Monitor&);
template std::size_t inverse_dynamics_vjp(const Model&, std::span<const float>, Numbers<float>,
                                          Numbers<float>, Numbers<float>, std::span<float>, int,
                                          const Monitor&);
template Outcome forward_dynamics_derivatives(const Model&, std::span<const float>, Numbers<float>,
                                              Numbers<float>, std::span<float>, int, const Monitor&);
template Outcome forward_dynamics_jvp(const Model&, std::span<const float>, Numbers<float>, Numbers<float>,
                                      Numbers<float>, Numbers<float>, Numbers<float>, std::span<float>, int,
                                      const Monitor&);
template Outcome forward_dynamics_vjp(const Model&, std::span<const float>, Numbers<float>, Numbers<float>,
                                      Numbers<float>, std::span<float>, int, const Monitor&);
template std::size_t mass_matrix(const Model&, std::span<const float>, std::span<float>, int, const Monitor&);
template Outcome inverse_mass_matrix(const Model&, std::span<const float>, std::span<float>, int,
                                     const Monitor&);
template std::size_t poses(const Model&, std::span<const float>, std::span<SE3<float>>, int, const Monitor&);
template std::size_t joint_screws(const Model&, std::span<const float>, std::span<Twist<Spatial, float>>, int,
                                  const Monitor&);

}  // namespace axode::batch
