#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/derivatives/inverse_dynamics_derivatives.hpp"
#include "axode/derivatives/spring_derivatives.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/dynamics/inverse_dynamics.hpp"
#include "axode/dynamics/mass_matrix.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/closed_motion.hpp"
#include "axode/integration/dry_friction.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/kinematics/twists.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"
#include "axode/model/workspace.hpp"

namespace axode {

/// The end of a step; without accelerations where a scheme does not know them.
struct StepEnd {
  std::vector<double> q, v, a;
};

/// What all schemes share: the motion so far in joint coordinates, accelerations, events, dry friction.
class Run {
 public:
  using Vector = std::vector<double>;
  using Span = std::span<const double>;

  Run(const Model& model, Span q_0, Span v_0, double until, const SimulationOptions& options)
      : trajectory(model),
        q(q_0.begin(), q_0.end()),
        v(v_0.begin(), v_0.end()),
        a(v_0.size()),
        model_(model),
        options_(options),
        workspace_(model, cut_tree),
        friction_(model.tree<double>(), options.joint_losses && options.coordinates == Coordinates::relative),
        tau_(v_0.size()),
        total_(v_0.size()),
        loads_(options.loads),
        until_(until) {
    if (!model.loops().empty()) loops_.emplace(model);
    check_configuration(model, q);
    check_size("v", v.size(), static_cast<std::size_t>(model.nv()), "nv");
    if (!finite(v)) throw std::invalid_argument("v has numbers that are not finite");
    if (!(until >= 0) || !std::isfinite(until))
      throw std::invalid_argument("until is " + std::to_string(until) + "; expected a time of 0 s or more");
    check_loads(model, loads());
    if (loops_) loops_->check(q, v);
    friction_.start(v);
    if (!accelerate(0, q, v, a)) return;
    friction_.release(a);
    trajectory.append(0, q, v, a, tau_);
    values_ = values_at(0, q, v);
  }

  /// Accelerations under what acts; false, with the reason kept, where there are none.
  bool accelerate(double t, Span q_t, Span v_t, std::span<double> a_t) {
    if (!begin_evaluation(t, q_t, v_t)) return false;
    const Span tau = in_joints(q_t, v_t);
    const Solvability found = loops_ ? loops_->accelerate(q_t, v_t, tau, loads(), a_t)
                                     : forward_dynamics(model_, workspace_, q_t, v_t, tau, a_t, loads());
    if (!found.ok()) return stop(t, to_string(model_, found));
    if (loops_) weakest_row_ = std::min(weakest_row_, loops_->weakest_row());
    if (!friction_.sticking().empty()) hold(q_t, a_t);
    return true;
  }

  /// ID(q, v, a) - tau or, with loops, a - FD(q, v, tau), which is 0 where a is the acceleration; a of what sticks. False, with
  /// the reason kept, where it is not finite.
  bool residual(double t, Span q_t, Span v_t, Span a_t, std::span<double> r) {
    if (loops_) {
      if (!accelerate(t, q_t, v_t, r)) return false;
      for (std::size_t c = 0; c < r.size(); ++c) r[c] = a_t[c] - r[c];
      return true;
    }
    ++trajectory.evaluations;
    if (!finite(q_t) || !finite(v_t) || !finite(a_t)) return stop(t, "the state is not finite");
    compute_loads(t, q_t, v_t);
    inverse_dynamics(model_, workspace_, q_t, v_t, a_t, r, loads());
    if (options_.drive) options_.drive(t, q_t, v_t, tau_);
    const Span tau = in_joints(q_t, v_t);
    for (std::size_t c = 0; c < r.size(); ++c) r[c] -= tau[c];
    for (const int c : friction_.sticking()) r[size(c)] = a_t[size(c)];
    return finite(r) || stop(t, "forces are not finite at " + joint_of(r));
  }
  /// Its derivatives, without those of the drive: by q, v and a.
  void residual_derivatives(Span q_t, Span v_t, Span a_t, const InverseDynamicsDerivatives<double>& dr) {
    const bool forces = !model_.springs().empty() || friction_.felt();
    SquareMatrix by_q, by_v;
    if (forces) {
      by_q.resize(nv(), nv()), by_v.resize(nv(), nv());
      spring_force_derivatives(model_, workspace_, q_t, v_t, {as_span(by_q), as_span(by_v)});
      if (friction_.felt()) by_v.diagonal() -= as_eigen(Span(tree().damping));
    }
    Eigen::Map<SquareMatrix> r_q(dr.q.data(), nv(), nv()), r_v(dr.v.data(), nv(), nv()),
        r_a(dr.a.data(), nv(), nv());
    if (loops_) {
      compliance_.resize(nv(), nv());
      loops_->differentiate(q_t, v_t, in_joints(q_t, v_t), loads(), {dr.q, dr.v, as_span(compliance_)});
      if (forces) r_q += compliance_ * by_q, r_v += compliance_ * by_v;
      friction_.hold_derivatives({as_span(compliance_), dr.q, dr.v});
      r_q = -r_q, r_v = -r_v;
      r_a.setIdentity();
    } else {
      inverse_dynamics_derivatives(model_, workspace_, q_t, v_t, a_t, dr, loads());
      if (forces) r_q -= by_q, r_v -= by_v;
      for (const int c : friction_.sticking())
        r_q.row(c).setZero(), r_v.row(c).setZero(), r_a.row(c).setZero(), r_a(c, c) = 1;
    }
  }
  bool is_driven() const { return static_cast<bool>(options_.drive); }
  /// What of the residual is the drive's, less: tau or, with loops, what tau makes of accelerations, to first order.
  Span drive(double t, Span q_t, Span v_t) {
    options_.drive(t, q_t, v_t, tau_);
    total_ = tau_;
    if (loops_) as_eigen(std::span(total_)) = compliance_ * as_eigen(Span(tau_));
    for (const int c : friction_.sticking()) total_[size(c)] = 0;
    return total_;
  }

  /// Goes from now to the end of a step at t_1, or to where dry friction changes before: a joint comes to rest, or begins to slide.
  /// attempt(t, end) computes the end of a step from now to t, that at t_1 last so far, with friction as it is now; it says
  /// begin_step().
  template <class Attempt> bool take_up_to(double t_1, StepEnd& end, const Attempt& attempt) {
    friction_changed_ = false;
    if (!friction_.felt()) return take(t_1, end.q, end.v, end.a);
    const double t_0 = now(), resolution = std::max(1e-13 * (t_1 - t_0), 1e-15 * t_1);
    if (!know_accelerations(t_1, end)) return false;
    if (!friction_changes(t_0, t_1, end)) return take(t_1, end.q, end.v, end.a) && (rest(0), true);
    double low = t_0, high = t_1, t = t_1, slip = friction_.slip(), rise = 0;
    StepEnd after = end;
    for (int tries = 0; high - low > resolution; ++tries) {
      // To first order: by what slips, which is told from two attempts, or by what turns.
      const double guess = t + (rise > 0 ? -slip / rise : friction_.rest_in(end.v, end.a));
      const double before = t, slip_before = slip;
      t = guess > low && guess < high && tries % 4 != 3
              ? std::clamp(guess, low + 0.5 * resolution, high - 0.5 * resolution)
              : low + (high - low) / 2;
      if (!attempt(t, end) || !know_accelerations(t, end)) return false;
      slip = friction_.slip();
      rise = slip > 1 && slip_before > 1 ? (slip_before - slip) / (before - t) : 0;
      if (friction_changes(t_0, t, end))
        high = t, after = end;
      else
        low = t;
    }
    constexpr double hasty = 1e-9;
    constexpr int most_hasty = 1000;
    hasty_steps_ = high - t_0 < hasty * (t_1 - t_0) ? hasty_steps_ + 1 : 0;
    if (hasty_steps_ > most_hasty) return stop(t_0, "dry friction changes faster than it can be followed");
    const bool at_once = high - t_0 <= resolution && rest(2 * resolution);
    if (!at_once) {
      if (!take(high, after.q, after.v, after.a)) return false;
      if (done()) return true;
      rest(2 * resolution);
    }
    friction_changed_ = true;
    if (!accelerate(now(), q, v, a)) return false;
    friction_.release(a);
    trajectory.jump(v, a);
    return true;
  }
  /// Before an attempt; it is one with friction as it is now.
  void begin_step() { friction_.watch(), weakest_row_ = 1; }
  /// The least LoopSystem::weakest_row() of accelerations since begin_step().
  double weakest_row() const { return weakest_row_; }
  /// Whether the last step ended where friction changed, and accelerations with it.
  bool friction_changed() const { return friction_changed_; }
  /// Sees whether what sticks can be held at the end of a step of a scheme that did not ask for accelerations there.
  bool can_hold(double t, const StepEnd& end) {
    Vector a_end(end.v.size());
    begin_step();
    return friction_.sticking().empty() || accelerate(t, end.q, end.v, a_end);
  }

  /// Takes the end of a step, with the acceleration there where it is known; false where the motion ends. Loops are
  /// closed again, which changes it a little.
  bool take(double t, Span q_end, Span v_end, Span known = {}) {
    Vector q_1(q_end.begin(), q_end.end()), v_1(v_end.begin(), v_end.end());
    if (!loops_) return record(t, q_1, v_1, known);
    if (!loops_->close(q_1, v_1)) return stop(t, open);
    return record(t, q_1, v_1);
  }
  /// The same of a scheme that keeps loops closed itself.
  bool take_closed(double t, Span q_end, Span v_end) {
    if (loops_) loops_->hold(q_end);
    return record(t, Vector(q_end.begin(), q_end.end()), Vector(v_end.begin(), v_end.end()));
  }
  bool stop(double t, const std::string& why) {
    trajectory.complete = false;
    trajectory.stopped = "at t = " + std::to_string(t) + " s: " + why;
    return false;
  }
  static constexpr const char* open = "the loops cannot be kept closed; a shorter step may help";
  bool done() const { return trajectory.size() == 0 || ended_ || !trajectory.complete || now() >= until_; }
  double now() const { return trajectory.t().back(); }
  const Tree<double>& tree() const { return model_.tree<double>(); }
  /// accelerate() as schemes call it.
  auto accelerations() {
    return
        [this](double t, Span q_t, Span v_t, std::span<double> a_t) { return accelerate(t, q_t, v_t, a_t); };
  }
  /// tau of drives and springs at a state, where it is finite; false, with the reason kept, where it is not.
  bool joint_forces(double t, Span q_t, Span v_t, Span& tau) {
    if (!begin_evaluation(t, q_t, v_t)) return false;
    tau = in_joints(q_t, v_t);
    return true;
  }
  /// What each joint resists its own acceleration with, 0 where it does not, as places move with it by c_x and velocities by c_v:
  /// springs, dampers and, by differences, the drive.
  bool joint_resistance(double t, Span q_t, Span v_t, double c_x, double c_v, Vector& out) {
    if (!finite(q_t) || !finite(v_t)) return stop(t, "the state is not finite at " + joint_of(v_t));
    out.assign(v_t.size(), 0.0);
    if (!model_.springs().empty()) {
      SquareMatrix by_q(nv(), nv()), by_v(nv(), nv());
      spring_force_derivatives(model_, workspace_, q_t, v_t, {as_span(by_q), as_span(by_v)});
      as_eigen(std::span(out)) = -c_x * by_q.diagonal() - c_v * by_v.diagonal();
    }
    if (options_.drive) add_resistance_of_drive(t, q_t, v_t, c_x, c_v, out);
    for (std::size_t c = 0; c < out.size(); ++c) {
      if (options_.joint_losses) out[c] += c_v * tree().damping[c];
      out[c] = std::max(out[c], 0.0);
    }
    return true;
  }
  Loads<double> loads() const { return {loads_, options_.joint_losses && !friction_.felt()}; }

  Trajectory trajectory;
  Vector q, v, a;  ///< now

 protected:
  using SquareMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  static std::size_t size(int n) { return static_cast<std::size_t>(n); }
  Eigen::Index nv() const { return model_.nv(); }

  bool record(double t, const Vector& q_1, const Vector& v_1, Span known = {}) {
    Vector a_1(known.begin(), known.end());
    if (known.size() != v_1.size()) {
      a_1.resize(v_1.size());
      if (!accelerate(t, q_1, v_1, a_1)) return false;
    }
    const double before = trajectory.t().back();
    trajectory.append(t, q_1, v_1, a_1, tau_);
    ++trajectory.steps;
    q = q_1, v = v_1, a = a_1;
    if (!options_.events.empty() && meets_end(before, t)) return false;
    if (options_.monitor && !options_.monitor(t)) return stop(t, "it was interrupted");
    return true;
  }
  /// tau of the drive, of the springs of the model and, where there is dry friction, of losses.
  Span in_joints(Span q_t, Span v_t) {
    if (model_.springs().empty() && !friction_.felt()) return tau_;
    total_.assign(tau_.begin(), tau_.end());
    add_spring_forces(model_, workspace_, q_t, v_t, total_);
    if (friction_.felt()) friction_.add_losses(v_t, total_);
    return total_;
  }
  void compute_loads(double t, Span q_t, Span v_t) {
    if (!options_.computed_loads) return;
    loads_ = options_.loads;
    options_.computed_loads(t, q_t, v_t, loads_);
    check_loads(model_, loads());
  }
  /// Drive forces and loads at a state, and whether all is finite.
  bool begin_evaluation(double t, Span q_t, Span v_t) {
    ++trajectory.evaluations;
    if (!finite(q_t) || !finite(v_t)) return stop(t, "the state is not finite at " + joint_of(v_t));
    compute_loads(t, q_t, v_t);
    if (!options_.drive) return true;
    options_.drive(t, q_t, v_t, tau_);
    return finite(tau_) || stop(t, "the drive forces are not finite at " + joint_of(tau_));
  }
  /// Takes a, the accelerations last found, to those with what sticks held.
  void hold(Span q_t, std::span<double> a_t) {
    const std::vector<int>& sticking = friction_.sticking();
    columns_.resize(nv(), static_cast<Eigen::Index>(sticking.size()));
    own_.resize(sticking.size());
    if (loops_) {
      loops_->factorize(q_t);
    } else {
      compliance_.resize(nv(), nv());
      static_cast<void>(inverse_mass_matrix(model_, workspace_, q_t, as_span(compliance_)));
    }
    Vector column(a_t.size());
    for (Eigen::Index k = 0; k < columns_.cols(); ++k) {
      const int c = sticking[static_cast<std::size_t>(k)];
      double& own = own_[static_cast<std::size_t>(k)];
      if (loops_) {
        own = loops_->respond(c, column);
        columns_.col(k) = as_eigen(Span(column));
      } else {
        columns_.col(k) = compliance_.col(c), own = compliance_(c, c);
      }
    }
    friction_.hold(columns_, own_, a_t);
  }
  std::string joint_of(Span x) const {
    for (std::size_t c = 0; c < x.size(); ++c)
      if (!std::isfinite(x[c])) return "joint \"" + velocity_names(model_)[c] + "\"";
    return "a joint";
  }

  const Model& model_;
  const SimulationOptions& options_;
  Workspace<> workspace_;
  std::optional<ClosedMotion> loops_;
  DryFriction friction_;
  Vector tau_, total_;
  std::vector<AppliedWrench<>> loads_;  ///< now

 private:
  void add_resistance_of_drive(double t, Span q_t, Span v_t, double c_x, double c_v, Vector& out) {
    options_.drive(t, q_t, v_t, tau_);
    const Vector before = tau_;
    Vector x(v_t.size()), v_k(v_t.begin(), v_t.end());
    for (std::size_t k = 0; k < x.size(); ++k) {
      const double by = 1e-7 * (1 + std::abs(v_t[k])) / c_v;
      x[k] = c_x * by, v_k[k] += c_v * by;
      options_.drive(t, integrate(model_, q_t, x), v_k, tau_);
      out[k] -= (tau_[k] - before[k]) / by;
      x[k] = 0, v_k[k] = v_t[k];
    }
  }
  /// Accelerations at the end of an attempt, where the scheme did not say them.
  bool know_accelerations(double t, StepEnd& end) {
    if (end.a.size() == end.v.size()) return true;
    end.a.resize(end.v.size());
    return accelerate(t, end.q, end.v, end.a);
  }
  bool friction_changes(double t_0, double t_1, const StepEnd& end) const {
    return friction_.slip() > 1 || friction_.turned(v, a, end.v, end.a, t_1 - t_0);
  }
  /// Now: what slid until a time ago, or will until then, rests. Whether there was any.
  bool rest(double within) { return friction_.rest(v, a, within); }
  Vector values_at(double t, Span q_t, Span v_t) const {
    Vector values;
    for (const Event& event : options_.events) values.push_back(event.value(t, q_t, v_t));
    return values;
  }
  /// The value of an event within the last step.
  double value_at(const Event& event, double t) const {
    Vector q_t(q.size()), v_t(v.size());
    trajectory.at(t, q_t, v_t);
    return event.value(t, q_t, v_t);
  }
  /// The number of parts of the last step, from a time on, in which no body turns by much more than a quarter turn. An event that
  /// depends on an attitude would come and go unseen in a longer part.
  int parts_by_turning(double before) {
    const double h = now() - before;
    const std::size_t k = trajectory.size() - 1;
    std::vector<Twist<BodyFixed>> V(size(model_.n_frames()));
    double fastest = 0;
    for (const std::size_t end : {k - 1, k}) {
      twists<BodyFixed, double>(model_, workspace_, trajectory.q(end), trajectory.v(end), V);
      for (const Twist<BodyFixed>& V_i : V) fastest = std::max(fastest, norm(V_i.w));
    }
    return static_cast<int>(std::clamp(std::ceil(h * fastest / (std::numbers::pi / 2)), 1.0, 1e9));
  }
  /// Times in a part of the last step at which the value of an event, from `begin` to `end`, changes sign: once, or twice if its
  /// rates at both ends show that it goes towards zero and comes back.
  void meet(std::size_t e, double before, double after, double begin, double end,
            std::vector<Trajectory::Met>& met) {
    const Event& event = options_.events[e];
    const auto value = [&](double t) { return value_at(event, t); };
    const double near = 1e-6 * (after - before);
    double soon = value(before + near);
    if (begin == 0) before += near, begin = soon, soon = value(before + near);  // it was met there
    const double sign = begin < 0 ? -1 : 1;
    const auto cross = [&](double low, double high, bool rises) {
      if (event.direction != 0 && rises != (event.direction > 0)) return;
      for (int k = 0; k < 60 && high - low > 1e-15 * std::max(1.0, std::abs(after)); ++k) {
        const double middle = low + (high - low) / 2;
        ((value(middle) < 0) == rises ? low : high) = middle;
      }
      met.push_back({e, high});
    };
    if ((begin < 0) != (end < 0)) return cross(before, after, begin < 0);
    if (!(sign * (soon - begin) < 0 && sign * (end - value(after - near)) > 0)) return;
    double low = before, high = after;
    for (int k = 0; k < 40; ++k) {  // a third goes each time, on the side of the larger value
      const double a_third = (high - low) / 3, one = low + a_third, two = high - a_third;
      const double at_one = sign * value(one), at_two = sign * value(two);
      if (std::min(at_one, at_two) < 0) {
        const double turn = at_one < at_two ? one : two;
        cross(before, turn, begin < 0), cross(turn, after, begin >= 0);
        return;
      }
      at_one < at_two ? high = two : low = one;
    }
  }
  /// Looks for events between two times, the last step; where one is terminal the trajectory is cut off there.
  bool meets_end(double before, double after) {
    const Vector next = values_at(after, q, v);
    std::vector<Trajectory::Met> met;
    const int parts = parts_by_turning(before);
    for (std::size_t e = 0; e < next.size(); ++e) {
      double from = before, begin = values_[e];
      for (int k = 1; k <= parts; ++k) {
        const bool last = k == parts;
        const double to = last ? after : before + k * ((after - before) / parts);
        const double end = last ? next[e] : value_at(options_.events[e], to);
        meet(e, from, to, begin, end, met);
        from = to, begin = end;
      }
    }
    values_ = next;
    std::ranges::sort(met, {}, &Trajectory::Met::t);
    for (const Trajectory::Met& one : met) {
      trajectory.events.push_back(one);
      if (!options_.events[one.event].terminal) continue;
      ended_ = true;
      Vector q_t(q.size()), v_t(v.size());
      trajectory.at(one.t, q_t, v_t);
      trajectory.take_back();
      if (loops_ && !loops_->close(q_t, v_t)) return !stop(one.t, open);
      Vector a_t(v_t.size());
      if (accelerate(one.t, q_t, v_t, a_t)) trajectory.append(one.t, q_t, v_t, a_t, tau_);
      return true;
    }
    return false;
  }

  SquareMatrix compliance_;  ///< ∂a/∂τ
  SquareMatrix columns_;     ///< of what sticks
  Vector own_;               ///< see DryFriction::hold()
  Vector values_;
  double until_, weakest_row_ = 1;
  bool ended_ = false, friction_changed_ = false;
  int hasty_steps_ = 0;
};

}  // namespace axode
