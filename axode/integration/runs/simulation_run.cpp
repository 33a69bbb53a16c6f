#include "axode/integration/runs/simulation_run.hpp"

#include <stdexcept>

#include "axode/derivatives/spring_derivatives.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/dynamics/inverse_dynamics.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/eigen.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"

namespace axode {
namespace {

/// The norm √m |g| of gravity as a force on the whole mechanism, an upper bound of that on any joint.
double weight_of(const Tree<double>& tree) {
  double mass = 0;
  for (int i = 1; i <= tree->n; ++i) mass += tree.M[i].m;
  return std::sqrt(mass) * axode::norm(tree.g);
}

/// Why a spring has no force at q: the gas in it has no volume left. Empty if there is no such spring.
std::string exhausted_gas(const Model& model, Workspace<>& workspace, std::span<const double> q) {
  const std::vector<Spring>& springs = model.springs().elements;
  for (std::size_t k = 0; k < springs.size(); ++k) {
    const auto* gas = std::get_if<GasCurve>(&springs[k].law.curve);
    if (gas == nullptr) continue;
    const double x = spring_coordinate(model, workspace, static_cast<int>(k), q) - springs[k].law.rest;
    if (!(gas->volume + gas->area * x > 0))
      return "the gas of spring \"" + springs[k].name + "\" has no volume left";
  }
  return {};
}

}  // namespace

SimulationRun::SimulationRun(const Model& model, Span q_0, Span v_0, double until,
                             const SimulationOptions& options, bool damping)
    : trajectory(model),
      q(as_eigen(q_0)),
      v(as_eigen(v_0)),
      a(v.size()),
      model_(model),
      options_(options),
      workspace_(model, cut_tree),
      friction_(model.tree<double>(), model.gears(),
                options.joint_losses && options.coordinates == Coordinates::relative),
      drives_(DriveSystem(model, options.drives)),
      norm_(model.tree<double>()),
      places_(0),
      weight_(weight_of(model.tree<double>())),
      tau_(Vector::Zero(model.nv())),
      forces_(tau_),
      loads_(options.loads),
      until_(until),
      damping_(damping),
      plays_(model) {
  if (!(model.loops().empty() && model.motions().empty() && options.motions.empty()))
    loops_.emplace(model, options.motions);
  check_configuration(model, q_0);
  check_size("v", v_0.size(), static_cast<std::size_t>(model.nv()), "nv");
  if (!finite(v)) throw std::invalid_argument("v is not finite");
  if (!(until >= 0) || !std::isfinite(until))
    throw std::invalid_argument("until is " + to_text(until) + " s; expected a finite time of 0 s or more");
  check_loads(model, loads());
  if (loops_) {
    loops_->motions().check_times(0, until);
    check_friction_of_motions();
    loops_->check(q_0, v_0);
  }
  places_ = norm_.of_places(tree(), q);
  friction_.start(v_0);
  drives_.start(0, q_0, v_0, options.x);
  trajectory.set_drive_states(drives_.names());
  if (Failure failure = accelerate(0, q_0, v_0, as_span(a))) {
    stop(failure);
    return;
  }
  drives_.dx = as_eigen(drives_.rates());
  friction_.start_sliding(as_span(a));
  trajectory.append(0, q_0, v_0, as_span(a), as_span(tau_), as_span(drives_.x), as_span(drives_.dx));
  if (plays_.any()) start_plays();
  values_ = values_at(0, q_0, as_span(v));
}

/// Throws std::invalid_argument if a joint with a prescribed motion has dry friction or a gear with losses.
void SimulationRun::check_friction_of_motions() const {
  if (!friction_.active()) return;
  for (const MotionRows::Row& row : loops_->motions().rows()) {
    const auto joint = std::ranges::find(model_.joints(), row.of, &Joint::name);
    if (joint == model_.joints().end()) continue;  // a rod
    const bool gear = std::ranges::find(model_.gears(), joint->iv, &Gear::velocity) != model_.gears().end();
    if (!gear && !(tree().friction[static_cast<std::size_t>(joint->iv)] > 0)) continue;
    throw std::invalid_argument("joint \"" + row.of + "\" follows a motion and has " +
                                (gear ? "a gear with losses" : "dry friction") +
                                ", which joint_losses would count; "
                                "its friction changes the force of the motion alone: set it to 0");
  }
}

void SimulationRun::stop(const Failure& failure) {
  trajectory.complete = false;
  trajectory.stop_reason = "at t = " + to_text(failure.t) + " s: " + failure.why;
  if (!loops_ || loops_->motions().empty() || trajectory.size() == 0) return;
  if (const std::string where = loops_->singularity(as_span(q), now()); !where.empty())
    trajectory.stop_reason += "; the mechanism is " + where;
}

// Forces and accelerations.

Failure SimulationRun::not_finite(double t, const char* what, Span x) const {
  return {t, what + std::string(" not finite at ") + joint_of(x)};
}

std::string SimulationRun::joint_of(Span x) const {
  for (std::size_t c = 0; c < x.size(); ++c)
    if (!std::isfinite(x[c])) return "joint \"" + velocity_names(model_)[c] + "\"";
  return "a joint";
}

void SimulationRun::compute_loads(double t, Span q_t, Span v_t) {
  if (!options_.computed_loads) return;
  loads_ = options_.loads;
  options_.computed_loads(t, q_t, v_t, loads_);
  check_loads(model_, loads());
}

Failure SimulationRun::begin_evaluation(double t, Span q_t, Span v_t) {
  ++trajectory.evaluations;
  if (!finite(q_t) || !finite(v_t)) return not_finite(t, "the state is", v_t);
  compute_loads(t, q_t, v_t);
  compute_drive_forces(t, q_t, v_t);
  if (!finite(drives_.rates()))
    return {t, "the rate of the drive state \"" + drives_.first_not_finite() + "\" is not finite"};
  return finite(tau_) ? Failure{} : not_finite(t, "the drive forces are", as_span(tau_));
}

void SimulationRun::compute_drive_forces(double t, Span q_t, Span v_t) {
  if (options_.drive) options_.drive(t, q_t, v_t, as_span(tau_));
  if (!drives_.empty()) {
    if (!options_.drive) tau_.setZero();
    drives_.add_forces(t, q_t, v_t, as_span(tau_));
  }
  if (!friction_.has_gears()) return;
  forces_.setZero();
  if (!drives_.empty()) drives_.add_line_forces(as_span(forces_));
  through_gears_ = tau_ - forces_;
}

Failure SimulationRun::accelerate_now() {
  drives_.act_at(as_span(drives_.x));
  Failure failure = accelerate(now(), as_span(q), as_span(v), as_span(a));
  drives_.dx = as_eigen(drives_.rates());
  return failure;
}

SimulationRun::Span SimulationRun::joint_force_sum(Span q_t, Span v_t) {
  forces_ = tau_;
  if (!model_.springs().empty()) add_spring_forces(model_, workspace_, q_t, v_t, as_span(forces_));
  if (friction_.active())
    friction_.add_losses(v_t, as_span(forces_));
  else if (damping_)
    forces_.array() -= as_eigen(Span(tree().damping)).array() * as_eigen(v_t).array();
  return as_span(std::as_const(forces_));
}

Failure SimulationRun::joint_forces(double t, Span q_t, Span v_t, Span& tau) {
  if (Failure failure = begin_evaluation(t, q_t, v_t)) return failure;
  tau = joint_force_sum(q_t, v_t);
  if (!finite(forces_))
    if (std::string why = exhausted_gas(model_, workspace_, q_t); !why.empty()) return {t, std::move(why)};
  return {};
}

Failure SimulationRun::accelerate(double t, Span q_t, Span v_t, std::span<double> a_t) {
  Span tau;
  if (Failure failure = joint_forces(t, q_t, v_t, tau)) return failure;
  if (loops_) loops_->set_time(t);
  const Solvability found = loops_ ? loops_->accelerate(q_t, v_t, tau, loads(), a_t)
                                   : forward_dynamics(model_, workspace_, q_t, v_t, tau, a_t, loads());
  if (!found.ok()) return {t, to_string(model_, found)};
  if (loops_) {
    weakest_row_ = std::min(weakest_row_, loops_->weakest_row());
    if (std::string why = loops_->unfollowed(q_t, v_t, a_t); !why.empty()) return {t, std::move(why)};
  }
  if (friction_.resisting().empty()) return {};
  const Solvability held = response_.apply(model_, workspace_, loops_ ? &*loops_ : nullptr, friction_, norm_,
                                           q_t, v_t, as_span(std::as_const(through_gears_)), a_t);
  return held.ok() ? Failure{} : Failure{t, to_string(model_, held)};
}

Failure SimulationRun::residual(double t, const Vector& q_t, const Vector& v_t, const Vector& a_t,
                                Vector& r) {
  if (loops_) {
    if (Failure failure = accelerate(t, as_span(q_t), as_span(v_t), as_span(r))) return failure;
    r = a_t - r;
    return {};
  }
  ++trajectory.evaluations;
  if (!finite(q_t) || !finite(v_t) || !finite(a_t)) return {t, "the state is not finite"};
  compute_loads(t, as_span(q_t), as_span(v_t));
  inverse_dynamics(model_, workspace_, as_span(q_t), as_span(v_t), as_span(a_t), as_span(r), loads());
  compute_drive_forces(t, as_span(q_t), as_span(v_t));
  r -= as_eigen(joint_force_sum(as_span(q_t), as_span(v_t)));
  if (friction_.has_gears())
    friction_.add_gear_losses(as_span(v_t), as_span(a_t), as_span(std::as_const(through_gears_)), as_span(r));
  for (const int c : friction_.sticking()) r[c] = a_t[c];
  return finite(r) ? Failure{} : not_finite(t, "forces are", as_span(r));
}

void SimulationRun::residual_derivatives(const Vector& q_t, const Vector& v_t, const Vector& a_t,
                                         const InverseDynamicsDerivatives<double>& dr) {
  if (!loops_) return tree_residual_derivatives(q_t, v_t, a_t, dr);
  const Eigen::Index nv = model_.nv();
  const Span q_s = as_span(q_t), v_s = as_span(v_t);
  Eigen::Map<SquareMatrix> r_q(dr.q.data(), nv, nv), r_v(dr.v.data(), nv, nv), r_a(dr.a.data(), nv, nv);
  compliance_.resize(nv, nv);
  loops_->differentiate(q_s, v_s, joint_force_sum(q_s, v_s), loads(), {dr.q, dr.v, as_span(compliance_)});
  if (find_force_derivatives(q_s, v_s)) {
    r_q += compliance_ * (springs_by_q_ + drives_by_q_);
    r_v += compliance_ * (springs_by_v_ + drives_by_v_);
  }
  friction_.constrain_derivatives({as_span(compliance_), dr.q, dr.v});
  r_q = -r_q;
  r_v = -r_v;
  r_a.setIdentity();
}

/// Computes the derivatives of the forces of springs, drives and damping. Returns whether there are any.
bool SimulationRun::find_force_derivatives(Span q_t, Span v_t) {
  const bool damped = friction_.active() || damping_;
  if (model_.springs().empty() && !damped && drives_.empty()) return false;
  const Eigen::Index nv = model_.nv();
  springs_by_q_.resize(nv, nv);
  springs_by_v_.resize(nv, nv);
  spring_force_derivatives(model_, workspace_, q_t, v_t, {as_span(springs_by_q_), as_span(springs_by_v_)});
  drives_by_q_.setZero(nv, nv);
  drives_by_v_.setZero(nv, nv);
  if (damped) drives_by_v_.diagonal() -= as_eigen(Span(tree().damping));
  if (!drives_.empty()) drives_.add_force_derivatives(q_t, v_t, drives_by_q_, drives_by_v_);
  return true;
}

void SimulationRun::tree_residual_derivatives(const Vector& q_t, const Vector& v_t, const Vector& a_t,
                                              const InverseDynamicsDerivatives<double>& dr) {
  const Eigen::Index nv = model_.nv();
  Eigen::Map<SquareMatrix> r_q(dr.q.data(), nv, nv), r_v(dr.v.data(), nv, nv), r_a(dr.a.data(), nv, nv);
  inverse_dynamics_derivatives(model_, workspace_, as_span(q_t), as_span(v_t), as_span(a_t), dr, loads());
  if (find_force_derivatives(as_span(q_t), as_span(v_t))) {
    r_q -= springs_by_q_;
    r_v -= springs_by_v_;
    if (friction_.has_gears()) friction_.scale_derivatives({dr.a, dr.q, dr.v});
    r_q -= drives_by_q_;
    r_v -= drives_by_v_;
  }
  for (const int c : friction_.sticking()) {
    r_q.row(c).setZero();
    r_v.row(c).setZero();
    r_a.row(c).setZero();
    r_a(c, c) = 1;
  }
}

SimulationRun::Span SimulationRun::tree_drive(double t, const Vector& q_t, const Vector& v_t) {
  driven_.resize(v_t.size());
  options_.drive(t, as_span(q_t), as_span(v_t), as_span(driven_));
  return as_span(std::as_const(driven_));
}

SimulationRun::Span SimulationRun::drive(double t, const Vector& q_t, const Vector& v_t) {
  tree_drive(t, q_t, v_t);
  if (loops_) driven_ = compliance_ * driven_;
  for (const int c : friction_.sticking()) driven_[c] = 0;
  return as_span(std::as_const(driven_));
}

Failure SimulationRun::joint_resistance(double t, Span q_t, Span v_t, double c_x, double c_v,
                                        std::vector<double>& out) {
  if (!finite(q_t) || !finite(v_t)) return not_finite(t, "the state is", v_t);
  const Eigen::Index nv = model_.nv();
  out.assign(v_t.size(), 0.0);
  Eigen::Map<Vector> inertia(out.data(), nv);
  if (!model_.springs().empty()) {
    SquareMatrix by_q(nv, nv), by_v(nv, nv);
    spring_force_derivatives(model_, workspace_, q_t, v_t, {as_span(by_q), as_span(by_v)});
    inertia = -c_x * by_q.diagonal() - c_v * by_v.diagonal();
  }
  if (options_.drive) add_resistance_of_drive(t, q_t, v_t, c_x, c_v, out);
  if (!drives_.empty()) {
    SquareMatrix by_q = SquareMatrix::Zero(nv, nv), by_v = by_q;
    drives_.add_force_derivatives(q_t, v_t, by_q, by_v);
    inertia -= c_x * by_q.diagonal() + c_v * by_v.diagonal();
  }
  if (options_.joint_losses) inertia += c_v * as_eigen(Span(tree().damping));
  inertia = inertia.cwiseMax(0);
  return {};
}

void SimulationRun::add_resistance_of_drive(double t, Span q_t, Span v_t, double c_x, double c_v,
                                            std::vector<double>& out) {
  options_.drive(t, q_t, v_t, as_span(tau_));
  const Vector before = tau_;
  const double size = velocity_scale(as_eigen(v_t), c_v);
  Vector x = Vector::Zero(before.size()), v_k = as_eigen(v_t);
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const double by = norm_.increment(k, v_k[k], size) / c_v;
    x[k] = c_x * by;
    v_k[k] += c_v * by;
    options_.drive(t, integrate(model_, q_t, as_span(x)), as_span(v_k), as_span(tau_));
    out[static_cast<std::size_t>(k)] -= (tau_[k] - before[k]) / by;
    x[k] = 0;
    v_k[k] = v_t[static_cast<std::size_t>(k)];
  }
}

// Dry friction.

void SimulationRun::begin_step() {
  friction_.reset_violation();
  weakest_row_ = 1;
}

Failure SimulationRun::check_sticking(double t, const StepEnd& end) {
  Vector a_end(end.v.size());
  begin_step();
  if (friction_.sticking().empty()) return {};
  return accelerate(t, as_span(end.q), as_span(end.v), as_span(a_end));
}

/// Computes the accelerations at the end of an attempt, unless the scheme has computed them.
Failure SimulationRun::ensure_accelerations(double t, StepEnd& end) {
  if (end.a.size() == end.v.size()) return {};
  end.a.resize(end.v.size());
  drives_.act_at(as_span(end.x));
  Failure failure = accelerate(t, as_span(end.q), as_span(end.v), as_span(end.a));
  end.dx = as_eigen(drives_.rates());
  return failure;
}

bool SimulationRun::friction_changes(double t_0, double t_1, const StepEnd& end) const {
  return friction_.violation() > 1 ||
         friction_.reverses(as_span(v), as_span(a), as_span(end.v), as_span(end.a), t_1 - t_0);
}

/// Calls DryFriction::stop_sliding() at the present state, and returns whether a joint came to rest.
bool SimulationRun::stop_sliding(double within) {
  return friction_.stop_sliding(as_span(v), as_span(a), within);
}

Failure SimulationRun::take_up_to(double t_1, StepEnd& end, const Attempt& attempt) {
  accelerations_jumped_ = false;
  if (Failure failure = end_at_switch(t_1, end, attempt)) return failure;
  if (Failure failure =
          plays_.any() ? take_up_to_play(t_1, end, attempt) : take_under_friction(t_1, end, attempt))
    return failure;
  return done() ? Failure{} : switch_drives();
}

Failure SimulationRun::take_under_friction(double t_1, StepEnd& end, const Attempt& attempt) {
  if (!friction_.active()) return take(t_1, end);
  const double t_0 = now(), resolution = std::max(1e-13 * (t_1 - t_0), 1e-15 * t_1);
  if (Failure failure = ensure_accelerations(t_1, end)) return failure;
  if (!friction_changes(t_0, t_1, end)) {
    Failure failure = take(t_1, end);
    if (!failure && !done()) stop_sliding(0);
    return failure;
  }
  double low = t_0, high = t_1, t = t_1, violation = friction_.violation(), rate = 0;
  StepEnd after = end;
  for (int tries = 0; high - low > resolution; ++tries) {
    // A first-order guess of the time at which friction changes: from the violations of two attempts, or from
    // the velocity that reverses.
    const double guess =
        t + (rate > 0 ? -violation / rate : friction_.time_to_stop(as_span(end.v), as_span(end.a)));
    const double before = t, violation_before = violation;
    t = guess > low && guess < high && tries % 4 != 3
            ? std::clamp(guess, low + 0.5 * resolution, high - 0.5 * resolution)
            : low + (high - low) / 2;
    if (Failure failure = attempt(t, end)) return failure;
    if (Failure failure = ensure_accelerations(t, end)) return failure;
    violation = friction_.violation();
    rate = violation > 1 && violation_before > 1 ? (violation_before - violation) / (before - t) : 0;
    if (friction_changes(t_0, t, end)) {
      high = t;
      after = end;
    } else {
      low = t;
    }
  }
  short_steps_ = high - t_0 < short_part * (t_1 - t_0) ? short_steps_ + 1 : 0;
  if (short_steps_ > most_short_steps)
    return {t_0, too_many_changes("dry friction") + ", or joint_losses = false"};
  const bool at_once = high - t_0 <= resolution && stop_sliding(2 * resolution);
  if (!at_once) {
    if (Failure failure = take(high, after)) return failure;
    if (done()) return {};
    stop_sliding(2 * resolution);
  }
  accelerations_jumped_ = true;
  if (Failure failure = accelerate_now()) return failure;
  friction_.start_sliding(as_span(a));
  trajectory.jump(as_span(v), as_span(a), as_span(drives_.x), as_span(drives_.dx));
  return {};
}

// Ends of steps.

Failure SimulationRun::continue_until(double until) {
  if (loops_) loops_->motions().check_times(now(), until);
  until_ = until;
  // After the last step of a call, friction and drives have not changed yet.
  if (friction_.active()) stop_sliding(0);
  if (Failure failure = switch_drives()) return failure;
  return friction_.active() ? forces_changed() : Failure{};
}

Failure SimulationRun::forces_changed() {
  if (friction_.active()) {  // joints at rest may stick under the new forces
    stop_sliding(0);
    friction_.start(as_span(v));
  }
  if (Failure failure = accelerate_now()) return failure;
  friction_.start_sliding(as_span(a));
  trajectory.jump(as_span(v), as_span(a), as_span(drives_.x), as_span(drives_.dx));
  return {};
}

Failure SimulationRun::take(double t, const StepEnd& end) {
  if (!loops_) return record(t, end);
  StepEnd closed{.q = end.q, .v = end.v, .x = end.x};
  loops_->set_time(t);
  if (!loops_->close(as_span(closed.q), as_span(closed.v))) return {t, open};
  return record(t, std::move(closed));
}

Failure SimulationRun::take_closed(double t, Span q_end, Span v_end, const Vector& x_end) {
  accelerations_jumped_ = false;
  if (loops_) {
    loops_->set_time(t);
    loops_->determine_rank(q_end);
  }
  return record(t, {.q = as_eigen(q_end), .v = as_eigen(v_end), .x = x_end});
}

Failure SimulationRun::record(double t, StepEnd end) {
  if (Failure failure = ensure_accelerations(t, end)) return failure;
  const double before = now();
  q = std::move(end.q);
  places_ = norm_.of_places(tree(), q);
  v = std::move(end.v);
  a = std::move(end.a);
  drives_.x = std::move(end.x);
  drives_.dx = std::move(end.dx);
  trajectory.append(t, as_span(q), as_span(v), as_span(a), as_span(tau_), as_span(drives_.x),
                    as_span(drives_.dx));
  ++trajectory.steps;
  if (!options_.events.empty())
    if (Failure failure = find_events(before, t)) return failure;
  return ended_ ? Failure{} : interruption(t);
}

Failure SimulationRun::interruption(double t) const {
  return options_.monitor && !options_.monitor(t) ? Failure{t, "it was interrupted"} : Failure{};
}

}  // namespace axode
