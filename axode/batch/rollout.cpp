#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "axode/batch.hpp"
#include "axode/batch/check_states.hpp"
#include "axode/batch/portions.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/integration/munthe_kaas.hpp"

namespace axode::batch {

Outcome rollout(const Model& model, std::span<const double> q, std::span<const double> v,
                std::span<const double> tau, double step, std::span<double> q_out, std::span<double> v_out,
                const Tableau& method, int threads, const Monitor& monitor) {
  constexpr std::size_t steps_at_once = 256;  // of one motion, between two looks at the monitor
  check(method), check_step(step);
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv()),
                    N = check_states(model, q, threads), K = N == 0 ? 0 : tau.size() / (N * nv);
  check_size("v", v.size(), N * nv, "nv N");
  check_size("tau", tau.size(), K * nv * N, "K nv N");
  check_size("q_out", q_out.size(), (K + 1) * nq * N, "(K + 1) nq N");
  check_size("v_out", v_out.size(), (K + 1) * nv * N, "(K + 1) nv N");
  for (const auto& [name, given] : {std::pair{"q", q}, {"v", v}, {"tau", tau}})
    check_separate("q_out", q_out, name, given), check_separate("v_out", v_out, name, given);
  check_separate("q_out", q_out, "v_out", std::span<const double>(v_out));

  for (const std::span<double> out : {q_out, v_out})
    std::ranges::fill(out, std::numeric_limits<double>::quiet_NaN());
  const auto q_at = [&](std::size_t n, std::size_t k) { return q_out.subspan((n * (K + 1) + k) * nq, nq); };
  const auto v_at = [&](std::size_t n, std::size_t k) { return v_out.subspan((n * (K + 1) + k) * nv, nv); };
  for (std::size_t n = 0; n < N; ++n)
    std::ranges::copy(q.subspan(n * nq, nq), q_at(n, 0).begin()),
        std::ranges::copy(v.subspan(n * nv, nv), v_at(n, 0).begin());

  std::vector<Solvability> found(N);
  Outcome outcome{.done = N};
  Watch watch(monitor, N);
  for (std::size_t begin = 0; begin < K && outcome.done == N; begin += steps_at_once) {
    outcome.done = in_portions(N, 1, threads, monitor, [&] {
      return [&, workspace = Workspace<double>(model), scheme = MuntheKaas(model.tree<double>(), method),
              group = ConfigurationGroup<double>(model.tree<double>()),
              a = std::vector<double>(nv)](std::size_t n, std::size_t) mutable {
        for (std::size_t k = begin; k < std::min(K, begin + steps_at_once) && found[n].ok(); ++k) {
          const std::span<const double> tau_k = tau.subspan((n * K + k) * nv, nv);
          const auto accelerate = [&](double, std::span<const double> q_t, std::span<const double> v_t,
                                      std::span<double> a_t) {
            double none = 0;
            for (const double x : q_t) none += x - x;
            found[n] = {.not_finite = true};
            if (none == 0) found[n] = axode::forward_dynamics(model, workspace, q_t, v_t, tau_k, a_t);
            return found[n].ok();
          };
          const std::span<const double> q_k = q_at(n, k), v_k = v_at(n, k);
          if (!accelerate(0, q_k, v_k, a) ||
              !scheme.run(0, q_k.data(), v_k.data(), a.data(), step, accelerate))
            return;
          group.move(q_k.data(), scheme.theta.data(), q_at(n, k + 1).data());
          std::ranges::copy(scheme.y, v_at(n, k + 1).begin());
        }
      };
    });
    if (!watch.go_on(0)) outcome.done = 0;
  }
  for (std::size_t n = 0; n < outcome.done; ++n)
    if (!found[n].ok() && outcome.singular_states++ == 0) outcome.first = n, outcome.solvability = found[n];
  return outcome;
}

}  // namespace axode::batch
