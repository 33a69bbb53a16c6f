#include "axode/constraints/prescribed/singularity.hpp"

#include <cmath>

#include "axode/constraints/loop_system/independent_rows.hpp"
#include "axode/constraints/vector_text.hpp"
#include "axode/model/configuration.hpp"
#include "axode/recursion/decompositions.hpp"

namespace axode {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// A singularity is nearby if the least singular value is smaller than this fraction of the largest one.
constexpr double near = 0.05;

}  // namespace

std::string nearby_singularity(MotionRows& motions, LoopSystem<double>& system, std::span<const double> q,
                               double t) {
  const Eigen::Index nv = motions.model().nv();
  motions.impose(t, system);
  system.update_kinematics(q.data());
  const std::vector<int> chosen = IndependentRows<double>(system, ConstraintLevel::velocity).independent;
  LoopSystem<double>::RowByRow all(motions.model().loops().rows, nv);
  system.make_rows(ConstraintLevel::velocity);
  system.write(all.data());
  Matrix A = all(chosen, Eigen::indexing::all);
  if (chosen.empty()) return {};
  for (std::size_t k = 0; k < chosen.size(); ++k)
    A.row(static_cast<Eigen::Index>(k)) /= system.scale()[chosen[k]];
  const SymmetricEigen squares = symmetric_eigen(A * A.transpose());
  const double least = std::sqrt(std::max(0.0, squares.values[0])),
               most = std::sqrt(squares.values[squares.values.size() - 1]);
  if (!(least < near * most)) return {};
  const Vector n = squares.vectors.col(0), x = A.transpose() * n;
  std::vector<std::string> moved, moving;
  double rate = 0, rates = 0;  // n·s' and the sum of its terms' absolute values
  for (const MotionRows::Row& row : motions.rows()) {
    const auto at = std::find(chosen.begin(), chosen.end(), row.place.row);
    if (at == chosen.end()) continue;
    const double n_k = n[at - chosen.begin()], ds = row.function(t).ds;
    rate += n_k * ds;
    rates += std::abs(n_k * ds);
    if (std::abs(n_k) > considerable * n.cwiseAbs().maxCoeff()) moved.push_back(row.of);
  }
  if (moved.empty()) return {};
  const std::vector<std::string> names = velocity_names(motions.model());
  for (Eigen::Index c = 0; c < nv; ++c)
    if (std::abs(x[c]) > considerable * x.cwiseAbs().maxCoeff())
      moving.push_back(names[static_cast<std::size_t>(c)]);
  const bool fold = std::abs(rate) > 1e-3 * rates;
  return "near a singularity at which the " + std::string(moved.size() == 1 ? "motion of " : "motions of ") +
         listed(moved) +
         (fold ? " would need speeds and forces without bound" : " would need forces without bound") +
         ", and " + listed(moving) + " would move without " + (moved.size() == 1 ? "it" : "them");
}

}  // namespace axode
