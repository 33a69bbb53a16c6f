#include "axode/integration/schemes/group_derivatives.hpp"

namespace axode {

GroupDerivatives::GroupDerivatives(const Tree<double>& tree) : tree_(&tree) {
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

template <class Joint>
void GroupDerivatives::take(const Joint& joint, const double* x, const double* y, Joints& to) noexcept {
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

void GroupDerivatives::at(const double* x, const double* y) noexcept {
  for (Joints& joints : joints_)
    if (const int i = joints.body; i > 0)
      with_subgroup((*tree_)->kind[i], tree_->pitch[i], [&]<class Joint>(const Joint& joint) {
        if constexpr (Joint::nv > 1) take(joint, x + joints.first, y + joints.first, joints);
      });
}

}  // namespace axode
