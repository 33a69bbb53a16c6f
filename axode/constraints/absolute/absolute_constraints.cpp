#include <cmath>
#include <limits>

#include "axode/constraints/absolute/absolute_system.hpp"

/// The constraint equations of a mechanism in absolute coordinates, in which every body has the coordinates
/// of a free body: the equations of joints, loops and rotors. A rotor is an additional body with one
/// coordinate, whose velocity is constrained to equal one joint velocity.
namespace axode {
namespace {

/// The difference between `angle`, the angle of a joint by the poses of its bodies, and its coordinate
/// `counted`, which counts whole turns. Poses determine angles up to whole turns; `angle` must be the one
/// nearest to `counted`. The difference is 0 if it is within the rounding error of `counted`.
double angle_residual(double angle, double counted) {
  const double open = angle - counted;
  const double rounding = 4 * std::numeric_limits<double>::epsilon();
  return std::abs(open) <= rounding * std::abs(counted) ? 0 : open;
}

}  // namespace

template <class Motion> void AbsoluteSystem::bind(const Motion& X, Vector& rows) const {
  for (int i = 1; i <= n_; ++i) {
    const auto& [closure, along] = bound_[index(i)];
    Six<double> x = six(X[index(i)].w, X[index(i)].v);
    const double own = along < 0 ? 0 : x[index(along)];
    x[5] -= closure.pitch * x[2];
    for (std::size_t k = 0; k < 6; ++k) rows[index(6 * (i - 1)) + k] = closure.free[k] ? 0 : x[k];
    const int l = leader_[index(i)];
    if (l > 0) rows[index(6 * (i - 1) + along)] = own - tree().ratio[index(i)] * rate(l, X[index(l)]);
  }
  for (int r = 0; r < n_rotors(); ++r) {
    const Rotor& rotor = rotors_[index(r)];
    rows[index(6 * n_ + r)] = rate(rotor, X[index(rotor.joint)]);
  }
}

/// The point about which the wrenches of a loop joint are taken: the origin of one of its two bodies.
const Vec3<>& AbsoluteSystem::loop_origin(const LoopPath& path) const {
  return C_[index(std::max(path.ends[0].body, path.ends[1].body))].r;
}
loops::LoopFrames<double> AbsoluteSystem::loop_frames(const LoopPath& path) const {
  const auto& [a, b] = path.ends;
  const Vec3<>& O = loop_origin(path);
  return {about(O, C_[index(a.body)] * a.F), about(O, C_[index(b.body)] * b.F)};
}

/// Computes the products A v of the rows of a loop joint with the present velocities of its two bodies.
template <class Joint>
Six<double> AbsoluteSystem::loop_rates(const LoopPath& path, const Joint& joint) const {
  const auto& [a, b] = path.ends;
  const Vec3<>& O = loop_origin(path);
  const Twist<Spatial> X =
      Ad(about(O, C_[index(b.body)]), V_[index(b.body)]) - Ad(about(O, C_[index(a.body)]), V_[index(a.body)]);
  loops::LoopWrenches<double> W;
  joint.wrenches(loop_frames(path), W.data());
  Six<double> rates{};
  for (std::size_t k = 0; k < index(path.rows.count); ++k) rates[k] = W[k] | X;
  return rates;
}

void AbsoluteSystem::position_residual(Span q, Vector& out, ConstraintLevel level) {
  find_poses(q);
  out.assign(index(rows(level)), 0.0);
  for (int i = 1; i <= n_; ++i) {
    const auto& [closure, along] = bound_[index(i)];
    const SE3<> E = closure.strip(joint_pose(i));
    const Six<double> open = six(log_SO3(E.R), E.r);
    for (std::size_t k = 0; k < 6; ++k) out[index(6 * (i - 1)) + k] = closure.free[k] ? 0 : open[k];
    const int l = leader_[index(i)];
    if (l > 0)
      out[index(6 * (i - 1) + along)] =
          angle(i) - tree().ratio[index(i)] * angle(l) - tree().offset[index(i)];
  }
  for (int r = 0; r < n_placed_rotors_; ++r)
    out[index(6 * n_ + r)] = angle_residual(angle(rotors_[index(r)].joint), q[index(7 * n_ + r)]);
  double* const open = out.data() + first_loop(level);
  loops_.table().each([&](std::size_t n, const auto& joint) {
    const LoopPath& path = loops_.table().paths[n];
    joint.residual(loop_frames(path),
                   open + (level == ConstraintLevel::position ? path.residuals : path.rows).first);
  });
  for (const LoopCoupling& coupling : model_.loops().couplings) {
    double& sum = open[level == ConstraintLevel::position ? coupling.first_residual : coupling.first_row];
    sum = -coupling.offset;
    for (const LoopCoupling::Term& term : coupling.terms) sum += term.factor * known_angle(term.velocity);
  }
  for (const PrescribedRow<double>& it : prescribed_)
    open[level == ConstraintLevel::position ? it.residual : it.row] -= it.s;
}

void AbsoluteSystem::velocity_residual(Span q, Span v, Vector& out) {
  find_poses(q);
  find_twists(v);
  out.resize(index(rows(ConstraintLevel::velocity)));
  for (int i = 1; i <= n_; ++i) X_[index(i)] = joint_twist(i);
  bind(X_, out);
  for (int r = 0; r < n_rotors(); ++r) out[index(6 * n_ + r)] -= v[index(6 * n_ + r)];
  double* const at = out.data() + first_loop(ConstraintLevel::velocity);
  loops_.table().each([&](std::size_t n, const auto& joint) {
    const LoopPath& path = loops_.table().paths[n];
    std::copy_n(loop_rates(path, joint).begin(), path.rows.count, at + path.rows.first);
  });
  for (const LoopCoupling& coupling : model_.loops().couplings)
    at[coupling.first_row] = coupled_rate(coupling, X_);
  for (const PrescribedRow<double>& it : prescribed_) at[it.row] -= it.ds;
}
/// Computes Σ factor q' over the terms of a coupling, for the relative motions X of all joints.
double AbsoluteSystem::coupled_rate(const LoopCoupling& coupling, const std::vector<BodyTwist>& X) const {
  double sum = 0;
  for (const LoopCoupling::Term& term : coupling.terms) {
    const int i = joint_of_[index(term.velocity)];
    sum += term.factor * rate(i, X[index(i)]);
  }
  return sum;
}

void AbsoluteSystem::set_nonholonomic_rates(Span q, Span v, double scale, Vector& out) {
  if (!has_nonholonomic_rows()) return;
  find_poses(q);
  find_twists(v);
  for (int r = n_placed_rotors_; r < n_rotors(); ++r) {
    const Rotor& rotor = rotors_[index(r)];
    out[index(6 * n_ + r)] = scale * (rate(rotor, joint_twist(rotor.joint)) - v[index(6 * n_ + r)]);
  }
  double* const at = out.data() + first_loop(ConstraintLevel::velocity);
  loops_.table().each([&](std::size_t n, const auto& joint) {
    const LoopPath& path = loops_.table().paths[n];
    if (path.residuals.count == path.rows.count) return;
    const Six<double> slip = loop_rates(path, joint);
    for (int k = path.residuals.count; k < path.rows.count; ++k)
      at[path.rows.first + k] = scale * slip[index(k)];
  });
}

void AbsoluteSystem::add_constraint_forces(Span q, Span lambda, Vector& f) {
  find_poses(q);
  for (int i = 1; i <= n_; ++i) {
    const double* const at = &lambda[index(6 * (i - 1))];
    BodyWrench W{angular(at), linear(at)};
    W.m.z -= bound_[index(i)].closure.pitch * W.f.z;
    add_joint_wrench(i, W, f);
    const int l = leader_[index(i)];
    if (l > 0) add_joint_wrench(l, co_screw(l, -tree().ratio[index(i)] * at[bound_[index(i)].along]), f);
  }
  for (int r = 0; r < n_rotors(); ++r) {
    const double mu = lambda[index(6 * n_ + r)];
    add_joint_wrench(rotors_[index(r)].joint, co_screw(rotors_[index(r)].along, mu), f);
    f[index(6 * n_ + r)] -= mu;
  }
  const double* const at = lambda.data() + first_loop(ConstraintLevel::velocity);
  loops_.table().each([&](std::size_t n, const auto& joint) {
    const LoopPath& path = loops_.table().paths[n];
    const auto& [a, b] = path.ends;
    const Vec3<>& O = loop_origin(path);
    loops::LoopWrenches<double> all;
    joint.wrenches(loop_frames(path), all.data());
    Wrench<Spatial> W{};
    for (int k = 0; k < path.rows.count; ++k) W += at[path.rows.first + k] * all[index(k)];
    add_wrench(C_[index(b.body)], coAd_inv(about(O, C_[index(b.body)]), W), b.body, f);
    add_wrench(C_[index(a.body)], coAd_inv(about(O, C_[index(a.body)]), -W), a.body, f);
  });
  for (const LoopCoupling& coupling : model_.loops().couplings)
    for (const LoopCoupling::Term& term : coupling.terms) {
      const int i = joint_of_[index(term.velocity)];
      add_joint_wrench(i, co_screw(i, term.factor * at[coupling.first_row]), f);
    }
}

Solvability AbsoluteSystem::factorize(Span q, ConstraintLevel level) {
  return factorize(q, level, tree().armature.data());
}

Solvability AbsoluteSystem::factorize(Span q, Span resistance) {
  armature_.assign(tree().armature.begin(), tree().armature.end());
  for (std::size_t c = 0; c < armature_.size(); ++c) armature_[c] += resistance[c];
  return factorize(q, ConstraintLevel::velocity, armature_.data());
}

Solvability AbsoluteSystem::factorize(Span q, ConstraintLevel level, const double* armature) {
  find_poses(q);
  factorized_C_ = C_;
  factorized_level_ = level;
  loops_.update_kinematics(factorized_C_.data(), -C_[0].r);
  const Solvability found = loops_.factorize_with_armature(armature);
  if (!found.ok()) return found;
  loops_.make_wrenches(level);
  loops_.factorize_rows();
  return found;
}

Solvability AbsoluteSystem::factorize_with_rank(Span q) {
  const Solvability found = factorize(q);
  if (found.ok()) loops_.determine_rank(rank_);
  return found;
}

void AbsoluteSystem::solve(Span r, Span rhs, Vector& x, Vector& lambda) {
  ArticulatedBodies<Spatial, double>& bodies = loops_.bodies();
  const int bound_rotors = n_rotors(factorized_level_), m = loops_.size(factorized_level_);
  const std::size_t loop_rows = index(first_loop(factorized_level_));
  x.resize(index(nv()));
  lambda.resize(loop_rows + index(m));

  // The right side prescribes the velocities along the rows of the joints. If K_i is the sum of these
  // velocities along the path to body i, Z_i = X_i - K_i is a motion that the joints allow.
  on_[0] = {};
  for (int i = 1; i <= n_; ++i) {
    const double* const at = &rhs[index(6 * (i - 1))];
    BodyTwist k{angular(at), linear(at)};
    k.v.z += bound_[index(i)].closure.pitch * k.w.z;
    known_[index(i)] = known_[index(parent(i))];
    known_[index(i)] += Ad(loops_.link(i).C, k);
    on_[index(i)] = coAd(loops_.link(i).C, wrench(factorized_C_[index(i)], r, i));
  }
  const auto inertial = [&](int i, const Twist<Spatial>& X) {
    const Momentum<Spatial> Pi = loops_.link(i).inertia(tree().M[index(i)]) * X;
    return Wrench<Spatial>{Pi.l, Pi.p};
  };
  std::ranges::fill(tau_, 0.0);
  for (int k = 0; k < bound_rotors; ++k) {
    const int c = rotors_[index(k)].velocity;
    tau_[index(c)] = r[index(6 * n_ + k)] + tree().armature[index(c)] * rhs[index(6 * n_ + k)];
  }
  const auto solve_tree = [&] {
    bodies.W[0] = {};
    for (int i = 1; i <= n_; ++i) bodies.W[i] = inertial(i, known_[index(i)]) - on_[index(i)];
    for (int t = 0; t < tree()->ties.begin[index(n_ + 1)]; ++t) bodies.u_tie[t] = 0;
    for (int i = n_; i > 0; --i) bodies.backward_step(tree(), i, tau_.data());
    bodies.backward_step_at_ground(tree(), tau_.data());
    bodies.forward_sweep(tree(), x_.data());
    V_s_[0] = {};
    for (int i = 1; i <= n_; ++i) V_s_[index(i)] = bodies.X[i] + known_[index(i)];
  };
  solve_tree();
  double* const loop_lambda = lambda.data() + loop_rows;
  if (m > 0) {
    loops_.rates(V_s_.data(), x_.data(), b_.data());
    for (int k = 0; k < m; ++k) b_[k] -= rhs[loop_rows + index(k)];
    loops_.solve_rows(b_.data(), loop_lambda, rank_);
    loops_.add_wrenches(loop_lambda, on_.data(), tau_.data());
    solve_tree();
  }

  std::ranges::fill(through_, Wrench<Spatial>{});
  for (int i = n_; i > 0; --i) {
    const SE3<>& C = loops_.link(i).C;
    put_twist(factorized_C_[index(i)], Ad_inv(C, V_s_[index(i)]), i, x);
    through_[index(i)] += inertial(i, V_s_[index(i)]) - on_[index(i)];
    const BodyWrench W = coAd_inv(C, through_[index(i)]);
    const auto& [closure, along] = bound_[index(i)];
    const Six<double> all = six(W.m, W.f);
    double* const at = &lambda[index(6 * (i - 1))];
    for (std::size_t k = 0; k < 6; ++k) at[k] = closure.free[k] ? 0 : all[k];
    if (leader_[index(i)] > 0) at[along] = all[index(along)] + closure.pitch * W.f.z;
    through_[index(parent(i))] += through_[index(i)];
  }
  for (int k = bound_rotors; k < n_rotors(); ++k)  // rotors without a row move with their joints
    x[index(6 * n_ + k)] = x_[index(rotors_[index(k)].velocity)];
  for (int k = 0; k < bound_rotors; ++k) {
    const int c = rotors_[index(k)].velocity;
    const double moved = x_[index(c)] - rhs[index(6 * n_ + k)];
    x[index(6 * n_ + k)] = moved;
    lambda[index(6 * n_ + k)] = r[index(6 * n_ + k)] - tree().armature[index(c)] * moved;
  }
}

void AbsoluteSystem::bias(Span v, Vector& rhs) {
  C_ = factorized_C_;
  find_twists(v);
  rhs.resize(index(rows(ConstraintLevel::velocity)));
  // If linear velocities are in inertial axes (SO3xR3), the body-fixed twists change although v is constant.
  std::vector<BodyTwist> rest(index(n_ + 1));
  for (int i = 1; i <= n_; ++i) {
    const BodyTwist& V = V_[index(i)];
    if (!is_on_SE3(i)) rest[index(i)].v = -cross(V.w, V.v + cross(V.w, com_[index(i)]));
    const SE3<>& C = loops_.link(i).C;
    V_s_[index(i)] = Ad(C, V);
    const Twist<Spatial> rate = Ad(C, rest[index(i)]);
    dV_s_[index(i)] = {rate.w, rate.v};
    const SE3<> D = inverse(factorized_C_[index(parent(i))]) * factorized_C_[index(i)];
    const BodyTwist V_p = carried(D, V_[index(parent(i))]);
    X_[index(i)] = ad(V_p, V) - rest[index(i)] + carried(D, rest[index(parent(i))]);
  }
  bind(X_, rhs);
  if (model_.loops().empty()) return;
  V_s_[0] = {};
  dV_s_[0] = {};
  loops_.bias(V_s_.data(), dV_s_.data(), b_.data());
  double* const at = rhs.data() + first_loop(ConstraintLevel::velocity);
  for (int k = 0; k < model_.loops().rows; ++k) at[k] = -b_[k];
  for (const LoopCoupling& coupling : model_.loops().couplings)
    at[coupling.first_row] = coupled_rate(coupling, X_);
  for (const PrescribedRow<double>& it : prescribed_) at[it.row] += it.dds;
}

}  // namespace axode
