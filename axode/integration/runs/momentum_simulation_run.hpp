#pragma once
#include <limits>

#include "axode/dynamics/inverse_dynamics.hpp"
#include "axode/dynamics/momentum/momentum.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/runs/simulation_run.hpp"
#include "axode/integration/schemes/floating_bases.hpp"
#include "axode/integration/schemes/phase_space.hpp"
#include "axode/model/finite.hpp"

namespace axode {

/// A motion that is integrated in configurations q and momenta p = M v. The coordinates of floating bases are
/// relative to moving frames, which fall with gravity but do not rotate.
class MomentumSimulationRun : public SimulationRun {
 public:
  MomentumSimulationRun(const Model& model, Span q_0, Span v_0, double until,
                        const SimulationOptions& options, bool damping = false)
      : SimulationRun(model, q_0, v_0, until, options, damping),
        phase_space_(model),
        bases_(model, q_0.data(), v_0.data(), is_loaded()),
        p_(model.nv()),
        q_factorized_(Vector::Constant(model.nq(), std::numeric_limits<double>::quiet_NaN())) {}

  FloatingBases& bases() { return bases_; }
  /// Writes q, v and p = M v at the start of the motion, relative to the moving frames of the floating bases.
  void initial_state(Vector& q_0, Vector& v_0, Vector& p_0) {
    q_0 = q;
    v_0 = v;
    p_0.resize(v.size());
    bases_.to_moving_frame(0, q_0.data(), v_0.data());
    momenta(model_, workspace_, Span(as_span(q_0)), as_span(v_0), as_span(p_0));
  }

  /// Computes the momenta p = M v and the forces f = τ + ∂L/∂q, with the Lagrangian L, at time t and the
  /// state (q_t, v_t). The coordinates and velocities of floating bases in this state are relative to moving
  /// frames, which fall with gravity but do not rotate.
  Failure partials(double t, const Vector& q_t, const Vector& v_t, Vector& p, Vector& f) {
    q_t_ = q_t;
    v_t_ = v_t;
    bases_.from_moving_frame(t, q_t_.data(), v_t_.data());
    Span tau;
    if (Failure failure = joint_forces(t, as_span(q_t_), as_span(v_t_), tau)) return failure;
    pushes_bases_ = is_loaded() || bases_.driven_by(tau.data());
    phase_space_.partials(q_t_.data(), v_t.data(), bases_.gravity(), tau, loads(), p.data(), f.data());
    return {};
  }
  Failure factorize(double t, const Vector& q_t) {
    q_factorized_ = q_t;
    return checked(t, phase_space_.factorize(q_t.data()));
  }
  /// Whether M was last factorised at these coordinates.
  bool is_factorized_at(const Vector& q_t) const { return q_factorized_ == q_t; }
  void solve(Vector& x) { phase_space_.solve(x.data()); }
  /// Computes v = M⁻¹ p of a state (q, p), and factorises M at q.
  Failure velocity(double t, const Vector& q_t, const Vector& p, Vector& v_t) {
    if (Failure failure = factorize(t, q_t)) return failure;
    v_t = p;
    solve(v_t);
    return finite(v_t) ? Failure{} : not_finite(t, "the state is", as_span(v_t));
  }
  /// Computes v = M⁻¹ p and f = p' - ad_vᵀ p of a state (q, p), where the forces of loops are included.
  Failure rates(double t, const Vector& q_t, const Vector& p, Vector& v_t, Vector& f) {
    if (Failure failure = velocity(t, q_t, p, v_t)) return failure;
    if (Failure failure = partials(t, q_t, v_t, p_, f)) return failure;
    if (!loops_) return {};
    loops_->set_time(t);
    return checked(t, loops_->add_constraint_forces(as_span(q_t_), as_span(v_t_), as_span(forces_), loads(),
                                                    as_span(f)));
  }
  Failure checked(double t, const Solvability& found) const {
    return found.ok() ? Failure{} : Failure{t, to_string(model_, found)};
  }
  /// close() projects p onto the momenta that keep the loops closed and follow the prescribed motions at time
  /// t. close_places() projects q onto the configurations in which the loops are closed and the prescribed
  /// motions are followed at time t. A prescribed motion gives a joint coordinate, or the length of a rod (a
  /// loop joint that keeps two points at a distance), as a function of time.
  Failure close(double t, const Vector& q_t, Vector& p) {
    if (!loops_) return {};
    loops_->set_time(t);
    return loops_->close_momenta(as_span(q_t), as_span(p)) ? Failure{} : Failure{t, open};
  }
  Failure close_places(double t, Vector& q_t) {
    if (!loops_) return {};
    loops_->set_time(t);
    return loops_->close_places(as_span(q_t)) ? Failure{} : Failure{t, open};
  }
  /// Whether a load or drive acted on a floating base in the last evaluation of forces.
  bool pushes_bases() const { return pushes_bases_; }
  /// Appends the end of a step, a state (q, p) with the states x of the drives, to the trajectory. In this
  /// state the coordinates and momenta of floating bases are relative to moving frames, which fall with
  /// gravity but do not rotate. The function converts them to coordinates and velocities in the inertial
  /// frame first.
  Failure take_momenta(double t, const Vector& q_t, const Vector& p, const Vector& x) {
    Vector q_1 = q_t, v_1, a_1(p.size());
    if (Failure failure = velocity(t, q_t, p, v_1)) return failure;
    bases_.from_moving_frame(t, q_1.data(), v_1.data());
    if (loops_) return take_closed(t, as_span(q_1), as_span(v_1), x);
    drives_.act_at(as_span(x));
    Span tau;  // M is factorised at q_1: a = M⁻¹ (τ - h)
    if (Failure failure = joint_forces(t, as_span(q_1), as_span(v_1), tau)) return failure;
    const Vector none = Vector::Zero(p.size());
    inverse_dynamics(model_, workspace_, Span(as_span(q_1)), as_span(v_1), as_span(none), as_span(a_1),
                     loads());
    a_1 = as_eigen(tau) - a_1;
    solve(a_1);
    if (!finite(a_1)) return {t, "accelerations are not finite"};
    return record(t, {q_1, v_1, a_1, x, as_eigen(drives_.rates())});
  }

 protected:
  bool is_loaded() const { return !options_.loads.empty() || options_.computed_loads; }

  PhaseSpace phase_space_;
  FloatingBases bases_;
  Vector q_t_, v_t_, p_, q_factorized_;
  bool pushes_bases_ = false;
};

}  // namespace axode
