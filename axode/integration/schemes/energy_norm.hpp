#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "axode/model/tree.hpp"

namespace axode {

/// A norm of velocities whose units differ (rad/s, m/s): |v| = √Σ m_c v_c², where m_c is a bound on the
/// inertia M_cc of velocity c, so that v_c counts by its energy. For momenta and forces the dual norm is |p|
/// = √Σ p_c²/m_c, by which |M v| has the size of |v|. Velocities without inertia are ignored.
class EnergyNorm {
 public:
  using Vector = Eigen::VectorXd;
  using Argument = Eigen::Ref<const Vector>;

  /// Constructs the norm from the bounds m_c of the inertias, one for each velocity.
  explicit EnergyNorm(const Vector& inertia)
      : root_(inertia.cwiseSqrt()),
        inverse_root_((root_.array() > 0).select(root_.cwiseInverse(), Vector::Zero(root_.size()))) {}
  /// Constructs the norm with the bounds m_c of the inertias of a tree.
  explicit EnergyNorm(const Tree<double>& tree) : EnergyNorm(inertia_of(tree)) {}

  double of_velocities(const Argument& v) const { return length(root_.cwiseProduct(v)); }
  double of_forces(const Argument& p) const { return length(inverse_root_.cwiseProduct(p)); }
  /// The norm of q as a displacement: each angle counts as one radian, and each length is that in q.
  double of_places(const Tree<double>& tree, const Argument& q) const {
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
  /// The weights √m_c of the velocities.
  const Vector& weights() const { return root_; }
  /// The value that velocity c must have so that the norm is `size` if all other velocities are 0. A velocity
  /// without inertia is treated like the one with the largest inertia.
  double alone(Eigen::Index c, double size) const {
    return size / (root_[c] > 0 ? root_[c] : root_.maxCoeff());
  }
  /// A small change of velocity c, now v_c, for difference quotients. `size` is the norm of all velocities.
  double increment(Eigen::Index c, double v_c, double size) const {
    return 1e-7 * std::max(std::abs(v_c), alone(c, size));
  }

 private:
  /// The Euclidean norm, also if the squares of its entries overflow.
  static double length(const auto& x) {
    const double norm = x.norm();
    return std::isfinite(norm) ? norm : x.stableNorm();
  }
  static Vector inertia_of(const Tree<double>& tree) {
    Vector m = Vector::Zero(tree->nv);
    for (int i = 1; i <= tree->n; ++i)
      for (int s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s)
        m[tree->iv[i] + s - tree->first_screw[i]] += std::pow(tree.ratio[i], 2) * tree.inertia_scale[s];
    return m;
  }

  Vector root_, inverse_root_;
};

}  // namespace axode
