#include "axode/integration/schemes/energy_norm.hpp"

namespace axode {
namespace {

using Eigen::VectorXd;

/// The Euclidean norm of the weighted numbers x, also if the squares of its entries overflow.
double length_of(const VectorXd& weights, const EnergyNorm::Argument& x) {
  const auto weighted = weights.cwiseProduct(x);
  const double norm = weighted.norm();
  return std::isfinite(norm) ? norm : weighted.stableNorm();
}

VectorXd inertia_of(const Tree<double>& tree) {
  VectorXd m = VectorXd::Zero(tree->nv);
  for (int i = 1; i <= tree->n; ++i)
    for (int s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s)
      m[tree->iv[i] + s - tree->first_screw[i]] += std::pow(tree.ratio[i], 2) * tree.inertia_scale[s];
  return m;
}

}  // namespace

EnergyNorm::EnergyNorm(const VectorXd& inertia)
    : root_(inertia.cwiseSqrt()),
      inverse_root_((root_.array() > 0).select(root_.cwiseInverse(), VectorXd::Zero(root_.size()))) {}

EnergyNorm::EnergyNorm(const Tree<double>& tree) : EnergyNorm(inertia_of(tree)) {}

double EnergyNorm::of_velocities(const Argument& v) const { return length_of(root_, v); }
double EnergyNorm::of_forces(const Argument& p) const { return length_of(inverse_root_, p); }

double EnergyNorm::of_places(const Tree<double>& tree, const Argument& q) const {
  double squares = 0;
  for (int i = 1; i <= tree->n; ++i) {
    if (tree->coupled[i]) continue;
    with_joint(tree, i, [&]<class Joint>(const Joint& joint) {
      for (int k = 0; k < Joint::nv; ++k) {
        const double x = k < joint.angles ? 1 : q[tree->iq[i] + Joint::nq - Joint::nv + k];
        squares += std::pow(root_[tree->iv[i] + k] * x, 2);
      }
    });
  }
  return std::sqrt(squares);
}

}  // namespace axode
