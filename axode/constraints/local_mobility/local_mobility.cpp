#include "axode/constraints/local_mobility/local_mobility.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <random>
#include <set>
#include <stdexcept>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/local_mobility/branches.hpp"
#include "axode/constraints/local_mobility/closure.hpp"
#include "axode/constraints/local_mobility/closure_series.hpp"
#include "axode/constraints/local_mobility/directions.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"

namespace axode {
namespace higher_order {
namespace {

constexpr int highest_order = 20;
/// The residual of a loop that counts as closed, in rad and m for lengths up to 1 m.
constexpr double negligible_gap = 1e-8;

int default_order(int d) {
  if (d <= 1) return 10;
  if (d == 2) return 9;
  return d <= 4 ? 7 : 5;
}

void check_order(int order) {
  if (order != 0 && (order < 2 || order > highest_order))
    throw std::invalid_argument("order is " + std::to_string(order) + "; expected 2 to " +
                                std::to_string(highest_order) + ", or 0 for the default");
}

void check_closed_at(const Model& model, std::span<const double> q, double length) {
  LoopWorkspace<double> workspace(model);
  std::vector<double> r(static_cast<std::size_t>(model.loops().residuals));
  loop_residual<double>(model, workspace, q, r);
  for (const LoopRows& loop : model.loops().all) {
    double squares = 0;
    for (int k = 0; k < loop.residuals; ++k)
      squares += std::pow(r[static_cast<std::size_t>(loop.first_residual + k)], 2);
    const double open = std::sqrt(squares), gap = negligible_gap * std::max(1.0, length);
    if (!(open <= gap))
      throw std::invalid_argument("loop \"" + loop.name + "\" is open by " + to_text(open) +
                                  " (rad and m) at q; at most " + to_text(gap) +
                                  " can be neglected: close it with assemble");
  }
}

/// Computes the dimensions of the kinematic tangent cones of order 1 ... K (D13.14).
std::vector<int> mobility_by_order(PolynomialRings& rings, const PolynomialRing& ring,
                                   const std::vector<Form>& rows, int K) {
  const int d = ring.variables();
  std::vector<int> out{d};
  std::vector<Direction> found;
  std::size_t searched = 0;  // number of forms whose common zeros are in `found`
  for (int k = 2; k <= K; ++k) {
    std::vector<Form> known;
    std::ranges::copy_if(rows, std::back_inserter(known), [&](const Form& row) { return row.degree <= k; });
    if (known.empty() || d == 1) {
      out.push_back(known.empty() ? d : 0);
      continue;
    }
    if (out.back() == 0) {
      out.push_back(0);
      continue;
    }
    if (known.size() != searched) {
      found = common_zeros(rings, ring, known);
      std::ranges::stable_sort(found, std::greater{}, &Direction::dimension);
      searched = known.size();
    }
    const auto reached = std::ranges::find_if(
        found, [&](const Direction& at) { return arc_exists(rings, ring, rows, at.e, k); });
    out.push_back(reached == found.end() ? 0 : reached->dimension);
  }
  return out;
}

MobilityProbe probe(const PolynomialRings& rings, const Closure& closure, const Eigen::MatrixXd& kernel,
                    const std::vector<MotionBranch>& branches) {
  double size = 0.04;
  for (const MotionBranch& branch : branches) size = std::min(size, 0.04 * reach(branch));
  MobilityProbe out;
  out.starts = 60;
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd none(0, closure.size());
  for (int k = 0; k < out.starts; ++k) {
    rings.ask();
    Eigen::VectorXd u(kernel.cols());
    for (double& entry : u) entry = normal(random);
    Eigen::VectorXd x = size * (kernel * u.normalized());
    const double residual = closure.close(x, none, Eigen::VectorXd(0));
    if (!(residual < 1e-13 && x.norm() > 0.1 * size && x.norm() < 2 * size)) continue;
    ++out.closed;
    if (std::ranges::none_of(branches, [&](const MotionBranch& branch) { return lies_on(branch, x); }))
      ++out.missed;
  }
  return out;
}

/// Fills in the conclusions of an analysis of mobility: the local mobility, the kind of the configuration,
/// and whether ranks alone prove the result. They follow from the members that are known already: the rank of
/// the loop equations, the mobility of each order, the branches (smooth sets of configurations with closed
/// loops), and the closed configurations that lie on no branch.
void draw_conclusions(LocalMobility& found) {
  std::set<int> dimensions;
  bool all_close = true, all_settled = true, singular = true;
  for (const MotionBranch& branch : found.branches) {
    all_close = all_close && branch.closes;
    all_settled = all_settled && branch.settled;
    if (!branch.closes) continue;
    dimensions.insert(branch.dimension);
    found.cusp = found.cusp || branch.cusp();
    found.shaky = found.shaky || branch.differential_mobility_beside > branch.dimension;
    singular = singular && branch.differential_mobility_beside < found.differential_mobility;
  }
  const auto moving =
      std::ranges::count_if(found.branches, [](const MotionBranch& branch) { return branch.closes; });
  found.local_mobility = dimensions.empty() ? 0 : *dimensions.rbegin();
  found.branch_point = moving > 1;
  found.kinematotropic = dimensions.size() > 1;
  found.kinematic_singularity = moving > 0 && singular;
  const std::vector<int>& orders = found.mobility_by_order;
  found.settled_at_order = static_cast<int>(orders.size());
  while (found.settled_at_order > 1 &&
         orders[static_cast<std::size_t>(found.settled_at_order) - 2] == orders.back())
    --found.settled_at_order;
  if (found.branches.empty() && found.probe.missed == 0 && found.differential_mobility > 0) {
    found.shaky = true;
    const auto zero = std::ranges::find(orders, 0);
    if (zero != orders.end()) found.rigid_at_order = static_cast<int>(zero - orders.begin()) + 1;
  }
  const bool explained = found.differential_mobility == 0 || found.rigid_at_order > 0 ||
                         (moving > 0 && (orders.back() == found.local_mobility || found.cusp));
  found.settled = explained && all_close && all_settled && found.probe.missed == 0;
  found.decided_by_rank = found.rank == found.equations || found.differential_mobility == 0 ||
                          (found.rigid_at_order > 0 && found.differential_mobility <= 2);
}

/// Converts tangents, curvatures, series and points of a branch from characteristic lengths to m.
void in_units(MotionBranch& branch, const Eigen::VectorXd& unit) {
  branch.T = branch.T * unit.asDiagonal();
  if (branch.II.size() > 0) branch.II = branch.II * unit.asDiagonal();
  if (branch.series.size() > 0) branch.series = unit.asDiagonal() * branch.series;
  for (BranchPoint& point : branch.points) point.x = unit.cwiseProduct(point.x);
}

/// Computes the conditions of degree 2 and higher that the loop equations put on velocities, the mobility of
/// each order and the branches (smooth sets of configurations with closed loops). Then searches for closed
/// configurations that lie on no branch. `left` has the equations that remain after the elimination of all
/// coordinates that the loop equations determine to first order; at least one coordinate must remain.
void find_branches(PolynomialRings& rings, const Closure& closure, const Elimination& left,
                   LocalMobility& found) {
  const int orders = found.differential_mobility <= 2 ? found.order : std::min(found.order, 6);
  const PolynomialRing& ring = *left.ring;
  const std::vector<Form> rows = independent_forms(ring, left.g, left.scale);
  for (const Form& row : rows)
    found.conditions.push_back({row.degree, closure.loops_of_equations(left.left * row.combination)});
  found.mobility_by_order = mobility_by_order(rings, ring, rows, orders);
  std::vector<Germ> all = germs(rings, ring, left.g, left.scale);
  for (Germ& germ : all) germ.z = ring.substitute(left.z, *germ.ring, germ.z);
  found.branches = branches(closure, all);
  found.probe = probe(rings, closure, left.z.middleCols(1, ring.variables()), found.branches);
}

/// The analysis of the equations of a closure. run() may be called for several orders.
class Analysis {
 public:
  explicit Analysis(const Closure& closure)
      : closure_(closure),
        A_(closure.jacobian(Eigen::VectorXd::Zero(closure.size()))),
        phi_([&closure](const PolynomialRing& ring, const Eigen::MatrixXd& x, int degree) {
          return closure.log_series(ring, x, degree);
        }) {
    rank_ = rank_of(singular_values(A_));
  }
  int differential_mobility() const { return closure_.size() - rank_; }

  LocalMobility run(int order, const std::function<bool()>& monitor) const {
    PolynomialRings rings(monitor);
    const Elimination left = eliminate(rings, phi_, A_, order);
    LocalMobility found;
    found.coordinates = closure_.coordinates();
    found.outside = closure_.outside();
    found.length = closure_.length();
    found.order = order;
    found.equations = closure_.rows();
    found.rank = left.rank;
    found.differential_mobility = differential_mobility();
    if (left.rank > 0) found.smallest_kept = left.singular_values[left.rank - 1];
    if (left.rank < left.singular_values.size()) found.largest_dropped = left.singular_values[left.rank];
    found.mobility_by_order.assign(1, 0);
    if (left.ring) find_branches(rings, closure_, left, found);
    draw_conclusions(found);
    return found;
  }

 private:
  const Closure& closure_;
  Eigen::MatrixXd A_;
  Equations phi_;
  int rank_ = 0;
};

}  // namespace
}  // namespace higher_order

LocalMobility local_mobility(const Model& model, std::span<const double> q,
                             const LocalMobilityOptions& options) {
  using namespace higher_order;
  check_configuration(model, q);
  if (!finite(q)) throw std::invalid_argument("q is not finite");
  check_order(options.order);
  if (!(options.length >= 0 && std::isfinite(options.length)))
    throw std::invalid_argument("length is " + to_text(options.length) +
                                "; expected a positive number of m, or 0 for the default");
  const Closure closure(model, q, options.length);
  check_closed_at(model, q, closure.length());
  const Analysis analysis(closure);
  const int d = analysis.differential_mobility();
  const auto too_large = [&](int order, double most) { return PolynomialRing::products(d, order) > most; };
  constexpr double affordable = 5e4;
  int order = options.order > 0 ? options.order : default_order(d);
  while (options.order == 0 && order > 2 && too_large(order, affordable)) --order;
  if (too_large(order, PolynomialRing::most_products))
    throw std::invalid_argument("order " + std::to_string(order) + " is too high for the " +
                                std::to_string(d) + " velocities that the loops leave; choose a lower one");
  LocalMobility found;
  try {
    found = analysis.run(order, options.monitor);
    constexpr int step = 2;
    const int raises = options.order == 0 ? 2 : 0;
    for (int k = 0; k < raises && !found.settled; ++k) {
      order += step;
      if (too_large(order, affordable)) break;
      found = analysis.run(order, options.monitor);
    }
  } catch (const AnalysisEnded&) {
    return {};
  }
  for (const LoopRows& loop : model.loops().all) found.loops.push_back(loop.name);
  for (MotionBranch& branch : found.branches) in_units(branch, closure.unit());
  return found;
}

std::vector<std::string> mobility_words(const Model& model, const LocalMobility& found) {
  if (found.coordinates.empty()) return {"no loops"};
  std::vector<std::string> out;
  if (found.differential_mobility == 0) out.emplace_back("rigid");
  if (found.branch_point) out.emplace_back("branch point");
  if (found.cusp) out.emplace_back("cusp");
  if (found.kinematotropic) out.emplace_back("kinematotropic");
  if (found.kinematic_singularity) out.emplace_back("kinematic singularity");
  if (found.shaky) out.emplace_back("shaky");
  if (found.rigid_at_order > 0) out.push_back("rigid at order " + std::to_string(found.rigid_at_order));
  if (out.empty() && found.settled) out.emplace_back("regular");
  std::set<std::string> dead, idle;
  const auto collect = [&](const std::vector<int>& coordinates, std::set<std::string>& names) {
    for (const int c : coordinates) {
      const ClosureCoordinate& coordinate = found.coordinates[static_cast<std::size_t>(c)];
      if (coordinate.velocity >= 0 && model.loops().driven[static_cast<std::size_t>(coordinate.velocity)])
        names.insert(coordinate.name);
    }
  };
  for (const MotionBranch& branch : found.branches) {
    if (!branch.closes) continue;
    collect(branch.dead, dead);
    collect(branch.idle, idle);
  }
  for (const std::string& name : dead) out.push_back("dead point of " + name);
  for (const std::string& name : idle) out.push_back("idle drive of " + name);
  if (!found.settled) out.push_back("not settled up to order " + std::to_string(found.order));
  return out;
}

std::vector<ClosureCoordinate> closure_coordinates(const Model& model) {
  return higher_order::walks(model, neutral(model)).coordinates;
}

std::vector<Eigen::MatrixXd> closure_derivatives(const Model& model, std::span<const double> q,
                                                 const Eigen::Ref<const Eigen::MatrixXd>& derivatives) {
  check_configuration(model, q);
  if (!finite(q)) throw std::invalid_argument("q is not finite");
  const higher_order::Walks walks = higher_order::walks(model, q);
  const auto n = static_cast<Eigen::Index>(walks.coordinates.size()), K = derivatives.cols();
  if (derivatives.rows() != n || K < 1 || K > higher_order::highest_order)
    throw std::invalid_argument("derivatives is " + std::to_string(derivatives.rows()) + " x " +
                                std::to_string(K) + "; expected " + std::to_string(n) +
                                " rows (closure_coordinates) and 1 to " +
                                std::to_string(higher_order::highest_order) + " columns");
  if (!derivatives.allFinite()) throw std::invalid_argument("derivatives has entries that are not finite");
  const higher_order::PolynomialRing line(1, static_cast<int>(K));
  Eigen::MatrixXd x = line.zero(n);
  double factorial = 1;
  for (Eigen::Index k = 1; k <= K; ++k) {
    factorial *= static_cast<double>(k);
    x.col(k) = derivatives.col(k - 1) / factorial;
  }
  std::vector<Eigen::MatrixXd> out;
  for (const std::vector<higher_order::PassedJoint>& loop : walks.loops) {
    out.emplace_back(higher_order::twist_series(line, loop, x, line.degree()).rightCols(K));
    factorial = 1;
    for (Eigen::Index k = 1; k < K; ++k) {
      factorial *= static_cast<double>(k);
      out.back().col(k) *= factorial;
    }
  }
  return out;
}

}  // namespace axode
