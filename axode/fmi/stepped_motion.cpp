#include "axode/fmi/stepped_motion.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>
#include <utility>

#include "axode/eigen.hpp"
#include "axode/integration/schemes/explicit_steps.hpp"

namespace axode::fmi {

std::shared_ptr<SteppedMotion::Fixed> SteppedMotion::fixed(const Model& model, const Settings& settings) {
  auto made =
      std::make_shared<Fixed>(Fixed{model, {}, std::vector<double>(static_cast<std::size_t>(model.nv()))});
  made->options.joint_losses = settings.joint_losses;
  made->options.drive = [&tau = made->tau](double, Span, Span, std::span<double> out) {
    std::ranges::copy(tau, out.begin());
  };
  made->options.computed_loads = [&loads = made->loads](double, Span, Span,
                                                        std::vector<AppliedWrench<>>& all) {
    all.insert(all.end(), loads.begin(), loads.end());
  };
  return made;
}

SteppedMotion::SteppedMotion(const Model& model, const Settings& settings, double t, Span q, Span v,
                             const Tolerances& tolerances)
    : fixed_(fixed(model, settings)),
      tau_(fixed_->tau),
      t_0_(t),
      tolerances_(tolerances),
      run_(fixed_->model, q, v, 0, fixed_->options) {
  if (t != 0 && !(model.motions().empty() && model.drives().empty()))
    throw std::invalid_argument("co-simulation starts at t = " + std::to_string(t) +
                                " s; a mechanism with prescribed motions or drives starts at 0 s");
  // Forces change only at communication points, where steps end, so that long steps cannot miss a change.
  if (model.motions().empty()) tolerances_.largest_step = std::numeric_limits<double>::infinity();
  check();
}

SteppedMotion::SteppedMotion(const SteppedMotion& other) = default;

void SteppedMotion::check() const {
  if (!run_.trajectory.complete) throw std::runtime_error(run_.trajectory.stop_reason);
}

void SteppedMotion::set_forces(Span tau, std::vector<AppliedWrench<>> loads) {
  const auto components = [](const AppliedWrench<>& W) {
    return std::array{W.m.x, W.m.y, W.m.z, W.f.x, W.f.y, W.f.z};
  };
  const bool changed =
      !std::ranges::equal(tau, tau_) || !std::ranges::equal(loads, loads_, {}, components, components);
  tau_.assign(tau.begin(), tau.end());
  loads_ = std::move(loads);
  act();
  if (!changed) return;
  if (Failure failure = run_.forces_changed()) run_.stop(failure);
  check();
}

/// Copies the forces of this motion to the memory, shared by copies, from which they are integrated.
void SteppedMotion::act() {
  fixed_->tau = tau_;
  fixed_->loads = loads_;
}

void SteppedMotion::advance(double t) {
  act();
  if (Failure failure = run_.continue_until(t - t_0_)) run_.stop(failure);
  take_adapted_steps(run_, t - t_0_, tolerances_);
  check();
  forget_past();
}

/// Removes all states of the trajectory except the last one.
void SteppedMotion::forget_past() {
  const Trajectory& all = run_.trajectory;
  const std::size_t last = all.size() - 1, nv = tau_.size();
  Trajectory end(fixed_->model);
  end.set_drive_states({all.drive_states().begin(), all.drive_states().end()});
  end.append(all.t()[last], all.q(last), all.v(last), all.a(last), all.tau().subspan(last * nv, nv),
             all.x(last), all.dx(last));
  run_.trajectory = std::move(end);
}

}  // namespace axode::fmi
