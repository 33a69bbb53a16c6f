#include "axode/contact/derivatives/displaced_motion.hpp"

namespace axode {
namespace {

using Changes = DisplacedMotion::Changes;
using Across = Eigen::Matrix<double, 3, 6>;

/// The normal n and the tangents t1, t2 of a contact, with their derivatives by six variables. Variables 3
/// to 5 are the components of n. If the tangents were chosen for an older normal, and then turned to be
/// perpendicular to n, variables 0 to 2 are the components of the older normal; otherwise the axes do not
/// depend on them.
struct DisplacedFrame {
  Vec3<Displaced> n, t1, t2;
};

DisplacedFrame frame_of(const Vec3<Displaced>& n) {
  using T = Displaced;
  const T s = n.z < T(0) ? T(-1) : T(1), c = T(-1) / (s + n.z), b = n.x * n.y * c;
  return {n, {T(1) + s * n.x * n.x * c, s * b, -(s * n.x)}, {b, s + n.y * n.y * c, -n.y}};
}

DisplacedFrame turned_frame(const DisplacedFrame& axes, const Vec3<Displaced>& n) {
  const Vec3<Displaced> across = axes.t1 - dot(n, axes.t1) * n;
  const Displaced length = norm(across);
  constexpr double parallel = 0.1;  // as in turned()
  if (!(length > Displaced(parallel))) return frame_of(n);
  const Vec3<Displaced> t1 = (Displaced(1) / length) * across;
  return {n, t1, cross(n, t1)};
}

/// The vector a, whose components are the variables `first` to `first` + 2 of six for differentiation.
Vec3<Displaced> along(const Vec3<>& a, std::size_t first) {
  Vec3<Displaced> out = cast<Displaced>(a);
  out.x.dx[first] = out.y.dx[first + 1] = out.z.dx[first + 2] = 1;
  return out;
}

FrameChanges changes(const DisplacedFrame& axes, const VectorChanges& dfrom, const VectorChanges& dto) {
  const auto apply = [&](const Vec3<Displaced>& a) -> VectorChanges {
    const Across by = derivatives(a);
    return by.leftCols<3>() * dfrom + by.rightCols<3>() * dto;
  };
  return {dto, apply(axes.t1), apply(axes.t2)};
}

}  // namespace

FrameChanges frame_changes(const Vec3<>& normal, const VectorChanges& dnormal) {
  const VectorChanges none = VectorChanges::Zero(3, dnormal.cols());
  return changes(frame_of(along(normal, 3)), none, dnormal);
}

FrameChanges turned_changes(const Vec3<>& from, const VectorChanges& dfrom, const Vec3<>& to,
                            const VectorChanges& dto) {
  return changes(turned_frame(frame_of(along(from, 0)), along(to, 3)), dfrom, dto);
}

ContactChanges contact_changes(const ContactJet& jet, const Displacements& a, const Displacements& b) {
  Changes relative(6, a.xi.cols());
  relative.topRows<3>() = b.xi.topRows<3>() - a.xi.topRows<3>();
  relative.bottomRows<3>() = b.of(jet.about) - a.of(jet.about);
  return {a.of(jet.point) + jet.point_by * relative,
          -skew(jet.normal) * a.xi.topRows<3>() + jet.normal_by * relative, jet.gap_by * relative};
}

DisplacedMotion::DisplacedMotion(const Model& model)
    : tree_(&model.tree<double>()),
      spatial_(model.topology()),
      poses_(static_cast<std::size_t>(model.n_bodies()) + 1),
      V_(poses_.size()) {}

void DisplacedMotion::run(const double* q, const double* v, const Changes& dq, const Changes& dv,
                          Eigen::Index first) {
  spatial_->run(*tree_, q);
  const Topology& topology = *tree_->operator->();
  xi_.setZero(6 * (topology.n + 1), dq.cols());
  dV_.setZero(6 * (topology.n + 1), dq.cols());
  if (geometry_.size() > 0 && dq.cols() > 0)
    xi_.middleCols(first, geometry_.cols()) = geometric_displacements(*tree_, *spatial_, q, geometry_);
  for (int i = 1; i <= topology.n; ++i) {
    const std::size_t k = static_cast<std::size_t>(i);
    const int p = topology.parent[i];
    poses_[k] = spatial_->pose(i);
    Twist<Spatial> Sv{};
    spatial_->each_screw(i, [&](int c, const Twist<Spatial>& S) { Sv += v[c] * S; });
    V_[k] = V_[static_cast<std::size_t>(p)] + Sv;
    if (dq.cols() == 0) continue;
    auto xi = xi_.middleRows<6>(6 * i), dV = dV_.middleRows<6>(6 * i);
    xi += xi_.middleRows<6>(6 * p);
    dV = dV_.middleRows<6>(6 * p);
    spatial_->each_screw(i, [&](int c, const Twist<Spatial>& S) {
      xi += to_eigen(S) * dq.row(c);
      dV += to_eigen(S) * dv.row(c);
    });
    dV -= ad_matrix(screw(Sv)) * xi;
  }
}

Changes DisplacedMotion::row_velocities(const ContactJet& at, const ContactChanges& change,
                                        const ContactFrame& axes, const FrameChanges& daxes, int rows,
                                        double* u) {
  Vec3<> slip, turning;
  VectorChanges dslip = VectorChanges::Zero(3, directions()), dturning = dslip;
  const auto add = [&](int body, double sign) {
    const Twist<Spatial>& V = V_[static_cast<std::size_t>(body)];
    const Vec3<> arm = at.point - origin(body);
    const auto dV = of(dV_, body);
    slip += sign * (V.v + cross(V.w, arm));
    turning += sign * V.w;
    dslip += sign * (dV.bottomRows<3>() - skew(arm) * dV.topRows<3>() + skew(V.w) * change.point);
    dturning += sign * dV.topRows<3>();
  };
  add(at.b, 1);
  add(at.a, -1);
  Changes out(rows, directions());
  const auto set = [&](int row, const Vec3<>& axis, const VectorChanges& daxis) {
    const Vec3<>& x = row < 3 ? slip : turning;
    u[row] = dot(axis, x);
    out.row(row) =
        to_eigen(axis).transpose() * (row < 3 ? dslip : dturning) + to_eigen(x).transpose() * daxis;
  };
  for (int row = 0; row < rows; ++row) {
    if (row % 3 == 0) set(row, axes.n, daxes.n);
    if (row % 3 == 1) set(row, axes.t1, daxes.t1);
    if (row % 3 == 2) set(row, axes.t2, daxes.t2);
  }
  return out;
}

void DisplacedMotion::add_impulse_changes(const ContactJet& at, const ContactChanges& change,
                                          const ContactFrame& axes, const FrameChanges& daxes, int rows,
                                          const double* lambda, Changes& out) {
  const auto sum = [&](int first) {
    Vec3<> a{};
    for (const auto& [row, axis] : {std::pair{first, &axes.n}, {first + 1, &axes.t1}, {first + 2, &axes.t2}})
      if (row < rows) a += lambda[row] * *axis;
    return a;
  };
  const auto dsum = [&](int first) -> VectorChanges {
    VectorChanges a = VectorChanges::Zero(3, directions());
    for (const auto& [row, axis] :
         {std::pair{first, &daxes.n}, {first + 1, &daxes.t1}, {first + 2, &daxes.t2}})
      if (row < rows) a += lambda[row] * *axis;
    return a;
  };
  const Vec3<> f = sum(0), m = sum(3);
  const VectorChanges df = dsum(0), dm = dsum(3);
  const auto add = [&](int end, double sign) {
    const Vec3<> arm = at.point - origin(end);
    Eigen::Matrix<double, 6, 1> W;
    W << to_eigen(m + cross(arm, f)), to_eigen(f);
    Changes dW(6, directions());
    dW.topRows<3>() = dm + skew(arm) * df - skew(f) * change.point;
    dW.bottomRows<3>() = df;
    for (int i = end; i > 0; i = (*tree_)->parent[static_cast<std::size_t>(i)])
      spatial_->each_screw(i, [&](int c, const Twist<Spatial>& S) {
        const Eigen::Matrix<double, 1, 6> by_xi = -(W.transpose() * ad_matrix(screw(S)));  // W | [ξ, S]
        out.row(c) += sign * (by_xi * of(xi_, i) + to_eigen(S).transpose() * dW);
      });
  };
  add(at.b, 1);
  add(at.a, -1);
}

}  // namespace axode
