#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/lie/twist.hpp"
#include "axode/model/tree.hpp"

namespace axode {

/// Derivatives of two maps on the configurations of a tree. If q is displaced by η and x changes by δx, then
/// q ⊕ x is displaced by Ad_{exp(-x)} η + dexp_{-x} δx. If x changes by δx and y by δy, then dexp⁻¹_{-x} y,
/// the rate of x for the velocity y, changes by dexp⁻¹_{-x} δy + (D dexp⁻¹_{-x} y) δx.
class GroupDerivatives {
 public:
  using Matrix = Eigen::MatrixXd;  ///< matrix with a row for each velocity
  using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;

  /// The four maps of a joint of several velocities; or a range of joints of one velocity, without matrices.
  struct Joints {
    int body;  ///< 0 for a range of joints of one velocity
    Eigen::Index first, n;
    Block carry{}, velocity{};  ///< Ad_{exp(-x)} of η, and dexp_{-x} of δx
    Block rate{}, turn{};       ///< dexp⁻¹_{-x} of δy, and D dexp⁻¹_{-x} y of δx
  };

  explicit GroupDerivatives(const Tree<double>& tree) : tree_(&tree) {
    for (int i = 1; i <= tree->n; ++i) {
      if (tree->coupled[i]) continue;
      const int n = tree->first_screw[i + 1] - tree->first_screw[i];
      if (n > 1) {
        const Block block(n, n);
        joints_.push_back({i, tree->iv[i], n, block, block, block, block});
      } else if (!joints_.empty() && joints_.back().body == 0) {
        ++joints_.back().n;
      } else {
        joints_.push_back({.body = 0, .first = tree->iv[i], .n = 1});
      }
    }
  }

  /// Computes the maps of all joints at a displacement x and a velocity y (nv numbers each).
  void at(const double* x, const double* y) noexcept {
    for (Joints& joints : joints_)
      if (const int i = joints.body; i > 0)
        with_subgroup((*tree_)->kind[i], tree_->pitch[i], [&]<class Joint>(const Joint& joint) {
          if constexpr (Joint::nv > 1) take(joint, x + joints.first, y + joints.first, joints);
        });
  }

  /// Products with a map, such as dexp_{-x}, that has been computed for all joints at a displacement x. add()
  /// adds the product of the map and z to `out`, and add_transposed() the product of the transposed map and
  /// z. z and `out` have nv rows and one or more columns.
  void add(Block Joints::*map, const Matrix& z, Matrix& out) const {
    add_to(map, z, out, [](const Block& block) -> const Block& { return block; });
  }
  void add_transposed(Block Joints::*map, const Matrix& z, Matrix& out) const {
    add_to(map, z, out, [](const Block& block) { return block.transpose(); });
  }

 private:
  template <class Joint>
  static void take(const Joint& joint, const double* x, const double* y, Joints& to) noexcept {
    const Twist<BodyFixed> x_twist = joint.twist(x), y_twist = joint.twist(y);
    const Screw<> X{x_twist.w, x_twist.v}, Y{y_twist.w, y_twist.v};
    const double s = dot(X.w, X.w);
    const ScrewOperator<double> dexp = dexp_operator(s), dexp_inv = dexp_inv_operator(s);
    for (int c = 0; c < joint.nv; ++c) {
      const Screw<> S = joint.column(c), moved = apply(dexp, -X, S);
      const auto write = [&](Block& block, const Screw<>& Z) {
        const auto z = joint.project(Wrench<BodyFixed>{Z.w, Z.v});
        for (int r = 0; r < joint.nv; ++r) block(r, c) = z[static_cast<std::size_t>(r)];
      };
      write(to.velocity, moved);
      write(to.carry, S - ad(X, moved));  // Ad_{exp(-X)} = 1 - ad_X dexp_{-X}
      write(to.rate, apply(dexp_inv, -X, S));
      write(to.turn, apply(dexp_inv, -X, -S, Y));
    }
  }
  template <class F> void add_to(Block Joints::*map, const Matrix& z, Matrix& out, const F& f) const {
    for (const Joints& joints : joints_) {
      if (joints.body > 0)
        out.middleRows(joints.first, joints.n).noalias() +=
            f(joints.*map) * z.middleRows(joints.first, joints.n);
      else if (map != &Joints::turn)
        out.middleRows(joints.first, joints.n) += z.middleRows(joints.first, joints.n);
    }
  }

  const Tree<double>* tree_;
  std::vector<Joints> joints_;
};

}  // namespace axode
