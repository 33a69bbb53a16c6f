#include "axode/constraints/absolute_system.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/lie/quaternion.hpp"
#include "axode/model/configuration.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode {
namespace {

using BodyTwist = Twist<BodyFixed, double>;
using BodyWrench = Wrench<BodyFixed, double>;

/// The direction of a joint with one velocity; -1 of others.
int direction_along(const std::array<bool, 6>& free) {
  return std::ranges::count(free, true) == 1 ? static_cast<int>(std::ranges::find(free, true) - free.begin())
                                             : -1;
}

Vec3<> angular(const double* x) { return {x[0], x[1], x[2]}; }
Vec3<> linear(const double* x) { return {x[3], x[4], x[5]}; }
/// angle - counted, or 0 if it is no more than the rounding of angles of that size.
double angle_residual(double angle, double counted) {
  const double open = angle - counted, rounding = 4 * std::numeric_limits<double>::epsilon();
  return std::abs(open) <= rounding * std::abs(counted) ? 0 : open;
}
/// Whether the velocity of a joint along a direction is the rate of an angle that poses give up to whole turns.
bool turns(const loops::SubgroupClosure& joint, std::size_t along) {
  return along == 2 && !joint.free[0] && joint.pitch == 0;
}
/// X seen from a body, on whose predecessor, with relative pose D, it is.
BodyTwist carried(const SE3<>& D, const BodyTwist& X) { return twist<BodyFixed>(Ad_inv(D, screw(X))); }
SE3<> about(const Vec3<>& O, const SE3<>& C) { return {C.R, C.r - O}; }

}  // namespace

AbsoluteSystem::AbsoluteSystem(const Model& model, BodyGroup kind)
    : model_(model),
      kind_(kind),
      n_(model.n_bodies()),
      bound_(index(n_ + 1)),
      leader_(index(n_ + 1)),
      joint_of_(index(model.nv())),
      com_(index(n_ + 1)),
      group_tree_(group_of(0, 0, kind)),
      loops_(model),
      reference_q_(neutral(model)),
      placed_(index(n_ + 1)),
      C_(index(n_ + 1)),
      V_(index(n_ + 1)),
      X_(index(n_ + 1)),
      known_(index(n_ + 1)),
      V_s_(index(n_ + 1)),
      dV_s_(index(n_ + 1)),
      on_(index(n_ + 1)),
      through_(index(n_ + 1)),
      x_(index(model.nv())),
      tau_(x_.size()),
      b_(model.loops().rows) {
  for (int i = 1; i <= n_; ++i) {
    const Joint& joint = model.joint(i);
    const std::array<bool, 6> free = free_directions(joint.kind);
    bound_[index(i)] = {{free, joint.pitch}, direction_along(free)};
    if (joint.leader) leader_[index(i)] = joint.leader->joint;
    if (tree().M[i].m > 0) com_[index(i)] = center_of_mass(tree().M[i]);
    if (joint.leader) continue;
    std::size_t along = 0;
    for (int c = joint.iv; c < joint.iv + joint.nv; ++c, ++along) {
      while (!bound_[index(i)].closure.free[along]) ++along;
      joint_of_[index(c)] = i;
      if (tree().armature[index(c)] != 0 || turns(bound_[index(i)].closure, along))
        rotors_.push_back({i, c, along});
    }
  }
  const auto unplaced = std::stable_partition(rotors_.begin(), rotors_.end(), [&](const Rotor& rotor) {
    const Bound& bound = bound_[index(rotor.joint)];
    return bound.along >= 0 || turns(bound.closure, rotor.along);
  });
  n_placed_rotors_ = static_cast<int>(unplaced - rotors_.begin());
  if (n_ > 0) C_[0].r = -(tree().B[1].r + tree().B[1].R * com_[1]);
  group_tree_ = group_of(n_, n_rotors(), kind);
}

/// Bodies as joints of a tree that is never moved: with the subgroups of their motions, all on the ground.
Tree<double> AbsoluteSystem::group_of(int n, int rotors, BodyGroup kind) {
  Connections all{.parent = {0}, .kind = {Subgroup::free}, .leader = {0}, .frame_body = {0}};
  const auto add = [&](Subgroup subgroup) {
    all.frame_body.push_back(static_cast<int>(all.parent.size()));
    all.parent.push_back(0), all.kind.push_back(subgroup), all.leader.push_back(0);
  };
  for (int i = 0; i < n; ++i) {
    if (kind == BodyGroup::SE3) {
      add(Subgroup::free);
    } else {
      add(Subgroup::spherical);
      for (int k = 0; k < 3; ++k) add(Subgroup::prismatic);
    }
  }
  for (int k = 0; k < rotors; ++k) add(Subgroup::prismatic);
  const std::size_t joints = all.parent.size();
  const auto topology = std::make_shared<const Topology>(std::move(all));
  const Vector none(index(topology->nv)), zero(joints), one(joints, 1.0);
  const std::vector<SE3<>> identity(joints);
  return {topology,
          {.pitch = zero,
           .ratio = one,
           .offset = zero,
           .B = identity,
           .M = std::vector<Inertia<>>(joints),
           .armature = none,
           .damping = none,
           .friction = none,
           .frame_offset = identity,
           .g = {}}};
}

// Coordinates of a body, and what they say.

SE3<> AbsoluteSystem::pose(Span q, int i) const {
  const double* const at = &q[index(7 * (i - 1))];
  const SO3<> R = rotation(Quaternion<>{at[0], at[1], at[2], at[3]});
  return {R, Vec3<>{at[4], at[5], at[6]} - R * com_[index(i)]};
}
void AbsoluteSystem::put_pose(const SE3<>& C, int i, Vector& q) const {
  const Quaternion<> turn = quaternion(C.R);
  const Vec3<> r = C.r + C.R * com_[index(i)];
  const std::array<double, 7> all{turn.x, turn.y, turn.z, turn.w, r.x, r.y, r.z};
  std::ranges::copy(all, q.begin() + 7 * (i - 1));
}
/// With the velocity of the centre of mass that is Rᵀ c' = v + ω × c in body axes.
BodyTwist AbsoluteSystem::twist(const SE3<>& C, Span v, int i) const {
  const double* const at = &v[index(6 * (i - 1))];
  const Vec3<> c_dot = kind_ == BodyGroup::SE3 ? linear(at) : transpose(C.R) * linear(at);
  return {angular(at), c_dot - cross(angular(at), com_[index(i)])};
}
void AbsoluteSystem::put_twist(const SE3<>& C, const BodyTwist& V, int i, Vector& v) const {
  const Vec3<> c_dot = V.v + cross(V.w, com_[index(i)]);
  const Six<double> all = six(V.w, kind_ == BodyGroup::SE3 ? c_dot : C.R * c_dot);
  std::ranges::copy(all, v.begin() + 6 * (i - 1));
}
BodyWrench AbsoluteSystem::wrench(const SE3<>& C, Span f, int i) const {
  const double* const at = &f[index(6 * (i - 1))];
  const Vec3<> f_b = kind_ == BodyGroup::SE3 ? linear(at) : transpose(C.R) * linear(at);
  return {angular(at) + cross(com_[index(i)], f_b), f_b};
}
void AbsoluteSystem::add_wrench(const SE3<>& C, const BodyWrench& W, int i, Vector& f) const {
  if (i == 0) return;
  const Six<double> all = six(W.m - cross(com_[index(i)], W.f), kind_ == BodyGroup::SE3 ? W.f : C.R * W.f);
  for (std::size_t k = 0; k < 6; ++k) f[index(6 * (i - 1)) + k] += all[k];
}

void AbsoluteSystem::find_poses(Span q) {
  for (int i = 1; i <= n_; ++i) C_[index(i)] = pose(q, i);
  for (int r = 0; r < n_placed_rotors_; ++r)
    reference_q_[index(tree()->iq[index(rotors_[index(r)].joint)])] = q[index(7 * n_ + r)];
}
void AbsoluteSystem::find_twists(Span v) {
  for (int i = 1; i <= n_; ++i) V_[index(i)] = twist(C_[index(i)], v, i);
}

// Joints, between bodies that are wherever they are.

/// B⁻¹ C_p⁻¹ C_i, the pose of the child's joint frame on the predecessor's.
SE3<> AbsoluteSystem::joint_pose(int i) const {
  return inverse(C_[index(parent(i))] * tree().B[index(i)]) * C_[index(i)];
}
/// V_i - Ad_{C_ip} V_p.
BodyTwist AbsoluteSystem::joint_twist(int i) const {
  const int p = parent(i);
  if (p == 0) return V_[index(i)];
  return V_[index(i)] - carried(inverse(C_[index(p)]) * C_[index(i)], V_[index(p)]);
}
/// The coordinates of a joint that are nearest to others.
void AbsoluteSystem::joint_coordinates(int i, const double* near, double* q_i) const {
  with_subgroup(tree()->kind[index(i)], tree().pitch[index(i)],
                [&](const auto& joint) { joint.coordinates(joint_pose(i), near, q_i); });
}
/// The first coordinate of a joint, coupled or not.
double AbsoluteSystem::angle(int i) const {
  const int l = leader_[index(i)];
  std::array<double, 7> near{}, q_i;
  if (l > 0) {
    near[0] = tree().ratio[index(i)] * angle(l) + tree().offset[index(i)];
  } else {
    std::copy_n(&reference_q_[index(tree()->iq[index(i)])], model_.joint(i).nq, near.begin());
  }
  joint_coordinates(i, near.data(), q_i.data());
  return q_i[0];
}
/// Of the coordinate whose velocity is c.
double AbsoluteSystem::known_angle(int c) const { return angle(joint_of_[index(c)]); }

template <class Motion> void AbsoluteSystem::bind(const Motion& X, Vector& rows) const {
  for (int i = 1; i <= n_; ++i) {
    const auto& [closure, along] = bound_[index(i)];
    Six<double> x = six(X[index(i)].w, X[index(i)].v);
    const double own = along < 0 ? 0 : x[index(along)];
    x[5] -= closure.pitch * x[2];
    for (std::size_t k = 0; k < 6; ++k) rows[index(6 * (i - 1)) + k] = closure.free[k] ? 0 : x[k];
    if (const int l = leader_[index(i)]; l > 0)
      rows[index(6 * (i - 1) + along)] = own - tree().ratio[index(i)] * rate(l, X[index(l)]);
  }
  for (int r = 0; r < n_rotors(); ++r) {
    const Rotor& rotor = rotors_[index(r)];
    rows[index(6 * n_ + r)] = rate(rotor, X[index(rotor.joint)]);
  }
}

/// The wrench on a body that a drive of its joint, with one velocity, exerts.
BodyWrench AbsoluteSystem::co_screw(int i, double tau) const {
  return co_screw(index(bound_[index(i)].along), tau);
}
BodyWrench AbsoluteSystem::co_screw(std::size_t along, double tau) {
  Six<double> all{};
  all[along] = tau;
  return {angular(all.data()), linear(all.data())};
}
BodyWrench AbsoluteSystem::joint_force(int i, Span tau) const {
  const double* const at = &tau[index(tree()->iv[index(i)])];
  if (bound_[index(i)].along >= 0) return co_screw(i, *at);
  Six<double> all{};
  int c = 0;
  for (std::size_t k = 0; k < 6; ++k)
    if (bound_[index(i)].closure.free[k]) all[k] = at[c++];
  return {angular(all.data()), linear(all.data())};
}
/// W on body i at its joint, and the reaction on the predecessor.
void AbsoluteSystem::add_joint_wrench(int i, const BodyWrench& W, Vector& f) const {
  add_wrench(C_[index(i)], W, i, f);
  const int p = parent(i);
  if (p == 0) return;
  const Wrench<Spatial> back = coAd(inverse(C_[index(p)]) * C_[index(i)], W);
  add_wrench(C_[index(p)], {-back.m, -back.f}, p, f);
}

/// The point about which a loop joint is seen: the origin of one of its bodies.
const Vec3<>& AbsoluteSystem::loop_origin(const LoopPath& path) const {
  return C_[index(std::max(path.ends[0].body, path.ends[1].body))].r;
}
loops::LoopFrames<double> AbsoluteSystem::loop_frames(const LoopPath& path) const {
  const auto& [a, b] = path.ends;
  const Vec3<>& O = loop_origin(path);
  return {about(O, C_[index(a.body)] * a.F), about(O, C_[index(b.body)] * b.F)};
}

/// The rows of a loop joint times the velocities of its bodies.
template <class Joint>
Six<double> AbsoluteSystem::loop_rates(const LoopPath& path, const Joint& joint) const {
  const auto& [a, b] = path.ends;
  const Vec3<>& O = loop_origin(path);
  const Twist<Spatial> X =
      Ad(about(O, C_[index(b.body)]), V_[index(b.body)]) - Ad(about(O, C_[index(a.body)]), V_[index(a.body)]);
  loops::LoopWrenches<double> W;
  joint.wrenches(loop_frames(path), W.data());
  Six<double> slip{};
  for (std::size_t k = 0; k < index(path.rows.count); ++k) slip[k] = W[k] | X;
  return slip;
}

void AbsoluteSystem::from_joint_state(Span q_joints, Span v_joints, Vector& q, Vector& v) {
  set_reference_angles(q_joints);
  q.resize(index(nq())), v.resize(index(nv()));
  std::vector<SE3<>> D(index(n_ + 1));
  std::vector<BodyTwist> Sv(index(n_ + 1));
  joint_poses(tree(), q_joints.data(), D.data());
  joint_screws(tree(), v_joints.data(), Sv.data());
  for (int i = 1; i <= n_; ++i) {
    const int p = parent(i);
    const SE3<> C = C_[index(i)] = C_[index(p)] * D[index(i)];
    V_[index(i)] = carried(D[index(i)], V_[index(p)]) + Sv[index(i)];
    put_pose(C, i, q), put_twist(C, V_[index(i)], i, v);
  }
  for (int r = 0; r < n_rotors(); ++r) {
    const Rotor& rotor = rotors_[index(r)];
    q[index(7 * n_ + r)] = r < n_placed_rotors_ ? q_joints[index(tree()->iq[index(rotor.joint)])] : 0;
    v[index(6 * n_ + r)] = v_joints[index(rotor.velocity)];
  }
}

void AbsoluteSystem::to_joint_state(Span q, Span v, Vector& q_joints, Vector& v_joints) {
  find_poses(q), find_twists(v);
  q_joints.resize(reference_q_.size()), v_joints.resize(x_.size());
  for (int i = 1; i <= n_; ++i) {
    if (leader_[index(i)] > 0) continue;
    const BodyTwist X = joint_twist(i);
    const std::size_t from = index(tree()->iq[index(i)]);
    joint_coordinates(i, &reference_q_[from], &q_joints[from]);
    const Six<double> x = six(X.w, X.v);
    double* v_i = &v_joints[index(tree()->iv[index(i)])];
    for (std::size_t k = 0; k < 6; ++k)
      if (bound_[index(i)].closure.free[k]) *v_i++ = x[k];
  }
}

void AbsoluteSystem::set_poses_and_twists(std::span<const SE3<>> C, std::span<const Twist<BodyFixed>> V,
                                          Vector& q, Vector& v) {
  q.resize(index(nq())), v.resize(index(nv()));
  for (int i = 1; i <= n_; ++i) {
    const SE3<>& offset = tree().frame_offset[index(i)];  // of the user's frame
    C_[index(i)] = about(-C_[0].r, C[index(i)]) * inverse(offset);
    const Screw<> X = Ad(offset, screw(V[index(i)]));
    V_[index(i)] = {X.w, X.v};
    put_pose(C_[index(i)], i, q), put_twist(C_[index(i)], V_[index(i)], i, v);
  }
  for (int r = 0; r < n_rotors(); ++r) {
    const Rotor& rotor = rotors_[index(r)];
    q[index(7 * n_ + r)] = r < n_placed_rotors_ ? angle(rotor.joint) : 0;
    v[index(6 * n_ + r)] = rate(rotor, joint_twist(rotor.joint));
  }
}

void AbsoluteSystem::position_residual(Span q, Vector& out, ConstraintLevel level) {
  find_poses(q);
  out.assign(index(rows(level)), 0.0);
  for (int i = 1; i <= n_; ++i) {
    const auto& [closure, along] = bound_[index(i)];
    const SE3<> E = closure.strip(joint_pose(i));
    const Six<double> open = six(log_SO3(E.R), E.r);
    for (std::size_t k = 0; k < 6; ++k) out[index(6 * (i - 1)) + k] = closure.free[k] ? 0 : open[k];
    if (const int l = leader_[index(i)]; l > 0)
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
}

void AbsoluteSystem::velocity_residual(Span q, Span v, Vector& out) {
  find_poses(q), find_twists(v);
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
}
/// Σ factor q' of a coupling for relative motions of all joints.
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
  find_poses(q), find_twists(v);
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
    if (const int l = leader_[index(i)]; l > 0)
      add_joint_wrench(l, co_screw(l, -tree().ratio[index(i)] * at[bound_[index(i)].along]), f);
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

void AbsoluteSystem::momentum(Span v, Vector& p) const {
  p.resize(index(nv()));
  for (int i = 1; i <= n_; ++i) {
    const double* const at = &v[index(6 * (i - 1))];
    const Inertia<>& M = tree().M[index(i)];
    const Six<double> all = six((M.m > 0 ? inertia_about_com(M) : M.Theta) * angular(at), M.m * linear(at));
    std::ranges::copy(all, p.begin() + 6 * (i - 1));
  }
  for (int r = 0; r < n_rotors(); ++r)
    p[index(6 * n_ + r)] = tree().armature[index(rotors_[index(r)].velocity)] * v[index(6 * n_ + r)];
}

double AbsoluteSystem::energy(Span q, Span v) {
  find_poses(q);
  momentum(v, p_);
  double sum = 0;
  for (std::size_t c = 0; c < p_.size(); ++c) sum += p_[c] * v[c] / 2;
  for (int i = 1; i <= n_; ++i) {
    const Inertia<>& M = tree().M[index(i)];
    sum -= dot(tree().g, M.m * (C_[index(i)].r - C_[0].r) + C_[index(i)].R * M.h);
  }
  return sum;
}

void AbsoluteSystem::forces(Span q, Span v, Span tau, const Loads<double>& loads, Vector& f) {
  find_poses(q), find_twists(v);
  f.assign(index(nv()), 0.0);
  std::vector<BodyWrench> applied(index(n_ + 1));
  if (!loads.wrenches.empty()) {
    std::vector<SE3<>> C(C_);
    for (SE3<>& C_i : C) C_i.r -= C_[0].r;
    sum_applied(tree(), loads.wrenches, C.data(), applied.data());
  }
  for (int i = 1; i <= n_; ++i) {
    const Inertia<>& M = tree().M[index(i)];
    const Vec3<> g = transpose(C_[index(i)].R) * tree().g;
    add_wrench(C_[index(i)], BodyWrench{cross(M.h, g), M.m * g} + applied[index(i)], i, f);
  }
  std::copy(tau.begin(), tau.end(), tau_.begin());
  if (loads.joint_losses)
    for (int i = 1; i <= n_; ++i) {
      if (leader_[index(i)] > 0) continue;
      const BodyTwist X = joint_twist(i);
      const Six<double> x = six(X.w, X.v);
      int c = tree()->iv[index(i)];
      for (std::size_t k = 0; k < 6; ++k)
        if (bound_[index(i)].closure.free[k]) tau_[index(c)] -= joint_loss(tree(), c, x[k]), ++c;
    }
  for (int i = 1; i <= n_; ++i)
    if (leader_[index(i)] == 0) add_joint_wrench(i, joint_force(i, tau_), f);
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
  placed_ = C_, factorized_level_ = level;
  loops_.update_kinematics(placed_.data(), -C_[0].r);
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
  x.resize(index(nv())), lambda.resize(loop_rows + index(m));

  // What joints bind is known: K_i along the path, so that Z_i = X_i - K_i moves as the joints allow.
  on_[0] = {};
  for (int i = 1; i <= n_; ++i) {
    const double* const at = &rhs[index(6 * (i - 1))];
    BodyTwist k{angular(at), linear(at)};
    k.v.z += bound_[index(i)].closure.pitch * k.w.z;
    known_[index(i)] = known_[index(parent(i))];
    known_[index(i)] += Ad(loops_.link(i).C, k);
    on_[index(i)] = coAd(loops_.link(i).C, wrench(placed_[index(i)], r, i));
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
  const auto eliminate = [&] {
    bodies.W[0] = {};
    for (int i = 1; i <= n_; ++i) bodies.W[i] = inertial(i, known_[index(i)]) - on_[index(i)];
    for (int t = 0; t < tree()->ties.begin[index(n_ + 1)]; ++t) bodies.u_tie[t] = 0;
    for (int i = n_; i > 0; --i) bodies.backward_step(tree(), i, tau_.data());
    bodies.backward_step_at_ground(tree(), tau_.data());
    bodies.forward_sweep(tree(), x_.data());
    V_s_[0] = {};
    for (int i = 1; i <= n_; ++i) V_s_[index(i)] = bodies.X[i] + known_[index(i)];
  };
  eliminate();
  double* const loop_lambda = lambda.data() + loop_rows;
  if (m > 0) {
    loops_.rates(V_s_.data(), x_.data(), b_.data());
    for (int k = 0; k < m; ++k) b_[k] -= rhs[loop_rows + index(k)];
    loops_.solve_rows(b_.data(), loop_lambda, rank_);
    loops_.add_wrenches(loop_lambda, on_.data(), tau_.data());
    eliminate();
  }

  std::ranges::fill(through_, Wrench<Spatial>{});
  for (int i = n_; i > 0; --i) {
    const SE3<>& C = loops_.link(i).C;
    put_twist(placed_[index(i)], Ad_inv(C, V_s_[index(i)]), i, x);
    through_[index(i)] += inertial(i, V_s_[index(i)]) - on_[index(i)];
    const BodyWrench W = coAd_inv(C, through_[index(i)]);
    const auto& [closure, along] = bound_[index(i)];
    const Six<double> all = six(W.m, W.f);
    double* const at = &lambda[index(6 * (i - 1))];
    for (std::size_t k = 0; k < 6; ++k) at[k] = closure.free[k] ? 0 : all[k];
    if (leader_[index(i)] > 0) at[along] = all[index(along)] + closure.pitch * W.f.z;
    through_[index(parent(i))] += through_[index(i)];
  }
  for (int k = bound_rotors; k < n_rotors(); ++k)  // which turn along
    x[index(6 * n_ + k)] = x_[index(rotors_[index(k)].velocity)];
  for (int k = 0; k < bound_rotors; ++k) {
    const int c = rotors_[index(k)].velocity;
    const double moved = x_[index(c)] - rhs[index(6 * n_ + k)];
    x[index(6 * n_ + k)] = moved;
    lambda[index(6 * n_ + k)] = r[index(6 * n_ + k)] - tree().armature[index(c)] * moved;
  }
}

void AbsoluteSystem::bias(Span v, Vector& rhs) {
  C_ = placed_;
  find_twists(v);
  rhs.resize(index(rows(ConstraintLevel::velocity)));
  // Twists of bodies that do not accelerate in their coordinates change all the same, where these are in inertial axes.
  std::vector<BodyTwist> rest(index(n_ + 1));
  for (int i = 1; i <= n_; ++i) {
    const BodyTwist& V = V_[index(i)];
    if (kind_ == BodyGroup::SO3xR3) rest[index(i)].v = -cross(V.w, V.v + cross(V.w, com_[index(i)]));
    const SE3<>& C = loops_.link(i).C;
    V_s_[index(i)] = Ad(C, V);
    const Twist<Spatial> rate = Ad(C, rest[index(i)]);
    dV_s_[index(i)] = {rate.w, rate.v};
    const SE3<> D = inverse(placed_[index(parent(i))]) * placed_[index(i)];
    const BodyTwist V_p = carried(D, V_[index(parent(i))]);
    X_[index(i)] = ad(V_p, V) - rest[index(i)] + carried(D, rest[index(parent(i))]);
  }
  bind(X_, rhs);
  if (model_.loops().empty()) return;
  V_s_[0] = {}, dV_s_[0] = {};
  loops_.bias(V_s_.data(), dV_s_.data(), b_.data());
  double* const at = rhs.data() + first_loop(ConstraintLevel::velocity);
  for (int k = 0; k < model_.loops().rows; ++k) at[k] = -b_[k];
  for (const LoopCoupling& coupling : model_.loops().couplings)
    at[coupling.first_row] = coupled_rate(coupling, X_);
}

}  // namespace axode
