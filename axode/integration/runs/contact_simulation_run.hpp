#pragma once
#include "axode/integration/runs/momentum_simulation_run.hpp"
#include "axode/integration/schemes/midpoint.hpp"
#include "axode/model/finite.hpp"

namespace axode {

/// The motion of a mechanism between the impulses of contacts, stops, dry friction and loops. The options
/// must not have joint losses: damping acts if `damping` is true, and dry friction acts by impulses.
class ContactSimulationRun : public MomentumSimulationRun {
 public:
  ContactSimulationRun(const Model& model, Span q_0, Span v_0, double until, const SimulationOptions& options,
                       bool damping)
      : MomentumSimulationRun(model, q_0, v_0, until, options, damping),
        midpoint_(*this, model.tree<double>()) {
    for (Vector* x : {&q_end, &q_middle, &q_t_, &q_0_, &q_moving_}) x->resize(model.nq());
    for (Vector* x : {&p_end, &v_middle, &v_t_, &p_0_, &y_, &p_before_, &change_}) x->resize(model.nv());
  }

  /// Begins another motion at time t, at (q_0, v_0). If x_0 is empty, the drives choose their states.
  void restart(double t, Span q_0, Span v_0, Span x_0) {
    drives_.start(t, q_0, v_0, x_0);
    midpoint_.forget_matrix();
    h_of_change_ = 0;
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
  /// Takes the present state of another motion of the same mechanism, the matrix with which its iteration
  /// solves a step, and its first guess for the next step.
  void continue_from(const ContactSimulationRun& other) {
    a = other.a;
    drives_ = other.drives_;
    move_to(other.now(), as_span(other.q), as_span(other.v), other.drives_.x);
    midpoint_.continue_from(other.midpoint_);
    h_of_change_ = other.h_of_change_;
    change_ = other.change_;
  }

  // Newton's matrix is that of the free motion, in which loops do not act.
  void residual_derivatives(const Vector& q_t, const Vector& v_t, const Vector& a_t,
                            const InverseDynamicsDerivatives<double>& dr) {
    tree_residual_derivatives(q_t, v_t, a_t, dr);
  }
  Span drive(double t, const Vector& q_t, const Vector& v_t) { return tree_drive(t, q_t, v_t); }

  /// Returns an error if a state at time t has numbers that are not finite.
  Failure check_finite(double t, const Vector& q_t, const Vector& v_t) const {
    return finite(q_t) && finite(v_t) ? Failure{} : not_finite(t, "the state is", as_span(v_t));
  }

  /// Returns an error if, at configuration q_t and time t (s), the residual (rad, m) of the loops and of the
  /// prescribed motions is above 1e-6. A prescribed motion gives a joint coordinate, or the length of a rod
  /// (a loop joint that keeps two points at a distance), as a function of time. If there are prescribed
  /// motions, also returns an error if `certificate`, the relative error of the laws of contact in the step
  /// that ends at t, is above 0.1, because contacts then block these motions.
  Failure check_closed(double t, const Vector& q_t, double certificate) {
    if (!loops_) return {};
    constexpr double blocked = 0.1;  // a certificate with which no step makes sense
    loops_->set_time(t);
    const bool is_closed = loops_->is_closed(as_span(q_t));
    if (loops_->motions().rows().empty() || (is_closed && certificate <= blocked))
      return is_closed ? Failure{} : Failure{t, open};
    std::string moved;
    const auto add = [&](const std::string& name) { moved += (moved.empty() ? "\"" : ", \"") + name + '"'; };
    for (const MotionDescription& motion : model_.motions()) add(motion.of);
    for (const PrescribedMotion& motion : options_.motions) add(motion.of);
    return {t, "contacts, stops or loops block the prescribed motion of " + moved};
  }

  /// The inertia that springs, dampers and drives seem to add to each velocity in a step of length h (nv
  /// numbers, kg m² or kg): the diagonal of Newton's matrix minus that of the mass matrix, or 0 where this
  /// difference is negative. Newton's matrix (D8.6) approximates the derivative of the equations of the step
  /// by the velocities in its middle, and contains the derivatives of the forces of springs, dampers and
  /// drives. Null if the last step had another length than h, or if its iteration used only the mass matrix.
  const double* resistance(double h) const { return midpoint_.resistance(h); }

  /// Begins a step of length h at time t, from the state (q_0, v_0) before impulses and the states x_0 of the
  /// drives. `bodies` have factorised the mass matrix at q_0.
  void begin(double t, double h, const Vector& q_0, const Vector& v_0, const Vector& x_0,
             const ArticulatedBodies<Spatial, double>& bodies) {
    t_ = t;
    q_0_ = q_0;
    bases().place(t, bodies);
    drives_.begin_midpoint_step(h, x_0);
    // The change of the velocities up to the middle is about that of the last step of this length.
    v_middle = v_0;
    if (h == h_of_change_) v_middle += change_;
    h_of_change_ = 0;
    h_ = h;
    flown_ = false;
    midpoint_.renew_matrix();
  }
  /// Computes the motion between the impulses at the two ends of the step by the midpoint rule (D8.5), from
  /// the configuration q_0 that begin() received and the joint momenta p_a = M(q_0) v_a, with the velocities
  /// v_a after the impulses at the start. Writes the configuration and velocities in the middle of the step
  /// to q_middle and v_middle, and the configuration at the end to q_end. If the impulses at the start are
  /// corrected, the function is called again in the same step, and then iterates from its previous result.
  /// The iteration ends when it changes the velocities by at most `enough` times their magnitude; is_exact()
  /// says whether only a rounding error remains.
  Failure fly(const Vector& p_a, double enough) {
    FloatingBases& bases = this->bases();
    p_before_.swap(p_0_);
    p_0_ = p_a;
    bases.start(is_loaded(), p_0_.data());
    y_ = p_0_;
    bases.begin(q_0_.data(), y_.data());
    bases.to_momenta(q_0_.data(), y_.data(), p_0_.data());
    if (flown_) {
      p_before_ = p_0_ - p_before_;
      midpoint_.follow(p_before_);
    } else {
      midpoint_.v = v_middle;
      q_middle = q_0_;
      bases.to_moving_frame(t_ + h_ / 2, q_middle.data(), midpoint_.v.data());
    }
    if (Failure failure = midpoint_.run_again(t_, h_, q_0_, p_0_, enough)) return failure;
    flown_ = true;
    q_middle = midpoint_.q_middle;
    v_middle = midpoint_.v;
    bases.from_moving_frame(t_ + h_ / 2, q_middle.data(), v_middle.data());
    p_end = midpoint_.p;
    bases.advance(midpoint_.q_middle.data(), h_, pushes_bases(), midpoint_.f.data(), y_.data());
    q_moving_ = midpoint_.q;
    bases.restore_centers(q_moving_.data());
    q_end = q_moving_;
    bases.from_moving_frame(t_ + h_, q_end.data());
    return {};
  }
  bool is_exact() const { return midpoint_.is_exact(); }
  /// Completes p_end, the joint momenta at the end of the step before the impulses there: replaces the six
  /// entries of each floating base by those that follow from its spatial momentum. Before the call, fly()
  /// must have computed the motion between the impulses at the two ends of the step. Each floating base has a
  /// moving frame, which falls with gravity but does not rotate, and its momenta are relative to this frame.
  /// They are exact to rounding if only gravity acts on the bases between the impulses. v_0 are the
  /// velocities that begin() received.
  void arrive(const Vector& v_0) {
    change_ = v_middle - v_0;
    h_of_change_ = h_;
    bases().to_momenta(q_moving_.data(), y_.data(), p_end.data());
  }
  /// Converts the velocities v_t at the end of the step, at the configuration that the last call of fly()
  /// computed, to the inertial frame. On entry the velocities of floating bases are relative to their moving
  /// frames, which fall with gravity but do not rotate.
  void leave_moving_frames(Vector& v_t) { bases().from_moving_frame(t_ + h_, q_moving_.data(), v_t.data()); }

  /// Computes the states x of the drives at the end of the present step by (D17.7b). The step has the length
  /// h and starts at time t at the configuration q_0 with the drive states x_0. v_0 are the velocities at its
  /// start before the impulses there, and v_1 those at its end after the impulses there.
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

  Vector q_end, p_end, q_middle, v_middle;  ///< results of fly() and arrive()

 private:
  Midpoint<ContactSimulationRun> midpoint_;
  Vector q_0_, p_0_, q_moving_, y_, p_before_, v_last_;
  Vector change_;  ///< of the velocities, up to the middle of the last step
  double t_ = 0, h_ = 0, h_of_change_ = 0;
  bool flown_ = false;  ///< whether fly() has been called in the step
};

}  // namespace axode
