#pragma once
#include <cstddef>

#include "axode/model/tree.hpp"
#include "axode/recursion/link.hpp"

namespace axode {

/// Adds -ad_v of every joint to its diagonal block of a matrix, whose rows have `width` numbers. ad_v is the
/// Lie bracket with the velocities v of the joint in its subgroup: with the joint screws S, column k of ad_v
/// is [S v, S e_k] in the coordinates of the joint.
template <class T> void subtract_ad(const Tree<T>& tree, const T* v, std::ptrdiff_t width, T* rows) {
  each_joint(tree, [&](const auto& joint, int i, bool coupled) {
    if (coupled) return;
    const std::ptrdiff_t first = tree->iv[i];
    const Twist<BodyFixed, T> V = joint.twist(v + first);
    for (int k = 0; k < joint.nv; ++k) {
      const Screw<T> X = ad(joint.column(k), Screw<T>{V.w, V.v});
      for (int l = 0; l < joint.nv; ++l) {
        const Screw<T> S = joint.column(l);
        rows[(first + l) * width + first + k] += dot(S.w, X.w) + dot(S.v, X.v);
      }
    }
  });
}

}  // namespace axode
