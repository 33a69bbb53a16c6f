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

/// The signed distance of two collision shapes, and their nearest points. Coordinates are in the inertial
/// frame.
struct ShapeDistance {
  int a = 0, b = 0;         ///< the two shapes, numbered as in ContactShapes
  double distance = 0;      ///< signed distance, negative in overlap, m; see ConvexDistance
  Vec3<> normal;            ///< unit vector from shape a to shape b
  Vec3<> point_a, point_b;  ///< nearest points, or deepest points in overlap, on the surfaces of a and b, m
  /// Error bound, m: the true signed distance is at least `distance` and at most `distance + residual`. If
  /// the shapes overlap, the upper bound holds only if `proved` is true.
  double residual = 0;
  bool proved = true;  ///< whether it is proved that no other normal has less overlap
};

/// Computes the distances between the collision shapes of a mechanism and their Jacobian. An object is the
/// scratch memory of one thread; no result of evaluate() depends on an earlier call.
class Distances {
 public:
  /// Prepares the distances of the given pairs of shapes or, without `pairs`, of all pairs that may touch.
  /// `shapes` must be made from the model; by default they are ContactShapes(model), which refuses meshes.
  /// Throws std::invalid_argument for a shape that does not exist, for a pair of a shape with itself, for a
  /// pair of two planes, and for a model that ContactShapes refuses. Allocates.
  explicit Distances(const Model& model);
  Distances(const Model& model, ContactShapes shapes);
  Distances(const Model& model, ContactShapes shapes, std::vector<std::array<int, 2>> pairs);
  Distances(const Distances&) = delete;
  Distances& operator=(const Distances&) = delete;

  /// Computes the signed distances at q of the pairs that are nearer than `margin` (m), in the order of the
  /// pairs; found() returns the last result again. Takes 0.2 to 15 µs for each pair within the margin. Throws
  /// std::invalid_argument for a wrong q or a margin that is NaN. Allocates nothing.
  std::span<const ShapeDistance> evaluate(Numbers<double> q,
                                          double margin = std::numeric_limits<double>::infinity());
  std::span<const ShapeDistance> found() const { return found_; }

  /// Computes the Jacobian of the distances that were computed last, at the same q: nv numbers for each
  /// distance, row by row. An entry is the rate of the distance for a unit of one velocity (D10.11), m/rad or
  /// m/m. It is exact if the nearest points are unique, and a one-sided derivative otherwise. Costs O(depth)
  /// for each distance, and nv to clear its row. Throws std::invalid_argument if J has another size.
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
