#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "axode/model/workspace.hpp"
#include "axode/recursion/changes.hpp"
#include "axode/recursion/spatial_tree.hpp"

namespace axode {

/// Directions along which the parameters of a mechanism change. Each matrix is empty, or has one column for
/// each of p directions.
struct ParameterDirections {
  Changes inertia;    ///< inertial parameters of inertial_parameters.hpp, 10 rows for each body
  Changes geometry;   ///< geometric parameters of geometry_derivatives.hpp, 6 rows for each body
  Changes placement;  ///< displacements of shapes on their bodies, along the unit screws of their
                      ///< own frames, 6 rows for each shape; angular before linear

  /// The number p of directions.
  Eigen::Index count() const { return std::max({inertia.cols(), geometry.cols(), placement.cols()}); }
};

/// Computes the displacements ξ = U dπ of all n bodies by changes dπ of their own geometric parameters along
/// p directions; ξ of a body does not contain the displacement of its predecessor. `geometry` has dπ, 6 n ×
/// p. The result is 6 (n + 1) × p; rows 6 i to 6 i + 5 belong to body i, and the first six rows, which are 0,
/// to the ground. The columns of U are the six unit screws of the frame that the body would have if its own
/// joint were at zero and all other joints at q. ξ and U are in inertial axes, about the origin at q of the
/// first body on the path from the ground to the body. `at` has the poses of the bodies at q.
Changes geometric_displacements(const Tree<double>& tree, const SpatialTree<double>& at, const double* q,
                                const Changes& geometry);

/// The changes of the momenta M v, of the derivative ∂T/∂q of the kinetic energy T, and of the generalised
/// forces of gravity, if parameters of the mechanism change along p directions but not the state (q, v)
/// (D11.36 to D11.38). An object is the scratch memory of one thread. Costs O(n p) for n bodies.
class ParameterChanges {
 public:
  explicit ParameterChanges(const Model& model);

  /// Computes `momenta`, `forces` and `gravity` at a state (q, v), nv × p numbers each: the derivatives of
  /// the momenta M v, of ∂T/∂q with the kinetic energy T, and of the generalised forces of gravity. Each
  /// column is for one of the p directions `along`, in which the parameters of the mechanism change.
  void run(const double* q, const double* v, const ParameterDirections& along);

  Changes momenta;  ///< changes of M v
  Changes forces;   ///< changes of ∂T/∂q, the derivative of the kinetic energy T at constant v
  Changes gravity;  ///< changes of the generalised forces of gravity
  /// The changes of the centre of mass of the subtree of a body in inertial axes (3 × p, m), along the p
  /// directions of the last call of run(), in which the inertial and geometric parameters of the mechanism
  /// change, at constant q.
  Eigen::Matrix3Xd center(int body);

 private:
  const Tree<double>* tree_;
  WithScratch<double, SpatialTree<double>> spatial_;
  std::vector<Twist<Spatial>> V_;
  std::vector<Momentum<Spatial>> Pi_, Gamma_;  ///< momentum and weight of the subtree of each body
  Changes xi_, dV_, dPi_, dGamma_, dh_, dm_;   ///< rows for each body, p columns
};

}  // namespace axode
