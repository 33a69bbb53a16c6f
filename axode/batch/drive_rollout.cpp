#include "axode/batch/drive_rollout.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "axode/batch/portions.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/driven/drive_steps.hpp"
#include "axode/integration/schemes/explicit_steps.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/scalar/text.hpp"

namespace axode::batch {
namespace {

using Span = std::span<const double>;

/// Why a motion could not continue, if it could not.
struct Reason {
  Solvability found;
  DriveSteps::End end = DriveSteps::End::none;
};
/// A state of a motion.
struct State {
  Span q, v, x;
};

/// The drive forces of a motion: those of a drive or, if there is none, those of the present step.
class Forces {
 public:
  explicit Forces(const Drive& drive) : drive_(drive) {}

  bool are_given() const { return !drive_; }
  void set(Span tau) { tau_ = tau; }
  void evaluate(double t, Span q, Span v, std::span<double> out) const {
    if (drive_)
      drive_(t, q, v, out);
    else
      std::ranges::copy(tau_, out.begin());
  }

 private:
  Drive drive_;
  Span tau_;
};

/// Integrates motions, one after the other.
class Motion {
 public:
  virtual ~Motion() = default;

  /// Begins a motion at a finite state (q, v) with the states x of the drives; if x is empty, the drives
  /// begin at their own initial states. The joint forces tau act in the first step.
  virtual void begin(Span q, Span v, Span x, Span tau) = 0;
  /// Advances the motion to t_1 under the forces tau, unless there is a drive.
  virtual Reason advance(double t_1, Span tau) = 0;
  virtual State state() = 0;
};

/// Integrates motions without dry friction, in memory that is allocated once.
class SmoothMotion final : public Motion {
 public:
  SmoothMotion(const Model& model, const CompiledDynamics<double>& compiled, const Drive& drive,
               const DriveMotions& drives, const Tableau& method, bool damping)
      : forces_(drive),
        accelerations_(model, compiled, damping),
        steps_(model, method, DriveSystem(model, drives.added)),
        tau_(static_cast<std::size_t>(model.nv())),
        t_0_(drives.t) {}

  void begin(Span q, Span v, Span x, Span) override {
    if (ClosedMotion* const loops = accelerations_.loops()) loops->determine_rank(q);
    steps_.begin(t_0_, q, v, x);
  }
  Reason advance(double t_1, Span tau) override {
    forces_.set(tau);
    Reason reason;
    const auto rates = [&](double t, Span q, Span v, Span x, std::span<double> a, std::span<double> dx) {
      reason.found = {.not_finite = true};
      if (!finite(q) || !finite(v)) return false;
      forces_.evaluate(t, q, v, tau_);
      steps_.drives().evaluate(t, q, v, x, tau_, dx);
      if (!finite(Span(tau_)) || !finite(Span(dx))) return false;
      reason.found = accelerations_.compute(q, v, tau_, a);
      return reason.found.ok();
    };
    ClosedMotion* const loops = accelerations_.loops();
    reason.end = steps_.advance(t_1, rates, [loops](std::span<double> q, std::span<double> v) {
      return loops == nullptr || loops->close(q, v);
    });
    return reason;
  }
  State state() override { return {steps_.q, steps_.v, steps_.x}; }

 private:
  Forces forces_;
  Accelerations<double> accelerations_;
  DriveSteps steps_;
  std::vector<double> tau_;
  double t_0_;
};

/// Integrates motions with dry friction or losses of gears. Each is a simulation, which records its states.
class MotionWithFriction final : public Motion {
 public:
  MotionWithFriction(const Model& model, const Drive& drive, const DriveMotions& drives,
                     const Tableau& method, double until)
      : model_(model), forces_(drive), method_(method), until_(until) {
    options_.drive = [this](double t, Span q, Span v, std::span<double> out) {
      forces_.evaluate(t, q, v, out);
    };
    options_.drives = drives.added;
    options_.joint_losses = true;
  }
  MotionWithFriction(const MotionWithFriction&) = delete;
  MotionWithFriction& operator=(const MotionWithFriction&) = delete;

  void begin(Span q, Span v, Span x, Span tau) override {
    forces_.set(tau);
    options_.x.assign(x.begin(), x.end());
    run_.emplace(model_, q, v, until_, options_);
    scheme_.emplace(model_.tree<double>(), method_, LocalCoordinates::exponential, run_->drives().size());
    begun_ = false;
  }
  Reason advance(double t_1, Span tau) override {
    const bool loops = !model_.loops().empty();
    const Reason failed{{.not_finite = !loops},
                        loops ? DriveSteps::End::loops_open : DriveSteps::End::failed};
    if (!run_->trajectory.complete) return failed;
    forces_.set(tau);
    if (std::exchange(begun_, true) && forces_.are_given() && run_->forces_changed()) return failed;
    const bool stopped = static_cast<bool>(take_until(*run_, t_1, end_, attempts(*run_, *scheme_), [] {}));
    return stopped ? failed : Reason{};
  }
  State state() override {
    return {as_span(std::as_const(run_->q)), as_span(std::as_const(run_->v)),
            as_span(std::as_const(run_->drives().x))};
  }

 private:
  const Model& model_;
  Forces forces_;
  const Tableau& method_;
  double until_;
  SimulationOptions options_;
  std::optional<SimulationRun> run_;
  std::optional<MuntheKaas<>> scheme_;
  StepEnd end_;
  bool begun_ = false;
};

}  // namespace

/// Checks the arguments of a rollout that belong to drives. Throws std::invalid_argument if the initial
/// states x of the drives have a wrong size or are not finite, if the memory x_out for the later states has a
/// wrong size or shares memory with an argument or a result, and if the time of the start is not finite or,
/// with dry friction or losses of gears, is not 0.
void check_drives(const MotionsUnderForces& motions, const DriveMotions& drives, const DriveSystem& system,
                  std::size_t N, const Losses& losses) {
  const std::size_t nx = system.nx();
  if (!drives.x.empty()) check_size("x", drives.x.size(), nx * N, "nx N");
  for (std::size_t k = 0; k < drives.x.size(); ++k)
    if (!finite(drives.x[k]))
      throw std::invalid_argument("state " + std::to_string(k / nx) + ": the state \"" +
                                  system.states()[k % nx].name + "\" of a drive is not finite");
  if (!finite(drives.t) || (losses.friction && drives.t != 0))
    throw std::invalid_argument("the motions begin at t = " + to_text(drives.t) +
                                (losses.friction ? " s; with drives and dry friction or losses of gears, "
                                                   "they begin at 0 s"
                                                 : " s; it must be finite"));
  if (drives.x_out.empty()) return;
  check_size("x_out", drives.x_out.size(), (motions.K + 1) * nx * N, "(K + 1) nx N");
  for (const auto& [name, other] : {std::pair<const char*, Span>{"q", motions.q},
                                    {"v", motions.v},
                                    {"tau", motions.tau},
                                    {"x", drives.x},
                                    {"q_out", motions.q_out},
                                    {"v_out", motions.v_out}})
    check_separate("x_out", drives.x_out, name, other);
}

Outcome run_with_drives(const Model& model, const CompiledDynamics<double>& compiled,
                        const MotionsUnderForces& motions, const DriveMotions& drives, const Tableau& method,
                        const Losses& losses, int threads, const Monitor& monitor) {
  const DriveSystem system(model, drives.added);
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv());
  const std::size_t nx = system.nx(), K = motions.K, N = nq == 0 ? 0 : motions.q.size() / nq;
  check_drives(motions, drives, system, N, losses);
  for (const std::span<double> out : {motions.q_out, motions.v_out, drives.x_out})
    std::ranges::fill(out, std::numeric_limits<double>::quiet_NaN());
  const auto write = [&](std::size_t n, std::size_t k, const State& state) {
    const std::size_t row = n * (K + 1) + k;
    std::ranges::copy(state.q, motions.q_out.subspan(row * nq, nq).begin());
    std::ranges::copy(state.v, motions.v_out.subspan(row * nv, nv).begin());
    if (!drives.x_out.empty()) std::ranges::copy(state.x, drives.x_out.subspan(row * nx, nx).begin());
  };
  const auto time = [&](std::size_t k) { return drives.t + static_cast<double>(k) * motions.step; };
  const auto make = [&]() -> std::shared_ptr<Motion> {
    if (losses.friction)
      return std::make_shared<MotionWithFriction>(model, motions.drive, drives, method, time(K));
    return std::make_shared<SmoothMotion>(model, compiled, motions.drive, drives, method, losses.damping);
  };

  std::vector<Reason> reasons(N);
  // The monitor is called within motions, because one motion can have many steps.
  const std::thread::id caller = std::this_thread::get_id();
  MonitorThrottle throttle(monitor, N);
  std::atomic<bool> stopped = false;
  const auto goes_on = [&] {
    if (!stopped && std::this_thread::get_id() == caller && !throttle.should_continue(0)) stopped = true;
    return !stopped;
  };
  in_portions(N, 1, threads, {}, [&]() -> Work {
    return [&, motion = make()](std::size_t n, std::size_t) {
      const Span q = motions.q.subspan(n * nq, nq), v = motions.v.subspan(n * nv, nv),
                 x = drives.x.empty() ? Span{} : drives.x.subspan(n * nx, nx);
      const auto tau = [&](std::size_t k) {
        return motions.drive || K == 0 ? Span{} : motions.tau.subspan((n * K + k) * nv, nv);
      };
      write(n, 0, {q, v, x});
      if (!finite(q) || !finite(v)) {
        if (K > 0) reasons[n] = {{.not_finite = true}, DriveSteps::End::failed};
        return;
      }
      motion->begin(q, v, x, tau(0));
      write(n, 0, motion->state());
      for (std::size_t k = 0; k < K && goes_on(); ++k) {
        reasons[n] = motion->advance(time(k + 1), tau(k));
        if (reasons[n].end != DriveSteps::End::none) return;
        write(n, k + 1, motion->state());
      }
    };
  });
  Outcome outcome{.done = stopped ? 0 : N};
  for (std::size_t n = 0; n < outcome.done; ++n)
    if (reasons[n].end != DriveSteps::End::none && outcome.singular_states++ == 0) {
      outcome.first = n;
      outcome.solvability = reasons[n].found;
      outcome.loops_open = reasons[n].end == DriveSteps::End::loops_open;
      outcome.too_many_changes = reasons[n].end == DriveSteps::End::too_many_changes;
    }
  return outcome;
}

}  // namespace axode::batch
