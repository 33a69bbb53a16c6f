#include "axode/constraints/absolute/absolute_system.hpp"

#include <algorithm>

#include "axode/lie/quaternion.hpp"
#include "axode/model/configuration.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode {
namespace {

using BodyTwist = Twist<BodyFixed, double>;
using BodyWrench = Wrench<BodyFixed, double>;

/// The index (0 to 5 for ω_x to v_z) of the free direction of a joint with one velocity, otherwise -1.
int direction_along(const std::array<bool, 6>& free) {
  return std::ranges::count(free, true) == 1 ? static_cast<int>(std::ranges::find(free, true) - free.begin())
                                             : -1;
}

/// Whether the velocity of a joint along a direction (0 to 5 for ω_x to v_z) is the rate of an angle.
bool turns(const loops::SubgroupClosure& joint, std::size_t along) {
  return along == 2 && !joint.free[0] && joint.pitch == 0;
}
}  // namespace

AbsoluteSystem::AbsoluteSystem(const Model& model, BodyGroup kind)
    : model_(model),
      n_(model.n_bodies()),
      on_SE3_(index(n_ + 1), kind == BodyGroup::SE3),
      joint_of_(index(model.nv())),
      group_tree_(make_group()),
      loops_(model),
      reference_q_(neutral(model)),
      x_(index(model.nv())),
      tau_(x_.size()),
      b_(model.loops().rows) {
  const auto resize = [&](auto&... by_body) { (by_body.resize(index(n_ + 1)), ...); };
  resize(bound_, leader_, com_, factorized_C_, C_, V_, X_, known_, V_s_, dV_s_, on_, through_);
  for (int i = 1; i <= n_; ++i) {
    const Joint& joint = model.joint(i);
    const std::array<bool, 6> free = free_directions(joint.kind);
    bound_[index(i)] = {{free, joint.pitch}, direction_along(free)};
    if (kind == BodyGroup::by_joint) on_SE3_[index(i)] = parent(i) == 0 && joint.kind != Subgroup::free;
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
  group_tree_ = make_group();
}

/// Makes the configuration group of the absolute coordinates, as a tree in which all bodies are on the
/// ground. A body on SE(3) has a free joint, and a body on SO(3) × R³ has a spherical and three prismatic
/// joints. A rotor, an additional body whose velocity is constrained to equal one joint velocity, has a
/// prismatic joint, because its coordinate is a real number that counts whole turns.
Tree<double> AbsoluteSystem::make_group() const {
  Connections all{.parent = {0}, .kind = {Subgroup::free}, .leader = {0}, .frame_body = {0}};
  const auto add = [&](Subgroup subgroup) {
    all.frame_body.push_back(static_cast<int>(all.parent.size()));
    all.parent.push_back(0);
    all.kind.push_back(subgroup);
    all.leader.push_back(0);
  };
  for (int i = 1; i <= n_; ++i) {
    if (is_on_SE3(i)) {
      add(Subgroup::free);
    } else {
      add(Subgroup::spherical);
      for (int k = 0; k < 3; ++k) add(Subgroup::prismatic);
    }
  }
  for (int k = 0; k < n_rotors(); ++k) add(Subgroup::prismatic);
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

// Coordinates, velocities and forces of a body.

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
/// Computes the body-fixed twist of body i, about the origin of its frame, from the entries of v for this
/// body: its angular velocity and the velocity of its centre of mass.
BodyTwist AbsoluteSystem::twist(const SE3<>& C, Span v, int i) const {
  const double* const at = &v[index(6 * (i - 1))];
  const Vec3<> c_dot = is_on_SE3(i) ? linear(at) : transpose(C.R) * linear(at);
  return {angular(at), c_dot - cross(angular(at), com_[index(i)])};
}
void AbsoluteSystem::put_twist(const SE3<>& C, const BodyTwist& V, int i, Vector& v) const {
  const Vec3<> c_dot = V.v + cross(V.w, com_[index(i)]);
  const Six<double> all = six(V.w, is_on_SE3(i) ? c_dot : C.R * c_dot);
  std::ranges::copy(all, v.begin() + 6 * (i - 1));
}
BodyWrench AbsoluteSystem::wrench(const SE3<>& C, Span f, int i) const {
  const double* const at = &f[index(6 * (i - 1))];
  const Vec3<> f_b = is_on_SE3(i) ? linear(at) : transpose(C.R) * linear(at);
  return {angular(at) + cross(com_[index(i)], f_b), f_b};
}
void AbsoluteSystem::add_wrench(const SE3<>& C, const BodyWrench& W, int i, Vector& f) const {
  if (i == 0) return;
  const Six<double> all = six(W.m - cross(com_[index(i)], W.f), is_on_SE3(i) ? W.f : C.R * W.f);
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

// Functions of the joints. The poses of the bodies need not be allowed by the joints.

/// The pose B⁻¹ C_p⁻¹ C_i of the joint frame on the body relative to the joint frame on the predecessor.
SE3<> AbsoluteSystem::joint_pose(int i) const {
  return inverse(C_[index(parent(i))] * tree().B[index(i)]) * C_[index(i)];
}
/// The twist V_i - Ad_{C_ip} V_p of a body relative to its predecessor, in the frame of the body.
BodyTwist AbsoluteSystem::joint_twist(int i) const {
  const int p = parent(i);
  if (p == 0) return V_[index(i)];
  return V_[index(i)] - carried(inverse(C_[index(p)]) * C_[index(i)], V_[index(p)]);
}
/// Computes the coordinates q_i of joint i from the present poses of its bodies. Of equivalent angles (by
/// whole turns) and quaternions (by sign), those nearest to the coordinates `near` are taken.
void AbsoluteSystem::joint_coordinates(int i, const double* near, double* q_i) const {
  with_subgroup(tree()->kind[index(i)], tree().pitch[index(i)],
                [&](const auto& joint) { joint.coordinates(joint_pose(i), near, q_i); });
}
/// The first coordinate of joint i at the present poses of its bodies. Of angles that differ by whole turns,
/// it is the one nearest to the reference angle of the joint or, for a coupled joint, to the angle that its
/// leader determines.
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
/// The coordinate whose rate is velocity c of the model, at the present poses.
double AbsoluteSystem::known_angle(int c) const { return angle(joint_of_[index(c)]); }

/// The wrench of the drive force tau of joint i, which has one velocity, on body i, in the body's frame.
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
/// Adds the wrench W that joint i exerts on body i, and its reaction on the predecessor, to the forces f.
void AbsoluteSystem::add_joint_wrench(int i, const BodyWrench& W, Vector& f) const {
  add_wrench(C_[index(i)], W, i, f);
  const int p = parent(i);
  if (p == 0) return;
  const Wrench<Spatial> back = coAd(inverse(C_[index(p)]) * C_[index(i)], W);
  add_wrench(C_[index(p)], {-back.m, -back.f}, p, f);
}

void AbsoluteSystem::from_joint_state(Span q_joints, Span v_joints, Vector& q, Vector& v) {
  set_reference_angles(q_joints);
  q.resize(index(nq()));
  v.resize(index(nv()));
  std::vector<SE3<>> D(index(n_ + 1));
  std::vector<BodyTwist> Sv(index(n_ + 1));
  joint_poses(tree(), q_joints.data(), D.data());
  joint_screws(tree(), v_joints.data(), Sv.data());
  for (int i = 1; i <= n_; ++i) {
    const int p = parent(i);
    const SE3<> C = C_[index(i)] = C_[index(p)] * D[index(i)];
    V_[index(i)] = carried(D[index(i)], V_[index(p)]) + Sv[index(i)];
    put_pose(C, i, q);
    put_twist(C, V_[index(i)], i, v);
  }
  for (int r = 0; r < n_rotors(); ++r) {
    const Rotor& rotor = rotors_[index(r)];
    q[index(7 * n_ + r)] = r < n_placed_rotors_ ? q_joints[index(tree()->iq[index(rotor.joint)])] : 0;
    v[index(6 * n_ + r)] = v_joints[index(rotor.velocity)];
  }
}

void AbsoluteSystem::to_joint_state(Span q, Span v, Vector& q_joints, Vector& v_joints) {
  find_poses(q);
  find_twists(v);
  q_joints.resize(reference_q_.size());
  v_joints.resize(x_.size());
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
  q.resize(index(nq()));
  v.resize(index(nv()));
  for (int i = 1; i <= n_; ++i) {
    const SE3<>& offset = tree().frame_offset[index(i)];  // pose of the user's frame in the internal frame
    C_[index(i)] = about(-C_[0].r, C[index(i)]) * inverse(offset);
    const Screw<> X = Ad(offset, screw(V[index(i)]));
    V_[index(i)] = {X.w, X.v};
    put_pose(C_[index(i)], i, q);
    put_twist(C_[index(i)], V_[index(i)], i, v);
  }
  for (int r = 0; r < n_rotors(); ++r) {
    const Rotor& rotor = rotors_[index(r)];
    q[index(7 * n_ + r)] = r < n_placed_rotors_ ? angle(rotor.joint) : 0;
    v[index(6 * n_ + r)] = rate(rotor, joint_twist(rotor.joint));
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
  find_poses(q);
  find_twists(v);
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
        if (bound_[index(i)].closure.free[k]) {
          tau_[index(c)] -= joint_loss(tree(), c, x[k]);
          ++c;
        }
    }
  for (int i = 1; i <= n_; ++i)
    if (leader_[index(i)] == 0) add_joint_wrench(i, joint_force(i, tau_), f);
}

}  // namespace axode
