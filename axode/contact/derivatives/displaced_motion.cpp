#include "axode/contact/derivatives/displaced_motion.hpp"

namespace axode {
namespace {

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

/// The 3 × 6 matrix that takes the displacement of a body, which is known at O, to that of a point on it.
Across displacement_of(const Vec3<>& point, const Vec3<>& O) {
  Across out;
  out.leftCols<3>() = -skew(point - O);
  out.rightCols<3>().setIdentity();
  return out;
}

}  // namespace

FrameChanges frame_changes(const Vec3<>& normal, const ChangesArgument& dnormal) {
  const DisplacedFrame axes = frame_of(along(normal, 3));
  const auto apply = [&](const Vec3<Displaced>& a) -> VectorChanges {
    return product(derivatives(a).rightCols<3>(), dnormal);
  };
  return {dnormal, apply(axes.t1), apply(axes.t2)};
}

FrameChanges turned_changes(const Vec3<>& from, const ChangesArgument& dfrom, const Vec3<>& to,
                            const ChangesArgument& dto) {
  const DisplacedFrame axes = turned_frame(frame_of(along(from, 0)), along(to, 3));
  const auto apply = [&](const Vec3<Displaced>& a) -> VectorChanges {
    const Across by = derivatives(a);
    VectorChanges out = product(by.leftCols<3>(), dfrom);
    add_product(by.rightCols<3>(), dto, out);
    return out;
  };
  return {dto, apply(axes.t1), apply(axes.t2)};
}

ContactChanges contact_changes(const ContactJet& jet, const Displacements& a, const Displacements& b) {
  ContactChanges out{.rows = decltype(out.rows)::Zero(7, b.xi.cols())};
  Eigen::Matrix<double, 7, 6> by_relative;
  by_relative << jet.point_by, jet.normal_by, jet.gap_by;
  const auto add = [&](const Displacements& end, double sign) {
    Matrix6<double> to_about = Matrix6<double>::Identity();
    to_about.bottomRows<3>() = displacement_of(jet.about, end.O);
    Eigen::Matrix<double, 7, 6> by = sign * by_relative * to_about;
    if (sign < 0) {  // the point and the normal move with a
      by.topRows<3>() += displacement_of(jet.point, end.O);
      by.block<3, 3>(3, 0) -= skew(jet.normal);
    }
    add_product(by, end.xi, out.rows);
  };
  add(a, -1);
  add(b, 1);
  return out;
}

DisplacedMotion::DisplacedMotion(const Model& model)
    : tree_(&model.tree<double>()),
      spatial_(model.topology()),
      poses_(static_cast<std::size_t>(model.n_bodies()) + 1),
      V_(poses_.size()) {}

void DisplacedMotion::run(const double* q, const double* velocities, const Changes& dq, const Changes& dv,
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
    spatial_->each_screw(i, [&](int c, const Twist<Spatial>& S) { Sv += velocities[c] * S; });
    V_[k] = V_[static_cast<std::size_t>(p)] + Sv;
    if (dq.cols() == 0) continue;
    auto xi = xi_.middleRows<6>(6 * i), dV = dV_.middleRows<6>(6 * i);
    xi += xi_.middleRows<6>(6 * p);
    dV = dV_.middleRows<6>(6 * p);
    spatial_->each_screw(i, [&](int c, const Twist<Spatial>& S) {
      add_product(to_eigen(S), dq.middleRows(c, 1), xi);
      add_product(to_eigen(S), dv.middleRows(c, 1), dV);
    });
    const Eigen::Matrix3d w = skew(Sv.w), v = skew(Sv.v);
    subtract_product(w, xi.topRows<3>(), dV.topRows<3>());
    subtract_product(v, xi.topRows<3>(), dV.bottomRows<3>());
    subtract_product(w, xi.bottomRows<3>(), dV.bottomRows<3>());
  }
}

Changes DisplacedMotion::row_velocities(const ContactJet& at, const ContactChanges& change,
                                        const ContactFrame& axes, const FrameChanges& daxes, int rows,
                                        double* u) {
  using Six = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor, LawBlock::most_rows, 6>;
  using Three = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor, LawBlock::most_rows, 3>;
  const std::array axis{&axes.n, &axes.t1, &axes.t2};
  const std::array daxis{&daxes.n, &daxes.t1, &daxes.t2};
  Vec3<> slip, turning;
  Changes out = Changes::Zero(rows, directions());
  Three by_point = Three::Zero(rows, 3);
  const auto add = [&](int body, double sign) {
    if (body == 0) return;  // the ground does not move
    const Twist<Spatial>& V = V_[static_cast<std::size_t>(body)];
    const Vec3<> arm = at.point - origin(body);
    slip += sign * (V.v + cross(V.w, arm));
    turning += sign * V.w;
    Six by_twist = Six::Zero(rows, 6);
    for (int row = 0; row < rows; ++row) {
      const Vec3<> a = sign * *axis[static_cast<std::size_t>(row % 3)];
      if (row < 3) {
        by_twist.row(row).head<3>() = to_eigen(cross(arm, a));
        by_twist.row(row).tail<3>() = to_eigen(a);
        by_point.row(row) += to_eigen(cross(a, V.w)).transpose();
      } else {
        by_twist.row(row).head<3>() = to_eigen(a);
      }
    }
    add_product(by_twist, of(dV_, body), out);
  };
  add(at.b, 1);
  add(at.a, -1);
  add_product(by_point, change.point(), out);
  for (int row = 0; row < rows; ++row) {
    const std::size_t k = static_cast<std::size_t>(row % 3);
    const Vec3<>& x = row < 3 ? slip : turning;
    u[row] = dot(*axis[k], x);
    add_product(to_eigen(x).transpose(), *daxis[k], out.middleRows(row, 1));
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
    if (end == 0) return;  // the ground does not move
    const Vec3<> arm = at.point - origin(end);
    const Wrench<Spatial> W{sign * (m + cross(arm, f)), sign * f};
    ScrewChanges dW(6, directions());
    dW.topRows<3>() = sign * dm;
    dW.bottomRows<3>() = sign * df;
    add_product(skew(sign * arm), df, dW.topRows<3>());
    subtract_product(skew(W.f), change.point(), dW.topRows<3>());
    for (int i = end; i > 0; i = (*tree_)->parent[static_cast<std::size_t>(i)])
      spatial_->each_screw(i, [&](int c, const Twist<Spatial>& S) {
        const Vector6<double> by_xi = to_eigen(coad(S, W)), by_W = to_eigen(S);  // W | [ξ, S]
        add_product(by_xi.transpose(), of(xi_, i), out.middleRows(c, 1));
        add_product(by_W.transpose(), dW, out.middleRows(c, 1));
      });
  };
  add(at.b, 1);
  add(at.a, -1);
}

}  // namespace axode
