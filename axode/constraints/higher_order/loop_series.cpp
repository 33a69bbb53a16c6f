#include "axode/constraints/higher_order/loop_series.hpp"

#include "axode/recursion/forward_kinematics.hpp"

namespace axode {
namespace {

/// Sets the coefficients of order n of a vector of power series.
template <class Series> void set(Vec3<Series>& of, std::size_t n, const Vec3<>& x) {
  of.x.c[n] = x.x;
  of.y.c[n] = x.y;
  of.z.c[n] = x.z;
}

}  // namespace

LoopSeries::LoopSeries(const Model& model, int order)
    : model_(model),
      table_(model),
      motion_(model.tree<double>(), order),
      pose_(order),
      origin_(static_cast<std::size_t>(model.n_bodies() + 1)),
      A_(static_cast<std::size_t>(order + 1), Eigen::MatrixXd::Zero(model.loops().rows, model.nv())) {}

Screw<LoopSeries::Series> LoopSeries::about(const Vec3<>& shift, const Screw<>* X) const {
  Screw<Series> out;
  for (int k = 0; k <= order(); ++k) {
    const auto n = static_cast<std::size_t>(k);
    const Vec3<>& w = X[k].w;
    const Vec3<> v = X[k].v + cross(shift, w);
    set(out.w, n, w);
    set(out.v, n, v);
  }
  return out;
}

SE3<LoopSeries::Series> LoopSeries::frame_series(const Loop::End& end, const Vec3<>& shift) {
  SE3<> C = motion_.pose(end.body) * end.F;
  pose_.run(order(), motion_.twist(end.body), C);
  const auto series_of = [&](const auto& coefficient) {
    Vec3<Series> out;
    for (int k = 0; k <= order(); ++k) {
      const auto n = static_cast<std::size_t>(k);
      const Vec3<> x = coefficient(k);
      set(out, n, x);
    }
    return out;
  };
  return {
      {series_of([&](int k) { return pose_.axes(k).x; }), series_of([&](int k) { return pose_.axes(k).y; }),
       series_of([&](int k) { return pose_.axes(k).z; })},
      series_of([&](int k) { return k == 0 ? pose_.origin(0) + shift : pose_.origin(k); })};
}

void LoopSeries::run(const double* q, const double* rates) noexcept {
  const Tree<double>& tree = model_.tree<double>();
  motion_.run_about_roots(tree, q, rates);
  for (int i = 1; i <= tree->n; ++i)
    if (tree->parent[i] == 0) origin_[static_cast<std::size_t>(i)] = joint_pose(tree, i, q).r;
  for (Eigen::MatrixXd& A : A_) A.setZero();
  table_.each([&](std::size_t number, const auto& joint) {
    const LoopPath& path = table_.paths[number];
    const auto origin = [&](int root) { return origin_[static_cast<std::size_t>(root)]; };
    const Vec3<> O = origin(path.root[1] > 0 ? path.root[1] : path.root[0]);
    const Vec3<> first = origin(path.root[0]) - O, second = origin(path.root[1]) - O;
    const loops::LoopFrames<Series> frames{frame_series(path.ends[0], first),
                                           frame_series(path.ends[1], second)};
    loops::LoopWrenches<Series> W;
    joint.wrenches(frames, W.data());
    for (const LoopColumn& column : path.columns) {
      const Screw<Series> J = about(column.side > 0 ? second : first, motion_.screw(column.screw));
      for (int r = 0; r < path.rows.count; ++r) {
        const Series entry = loops::power(W[static_cast<std::size_t>(r)], J);
        for (int k = 0; k <= order(); ++k)
          A_[static_cast<std::size_t>(k)](path.rows.first + r, column.velocity) +=
              column.side * axode::derivative(entry, static_cast<std::size_t>(k));
      }
    }
  });
  for (const LoopPath& path : table_.of_couplings())
    for (const LoopColumn& column : path.columns)
      A_.front()(path.rows.first, column.velocity) += column.factor;
}

Eigen::VectorXd LoopSeries::known_terms(const double* rates, int k) const {
  const Eigen::Index nv = model_.nv();
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(model_.loops().rows);
  double binomial = 1;
  for (int l = 1; l <= k; ++l) {
    binomial = binomial * (k - l + 1) / l;
    sum += binomial * (derivative(l) * Eigen::Map<const Eigen::VectorXd>(rates + (k - l) * nv, nv));
  }
  return sum;
}

}  // namespace axode
