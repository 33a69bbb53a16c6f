#include "axode/batch/contact_rollout.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "axode/batch/check_loops.hpp"
#include "axode/batch/check_states.hpp"
#include "axode/batch/portions.hpp"
#include "axode/integration/momenta/contact_step.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/integration/simulation.hpp"

namespace axode::batch {
namespace {

using Span = std::span<const double>;

/// Integrates motions with contact, one after the other, in the same memory.
class ContactMotion {
 public:
  /// `goes_on` is called in the thread of the motion, also within long steps; false ends the motion.
  ContactMotion(const Model& model, const ContactShapes& shapes, const Drive& drive, bool joint_losses,
                const std::function<bool()>& goes_on)
      : drive_(drive),
        options_(options_with(goes_on)),
        rest_(static_cast<std::size_t>(model.nv()), 0.0),
        run_(model, neutral(model), rest_, 0, options_, joint_losses),
        step_(run_, model, shapes, joint_losses),
        q_(model.nq()),
        v_(model.nv()) {}
  ContactMotion(const ContactMotion&) = delete;
  ContactMotion& operator=(const ContactMotion&) = delete;

  void begin(Span q, Span v) {
    q_ = as_eigen(q);
    v_ = as_eigen(v);
    run_.restart(q_);
    step_.restart();
  }
  /// Computes step k of length h from the present state, and writes the new state to q_1 and v_1. The forces
  /// tau act if there is no drive. Returns false on failure.
  bool run(std::size_t k, double h, Span tau, std::span<double> q_1, std::span<double> v_1) {
    tau_ = tau;
    if (step_.run(static_cast<double>(k) * h, h, q_, v_)) return false;
    q_ = step_.q;
    v_ = step_.v;
    std::ranges::copy(q_, q_1.begin());
    std::ranges::copy(v_, v_1.begin());
    return true;
  }
  double certificate() const { return step_.certificate; }

 private:
  SimulationOptions options_with(const std::function<bool()>& goes_on) {
    SimulationOptions options;
    options.monitor = [goes_on](double) { return goes_on(); };
    options.drive = [this](double t, Span q, Span v, std::span<double> out) {
      if (drive_)
        drive_(t, q, v, out);
      else if (!tau_.empty())
        std::ranges::copy(tau_, out.begin());
      else
        std::ranges::fill(out, 0.0);
    };
    return options;
  }

  Drive drive_;
  Span tau_;
  SimulationOptions options_;
  std::vector<double> rest_;
  ContactSimulationRun run_;
  ContactStep step_;
  Eigen::VectorXd q_, v_;
};

Outcome run_motions(const Model& model, const ContactShapes& shapes, Span q, Span v, std::size_t K, Span tau,
                    const Drive& drive, double step, std::span<double> q_out, std::span<double> v_out,
                    std::span<double> certificates, int threads, const Monitor& monitor, bool joint_losses) {
  if (joint_losses) refuse_gears(model);
  // The number of steps that a thread computes of one motion before it takes another motion.
  constexpr std::size_t steps_at_once = 64;
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv()),
                    N = nq == 0 ? 0 : q.size() / nq;
  check_size("v", v.size(), N * nv, "nv N");
  check_size("q_out", q_out.size(), (K + 1) * nq * N, "(K + 1) nq N");
  check_size("v_out", v_out.size(), (K + 1) * nv * N, "(K + 1) nv N");
  if (!certificates.empty()) check_size("certificates", certificates.size(), K * N, "K N");
  for (const auto& [name, given] : {std::pair<const char*, Span>{"q", q}, {"v", v}, {"tau", tau}}) {
    check_separate("q_out", q_out, name, given);
    check_separate("v_out", v_out, name, given);
    check_separate("certificates", certificates, name, given);
  }
  check_separate("q_out", q_out, "v_out", Span(v_out));
  check_separate("certificates", certificates, "q_out", Span(q_out));
  check_separate("certificates", certificates, "v_out", Span(v_out));
  if (!check_loops(model, q, v, threads, monitor)) return {};

  for (const std::span<double> out : {q_out, v_out, certificates})
    std::ranges::fill(out, std::numeric_limits<double>::quiet_NaN());
  const auto q_at = [&](std::size_t n, std::size_t k) { return q_out.subspan((n * (K + 1) + k) * nq, nq); };
  const auto v_at = [&](std::size_t n, std::size_t k) { return v_out.subspan((n * (K + 1) + k) * nv, nv); };
  for (std::size_t n = 0; n < N; ++n) {
    std::ranges::copy(q.subspan(n * nq, nq), q_at(n, 0).begin());
    std::ranges::copy(v.subspan(n * nv, nv), v_at(n, 0).begin());
  }
  std::vector<char> failed(N, 0);
  // All motions advance together. Therefore none is complete if the monitor ends the call.
  const std::thread::id caller = std::this_thread::get_id();
  MonitorThrottle throttle(monitor, N);
  std::atomic<bool> stopped = false;
  const auto goes_on = [&] {
    if (!stopped && std::this_thread::get_id() == caller && !throttle.should_continue(0)) stopped = true;
    return !stopped;
  };
  for (std::size_t begin = 0; begin < K && !stopped; begin += steps_at_once) {
    const std::size_t end = std::min(K, begin + steps_at_once);
    in_portions(N, 1, threads, {}, [&]() -> Work {
      return [&, motion = std::make_shared<ContactMotion>(model, shapes, drive, joint_losses, goes_on)](
                 std::size_t n, std::size_t) {
        if (failed[n] != 0) return;
        motion->begin(q_at(n, begin), v_at(n, begin));
        for (std::size_t k = begin; k < end && failed[n] == 0 && goes_on(); ++k) {
          const Span tau_k = drive ? Span{} : tau.subspan((n * K + k) * nv, nv);
          failed[n] = motion->run(k, step, tau_k, q_at(n, k + 1), v_at(n, k + 1)) ? 0 : 1;
          if (failed[n] == 0 && !certificates.empty()) certificates[n * K + k] = motion->certificate();
        }
      };
    });
  }
  Outcome outcome{.done = stopped ? 0 : N};
  for (std::size_t n = 0; n < outcome.done; ++n)
    if (failed[n] != 0 && outcome.singular_states++ == 0) {
      outcome.first = n;
      outcome.solvability.not_finite = true;
    }
  return outcome;
}

}  // namespace

Outcome rollout_with_contact(const Model& model, const ContactShapes& shapes, Span q, Span v, Span tau,
                             double step, std::span<double> q_out, std::span<double> v_out,
                             std::span<double> certificates, int threads, const Monitor& monitor,
                             bool joint_losses) {
  check_step(step);
  check_contact(model, shapes);
  const std::size_t nv = static_cast<std::size_t>(model.nv()), N = check_states(model, q, threads),
                    K = N * nv == 0 ? 0 : tau.size() / (N * nv);
  check_size("tau", tau.size(), K * nv * N, "K nv N");
  return run_motions(model, shapes, q, v, K, tau, {}, step, q_out, v_out, certificates, threads, monitor,
                     joint_losses);
}

Outcome rollout_with_contact(const Model& model, const ContactShapes& shapes, Span q, Span v,
                             const Drive& drive, std::size_t K, double step, std::span<double> q_out,
                             std::span<double> v_out, std::span<double> certificates, int threads,
                             const Monitor& monitor, bool joint_losses) {
  check_step(step);
  check_contact(model, shapes);
  if (!drive) throw std::invalid_argument("drive is empty; expected a function of (t, q, v)");
  static_cast<void>(check_states(model, q, threads));
  return run_motions(model, shapes, q, v, K, {}, drive, step, q_out, v_out, certificates, threads, monitor,
                     joint_losses);
}

}  // namespace axode::batch
