#include <algorithm>
#include <concepts>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "axode/batch.hpp"
#include "axode/batch/accelerations.hpp"
#include "axode/batch/check_loops.hpp"
#include "axode/batch/check_states.hpp"
#include "axode/batch/control_law_sampler.hpp"
#include "axode/batch/drive_rollout.hpp"
#include "axode/batch/kernels.hpp"
#include "axode/batch/portions.hpp"
#include "axode/batch/scratch.hpp"
#include "axode/integration/schemes/munthe_kaas.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"
#include "axode/table/check_counts.hpp"

namespace axode::batch {

namespace {

template <class S> void none(std::span<S> x) { std::ranges::fill(x, std::numeric_limits<S>::quiet_NaN()); }

/// Integrates one motion under given forces or a drive.
template <class S> class ScalarRollout {
 public:
  ScalarRollout(const Model& model, const CompiledDynamics<S>& compiled, const Tableau& method,
                const Drive& drive, const Losses& losses)
      : model_(&model),
        accelerations_(model, compiled, losses.damping),
        method_(&method),
        scheme_(model.tree<S>(), method),
        group_(model.tree<S>()),
        drive_(drive),
        losses_(losses),
        a_(model.nv()),
        total_(a_) {}

  /// Begins at a configuration q with closed loops: determines which loop constraints are redundant there.
  void begin(std::span<const S> q) {
    if constexpr (std::same_as<S, double>)
      if (ClosedMotion* const loops = accelerations_.loops()) loops->determine_rank(q);
  }

  /// Computes step k from the state (q, v), and writes the new state to q_1 and v_1. All joint forces are
  /// those that the drive of the constructor computes or, if it is empty, the forces tau (nv), which are
  /// constant during the step. Returns why the step failed, if it did.
  Solvability run(std::size_t k, std::span<const S> q, std::span<const S> v, std::span<const S> tau,
                  double step, std::span<S> q_1, std::span<S> v_1) {
    if constexpr (std::same_as<S, double>)
      if (losses_.friction && step_with_friction(k, q, v, tau, step, q_1, v_1)) return {};
    Solvability found;
    std::size_t stage = 0;
    const auto accelerate = [&](double, std::span<const S> q_t, std::span<const S> v_t, std::span<S> a_t) {
      found = {.not_finite = true};
      if (!finite(q_t)) return false;
      if (drive_)
        drive(time_of(*method_, step, k, stage++), q_t, v_t);
      else
        total_.assign(tau.begin(), tau.end());
      found = accelerations_.compute(q_t, v_t, total_, a_t);
      return found.ok();
    };
    if (losses_.friction) {  // the step has failed: find out why
      if (!accelerate(0, q, v, a_)) return found;
      loops_open_ = accelerations_.loops() != nullptr;
      found.not_finite = !loops_open_;
      return found;
    }
    if (!accelerate(0, q, v, a_) || !scheme_.run(0, q.data(), v.data(), a_.data(), step, accelerate))
      return found;
    group_.move(q.data(), scheme_.theta.data(), q_1.data());
    std::ranges::copy(scheme_.y, v_1.begin());
    if constexpr (std::same_as<S, double>)
      if (ClosedMotion* const loops = accelerations_.loops()) {
        std::vector<double> q_end(q_1.begin(), q_1.end());
        loops_open_ = !loops->close(q_end, scheme_.y);
        std::ranges::copy(q_end, q_1.begin());
        std::ranges::copy(scheme_.y, v_1.begin());
      }
    return found;
  }
  /// Whether the loops could not be closed at the end of the last step.
  bool loops_open() const { return loops_open_; }

 private:
  /// Computes a step in which joints may stick and slide. Returns false if the motion cannot continue.
  bool step_with_friction(std::size_t k, std::span<const double> q, std::span<const double> v,
                          std::span<const double> tau, double step, std::span<double> q_1,
                          std::span<double> v_1) {
    if (!finite(q) || !finite(v)) return false;
    SimulationOptions options{.joint_losses = true};
    options.drive = [&](double t, std::span<const double> q_t, std::span<const double> v_t,
                        std::span<double> out) {
      if (drive_)
        drive_(static_cast<double>(k) * step + t, q_t, v_t, out);
      else
        std::ranges::copy(tau, out.begin());
    };
    const Trajectory motion = simulate_fixed(*model_, q, v, step, step, *method_, options);
    if (!motion.complete) return false;
    std::ranges::copy(motion.q(motion.size() - 1), q_1.begin());
    std::ranges::copy(motion.v(motion.size() - 1), v_1.begin());
    return true;
  }
  void drive(double t, std::span<const S> q, std::span<const S> v) {
    if constexpr (std::same_as<S, double>) {
      drive_(t, q, v, total_);
    } else {
      const std::vector<double> v_t(v.begin(), v.end()),
          q_t = normalize(*model_, std::vector<double>(q.begin(), q.end()));  // exact to double
      std::vector<double> tau(v.size());
      drive_(t, q_t, v_t, tau);
      total_.assign(tau.begin(), tau.end());
    }
  }

  const Model* model_;
  Accelerations<S> accelerations_;
  const Tableau* method_;
  MuntheKaas<S> scheme_;
  ConfigurationGroup<S> group_;
  Drive drive_;
  Losses losses_;
  bool loops_open_ = false;
  std::vector<S> a_, total_;
};

/// Integrates several motions at once in SIMD lanes, for models without springs and loops. For a model with
/// coupled joints `compiled` must have the functions that code generation has compiled for this model.
template <class S> class LaneRollout {
 public:
  LaneRollout(const Tree<S>& tree, const CompiledDynamics<S>& compiled, const Tableau& method)
      : kernel_(kernels<S>().rollout), rollout_(kernel_.make(tree, method), kernel_.remove) {
    if (!compiled.call) return;
    const std::size_t lanes = kernels<S>().lanes, nq = lanes * tree->nq, nv = lanes * tree->nv;
    numbers_ = scratch<S>(compiled.scratch + nq + 3 * nv);
    maybe_singular_ = std::make_shared<std::vector<unsigned char>>(lanes);
    S* const q = numbers_.get() + compiled.scratch;
    call_ = {.dynamics = &compiled,
             .q = q,
             .v = q + nq,
             .tau = q + nq + nv,
             .a = q + nq + 2 * nv,
             .scratch = numbers_.get(),
             .maybe_singular = maybe_singular_->data()};
  }
  unsigned run(Motions<S> motions, std::size_t k, std::size_t end) {
    if (call_.dynamics) motions.compiled = &call_;
    return kernel_.run(rollout_.get(), motions, static_cast<std::ptrdiff_t>(k),
                       static_cast<std::ptrdiff_t>(end));
  }

 private:
  RolloutKernel<S> kernel_;
  std::shared_ptr<void> rollout_;
  std::shared_ptr<S> numbers_;
  std::shared_ptr<std::vector<unsigned char>> maybe_singular_;
  CompiledCall<S> call_{};
};

/// Throws std::invalid_argument for an argument of a wrong size, and for results that share memory with one
/// another or with an argument.
template <class S>
void check_motions(const Model& model, std::span<const S> q, std::span<const S> v, std::span<const S> tau,
                   std::size_t K, std::span<S> q_out, std::span<S> v_out) {
  const std::size_t nq = model.nq(), nv = model.nv(), N = nq == 0 ? 0 : q.size() / nq;
  check_size("v", v.size(), N * nv, "nv N");
  check_size("q_out", q_out.size(), (K + 1) * nq * N, "(K + 1) nq N");
  check_size("v_out", v_out.size(), (K + 1) * nv * N, "(K + 1) nv N");
  for (const auto& [name, given] :
       {std::pair<const char*, std::span<const S>>{"q", q}, {"v", v}, {"tau", tau}}) {
    check_separate("q_out", q_out, name, given);
    check_separate("v_out", v_out, name, given);
  }
  check_separate("q_out", q_out, "v_out", std::span<const S>(v_out));
}

/// Integrates N motions of K steps under given forces or a drive, several at once in SIMD lanes if possible.
template <class S>
Outcome run_rollouts(const Model& model, const CompiledDynamics<S>& compiled, std::span<const S> q,
                     std::span<const S> v, std::size_t K, std::span<const S> tau, const Drive& drive,
                     double step, std::span<S> q_out, std::span<S> v_out, const Tableau& method, int threads,
                     const Monitor& monitor, const Losses& losses) {
  // The number of steps between two calls of the monitor. A step with friction takes up to milliseconds.
  const std::size_t steps_at_once = losses.friction ? 16 : 256;
  const std::size_t nq = model.nq(), nv = model.nv(), N = nq == 0 ? 0 : q.size() / nq;
  for (const std::span<S> out : {q_out, v_out}) std::ranges::fill(out, std::numeric_limits<S>::quiet_NaN());
  const auto q_at = [&](std::size_t n, std::size_t k) { return q_out.subspan((n * (K + 1) + k) * nq, nq); };
  const auto v_at = [&](std::size_t n, std::size_t k) { return v_out.subspan((n * (K + 1) + k) * nv, nv); };
  const auto tau_at = [&](std::size_t n, std::size_t k) {
    return drive ? std::span<const S>{} : tau.subspan((n * K + k) * nv, nv);
  };
  for (std::size_t n = 0; n < N; ++n) {
    std::ranges::copy(q.subspan(n * nq, nq), q_at(n, 0).begin());
    std::ranges::copy(v.subspan(n * nv, nv), v_at(n, 0).begin());
  }

  const Tree<S>& tree = model.tree<S>();
  ControlLawSampler<S> sampler(model, drive);
  const bool in_lanes = N > 1 && (tree->coupled_bodies.empty() || compiled.call) && model.springs().empty() &&
                        model.loops().empty() && !losses.friction && (!drive || sampler.known());
  const std::size_t group = in_lanes ? static_cast<std::size_t>(kernels<S>().lanes) : 1;
  std::vector<Solvability> found(N);
  std::vector<char> loops_open(N);
  Outcome outcome{.done = N};
  MonitorThrottle throttle(monitor, N);
  for (std::size_t begin = 0; begin < K && outcome.done == N; begin += steps_at_once) {
    const std::size_t end = std::min(K, begin + steps_at_once);
    const ControlLaw<S>* law = in_lanes && drive ? &sampler.law(method, step, begin, end) : nullptr;
    outcome.done = in_portions(N, group, threads, monitor, [&] {
      return [&, lanes = in_lanes ? std::optional(LaneRollout<S>(tree, compiled, method)) : std::nullopt,
              one = std::optional<ScalarRollout<S>>()](std::size_t first, std::size_t count) mutable {
        unsigned singular_lanes = ~0u;
        if (lanes)
          singular_lanes = lanes->run({tau_at(first, 0).data(), law, q_at(first, 0).data(),
                                       v_at(first, 0).data(), static_cast<std::ptrdiff_t>(K),
                                       static_cast<std::ptrdiff_t>(count), step, losses.damping, nullptr},
                                      begin, end);
        for (std::size_t l = 0; l < count; ++l) {
          const std::size_t n = first + l;
          if ((singular_lanes >> l & 1) == 0 && finite(v_at(n, end)) && finite(q_at(n, end))) continue;
          if (!one) one.emplace(model, compiled, method, drive, losses);
          if (found[n].ok() && !loops_open[n]) one->begin(q_at(n, begin));
          for (std::size_t k = begin; k < end; ++k) {
            if (found[n].ok() && !loops_open[n]) {
              found[n] =
                  one->run(k, q_at(n, k), v_at(n, k), tau_at(n, k), step, q_at(n, k + 1), v_at(n, k + 1));
              loops_open[n] = one->loops_open();
            }
            if (found[n].ok() && !loops_open[n]) continue;
            none(q_at(n, k + 1));
            none(v_at(n, k + 1));
          }
        }
      };
    });
    if (!throttle.should_continue(0)) outcome.done = 0;
  }
  for (std::size_t n = 0; n < outcome.done; ++n)
    if ((!found[n].ok() || loops_open[n]) && outcome.singular_states++ == 0) {
      outcome.first = n;
      outcome.solvability = found[n];
      outcome.loops_open = loops_open[n];
    }
  return outcome;
}

using batch::check_loops;
/// Throws std::invalid_argument for a model with loops, which rollouts in float do not take into account.
bool check_loops(const Model& model, std::span<const float>, std::span<const float>, int, const Monitor&) {
  if (model.loops().empty()) return true;
  throw std::invalid_argument("model \"" + model.name() +
                              "\" has loops, which rollouts count in double precision alone");
}

/// Whether the model has drives with states or `drives` adds some to it. Throws std::invalid_argument if
/// there are such drives and S is float, or if there are none although arrays for their states x are given.
template <class S> bool has_drives(const Model& model, const DriveMotions& drives) {
  if (model.drives().empty() && drives.added.empty()) {
    check_size("x", drives.x.size(), 0, "nx N");
    check_size("x_out", drives.x_out.size(), 0, "(K + 1) nx N");
    return false;
  }
  if (std::same_as<S, float>)
    throw std::invalid_argument("model \"" + model.name() +
                                "\" has drives with states, which rollouts count in double precision alone");
  return true;
}

/// The joint losses of a model that act if `enabled` is set. Throws std::invalid_argument if S is float and
/// dry friction or losses of gears would act.
template <class S> Losses losses_of(const Model& model, bool enabled) {
  const bool gears = !model.gears().empty();
  const bool friction = enabled && (gears || std::ranges::any_of(model.tree<double>().friction,
                                                                 [](double f) { return f > 0; }));
  if (std::same_as<S, float> && friction)
    throw std::invalid_argument("model \"" + model.name() + "\" has " +
                                (gears ? "gears with losses" : "dry friction") +
                                ", which rollouts count in double precision alone");
  return {enabled, friction};
}

/// Integrates N motions with checked forces tau, or with a drive, by the functions that the model needs.
template <class S>
Outcome integrate_motions(const Model& model, const CompiledDynamics<S>& compiled, std::span<const S> q,
                          std::span<const S> v, std::size_t K, std::span<const S> tau, const Drive& drive,
                          double step, std::span<S> q_out, std::span<S> v_out, const Tableau& method,
                          int threads, const Monitor& monitor, bool joint_losses,
                          const DriveMotions& drives) {
  const Losses losses = losses_of<S>(model, joint_losses);
  const bool with_drives = has_drives<S>(model, drives);
  check_motions(model, q, v, tau, K, q_out, v_out);
  if (!check_loops(model, q, v, threads, monitor)) return {};
  if constexpr (std::same_as<S, double>)
    if (with_drives)
      return run_with_drives(model, compiled, {q, v, tau, drive, K, step, q_out, v_out}, drives, method,
                             losses, threads, monitor);
  return run_rollouts<S>(model, compiled, q, v, K, tau, drive, step, q_out, v_out, method, threads, monitor,
                         losses);
}

}  // namespace

template <class S>
Outcome rollout(const Model& model, std::span<const S> q, Numbers<S> v, Numbers<S> tau, double step,
                std::type_identity_t<std::span<S>> q_out, std::type_identity_t<std::span<S>> v_out,
                const Tableau& method, int threads, const Monitor& monitor, bool joint_losses,
                const CompiledDynamics<S>& compiled, const DriveMotions& drives) {
  check(method);
  check_step(step);
  catalog::check_counts<"rollout">(model);
  const std::size_t nv = model.nv(), N = check_states(model, q, threads),
                    K = N * nv == 0 ? 0 : tau.size() / (N * nv);
  check_size("tau", tau.size(), K * nv * N, "K nv N");
  return integrate_motions<S>(model, compiled, q, v, K, tau, {}, step, q_out, v_out, method, threads, monitor,
                              joint_losses, drives);
}

template <class S>
Outcome rollout(const Model& model, std::span<const S> q, Numbers<S> v, const Drive& drive, std::size_t K,
                double step, std::type_identity_t<std::span<S>> q_out,
                std::type_identity_t<std::span<S>> v_out, const Tableau& method, int threads,
                const Monitor& monitor, bool joint_losses, const CompiledDynamics<S>& compiled,
                const DriveMotions& drives) {
  check(method);
  check_step(step);
  catalog::check_counts<"rollout">(model);
  if (!drive) throw std::invalid_argument("drive is empty; expected a function of (t, q, v)");
  static_cast<void>(check_states(model, q, threads));
  return integrate_motions<S>(model, compiled, q, v, K, {}, drive, step, q_out, v_out, method, threads,
                              monitor, joint_losses, drives);
}

template Outcome rollout(const Model&, std::span<const double>, Numbers<double>, Numbers<double>, double,
                         std::span<double>, std::span<double>, const Tableau&, int, const Monitor&, bool,
                         const CompiledDynamics<double>&, const DriveMotions&);
template Outcome rollout(const Model&, std::span<const float>, Numbers<float>, Numbers<float>, double,
                         std::span<float>, std::span<float>, const Tableau&, int, const Monitor&, bool,
                         const CompiledDynamics<float>&, const DriveMotions&);
template Outcome rollout(const Model&, std::span<const double>, Numbers<double>, const Drive&, std::size_t,
                         double, std::span<double>, std::span<double>, const Tableau&, int, const Monitor&,
                         bool, const CompiledDynamics<double>&, const DriveMotions&);
template Outcome rollout(const Model&, std::span<const float>, Numbers<float>, const Drive&, std::size_t,
                         double, std::span<float>, std::span<float>, const Tableau&, int, const Monitor&,
                         bool, const CompiledDynamics<float>&, const DriveMotions&);

}  // namespace axode::batch
