#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "axode/model/tree.hpp"

namespace axode {

/// A norm of velocities whose units differ (rad/s, m/s): |v| = √Σ m_c v_c². The constant m_c estimates the
/// diagonal entry M_cc of the mass matrix M, so that v_c counts by its kinetic energy. For momenta and forces
/// the dual norm is |p| = √Σ p_c²/m_c, by which |M v| has the size of |v|. Velocities with m_c = 0 are
/// ignored.
class EnergyNorm {
 public:
  using Vector = Eigen::VectorXd;
  using Argument = Eigen::Ref<const Vector>;

  /// Constructs the norm from the inertias m_c, one for each velocity, kg m² or kg.
  explicit EnergyNorm(const Vector& inertia);
  /// Constructs the norm √Σ m_c v_c² of the velocities v of a tree. The weight m_c is an upper bound of the
  /// diagonal entry M_cc of the mass matrix at q = 0. For a velocity that coupled joints share, m_c is the
  /// sum of the bounds of these joints, each times the squared ratio of its joint.
  explicit EnergyNorm(const Tree<double>& tree);

  double of_velocities(const Argument& v) const;
  double of_forces(const Argument& p) const;
  /// The norm of q as a displacement: each angle counts as one radian, and each length is that in q.
  double of_places(const Tree<double>& tree, const Argument& q) const;
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
  Vector root_, inverse_root_;
};

}  // namespace axode
