#pragma once
#include <Eigen/Core>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// A coordinate of an analysis of mobility: a velocity of the tree, or a degree of freedom of a loop joint.
struct ClosureCoordinate {
  std::string name;
  int velocity = -1;    ///< index among the velocities of the model; -1 for a loop joint
  bool angular = true;  ///< whether its unit is rad, and not m
};

struct LocalMobilityOptions {
  /// The highest order K of the constraints. 0 stands for 10, 9, 7, 7 for a differential mobility of 1, 2, 3,
  /// 4 and 5 above; for less if that takes too long, and for up to 4 more if the mobility is not settled
  /// then.
  int order = 0;
  /// The length by which lengths are divided before they are compared with angles, m; 0 stands for the mean
  /// distance between the centres of two joints.
  double length = 0;
  /// A function that is called now and then. If it returns false, the analysis ends with an empty result.
  std::function<bool()> monitor = {};
};

/// A point of a branch near q that Newton's method has closed.
struct BranchPoint {
  Eigen::VectorXd parameter;  ///< s, ζ or τ of MotionBranch (dimension numbers)
  Eigen::VectorXd x;          ///< n coordinates, rad and m
  std::vector<double> q;      ///< the configuration of the model (nq)
  double residual = 0;        ///< |log| of the open loops, in rad and characteristic lengths
};

/// A branch of the configuration space at q, as x of n coordinates with the configuration q ⊕ x. Tangents and
/// curvatures are in rad and m; products and norms divide lengths by the characteristic length.
///
/// A branch of dimension 1 is a series in s = t·x for its unit tangent t. At a cusp it is a series in ζ with
/// ζ^power = t·x, so that x = t ζ² + c ζ³ + ... and the mechanism moves in the direction t only. For a
/// dimension D > 1, x = Tᵀ τ + Σ τ_a τ_b II_ab / 2 + ... with τ = T x and T II = 0 (D13.13).
struct MotionBranch {
  int dimension = 0;
  int power = 1;           ///< 1, or above 1 for a cusp: the power of the parameter with which x begins
  Eigen::MatrixXd T;       ///< D × n: the tangent space, orthonormal rows
  Eigen::MatrixXd II;      ///< D² × n: the second fundamental form, II_ab in row a D + b; empty at a cusp
  Eigen::MatrixXd series;  ///< n × (orders + 1) for D = 1: coefficients of s^k or ζ^k; empty for D > 1
  /// Whether enough orders were left to exclude that a higher one ends the branch.
  bool settled = false;
  bool closes = false;                   ///< whether Newton's method closed points on both sides of q
  bool multiple = false;                 ///< whether the equations hold doubly along the branch
  int differential_mobility_beside = 0;  ///< at other points of the branch near q
  std::vector<int> dead;   ///< coordinates that have no velocity at q and move beside q: dead points
  std::vector<int> idle;   ///< coordinates that rest along the branch
  std::vector<int> loops;  ///< indices of the loops and couplings in which something moves
  std::vector<BranchPoint> points;
  /// For D = 1: the measured order in s or ζ of the residual of the series cut after 1, 2, ... terms;
  /// infinite if it is at rounding.
  std::vector<double> residual_orders;

  bool cusp() const { return power > 1; }
};

/// An equation that is left after the elimination of what the loops determine to first order: a condition on
/// velocities of degree 2 or higher.
struct MobilityCondition {
  int degree = 0;          ///< lowest degree of its terms
  std::vector<int> loops;  ///< indices of the loops and couplings whose equations it combines
};

/// The closed points near q that Newton's method finds from random starts in the kernel.
struct MobilityProbe {
  int starts = 0, closed = 0;
  int missed = 0;  ///< closed points on none of the branches
};

struct LocalMobility {
  std::vector<ClosureCoordinate> coordinates;  ///< n coordinates; those of the tree come first
  std::vector<int> outside;        ///< velocities of joints in no loop; each adds 1 to every mobility below
  std::vector<std::string> loops;  ///< loops and couplings that were analysed
  double length = 1;               ///< characteristic length, m
  int order = 0;                   ///< K
  int equations = 0;               ///< 6 for each loop, 1 for each coupling
  int rank = 0;                    ///< of the equations' derivative
  double smallest_kept = 0, largest_dropped = 0;  ///< singular values on either side of the rank
  int differential_mobility = 0;                  ///< n - rank
  /// Dimension of the kinematic tangent cone of order 1, 2, ...: of all velocities with which the
  /// constraints of that order can be satisfied.
  std::vector<int> mobility_by_order;
  int settled_at_order = 0;  ///< the order from which on mobility_by_order does not change
  bool settled = false;      ///< whether orders, branches and their points agree
  int local_mobility = 0;    ///< the largest dimension of a branch
  int rigid_at_order = 0;    ///< the first order with mobility 0 if nothing moves; else 0
  /// The conditions that do not vanish up to order K, by degree; their leading forms are independent.
  std::vector<MobilityCondition> conditions;
  std::vector<MotionBranch> branches;
  MobilityProbe probe;

  bool branch_point = false;           ///< more than one branch
  bool kinematotropic = false;         ///< branches of different dimensions
  bool cusp = false;                   ///< some branch is a cusp
  bool kinematic_singularity = false;  ///< on every branch the differential mobility is smaller beside q
  /// On some branch the differential mobility beside q is above the dimension; or nothing moves although
  /// the differential mobility is not 0.
  bool shaky = false;
  /// Whether ranks and roots alone decide: the equations are independent, or nothing moves and at most two
  /// velocities are free. Otherwise points are evidence for motions, and a search for missing branches.
  bool decided_by_rank = false;
};

/// The words for a configuration: regular, kinematic singularity, branch point, kinematotropic, cusp, shaky,
/// rigid, rigid at order m, dead points and idle drives by name, not settled up to order K.
std::vector<std::string> mobility_words(const Model& model, const LocalMobility& found);

/// Finds what a mechanism with loops can do at a closed q (nq): mobility by order, branches of the
/// configuration space with tangents and curvatures, cusps and shakiness.
///
/// The closures are expanded to order K by brackets of joint screws (D13.3 to D13.6), the velocities that
/// they determine are eliminated (D13.8), and the remaining equations are solved by blow-ups (D13.11) and
/// deflation (D13.12). Every branch is traced by closed points. Allocates; about 1 ms for a loop of six
/// joints with one branch; it grows with the number of polynomials' terms, C(2d + K, K) for d degrees of
/// freedom. Throws std::invalid_argument for a wrong or open q, a rolling contact, or an order that is
/// negative, 1, above 20 or too large for d.
[[nodiscard]] LocalMobility local_mobility(const Model& model, std::span<const double> q,
                                           const LocalMobilityOptions& options = {});

/// The coordinates of closure_derivatives(): velocities of the joints in loops, then loop joints.
std::vector<ClosureCoordinate> closure_coordinates(const Model& model);

/// The derivatives H^(k) = d^(k-1)V/dt^(k-1) at t = 0, k = 1 ... K, of the twist V of the last body of each
/// loop, along any curve q ⊕ x(t) with the derivatives x', x'', ... (n × K, rad and m, in the order of
/// closure_coordinates()); they are 0 for motions of the mechanism (D13.5). V is spatial, about the inertial
/// origin, in rad and m; it passes the loop from the body where its paths meet through its first body. One
/// matrix (6 × K) for each loop joint. O(n K²) brackets. Throws std::invalid_argument for wrong sizes and
/// rolling contacts.
std::vector<Eigen::MatrixXd> closure_derivatives(const Model& model, std::span<const double> q,
                                                 const Eigen::Ref<const Eigen::MatrixXd>& derivatives);

}  // namespace axode
