#pragma once
#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/constraints/absolute_system.hpp"
#include "axode/integration/run.hpp"

namespace axode {

/// A run in absolute coordinates: q, v and a are those of the bodies, see AbsoluteSystem. What it takes is told in joint
/// coordinates, with the accelerations of these.
class AbsoluteRun {
 public:
  using Vector = std::vector<double>;
  using Span = std::span<const double>;
  using Rows = AbsoluteSystem::Rows;

  AbsoluteRun(const Model& model, Span q_0, Span v_0, double until, const SimulationOptions& options)
      : run_(model, q_0, v_0, until, options),
        trajectory(run_.trajectory),
        bodies_(model, options.coordinates == Coordinates::absolute ? BodyGroup::SE3 : BodyGroup::SO3xR3),
        group_(bodies_.group()) {
    if (run_.done()) return;
    bodies_.enter(q_0, v_0, q, v);
    a.resize(v.size());
    tell_bodies();
    if (hold(0, q)) accelerate(0, q, v, a);
  }
  AbsoluteRun(const AbsoluteRun&) = delete;

 private:
  Run run_;

 public:
  Trajectory& trajectory;
  Vector q, v, a, lambda;  ///< now

  AbsoluteSystem& bodies() { return bodies_; }
  const Tree<double>& tree() const { return bodies_.group(); }
  bool done() const { return run_.done(); }
  double now() const { return run_.now(); }
  bool stop(double t, const std::string& why) { return run_.stop(t, why); }

  // What schemes ask for; false, with the reason kept, where there is none.
  bool place(double t, Span q_t) { return found(t, bodies_.place(q_t)); }
  bool hold(double t, Span q_t) { return found(t, bodies_.hold(q_t)); }
  /// With springs, dampers and drives as they resist what moves with an acceleration: places by c_x, velocities by c_v.
  bool place(double t, Span q_t, Span v_t, double c_x, double c_v) {
    bodies_.leave(q_t, v_t, q_joints_, v_joints_);
    if (!run_.joint_resistance(t, q_joints_, v_joints_, c_x, c_v, resistance_)) return false;
    return found(t, bodies_.place(q_t, resistance_));
  }
  bool forces(double t, Span q_t, Span v_t, Vector& f) {
    if (!finite(q_t) || !finite(v_t)) return stop(t, "the state is not finite");
    bodies_.leave(q_t, v_t, q_joints_, v_joints_);
    Span tau;
    if (!run_.joint_forces(t, q_joints_, v_joints_, tau)) return false;
    bodies_.forces(q_t, v_t, tau, run_.loads(), f);
    return true;
  }
  bool accelerate(double t, Span q_t, Span v_t, std::span<double> a_t) {
    if (!forces(t, q_t, v_t, f_) || !place(t, q_t)) return false;
    bodies_.momentum(v_t, p_);
    turning_.resize(p_.size());
    group_.cobracket(v_t.data(), p_.data(), turning_.data());
    for (std::size_t c = 0; c < f_.size(); ++c) f_[c] += turning_[c];
    bodies_.bias(v_t, rows_);
    bodies_.solve(f_, rows_, x_, lambda);
    weakest_row_ = std::min(weakest_row_, bodies_.weakest_row());
    std::ranges::copy(x_, a_t.begin());
    return finite(x_) || stop(t, "accelerations are not finite");
  }
  auto accelerations() {
    return
        [this](double t, Span q_t, Span v_t, std::span<double> a_t) { return accelerate(t, q_t, v_t, a_t); };
  }

  /// Closes joints and loops again, by the displacement and the impulses that move the masses least, and is held there.
  bool close(double t, Vector& q_1, Vector& v_1) {
    constexpr double closed = 1e-13, tolerable = 1e-6;
    double before = open_at(q_1);
    if (!(before <= closed) && !found(t, bodies_.place(q_1, Rows::places))) return false;
    for (int n = 0; n < 10 && !(before <= closed); ++n) {
      for (double& open : rows_) open = -open;
      f_.assign(v_1.size(), 0.0);
      bodies_.solve(f_, rows_, x_, multipliers_);
      group_.move(q_1.data(), x_.data(), q_1.data());
      const double now = open_at(q_1);
      const bool done = !(now < 0.5 * before);  // as far as rounding lets it come, or not at all
      before = now;
      if (done) break;
    }
    if (!(before <= tolerable))
      return stop(t, "joints and loops cannot be kept closed; a shorter step may help");
    if (!hold(t, q_1)) return false;
    bodies_.slip(q_1, v_1, rows_);
    for (double& slip : rows_) slip = -slip;
    f_.assign(v_1.size(), 0.0);
    bodies_.solve(f_, rows_, x_, multipliers_);
    for (std::size_t c = 0; c < v_1.size(); ++c) v_1[c] += x_[c];
    return true;
  }
  /// Takes the end of a step, closed again.
  bool take(double t, Span q_end, Span v_end, Span = {}) {
    Vector q_1(q_end.begin(), q_end.end()), v_1(v_end.begin(), v_end.end());
    return close(t, q_1, v_1) && take_closed(t, q_1, v_1) && accelerate(t, q, v, a);
  }
  /// The same; dry friction is the force that the velocity says, and changes in steps.
  template <class Attempt> bool take_up_to(double t_1, const StepEnd& end, const Attempt&) {
    return take(t_1, end.q, end.v);
  }
  void begin_step() { weakest_row_ = 1; }
  double weakest_row() const { return weakest_row_; }
  /// The same of a scheme that keeps joints and loops closed itself.
  bool take_closed(double t, Span q_end, Span v_end) {
    bodies_.leave(q_end, v_end, q_joints_, v_joints_);
    bodies_.keep(q_joints_);
    q.assign(q_end.begin(), q_end.end()), v.assign(v_end.begin(), v_end.end());
    const std::size_t before = trajectory.size();
    const bool goes_on = run_.take_closed(t, q_joints_, v_joints_);
    if (trajectory.size() > before) tell_bodies();
    return goes_on;
  }

 private:
  bool found(double t, const Solvability& how) {
    return how.ok() || stop(t, to_string(trajectory.model(), how));
  }
  void tell_bodies() {
    bodies_.gap(q, rows_);
    trajectory.gaps.push_back(largest_of(rows_));
    bodies_.slip(q, v, rows_);
    trajectory.slips.push_back(largest_of(rows_));
    trajectory.body_energies.push_back(bodies_.energy(q, v));
  }
  double open_at(Span q_t) {
    bodies_.gap(q_t, rows_);
    double sum = 0;
    for (const double open : rows_) sum += open * open;
    return std::sqrt(sum);
  }

  AbsoluteSystem bodies_;
  ConfigurationGroup<double> group_;
  double weakest_row_ = 1;
  Vector q_joints_, v_joints_, resistance_, f_, p_, turning_, rows_, x_, multipliers_;
};

}  // namespace axode
