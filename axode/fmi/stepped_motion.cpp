#include "axode/fmi/stepped_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "axode/eigen.hpp"
#include "axode/integration/methods.hpp"
#include "axode/integration/schemes/explicit_steps.hpp"
#include "axode/scalar/text.hpp"

namespace axode::fmi {
namespace {

constexpr double usual_step_with_contact =
    std::ranges::find(methods, std::string_view("contact"), [](const auto& row) { return row.first; })
        -> second.usual_step;

}  // namespace

bool has_shapes_that_touch(const Model& model) {
  const auto touches = [](const std::vector<ShapeDescription>& shapes) {
    return std::ranges::find(shapes, ShapeDescription::Role::collision, &ShapeDescription::role) !=
           shapes.end();
  };
  const Description& d = model.description();
  const auto carries = [&](const BodyDescription& body) { return touches(body.shapes); };
  return d.contact && (touches(d.shapes) || std::ranges::any_of(d.bodies, carries));
}

std::shared_ptr<SteppedMotion::Fixed> SteppedMotion::fixed(const Model& model, const Settings& settings) {
  auto made = std::make_shared<Fixed>(
      Fixed{.model = model, .tau = std::vector<double>(static_cast<std::size_t>(model.nv()))});
  if (moves_with_contact(model)) made->shapes.emplace(model);
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
                             std::optional<double> tolerance)
    : fixed_(fixed(model, settings)),
      tau_(fixed_->tau),
      t_0_(t),
      adaptive_(tolerance.has_value()),
      run_(fixed_->model, q, v, 0, fixed_->options) {
  if (t != 0 && !(model.motions().empty() && model.drives().empty()))
    throw std::invalid_argument("co-simulation starts at t = " + axode::to_text(t) +
                                " s; a mechanism with prescribed motions or drives starts at 0 s");
  if (tolerance) {
    tolerances_.relative = *tolerance;
    tolerances_.absolute = 0.01 * *tolerance;
  }
  // Forces change only at communication points, where steps end, so that long steps cannot miss a change.
  if (model.motions().empty()) tolerances_.largest_step = std::numeric_limits<double>::infinity();
  check();
  if (fixed_->shapes)
    contact_ = std::make_unique<ContactMotion>(fixed_->model, *fixed_->shapes, q, v, 0, fixed_->options);
}

SteppedMotion::SteppedMotion(const SteppedMotion& other)
    : fixed_(other.fixed_),
      tau_(other.tau_),
      loads_(other.loads_),
      t_0_(other.t_0_),
      adaptive_(other.adaptive_),
      tolerances_(other.tolerances_),
      run_(other.run_),
      contact_(other.contact_ ? other.contact_->fork() : nullptr) {}

void SteppedMotion::check() const {
  if (!run_.trajectory.complete) throw std::runtime_error(run_.trajectory.stop_reason);
}

void SteppedMotion::set_forces(Span tau, std::vector<AppliedWrench<>> loads) {
  const auto entries = [](const AppliedWrench<>& W) {
    return std::array{W.m.x, W.m.y, W.m.z, W.f.x, W.f.y, W.f.z};
  };
  const bool changed =
      !std::ranges::equal(tau, tau_) || !std::ranges::equal(loads, loads_, {}, entries, entries);
  tau_.assign(tau.begin(), tau.end());
  loads_ = std::move(loads);
  act();
  // After a step with contact, accelerations are the means over the step, and sticking joints are not known.
  if (!changed || (contact_ && run_.now() > 0)) return;
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
  if (contact_) return advance_with_contact(t);
  if (Failure failure = run_.continue_until(t - t_0_)) run_.stop(failure);
  take_adapted_steps(run_, t - t_0_, tolerances_);
  check();
  forget_past(run_);
}

void SteppedMotion::advance_with_contact(double t) {
  ContactSimulationRun& run = contact_->run();
  const double h = t - t_0_ - run.now();
  contact_->continue_until(t - t_0_);
  if (adaptive_)
    contact_->take_steps(tolerances_);
  else
    contact_->take_steps(h / std::max(1.0, std::ceil(h / usual_step_with_contact - 1e-9)));
  if (!run.trajectory.complete) throw std::runtime_error(run.trajectory.stop_reason);
  forget_past(run);
  run_.q = run.q;
  run_.v = run.v;
  run_.a = run.a;
  run_.drives() = run.drives();
  run_.trajectory = run.trajectory;
}

/// Removes all states of the trajectory of a run except the last one.
void SteppedMotion::forget_past(SimulationRun& run) {
  const Trajectory& all = run.trajectory;
  const std::size_t last = all.size() - 1, nv = tau_.size();
  Trajectory end(fixed_->model);
  end.set_drive_states({all.drive_states().begin(), all.drive_states().end()});
  end.append(all.t()[last], all.q(last), all.v(last), all.a(last), all.tau().subspan(last * nv, nv),
             all.x(last), all.dx(last));
  run.trajectory = std::move(end);
}

}  // namespace axode::fmi
