#include "axode/batch/contact_rollout.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "axode/batch/check_loops.hpp"
#include "axode/batch/check_states.hpp"
#include "axode/batch/drive_rollout.hpp"
#include "axode/batch/portions.hpp"
#include "axode/integration/momenta/contact_motion.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/scalar/text.hpp"

namespace axode::batch {
namespace {

using Span = std::span<const double>;

/// Integrates motions with contact, one after the other, in the same memory.
class RolledMotion {
 public:
  /// Allocates the memory for all motions, which end at the time `until` (s). This needs a finite state (q,
  /// v) with closed loops, for example the start of the first motion; begin() then sets the start of each
  /// motion. `goes_on` is called in the thread of the motion during steps that take many iterations. If it
  /// returns false, the motion ends.
  RolledMotion(const Model& model, const ContactShapes& shapes, Span q, Span v, double until,
               const Drive& drive, const DriveMotions& drives, bool joint_losses,
               const std::function<bool()>& goes_on)
      : drive_(drive),
        options_(options_with(drives, goes_on)),
        run_(model, q, v, until, options_, joint_losses),
        steps_(run_, shapes, joint_losses) {}
  RolledMotion(const RolledMotion&) = delete;
  RolledMotion& operator=(const RolledMotion&) = delete;

  void begin(double t, Span q, Span v, Span x) {
    run_.restart(t, q, v, x);
    steps_.restart();
  }
  /// Advances the motion to the time t_1 (s), in several steps if before t_1 an input of a drive or a
  /// prescribed motion jumps, or the law of a drive changes its form. The joint forces tau act unless there
  /// is a Drive, a function that computes them. Returns false if the motion cannot continue.
  bool advance(double t_1, Span tau) {
    tau_ = tau;
    certificate = 0;
    while (run_.now() < t_1) {
      double t = run_.step_end(t_1);
      if (steps_.compute_up_to_switch(t, computed_)) return false;
      certificate = std::max(certificate, computed_.certificate);
      const StepEnd& end = computed_.end;
      run_.move_to(t, as_span(end.q), as_span(end.v), end.x);
      run_.drives().switch_at(t, q(), v());
    }
    return true;
  }
  Span q() const { return as_span(run_.q); }
  Span v() const { return as_span(run_.v); }
  Span x() const { return as_span(run_.drives().x); }

  double certificate = 0;  ///< the largest one of the last advance()

 private:
  SimulationOptions options_with(const DriveMotions& drives, const std::function<bool()>& goes_on) {
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
    options.drives = drives.added;
    return options;
  }

  Drive drive_;
  Span tau_;
  SimulationOptions options_;
  ContactSimulationRun run_;
  ContactSteps steps_;
  ComputedContactStep computed_;
};

Outcome run_motions(const Model& model, const ContactShapes& shapes, const MotionsUnderForces& motions,
                    std::span<double> certificates, int threads, const Monitor& monitor, bool joint_losses,
                    const DriveMotions& drives) {
  if (joint_losses) refuse_gears(model);
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv());
  const std::size_t K = motions.K, N = nq == 0 ? 0 : motions.q.size() / nq;
  check_size("v", motions.v.size(), N * nv, "nv N");
  check_size("q_out", motions.q_out.size(), (K + 1) * nq * N, "(K + 1) nq N");
  check_size("v_out", motions.v_out.size(), (K + 1) * nv * N, "(K + 1) nv N");
  if (!certificates.empty()) check_size("certificates", certificates.size(), K * N, "K N");
  for (const auto& [name, given] :
       {std::pair<const char*, Span>{"q", motions.q}, {"v", motions.v}, {"tau", motions.tau}}) {
    check_separate("q_out", motions.q_out, name, given);
    check_separate("v_out", motions.v_out, name, given);
    check_separate("certificates", certificates, name, given);
  }
  check_separate("q_out", motions.q_out, "v_out", Span(motions.v_out));
  for (const auto& [name, states] : {std::pair<const char*, Span>{"q_out", motions.q_out},
                                     {"v_out", motions.v_out},
                                     {"x_out", drives.x_out}})
    check_separate("certificates", certificates, name, states);
  const DriveSystem system(model, drives.added);
  check_drives(motions, drives, system, N, {});
  if (!model.motions().empty() && drives.t != 0)
    throw std::invalid_argument("the motions begin at t = " + to_text(drives.t) +
                                " s; with prescribed motions they begin at 0 s");
  if (!check_loops(model, motions.q, motions.v, threads, monitor)) return {};

  for (const std::span<double> out : {motions.q_out, motions.v_out, drives.x_out, certificates})
    std::ranges::fill(out, std::numeric_limits<double>::quiet_NaN());
  const std::size_t nx = system.nx();
  const auto q_of = [&](std::size_t n) { return motions.q.subspan(n * nq, nq); };
  const auto v_of = [&](std::size_t n) { return motions.v.subspan(n * nv, nv); };
  const auto is_finite = [&](std::size_t n) { return finite(q_of(n)) && finite(v_of(n)); };
  const auto write = [&](std::size_t n, std::size_t k, Span q, Span v, Span x) {
    const std::size_t row = n * (K + 1) + k;
    std::ranges::copy(q, motions.q_out.subspan(row * nq, nq).begin());
    std::ranges::copy(v, motions.v_out.subspan(row * nv, nv).begin());
    if (!drives.x_out.empty()) std::ranges::copy(x, drives.x_out.subspan(row * nx, nx).begin());
  };
  const auto time = [&](std::size_t k) { return drives.t + static_cast<double>(k) * motions.step; };
  const double duration = static_cast<double>(K) * motions.step;
  std::size_t first = 0;  // of the motions that can begin
  while (first < N && !is_finite(first)) ++first;

  std::vector<char> failed(N, 0);
  // The monitor is called within motions, because one motion can have many steps.
  const std::thread::id caller = std::this_thread::get_id();
  MonitorThrottle throttle(monitor, N);
  std::atomic<bool> stopped = false;
  const auto goes_on = [&] {
    if (!stopped && std::this_thread::get_id() == caller && !throttle.should_continue(0)) stopped = true;
    return !stopped;
  };
  in_portions(N, 1, threads, {}, [&]() -> Work {
    std::shared_ptr<RolledMotion> motion;
    if (first < N)
      motion = std::make_shared<RolledMotion>(model, shapes, q_of(first), v_of(first), duration,
                                              motions.drive, drives, joint_losses, goes_on);
    return [&, motion](std::size_t n, std::size_t) {
      const Span x = drives.x.empty() ? Span{} : drives.x.subspan(n * nx, nx);
      write(n, 0, q_of(n), v_of(n), x);
      failed[n] = K > 0 && !is_finite(n) ? 1 : 0;
      if (!is_finite(n)) return;
      motion->begin(drives.t, q_of(n), v_of(n), x);
      write(n, 0, motion->q(), motion->v(), motion->x());
      for (std::size_t k = 0; k < K && goes_on(); ++k) {
        const Span tau = motions.drive ? Span{} : motions.tau.subspan((n * K + k) * nv, nv);
        failed[n] = motion->advance(time(k + 1), tau) ? 0 : 1;
        if (failed[n] != 0) return;
        write(n, k + 1, motion->q(), motion->v(), motion->x());
        if (!certificates.empty()) certificates[n * K + k] = motion->certificate;
      }
    };
  });
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
                             bool joint_losses, const DriveMotions& drives) {
  check_step(step);
  check_contact(model, shapes);
  const std::size_t nv = static_cast<std::size_t>(model.nv()), N = check_states(model, q, threads),
                    K = N * nv == 0 ? 0 : tau.size() / (N * nv);
  check_size("tau", tau.size(), K * nv * N, "K nv N");
  return run_motions(model, shapes, {q, v, tau, {}, K, step, q_out, v_out}, certificates, threads, monitor,
                     joint_losses, drives);
}

Outcome rollout_with_contact(const Model& model, const ContactShapes& shapes, Span q, Span v,
                             const Drive& drive, std::size_t K, double step, std::span<double> q_out,
                             std::span<double> v_out, std::span<double> certificates, int threads,
                             const Monitor& monitor, bool joint_losses, const DriveMotions& drives) {
  check_step(step);
  check_contact(model, shapes);
  if (!drive) throw std::invalid_argument("drive is empty; expected a function of (t, q, v)");
  static_cast<void>(check_states(model, q, threads));
  return run_motions(model, shapes, {q, v, {}, drive, K, step, q_out, v_out}, certificates, threads, monitor,
                     joint_losses, drives);
}

}  // namespace axode::batch
