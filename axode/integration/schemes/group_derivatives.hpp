#pragma once
#include <Eigen/Core>
#include <type_traits>
#include <vector>

#include "axode/lie/twist.hpp"
#include "axode/model/tree.hpp"
#include "axode/recursion/changes.hpp"

namespace axode {

/// Derivatives of two maps on the configurations of a tree. If q is displaced by η and x changes by δx, then
/// q ⊕ x is displaced by Ad_{exp(-x)} η + dexp_{-x} δx. If x changes by δx and y by δy, then dexp⁻¹_{-x} y,
/// the rate of x for the velocity y, changes by dexp⁻¹_{-x} δy + (D dexp⁻¹_{-x} y) δx.
class GroupDerivatives {
 public:
  using Matrix = Eigen::MatrixXd;
  using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;

  /// The four maps of a joint of several velocities; or a range of joints of one velocity, without matrices.
  struct Joints {
    int body;  ///< 0 for a range of joints of one velocity
    Eigen::Index first, n;
    Block carry{}, velocity{};  ///< Ad_{exp(-x)} of η, and dexp_{-x} of δx
    Block rate{}, turn{};       ///< dexp⁻¹_{-x} of δy, and D dexp⁻¹_{-x} y of δx
  };

  explicit GroupDerivatives(const Tree<double>& tree);

  /// Computes the maps of all joints at a displacement x and a velocity y (nv numbers each).
  void at(const double* x, const double* y) noexcept;

  /// Products with a map, such as dexp_{-x}, that has been computed for all joints at a displacement x. add()
  /// adds the product of the map and z to `out`, and add_transposed() the product of the transposed map and
  /// z. z and `out` have nv rows and one or more columns.
  template <class M> void add(Block Joints::*map, const M& z, M& out) const {
    add_to(map, z, out, [](const Block& block) -> const Block& { return block; });
  }
  template <class M> void add_transposed(Block Joints::*map, const M& z, M& out) const {
    add_to(map, z, out, [](const Block& block) { return block.transpose(); });
  }

 private:
  template <class Joint>
  static void take(const Joint& joint, const double* x, const double* y, Joints& to) noexcept;
  template <class M, class F> void add_to(Block Joints::*map, const M& z, M& out, const F& f) const {
    for (const Joints& joints : joints_) {
      const auto own = [&](auto& x) { return x.middleRows(joints.first, joints.n); };
      if (joints.body == 0) {
        if (map != &Joints::turn) own(out) += own(z);
      } else if constexpr (std::is_same_v<M, Changes>) {
        add_product(f(joints.*map), own(z), own(out));
      } else {
        own(out).noalias() += f(joints.*map) * own(z);
      }
    }
  }

  const Tree<double>* tree_;
  std::vector<Joints> joints_;
};

}  // namespace axode
