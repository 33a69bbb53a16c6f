#pragma once
#include <Eigen/Core>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// A coordinate in an analysis of mobility: a velocity of the spanning tree or a freedom of a loop joint.
struct ClosureCoordinate {
  std::string name;
  int velocity = -1;    ///< index of the velocity of the model; -1 for a loop joint
  bool angular = true;  ///< true if the unit is rad, false if it is m
};

struct LocalMobilityOptions {
  /// The highest order K of the power series of the loop equations. If it is 0, the order is chosen by the
  /// dimension d of the velocities that the loops allow: 10 for d ≤ 1, 9 for d = 2, 7 for d = 3 and d = 4,
  /// and 5 for larger d. A lower order is chosen if the computation would take too long, and up to 4 orders
  /// are added if the result is not settled (see LocalMobility::settled).
  int order = 0;
  /// The characteristic length (m) by which lengths are divided, within a factor of 1e6 of the mean distance
  /// of two joints; 0 means this distance.
  double length = 0;
  /// A function that the analysis calls again and again; if it returns false, the result is empty.
  std::function<bool()> monitor = {};
};

/// A point of a branch near q at which Newton's method has closed the loops.
struct BranchPoint {
  Eigen::VectorXd parameter;  ///< parameters s, ζ or τ of the point, see MotionBranch
  Eigen::VectorXd x;          ///< n coordinates x with the configuration q ⊕ x, rad and m
  std::vector<double> q;      ///< the configuration of the model at the point (nq)
  double residual = 0;        ///< norm of the residual log f of the loops, in rad and characteristic lengths
};

/// A branch of the configuration space at q: a smooth set of configurations through q with closed loops. Its
/// points are given by n coordinates x, with the configuration q ⊕ x. Tangents and curvatures are in rad and
/// m; products and norms divide lengths by the characteristic length.
///
/// A branch of dimension 1 is a power series in s = t·x, the displacement along its unit tangent t. At a cusp
/// it is a series in ζ with ζ^power = t·x. For power 2 this is x = t ζ² + c ζ³ + ..., and the mechanism
/// leaves q only in the direction t, not in -t. A branch of dimension D > 1 is x = Tᵀ τ + Σ τ_a τ_b II_ab / 2
/// + ... with its tangent space T, parameters τ = T x, and second fundamental form II, whose entries are
/// orthogonal to the tangent space (D13.13).
struct MotionBranch {
  int dimension = 0;
  int power = 1;           ///< power of the parameter with which the series of x begins: 1, or above 1 for a
                           ///< cusp
  Eigen::MatrixXd T;       ///< D × n for dimension D: orthonormal rows that span the tangent space
  Eigen::MatrixXd II;      ///< D² × n: the second fundamental form, with II_ab in row a D + b; empty at a
                           ///< cusp
  Eigen::MatrixXd series;  ///< n × (orders + 1) for D = 1: coefficients of s^k or ζ^k; empty for D > 1
  /// Whether enough orders of the expansion remained to exclude that terms of higher order end the branch.
  bool settled = false;
  bool closes = false;                   ///< whether Newton's method found closed points on both sides of q
  bool multiple = false;                 ///< whether the equations hold doubly along the branch
  int differential_mobility_beside = 0;  ///< differential mobility at other points of the branch near q
  std::vector<int> dead;   ///< indices of coordinates that have no velocity at q and move beside q: dead
                           ///< points
  std::vector<int> idle;   ///< indices of coordinates that rest along the branch
  std::vector<int> loops;  ///< indices of the loops and couplings in which something moves
  std::vector<BranchPoint> points;
  /// For a branch of dimension 1 (a curve of configurations with closed loops), how well its power series
  /// solves the loop equations. Entry n has the exponent k for the series cut after n + 1 terms: the residual
  /// of the loops was found to vanish as (parameter)^k. k is infinite if the residual is a rounding error.
  std::vector<double> residual_orders;

  bool cusp() const { return power > 1; }
};

/// A condition of degree 2 or higher on the velocities: one of the equations that remain after the
/// elimination of all coordinates that the loop equations determine to first order.
struct MobilityCondition {
  int degree = 0;          ///< lowest degree of its terms
  std::vector<int> loops;  ///< indices of the loops and couplings whose equations it combines
};

/// A test for missed branches, which are smooth sets of configurations with closed loops. From random starts
/// along the velocities that the loops allow, Newton's method searches configurations near q with closed
/// loops; each of them should lie on a branch.
struct MobilityProbe {
  int starts = 0, closed = 0;
  int missed = 0;  ///< number of closed points that lie on none of the branches
};

struct LocalMobility {
  std::vector<ClosureCoordinate> coordinates;  ///< n coordinates: velocities of the spanning tree, followed
                                               ///< by degrees of freedom of loop joints
  std::vector<int> outside;        ///< indices of velocities of joints in no loop or coupling; each adds 1
                                   ///< to every mobility below
  std::vector<std::string> loops;  ///< names of the loops and couplings that were analysed
  double length = 1;               ///< characteristic length, m
  int order = 0;                   ///< highest order K of the expansion that was used
  int equations = 0;               ///< number of equations: 6 for each loop joint, 1 for each coupling
  int rank = 0;                    ///< rank of the derivative of the equations at q
  double smallest_kept = 0, largest_dropped = 0;  ///< least singular value that counts for the rank, and
                                                  ///< largest one that does not
  int differential_mobility = 0;                  ///< n - rank
  /// The dimension of the kinematic tangent cone for each order 1, 2, ...: of the set of velocities for which
  /// the loop equations can be satisfied up to that order.
  std::vector<int> mobility_by_order;
  int settled_at_order = 0;  ///< order from which on mobility_by_order does not change
  /// Whether three results agree. The mobility of the highest order K is the largest dimension of a branch (a
  /// smooth set of configurations with closed loops; 0 if there is none), or some branch is a cusp. Newton's
  /// method finds closed configurations on every branch, and terms of order above K cannot end the branch.
  /// Every closed configuration that Newton's method finds near q lies on a branch.
  bool settled = false;
  int local_mobility = 0;  ///< largest dimension of a branch
  int rigid_at_order = 0;  ///< first order with mobility 0 if nothing moves; otherwise 0
  /// The polynomial conditions of degree 2 or more that the loop equations put on velocities, up to the order
  /// K of the power series of the loop equations about q. They are sorted by their lowest degree. The terms
  /// of lowest degree of those conditions that begin with the same degree are linearly independent
  /// polynomials.
  std::vector<MobilityCondition> conditions;
  std::vector<MotionBranch> branches;
  MobilityProbe probe;

  bool branch_point = false;           ///< whether there is more than one branch
  bool kinematotropic = false;         ///< whether there are branches of different dimensions
  bool cusp = false;                   ///< whether some branch is a cusp
  bool kinematic_singularity = false;  ///< whether on every branch the differential mobility is smaller
                                       ///< beside q than at q
  /// Whether the loop equations allow velocities that belong to no finite motion. If the mechanism can move,
  /// this is judged beside q: on each branch (a smooth set of configurations through q with closed loops), at
  /// a point near q. `shaky` is true if such velocities exist there for any branch. If the mechanism cannot
  /// move, this is judged at q.
  bool shaky = false;
  /// Whether the result is proved by ranks of matrices and roots of polynomials alone. It is if the loop
  /// equations are independent, if they allow no velocities, or if they allow velocities of dimension 1 or 2
  /// but no finite motion. Otherwise it also rests on numerical evidence: closed configurations that Newton's
  /// method found.
  bool decided_by_rank = false;
};

/// Returns words for a configuration, from the result `found` of local_mobility() there: as far as they
/// apply, "rigid", "branch point", "cusp", "kinematotropic", "kinematic singularity", "shaky" and "rigid at
/// order m"; "regular" if none of these applies and the result is settled; "dead point of NAME" for a driven
/// (not passive) joint that has no velocity at the configuration but moves near it; "idle drive of NAME" for
/// a driven joint that rests along a branch of motions; "not settled up to order K" if the result is not
/// settled; "no loops" for a mechanism without loops and couplings. The result is settled if the expansion of
/// the loop equations up to order K gives branches (smooth sets of configurations with closed loops) that
/// Newton's method confirms, and misses none; see LocalMobility::settled.
std::vector<std::string> mobility_words(const Model& model, const LocalMobility& found);

/// Finds how a mechanism with loops can move from a closed configuration q (nq): the dimension of the
/// velocities that satisfy the loop equations up to each order, the branches of the configuration space
/// (smooth sets of configurations with closed loops) with tangents and curvatures, cusps, and shakiness:
/// velocities without a finite motion.
///
/// The loop equations are expanded in the joint coordinates up to degree K by brackets of joint screws (D13.3
/// to D13.6). Coordinates that the linear terms determine are eliminated (D13.8). The remaining equations are
/// solved by blow-ups (substitutions of a direction and a distance for the unknowns, D13.11) and deflation
/// (additional unknowns for multiple solutions, D13.12). Finally, points with closed loops are computed on
/// every branch.
///
/// Allocates. The function takes about 1 ms for a loop of six joints with one branch; its time grows with the
/// number of products of monomials, C(2d + K, K) if the loops allow velocities of dimension d. The order K of
/// the options must be from 2 to 20, or 0 for an automatic choice. Throws std::invalid_argument for another
/// order, for an order with more than 1e6 products of monomials, for a q of a wrong size or with numbers that
/// are not finite, for a loop that is open at q, and for rolling contacts and belts.
[[nodiscard]] LocalMobility local_mobility(const Model& model, std::span<const double> q,
                                           const LocalMobilityOptions& options = {});

/// Returns the coordinates of the loop closure equations. There is one for each velocity of the joints of the
/// spanning tree that are in a loop or coupling, followed by one for each degree of freedom of the loop
/// joints. Each has a name, the index of the velocity in v (-1 for a loop joint), and the unit, rad or m.
std::vector<ClosureCoordinate> closure_coordinates(const Model& model);

/// Computes, for each loop joint, the sum V of the joint twists around its loop, and the time derivatives of
/// V at t = 0, for the motion q ⊕ x(t) of the joints. The twists are added from the last common predecessor
/// of the two bodies of the loop joint to its first body, across the loop joint, and from its second body
/// back. Column k of the result (6 × K, k = 1 ... K) is d^(k-1)V/dt^(k-1), spatial about the inertial origin.
/// All columns are 0 if the loops stay closed (D13.5). `derivatives` has x', x'', ... as its columns (n × K,
/// rad and m, in the order of closure_coordinates()). O(n K²) brackets. Throws std::invalid_argument for
/// wrong sizes, a K above 20, numbers that are not finite, and rolling contacts and belts.
std::vector<Eigen::MatrixXd> closure_derivatives(const Model& model, std::span<const double> q,
                                                 const Eigen::Ref<const Eigen::MatrixXd>& derivatives);

}  // namespace axode
