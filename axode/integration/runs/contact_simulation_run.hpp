#pragma once
#include "axode/integration/runs/momentum_simulation_run.hpp"
#include "axode/integration/schemes/midpoint.hpp"
#include "axode/model/building/checks/value_checks.hpp"
#include "axode/model/finite.hpp"

namespace axode {

/// The motion of a mechanism between the impulses of contacts, stops, dry friction and loops. The options
/// must not have joint losses: damping acts if `damping` is true, and dry friction acts by impulses.
class ContactSimulationRun : public MomentumSimulationRun {
 public:
  ContactSimulationRun(const Model& model, Span q_0, Span v_0, double until, const SimulationOptions& options,
                       bool damping)
      : MomentumSimulationRun(model, q_0, v_0, until, options, damping),
        midpoint_(*this, model.tree<double>()),
        q_0_(model.nq()),
        p_(model.nv()),
        y_(model.nv()),
        v_0_(model.nv()),
        change_(model.nv()) {
    for (Vector* x : {&q_end, &q_middle, &q_t_}) x->resize(model.nq());
    for (Vector* x : {&v_end, &v_middle, &v_t_}) x->resize(model.nv());
  }

  /// Begins another motion at time t, at (q_0, v_0). If x_0 is empty, the drives choose their states.
  void restart(double t, Span q_0, Span v_0, Span x_0) {
    drives_.start(t, q_0, v_0, x_0);
    h_ = 0;
    short_steps_ = 0;
    move_to(t, q_0, v_0, drives_.x);
  }
  /// Makes the end of a step the present state, which becomes the only one of the trajectory.
  void move_to(double t, Span q_1, Span v_1, const Vector& x_1) {
    while (trajectory.size() > 0) trajectory.pop_back();
    q = as_eigen(q_1);
    places_ = norm_.of_places(tree(), q);
    v = as_eigen(v_1);
    drives_.x = x_1;
    trajectory.append(t, q_1, v_1, as_span(a), as_span(tau_), as_span(drives_.x), as_span(drives_.dx));
  }
  /// Takes the present state of another motion of the same mechanism, and its first guess of the next step.
  void continue_from(const ContactSimulationRun& other) {
    a = other.a;
    drives_ = other.drives_;
    move_to(other.now(), as_span(other.q), as_span(other.v), other.drives_.x);
    h_ = other.h_;
    change_ = other.change_;
  }

  // Newton's matrix is that of the free motion, in which loops do not act.
  void residual_derivatives(const Vector& q_t, const Vector& v_t, const Vector& a_t,
                            const InverseDynamicsDerivatives<double>& dr) {
    tree_residual_derivatives(q_t, v_t, a_t, dr);
  }
  Span drive(double t, const Vector& q_t, const Vector& v_t) { return tree_drive(t, q_t, v_t); }

  /// Fails if a state at time t has numbers that are not finite.
  Failure check_finite(double t, const Vector& q_t, const Vector& v_t) const {
    return finite(q_t) && finite(v_t) ? Failure{} : not_finite(t, "the state is", as_span(v_t));
  }

  /// Fails if the loops are open, or prescribed motions are not followed, at q_t and time t, or if the
  /// certificate of the step shows that contacts block the motions.
  Failure check_closed(double t, const Vector& q_t, double certificate) {
    if (!loops_) return {};
    constexpr double blocked = 0.1;  // a certificate with which no step makes sense
    loops_->set_time(t);
    const bool is_closed = loops_->is_closed(as_span(q_t));
    if (loops_->motions().rows().empty() || (is_closed && certificate <= blocked))
      return is_closed ? Failure{} : Failure{t, open};
    std::string moved;
    const auto add = [&](const std::string& name) { moved += (moved.empty() ? "" : ", ") + quoted(name); };
    for (const MotionDescription& motion : model_.motions()) add(motion.of);
    for (const PrescribedMotion& motion : options_.motions) add(motion.of);
    return {t, "contacts, stops or loops block the prescribed motion of " + moved};
  }

  /// Computes the free motion from (q_0, v_0), with the states x_0 of the drives, at time t over a step of
  /// length h by the midpoint rule (D8.5). Momenta of floating bases are exact to rounding under gravity.
  /// Writes the state at the end to q_end and v_end, and the configuration and velocities in the middle to
  /// q_middle and v_middle.
  Failure fly(double t, double h, const Vector& q_0, const Vector& v_0, const Vector& x_0) {
    FloatingBases& bases = this->bases();
    bases.restart(t, q_0.data(), v_0.data(), is_loaded());
    q_0_ = q_0;
    v_0_ = v_0;
    bases.to_moving_frame(t, q_0_.data(), v_0_.data());
    if (Failure failure = check_finite(t, q_0_, v_0_)) return failure;
    momenta(model_, workspace_, Span(as_span(q_0_)), as_span(v_0_), as_span(p_));
    y_ = p_;
    bases.begin(q_0_.data(), y_.data());
    bases.to_momenta(q_0_.data(), y_.data(), p_.data());
    // The change of the velocities up to the middle is about that of the last motion of this length.
    midpoint_.v = v_0_;
    if (h == h_) midpoint_.v += change_;
    h_ = 0;
    drives_.begin_midpoint_step(h, x_0);
    if (Failure failure = midpoint_.run(t, h, q_0_, p_)) return failure;
    h_ = h;
    change_ = midpoint_.v - v_0_;
    q_end = midpoint_.q;
    p_ = midpoint_.p;
    bases.advance(midpoint_.q_middle.data(), h, pushes_bases(), midpoint_.f.data(), y_.data());
    bases.restore_centers(q_end.data());
    bases.to_momenta(q_end.data(), y_.data(), p_.data());
    if (Failure failure = velocity(t + h, q_end, p_, v_end)) return failure;
    bases.from_moving_frame(t + h, q_end.data(), v_end.data());
    q_middle = midpoint_.q_middle;
    v_middle = midpoint_.v;
    bases.from_moving_frame(t + h / 2, q_middle.data(), v_middle.data());
    return {};
  }

  /// Computes the states x of the drives at the end of the last motion without impulses that was computed, by
  /// (D17.7b). It began at time t at q_0 with the states x_0. v_0 and v_1 are the velocities before and after
  /// all impulses.
  void advance_drives(double t, double h, const Vector& q_0, const Vector& v_0, const Vector& v_1,
                      const Vector& x_0, Vector& x) {
    if (drives_.empty()) return;
    constexpr double stage = DriveStates::stage;
    v_t_ = stage * h * v_middle;
    group().move(q_0, v_t_, q_t_);
    v_t_ = v_middle + (stage - 0.5) * (v_1 - v_0);
    v_last_ = v_middle + 0.5 * (v_1 - v_0);
    drives_.take_two_stages(t, h, x_0, as_span(q_t_), as_span(v_t_), as_span(q_end), as_span(v_last_), x);
  }

  /// Appends the state at the end of a step to the trajectory. If its accelerations are empty, computes those
  /// of the motion without contact.
  Failure take_contact(double t, StepEnd end) {
    drives_.act_at(as_span(end.x));
    Span tau;
    if (Failure failure = joint_forces(t, as_span(end.q), as_span(end.v), tau)) return failure;
    end.dx = as_eigen(drives_.rates());
    return record(t, std::move(end));
  }

  Vector q_end, v_end, q_middle, v_middle;  ///< results of fly()

 private:
  Midpoint<ContactSimulationRun> midpoint_;
  Vector q_0_, p_, y_, v_0_, change_, v_last_;
  double h_ = 0;  ///< length of the motion in which v changed by change_; 0: none
};

}  // namespace axode
