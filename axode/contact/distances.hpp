#pragma once
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "axode/contact/contact_shapes.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/forward_kinematics.hpp"

namespace axode {

/// The nearest points of two collision shapes. Coordinates are in the inertial frame.
struct ShapeDistance {
  int a = 0, b = 0;         ///< shapes as ContactShapes numbers them
  double distance = 0;      ///< signed distance, negative in overlap, m; see ConvexDistance
  Vec3<> normal;            ///< unit vector from a to b
  Vec3<> point_a, point_b;  ///< nearest points, or deepest points in overlap, on the surfaces of a and b, m
  /// The certificate: the true distance is at least `distance` and at most `distance + residual`, m, for an
  /// overlap if it is `proved`, see ConvexDistance.
  double residual = 0;
  bool proved = true;  ///< whether no other normal has less overlap
};

/// Distances between the collision shapes of a mechanism, with their Jacobian: for clearances, inverse
/// kinematics and control. It is the scratch memory of one thread; no result
/// depends on an earlier call.
class Distances {
 public:
  /// For the given pairs of shapes, or for all that may touch. `shapes` are those of the model. Throws
  /// std::invalid_argument for a shape that does not exist, a pair of one shape and a pair of planes, and
  /// what ContactShapes refuses. Allocates.
  explicit Distances(const Model& model);
  Distances(const Model& model, ContactShapes shapes);
  Distances(const Model& model, ContactShapes shapes, std::vector<std::array<int, 2>> pairs);
  Distances(const Distances&) = delete;
  Distances& operator=(const Distances&) = delete;

  /// Computes the distances of the pairs that are nearer than `margin` (m) at q, in the order of the pairs.
  /// Takes 0.2 to 15 µs for each pair within the margin, see convex_distance(). Throws std::invalid_argument
  /// for a wrong q or a margin that is not a number. Allocates nothing.
  std::span<const ShapeDistance> evaluate(Numbers<double> q,
                                          double margin = std::numeric_limits<double>::infinity());
  std::span<const ShapeDistance> found() const { return found_; }

  /// The Jacobian of the distances that evaluate() has found, at its q: nv numbers for each of them, the rate
  /// of the distance for a unit of each velocity (D10.11), m/rad or m/m. It is exact if the nearest points
  /// are unique, and a one-sided derivative otherwise. O(depth) for each distance, and nv to clear the row.
  /// Throws std::invalid_argument if J has another size.
  void jacobian(std::span<double> J) const;

  const ContactShapes& shapes() const { return shapes_; }

 private:
  Model model_;
  ContactShapes shapes_;
  std::vector<std::array<int, 2>> pairs_;
  std::vector<ShapeDistance> found_;
  mutable WithScratch<double, BodyPoses<double>> poses_;
};

}  // namespace axode
