#include "tests/paper/motion.hpp"

#include "tests/support/any_scalar.hpp"
#include "tests/support/random_tree.hpp"

namespace axode::test::paper {

template <class Rep> const Motion::Answer<Rep>& Motion::answer(Asked asked) const {
  Answer<Rep>& known = std::get<Answer<Rep>>(answers_);
  Workspace<double> workspace(model());
  const Loads<> loads{.wrenches = system_.loads};
  const auto unknown = [](auto& x, std::size_t size) { return x.empty() && (x.resize(size), true); };
  const auto n_frames = static_cast<std::size_t>(model().n_frames());
  if (asked == Asked::twists && unknown(known.V, n_frames))
    axode::twists<Rep>(model(), workspace, q_, v_, known.V);
  if (asked == Asked::accelerations && unknown(known.dV, n_frames))
    axode::accelerations<Rep>(model(), workspace, q_, v_, a_, known.dV);
  if (asked == Asked::joint_wrenches && unknown(known.W, static_cast<std::size_t>(n())))
    axode::joint_wrenches<Rep>(model(), workspace, q_, v_, a_, known.W, loads);
  if (asked == Asked::joint_forces && unknown(known.tau, v_.size()))
    axode::inverse_dynamics<Rep>(model(), workspace, q_, v_, a_, known.tau, loads);
  return known;
}
template const Motion::Answer<BodyFixed>& Motion::answer(Asked) const;
template const Motion::Answer<Spatial>& Motion::answer(Asked) const;
template const Motion::Answer<Hybrid>& Motion::answer(Asked) const;
template const Motion::Answer<Mixed>& Motion::answer(Asked) const;

namespace {

/// Random numbers that are neither small nor large, so that no term of an equation vanishes beside another
/// one.
std::vector<double> generic_numbers(Random<double>& random, int size) {
  std::vector<double> numbers = random_numbers(random, size);
  for (double& x : numbers) x = x < 0 ? x - 0.5 : x + 0.5;
  return numbers;
}

}  // namespace

Motion::Motion(System system, std::uint64_t seed) : system_(std::move(system)) {
  Random<double> random(100 + seed);
  q_ = random_configuration(model(), 100 + seed);
  v_ = generic_numbers(random, model().nv());
  a_ = generic_numbers(random, model().nv());
  C_ = poses_of_t(v_, a_);
  pose_ = poses_at(q_), pose_at_zero_ = poses_at(neutral(model()));
}

std::vector<SE3<>> Motion::poses_at(const std::vector<double>& q) const {
  std::vector<SE3<>> C(static_cast<std::size_t>(model().n_frames()));
  Workspace<double> workspace(model());
  axode::poses(model(), workspace, q, C);
  return C;
}

std::vector<PoseOfT> Motion::poses_of_t(const std::vector<double>& v, const std::vector<double>& a) const {
  const Tree<Series> tree = axode::cast<Series>(model().tree<double>());
  return frame_poses(tree, moving<3>(tree, q_, v, a));
}

std::vector<int> Motion::children(int i) const {
  std::vector<int> children;
  for (int k = i + 1; k <= n(); ++k)
    if (predecessor(k) == i) children.push_back(k);
  return children;
}

std::vector<int> Motion::path(int i) const {
  std::vector<int> path;
  for (; i > 0; i = predecessor(i)) path.insert(path.begin(), i);
  return path;
}

Matrix Motion::X(int i) const {
  Matrix columns(6, model().joint(i).nv);
  for (int k = 0; k < columns.cols(); ++k) columns.set_block(0, k, body(i).X[k]);
  return columns;
}

JointFrames Motion::joint_frames(int i) const {
  if (drawn(i).joint_frames) return *drawn(i).joint_frames;
  const Joint& joint = model().joint(i);
  const auto Z = [](const auto& subgroup) { return subgroup.column(0); };
  return {body(i).S_prev, body(i).S_self, with_subgroup(joint.kind, joint.pitch, Z)};
}

SE3<> Motion::product_of_Y(int i) const {
  SE3<> product;
  for (const int j : path(i)) product = product * exp(q(j) * drawn(j).Y);
  return product;
}

Matrix Motion::of_joint(int i, const std::vector<double>& x) const {
  const Joint& joint = model().joint(i);
  return Matrix(std::vector<double>(&x[joint.iv], &x[joint.iv] + joint.nv));
}

Vec6OfT Motion::V_of_t(int i, const PoseOfT& F) const {
  const Vec6OfT V = V_of_t<Hybrid>(i);
  const Vec3<Series> w{V[0], V[1], V[2]}, dr{V[3], V[4], V[5]};
  const SO3<Series> Rt = transpose(F.R);
  return Screw<Series>{Rt * w, Rt * (dr + cross(w, F.r - C_[i].r))};
}

Vec6OfT Motion::Pi_of_t(int i, const PoseOfT& F) const {
  const int b = body_of(i);
  const SO3<Series> Rt = transpose(F.R);
  Screw<Series> Pi;
  for (const PointMass& point : drawn(b).points) {
    const Vec3<Series> p = position(b, point), momentum = Series(point.m) * derivative(p);
    Pi = Pi + Screw<Series>{Rt * cross(p - F.r, momentum), Rt * momentum};
  }
  return Pi;
}

Mat6 Motion::M(int i, const PoseOfT& F) const {
  const int b = body_of(i);
  Mat6 M;
  for (const PointMass& point : drawn(b).points) {
    const Mat3 p = tilde(inverse(now(F)) * now(position(b, point)));
    M += point.m * blocks(-p * p, p, -p, identity(3));
  }
  return M;
}

Vec6 Motion::W(int i, const PoseOfT& F) const {
  const int b = body_of(i);
  const SE3<> F_now = now(F);
  const SO3<> Rt = transpose(F_now.R);
  Screw<> W;
  for (const PointMass& point : drawn(b).points) {
    const Vec3<Series> p = position(b, point);
    const Vec3<> force = point.m * second_rate(p);
    W = W + Screw<>{Rt * cross(now(p) - F_now.r, force), Rt * force};
  }
  return W;
}

double Motion::kinetic_energy(int i) const {
  double energy = 0;
  for (const PointMass& point : drawn(i).points) {
    const Vec3<> dp = rate(position(i, point));
    energy += 0.5 * point.m * dot(dp, dp);
  }
  return energy;
}

Vec6 Motion::W_app(int i, const PoseOfT& F) const {
  const SE3<> F_now = now(F);
  const SO3<> Rt = transpose(F_now.R);
  Screw<> W;
  const auto add = [&](const Vec3<>& moment, const Vec3<>& force, const Vec3<>& at) {  // in inertial axes
    W = W + Screw<>{Rt * (moment + cross(at - F_now.r, force)), Rt * force};
  };
  for (const PointMass& point : drawn(i).points)
    add(Vec3<>{}, point.m * model().gravity(), now(position(i, point)));
  for (const AppliedWrench<>& load : system_.loads) {
    if (body_of(load.frame) != i) continue;
    const SE3<> C = now(C_[load.frame]);
    switch (load.representation) {
      case Representation::body: add(C.R * load.m, C.R * load.f, C.r); break;
      case Representation::spatial: add(load.m, load.f, Vec3<>{}); break;
      case Representation::hybrid: add(load.m, load.f, C.r); break;
      case Representation::mixed: add(C.R * load.m, load.f, C.r); break;
    }
  }
  return W;
}

Vec6 Motion::transmitted(int i, const PoseOfT& F) const {
  Vec6 sum = W(i, F) - W_app(i, F);
  for (const int k : children(i)) sum += transmitted(k, F);
  return sum;
}

Twist<Spatial> Motion::joint_screw(int i) const {
  std::vector<Twist<Spatial>> J(static_cast<std::size_t>(model().n_screws()));
  Workspace<double> workspace(model());
  joint_screws(model(), workspace, q_, J);
  return J[static_cast<std::size_t>(model().first_screw(i))];
}

FramePair<> Motion::frame_pair(int j, int k) const {
  return {pose(j).r, twist<Hybrid>(j).v, pose(k).R, twist<Hybrid>(k).w};
}

template <class Rep> Link<Rep, double> Motion::link(int i) const {
  if (i == 0) return Link<Rep, double>::root();
  return link<Rep>(predecessor(i)).child(C(predecessor(i), i));
}
template <class Rep> Twist<Rep> Motion::push_Xqd(int i) const {
  return push(link<Rep>(i), from_six<Twist<BodyFixed>>(Xqd(i)));
}
template <class Rep> Vec6 Motion::bias(int i) const {
  return link<Rep>(i).bias(twist<Rep>(predecessor(i)), twist<Rep>(i), push_Xqd<Rep>(i));
}
template Link<Spatial, double> Motion::link(int i) const;
template Link<Hybrid, double> Motion::link(int i) const;
template Twist<BodyFixed> Motion::push_Xqd(int i) const;
template Twist<Spatial> Motion::push_Xqd(int i) const;
template Twist<Hybrid> Motion::push_Xqd(int i) const;
template Vec6 Motion::bias<BodyFixed>(int i) const;
template Vec6 Motion::bias<Spatial>(int i) const;
template Vec6 Motion::bias<Hybrid>(int i) const;

Matrix Motion::J(int i, int j, Representation representation) const {
  const Joint& joint = model().joint(j);
  Matrix columns(6, joint.nv);
  for (int k = 0; k < joint.nv; ++k) {
    std::vector<double> unit(v_.size());
    unit[joint.iv + k] = 1;
    const std::vector<PoseOfT> C = poses_of_t(unit, std::vector<double>(v_.size()));
    columns.set_block(0, k, now(twist_of(C[i], representation)));
  }
  return columns;
}

PoseOfT Motion::frame(int f, Representation representation) const {
  switch (representation) {
    case Representation::body: return C_[f];
    case Representation::spatial: return {};
    case Representation::hybrid: break;
    case Representation::mixed: break;
  }
  return {{}, C_[f].r};
}

Vec6 Motion::W(int f, Representation representation) const {
  if (representation != Representation::mixed) return W(f, frame(f, representation));
  return stack(angular(W<BodyFixed>(f)), linear(W<Hybrid>(f)));
}

}  // namespace axode::test::paper
