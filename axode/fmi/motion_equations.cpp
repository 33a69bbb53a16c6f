#include "axode/fmi/motion_equations.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "axode/constraints/assembly.hpp"
#include "axode/derivatives/forward_dynamics_derivatives.hpp"
#include "axode/derivatives/spring_derivatives.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/dynamics/inverse_dynamics.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/eigen.hpp"
#include "axode/kinematics/jacobian.hpp"
#include "axode/kinematics/poses.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"
#include "axode/scalar/dual.hpp"

namespace axode::fmi {
namespace {

using Span = std::span<const double>;

/// Calls f(subgroup, iq, iv) for every joint that is not coupled to another one, with its subgroup of SE(3)
/// for numbers of the type T, and the indices of its first coordinate and its first velocity.
template <class T, class F> void each_subgroup(const Model& model, const F& f) {
  for (const Joint& joint : model.joints())
    if (!joint.leader)
      with_subgroup(joint.kind, T(joint.pitch),
                    [&](const auto& subgroup) { f(subgroup, joint.iq, joint.iv); });
}

}  // namespace

std::vector<AppliedWrench<>> applied(Span wrenches, std::span<const int> frames) {
  std::vector<AppliedWrench<>> out;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const double* W = &wrenches[6 * k];
    out.emplace_back(frames[k], Representation::hybrid, Vec3<>{W[0], W[1], W[2]}, Vec3<>{W[3], W[4], W[5]});
  }
  return out;
}

MotionEquations::MotionEquations(const Model& model, const Settings& settings, std::span<const int> loads)
    : model_(model),
      settings_(settings),
      load_frames_(loads.begin(), loads.end()),
      workspace_(model_, cut_tree),
      drives_(model_),
      plays_(model_, true),
      friction_(model_.tree<double>(), model_.gears(), settings.joint_losses),
      norm_(model_.tree<double>()) {
  if (!model_.loops().empty() || !model_.motions().empty()) loops_.emplace(model_);
}

std::vector<double> MotionEquations::normalized(Span q) const {
  if (const std::string bad = first_not_finite(model_, q, {}); !bad.empty())
    throw NoRates(bad + "; it must be finite");
  try {
    return normalize(model_, q);
  } catch (const std::invalid_argument& error) {
    throw NoRates(error.what());
  }
}

/// Sets the time of the prescribed motions. Throws NoRates for a time beyond the samples of a motion.
void MotionEquations::set_time(double t) {
  try {
    loops_->motions().check_times(t, t);
  } catch (const std::invalid_argument& error) {
    throw NoRates(error.what());
  }
  loops_->set_time(t);
}

void MotionEquations::start(Point& at) {
  at.q = normalized(at.q);
  const bool engaged = plays_.any_at_an_end();
  plays_ = Plays(model_, true);
  if (engaged) engagement(at)();
  if (loops_) {
    loops_->motions().check_times(at.t, at.t);
    loops_->set_time(at.t);
    if (!is_closed(at)) {
      AssemblyResult found = assemble(model_, at.q, at.v, {.time = at.t});
      if (found.status != AssemblyStatus::closed) throw std::runtime_error(to_string(model_, found));
      at.q = std::move(found.q);
      at.v = std::move(found.v);
    }
    loops_->check(at.q, at.v);
    if (!close(at))
      throw std::runtime_error("the loops cannot be closed at t = " + axode::to_text(at.t) +
                               " s; start from another q");
  }
  drives_.set_state(at.t, at.q, at.v, at.x);
  friction_.start(at.v);
  if (friction_.active()) friction_.start_sliding(rates(at).a);
}

/// Whether at q and v the loops are closed and the prescribed motions are followed.
bool MotionEquations::is_closed(const Point& at) {
  try {
    loops_->check(at.q, at.v);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

bool MotionEquations::close(Point& at) {
  at.q = normalized(at.q);
  if (!loops_) return true;
  set_time(at.t);
  return loops_->close(at.q, at.v);
}

Loads<double> MotionEquations::loads(const Point& at) {
  wrenches_ = applied(at.wrenches, load_frames_);
  return {wrenches_, settings_.joint_losses && !friction_.active()};
}

std::vector<double> MotionEquations::force_sum(const Point& at, Span q, std::vector<double>* dx) {
  std::vector<double> tau = at.tau, rates(at.x.size());
  if (!drives_.empty()) drives_.evaluate(at.t, q, at.v, at.x, tau, rates);
  if (friction_.has_gears()) {
    std::vector<double> along_lines(tau.size());
    if (!drives_.empty()) drives_.add_line_forces(along_lines);
    through_gears_ = tau;
    as_eigen(std::span(through_gears_)) -= as_eigen(Span(along_lines));
  }
  if (!model_.springs().empty()) add_spring_forces(model_, workspace_, q, Span(at.v), tau);
  if (friction_.active()) friction_.add_losses(at.v, tau);
  if (dx != nullptr) *dx = std::move(rates);
  return tau;
}

Rates MotionEquations::rates(const Point& at) {
  const std::vector<double> q = normalized(at.q);
  if (const std::string bad = first_not_finite(model_, q, at.v); !bad.empty())
    throw NoRates(bad + " at t = " + axode::to_text(at.t) + " s; it must be finite");
  for (std::size_t k = 0; k < at.x.size(); ++k)
    if (!finite(at.x[k]))
      throw NoRates("the state \"" + drives_.states()[k].name + "\" is " + axode::to_text(at.x[k]) +
                    " at t = " + axode::to_text(at.t) + " s; it must be finite");
  Rates out{coordinate_rates(model_, q, at.v), std::vector<double>(at.v.size()), {}};
  const std::vector<double> tau = force_sum(at, q, &out.dx);
  Solvability found;
  if (loops_) {
    set_time(at.t);
    found = loops_->accelerate(q, at.v, tau, loads(at), out.a);
  } else {
    found = forward_dynamics(model_, workspace_, Span(q), Span(at.v), Span(tau), out.a, loads(at));
  }
  if (!found.ok()) throw NoRates(to_string(model_, found));
  if (!friction_.resisting().empty())
    if (const Solvability held = response_.apply(model_, workspace_, loops_ ? &*loops_ : nullptr, friction_,
                                                 norm_, q, at.v, through_gears_, out.a);
        !held.ok())
      throw NoRates(to_string(model_, held));
  if (!finite(out.dx)) throw NoRates("the rates of the states of the drives are not finite");
  if (loops_)
    if (const std::string why = loops_->unfollowed(q, at.v, out.a); !why.empty()) throw NoRates(why);
  for (std::size_t k = 0; k < friction_.size(); ++k) out.reserves.push_back(friction_.reserve(k, at.v));
  for (std::size_t k = 0; k < plays_.size(); ++k)
    out.reserves.push_back(plays_.reserve(k, q, loops_ ? &*loops_ : nullptr));
  return out;
}

void MotionEquations::switch_drives(Point& at) {
  if (!drives_.empty()) static_cast<void>(drives_.switch_at(at.t, normalized(at.q), at.v, at.x));
}

/// Sets up the loops anew, with a coupling without play for every play that is at an end.
Plays::Engage MotionEquations::engagement(const Point& at) {
  return [this, &at]() -> ClosedMotion* {
    const Model& model = plays_.any_at_an_end() ? plays_.engaged() : model_;
    loops_.reset();
    if (model.loops().empty() && model.motions().empty()) return nullptr;
    loops_.emplace(model);
    loops_->set_time(at.t);
    loops_->determine_rank(at.q);
    return &*loops_;
  };
}

/// Lets plays at an end become free if they would be pulled.
void MotionEquations::settle_plays(const Point& at) {
  for (;;) {
    static_cast<void>(rates(at));
    if (plays_.release_pulled(loops_ ? &*loops_ : nullptr).empty()) break;
    engagement(at)();
  }
  plays_.allow_overshoot(at.q);
}

void MotionEquations::start_plays(Point& at) {
  if (!plays_.any()) return;
  plays_.start(at.q, at.v, engagement(at));
  settle_plays(at);
}

void MotionEquations::switch_plays(Point& at) {
  if (!plays_.any()) return;
  const std::vector<double> reserves = rates(at).reserves;
  plays_.change(Span(reserves).subspan(friction_.size()), at.q, at.v, engagement(at));
  settle_plays(at);
}

void MotionEquations::switch_friction(Point& at) {
  if (!friction_.active()) return;
  // Joints of a loop come to rest at one time, which the importing program finds up to rounding.
  constexpr double rounding = 1e-11;
  friction_.stop_sliding(at.v, rates(at).a, rounding * std::max(1.0, std::abs(at.t)));
  friction_.start(at.v);
  friction_.start_sliding(rates(at).a);
}

double MotionEquations::next_jump(double t) const {
  const double next = drives_.next_jump(t);
  return loops_ ? std::min(next, loops_->motions().next_jump(t)) : next;
}

double MotionEquations::least_margin(const Point& at) {
  const double least = drives_.least_margin(at.t, normalized(at.q), at.v, at.x);
  return std::isfinite(least) ? least : 1;
}

std::vector<double> MotionEquations::poses(const Point& at, std::span<const int> frames) {
  const std::vector<double> q = normalized(at.q);
  const std::vector<Place<double>> places(frames.begin(), frames.end());
  std::vector<SE3<>> C(places.size());
  axode::poses<double>(model_, workspace_, q, places, C);
  std::vector<double> out;
  for (const SE3<>& pose : C)
    for (const Vec3<>& column : {pose.R.x, pose.R.y, pose.R.z, pose.r})
      out.insert(out.end(), {column.x, column.y, column.z});
  return out;
}

MotionEquations::Derivatives MotionEquations::derivatives(const Point& at, Span q) {
  const Eigen::Index nv = model_.nv();
  const Span v(at.v);
  const std::vector<double> tau = force_sum(at, q, nullptr);
  Derivatives d{RowMajor(nv, nv), RowMajor(nv, nv), RowMajor(nv, nv), {}, {}};
  if (loops_) {
    set_time(at.t);
    loops_->differentiate(q, v, tau, loads(at), {as_span(d.a_q), as_span(d.a_v), as_span(d.a_tau)});
  } else {
    static_cast<void>(forward_dynamics_derivatives(
        model_, workspace_, q, v, Span(tau), {as_span(d.a_q), as_span(d.a_v), as_span(d.a_tau)}, loads(at)));
  }
  if (!d.a_q.allFinite() || !d.a_v.allFinite() || !d.a_tau.allFinite())
    throw NoRates("the accelerations have no derivatives at this state");
  RowMajor by_q = RowMajor::Zero(nv, nv), by_v = by_q;
  if (!model_.springs().empty())
    spring_force_derivatives(model_, workspace_, q, v, {as_span(by_q), as_span(by_v)});
  if (friction_.active()) by_v.diagonal() -= as_eigen(Span(model_.tree<double>().damping));
  d.drives = drives_.derivatives(at.t, q, v, at.x);
  d.a_q += d.a_tau * (by_q + d.drives.tau_q);
  d.a_v += d.a_tau * (by_v + d.drives.tau_v);
  friction_.constrain_derivatives({as_span(d.a_tau), as_span(d.a_q), as_span(d.a_v)});
  d.a_x = d.a_tau * d.drives.tau_x;
  return d;
}

void MotionEquations::seeds(Span raw, Span q, Eigen::MatrixXd& displacement,
                            Eigen::MatrixXd& normalization) const {
  normalization = Eigen::MatrixXd::Identity(model_.nq(), model_.nq());
  displacement = Eigen::MatrixXd::Zero(model_.nv(), model_.nq());
  each_subgroup<double>(model_, [&]<class Kind>(const Kind& joint, int iq, int iv) {
    if constexpr (Kind::nq > Kind::nv) {
      const Eigen::Vector4d unit = as_eigen(q).segment<4>(iq);
      const double size = as_eigen(raw).segment<4>(iq).norm();
      normalization.block<4, 4>(iq, iq) = (Eigen::Matrix4d::Identity() - unit * unit.transpose()) / size;
    }
    for (int k = 0; k < Kind::nq; ++k) {
      const Eigen::VectorXd dq = normalization.block(iq, iq + k, Kind::nq, 1);
      joint.velocities(q.data() + iq, dq.data(), &displacement(iv, iq + k));
    }
  });
}

/// The derivatives of the coordinate rates q' = E(q) v by the entries of q, nq × nq.
Eigen::MatrixXd MotionEquations::rates_by_coordinates(Span q, Span v) const {
  using T = Dual<double, 1>;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(model_.nq(), model_.nq());
  each_subgroup<T>(model_, [&]<class Kind>(const Kind& joint, int iq, int iv) {
    if constexpr (!Kind::vector_coordinates) {
      T at[Kind::nq], velocity[Kind::nv], rate[Kind::nq];
      const double *const q_joint = q.data() + iq, *const v_joint = v.data() + iv;
      for (int k = 0; k < Kind::nq; ++k) at[k] = T(q_joint[k]);
      for (int k = 0; k < Kind::nv; ++k) velocity[k] = T(v_joint[k]);
      for (int k = 0; k < Kind::nq; ++k) {
        at[k].dx[0] = 1;
        joint.rates(at, velocity, rate);
        at[k].dx[0] = 0;
        for (int i = 0; i < Kind::nq; ++i) out(iq + i, iq + k) = rate[i].dx[0];
      }
    }
  });
  return out;
}

Eigen::MatrixXd MotionEquations::jacobian(const Point& at, std::span<const int> frames) {
  const std::vector<double> q = normalized(at.q);
  const Eigen::Index nq = model_.nq(), nv = model_.nv(), nx = static_cast<Eigen::Index>(at.x.size());
  const Eigen::Index n_poses = 12 * static_cast<Eigen::Index>(frames.size());
  Eigen::MatrixXd displacement, normalization;
  seeds(at.q, q, displacement, normalization);
  const Derivatives d = derivatives(at, q);
  const Eigen::Index n_loads = static_cast<Eigen::Index>(load_frames_.size());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(nq + nv + nx + n_poses, nq + 2 * nv + nx + 6 * n_loads);
  J.topLeftCorner(nq, nq) = rates_by_coordinates(q, at.v) * normalization;
  each_subgroup<double>(model_, [&]<class Kind>(const Kind& joint, int iq, int iv) {
    for (int k = 0; k < Kind::nv; ++k) {
      double unit[Kind::nv] = {};
      unit[k] = 1;
      Eigen::Matrix<double, Kind::nq, 1> rate;
      joint.rates(&q[static_cast<std::size_t>(iq)], unit, rate.data());
      J.block<Kind::nq, 1>(iq, nq + iv + k) = rate;
    }
  });
  J.middleRows(nq, nv).leftCols(nq + 2 * nv + nx) << d.a_q * displacement, d.a_v, d.a_x, d.a_tau;
  J.middleRows(nq + nv, nx).leftCols(nq + nv + nx) << d.drives.f_q * displacement, d.drives.f_v, d.drives.f_x;

  std::vector<Twist<Hybrid>> hybrid(static_cast<std::size_t>(nv));
  for (std::size_t f = 0; f < load_frames_.size(); ++f) {
    axode::jacobian<Hybrid>(model_, workspace_, Span(q), Place<double>(load_frames_[f]), std::span(hybrid));
    Eigen::MatrixXd by_wrench(nv, 6);
    for (Eigen::Index c = 0; c < nv; ++c) {
      const Twist<Hybrid>& V = hybrid[static_cast<std::size_t>(c)];
      by_wrench.row(c) << V.w.x, V.w.y, V.w.z, V.v.x, V.v.y, V.v.z;
    }
    J.block(nq, nq + 2 * nv + nx + 6 * static_cast<Eigen::Index>(f), nv, 6) = d.a_tau * by_wrench;
  }
  const std::vector<double> C = poses(at, frames);
  std::vector<Twist<BodyFixed>> columns(static_cast<std::size_t>(nv));
  for (std::size_t f = 0; f < frames.size(); ++f) {
    axode::jacobian<BodyFixed>(model_, workspace_, Span(q), Place<double>(frames[f]), std::span(columns));
    const Eigen::Index row = nq + nv + nx + 12 * static_cast<Eigen::Index>(f);
    const Eigen::Map<const Eigen::Matrix3d> R(&C[12 * f]);
    Eigen::MatrixXd by_displacement(12, nv);
    for (Eigen::Index c = 0; c < nv; ++c) {
      const Twist<BodyFixed>& V = columns[static_cast<std::size_t>(c)];
      const Eigen::Vector3d w(V.w.x, V.w.y, V.w.z), v(V.v.x, V.v.y, V.v.z);
      for (Eigen::Index k = 0; k < 3; ++k)
        by_displacement.block<3, 1>(3 * k, c) = R * w.cross(Eigen::Vector3d::Unit(k));
      by_displacement.block<3, 1>(9, c) = R * v;
    }
    J.block(row, 0, 12, nq) = by_displacement * displacement;
  }
  return J;
}

Eigen::VectorXd MotionEquations::acceleration_by(const Point& at, const Parameter& parameter) {
  const std::vector<double> q = normalized(at.q), a = rates(at).a;
  wrenches_ = applied(at.wrenches, load_frames_);
  const Loads<double> acting{wrenches_, settings_.joint_losses};  // with the damping of all joints
  const auto missing_force = [&](double by) {
    Description description = model_.description();
    parameter.in(description) += by;
    const Model changed = ModelBuilder(std::move(description)).build();
    Workspace<> workspace(changed, cut_tree);
    std::vector<double> force(a.size()), springs(a.size());
    inverse_dynamics(changed, workspace, Span(q), Span(at.v), Span(a), force, acting);
    spring_forces(changed, workspace, Span(q), Span(at.v), springs);
    return Eigen::VectorXd(as_eigen(Span(force)) - as_eigen(Span(springs)));
  };
  Description numbers = model_.description();
  const double value = std::abs(parameter.in(numbers)), h = parameter.step * (value > 0 ? value : 1);
  // A number that is 0 is only increased, because some numbers must not be negative.
  const Eigen::VectorXd change =
      value > 0 ? Eigen::VectorXd(missing_force(h) - missing_force(-h))
                : Eigen::VectorXd(4 * missing_force(h) - missing_force(2 * h) - 3 * missing_force(0));
  return derivatives(at, q).a_tau * change / (-2 * h);
}

}  // namespace axode::fmi
