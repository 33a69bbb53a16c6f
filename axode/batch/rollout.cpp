#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "axode/batch.hpp"
#include "axode/batch/portions.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/integration/munthe_kaas.hpp"
#include "axode/kinematics/check_arguments.hpp"

namespace axode::batch {

Outcome rollout(const Model& model, std::span<const double> q, std::span<const double> v,
                std::span<const double> tau, double step, std::span<double> q_out, std::span<double> v_out,
                const Tableau& method, int threads, const Monitor& monitor) {
  if (threads < 1)
    throw std::invalid_argument("threads is " + std::to_string(threads) + "; expected 1 or more");
  if (!(step > 0) || !std::isfinite(step))
    throw std::invalid_argument("step is " + std::to_string(step) + "; expected a time of more than 0 s");
  check(method);
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv());
  if (nv == 0) return {};
  const std::size_t N = q.size() / nq;
  check_size("q", q.size(), N * nq, "nq N");
  check_size("v", v.size(), N * nv, "nv N");
  const std::size_t K = N == 0 ? 0 : tau.size() / (N * nv);
  check_size("tau", tau.size(), K * nv * N, "K nv N");
  check_size("q_out", q_out.size(), (K + 1) * nq * N, "(K + 1) nq N");
  check_size("v_out", v_out.size(), (K + 1) * nv * N, "(K + 1) nv N");
  for (const auto& [name, given] : {std::pair{"q", q}, {"v", v}, {"tau", tau}})
    check_separate("q_out", q_out, name, given), check_separate("v_out", v_out, name, given);
  check_separate("q_out", q_out, "v_out", std::span<const double>(v_out));
  for (std::size_t n = 0; n < N; ++n) try {
      check_configuration(model, q.subspan(n * nq, nq));
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("state " + std::to_string(n) + ": " + error.what());
    }

  std::vector<Solvability> found(N);
  Outcome outcome;
  outcome.done = in_portions(N, 1, threads, monitor, [&] {
    return [&, workspace = Workspace<double>(model), scheme = MuntheKaas(model.tree<double>(), method),
            group = ConfigurationGroup<double>(model.tree<double>()),
            a = std::vector<double>(nv)](std::size_t n, std::size_t) mutable {
      const std::span<double> q_n = q_out.subspan(n * (K + 1) * nq, (K + 1) * nq),
                              v_n = v_out.subspan(n * (K + 1) * nv, (K + 1) * nv);
      std::ranges::fill(q_n, std::numeric_limits<double>::quiet_NaN());
      std::ranges::fill(v_n, std::numeric_limits<double>::quiet_NaN());
      std::ranges::copy(q.subspan(n * nq, nq), q_n.begin()),
          std::ranges::copy(v.subspan(n * nv, nv), v_n.begin());
      for (std::size_t k = 0; k < K; ++k) {
        const std::span<const double> tau_k = tau.subspan((n * K + k) * nv, nv);
        const auto accelerate = [&](double, std::span<const double> q_t, std::span<const double> v_t,
                                    std::span<double> a_t) {
          double none = 0;
          for (const double x : q_t) none += x - x;
          found[n] = {.not_finite = true};
          if (none == 0) found[n] = axode::forward_dynamics(model, workspace, q_t, v_t, tau_k, a_t);
          return found[n].ok();
        };
        const std::span<const double> q_k = q_n.subspan(k * nq, nq), v_k = v_n.subspan(k * nv, nv);
        if (!accelerate(0, q_k, v_k, a) || !scheme.run(0, q_k.data(), v_k.data(), a.data(), step, accelerate))
          return;
        group.move(q_k.data(), scheme.theta.data(), &q_n[(k + 1) * nq]);
        std::ranges::copy(scheme.v, &v_n[(k + 1) * nv]);
      }
    };
  });
  for (std::size_t n = 0; n < outcome.done; ++n)
    if (!found[n].ok() && outcome.singular_states++ == 0) outcome.first = n, outcome.solvability = found[n];
  return outcome;
}

}  // namespace axode::batch
