#include "axode/contact/distances.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "axode/contact/convex/convex_distance.hpp"
#include "axode/contact/convex/support.hpp"
#include "axode/kinematics/path.hpp"
#include "axode/model/configuration.hpp"

namespace axode {
namespace {

std::vector<std::array<int, 2>> all_pairs(const ContactShapes& shapes) {
  return {shapes.pairs().begin(), shapes.pairs().end()};
}

bool is_plane(const ContactShape& shape) { return shape.kind == ShapeKind::plane; }

/// The distance of a shape from a half-space. The normal points from the plane to the shape.
ShapeDistance above_plane(const SE3<>& plane, const ContactShape& shape, const SE3<>& pose) noexcept {
  const Vec3<>& n = plane.R.z;
  const Vec3<> p = pose * convex::support_point(shape.convex, transpose(pose.R) * -n);
  const double height = dot(n, p - plane.r);
  return {.distance = height, .normal = n, .point_a = p - height * n, .point_b = p};
}

ShapeDistance between(const ContactShape& a, const SE3<>& A, const ContactShape& b, const SE3<>& B) noexcept {
  if (is_plane(a)) return above_plane(A, b, B);
  if (is_plane(b)) {
    ShapeDistance d = above_plane(B, a, A);
    d.normal = -d.normal;
    std::swap(d.point_a, d.point_b);
    return d;
  }
  const ConvexDistance d = convex_distance(a.convex, A, b.convex, B);
  return {.distance = d.distance,
          .normal = d.normal,
          .point_a = d.point_a,
          .point_b = d.point_b,
          .residual = d.residual,
          .proved = d.proved()};
}

/// Whether the bounding balls of two shapes are farther apart than `margin`; false if one shape is a plane.
bool far_apart(const ContactShape& a, const SE3<>& A, const ContactShape& b, const SE3<>& B, double margin) {
  if (is_plane(a) || is_plane(b)) return false;
  return norm(B.r - A.r) - a.convex.extent - b.convex.extent > margin;
}

}  // namespace

Distances::Distances(const Model& model) : Distances(model, ContactShapes(model)) {}
Distances::Distances(const Model& model, ContactShapes shapes)
    : Distances(model, shapes, all_pairs(shapes)) {}

Distances::Distances(const Model& model, ContactShapes shapes, std::vector<std::array<int, 2>> pairs)
    : model_(model), shapes_(std::move(shapes)), pairs_(std::move(pairs)), poses_(model.topology()) {
  check_shapes(model, shapes_);
  for (const auto& [i, j] : pairs_) {
    for (const int k : {i, j})
      if (k < 0 || k >= shapes_.size())
        throw std::invalid_argument("pairs: there is no shape " + std::to_string(k) + "; model \"" +
                                    model.name() + "\" has " + std::to_string(shapes_.size()) +
                                    " collision shapes");
    if (i == j) throw std::invalid_argument("pairs: shape \"" + shapes_[i].name + "\" is paired with itself");
    if (is_plane(shapes_[i]) && is_plane(shapes_[j]))
      throw std::invalid_argument("pairs: \"" + shapes_[i].name + "\" and \"" + shapes_[j].name +
                                  "\" are planes, and the distance of two half-spaces is not defined");
  }
  found_.reserve(pairs_.size());
}

std::span<const ShapeDistance> Distances::evaluate(Numbers<double> q, double margin) {
  check_configuration(model_, q);
  if (std::isnan(margin)) throw std::invalid_argument("margin is not a number; give a distance in m");
  poses_->run(model_.tree<double>(), q.data());
  found_.clear();
  for (const auto& [i, j] : pairs_) {
    const ContactShape &a = shapes_[i], &b = shapes_[j];
    const SE3<> A = (*poses_)[a.body] * a.pose, B = (*poses_)[b.body] * b.pose;
    if (far_apart(a, A, b, B, margin)) continue;
    ShapeDistance d = between(a, A, b, B);
    if (!(d.distance < margin)) continue;
    d.a = i;
    d.b = j;
    found_.push_back(d);
  }
  return found_;
}

void Distances::jacobian(std::span<double> J) const {
  const std::size_t nv = model_.nv();
  check_size("J", J.size(), nv * found_.size(), "nv for each distance");
  std::ranges::fill(J, 0.0);
  const Tree<double>& tree = model_.tree<double>();
  for (std::size_t k = 0; k < found_.size(); ++k) {
    double* row = J.data() + k * nv;
    const ShapeDistance& d = found_[k];
    const auto add = [&](int body, const Vec3<>& point, double sign) {
      for (int i = body; i > 0; i = tree->parent[i])
        each_screw(tree, i, (*poses_)[i],
                   [&](int c, const Screw<>& X) { row[c] += sign * dot(d.normal, X.v + cross(X.w, point)); });
    };
    add(shapes_[d.b].body, d.point_b, 1);
    add(shapes_[d.a].body, d.point_a, -1);
  }
}

}  // namespace axode
