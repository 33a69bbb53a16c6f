#pragma once
#include "axode/fast/any_joint.hpp"
#include "axode/fast/joint_angles.hpp"
#include "axode/fast/lanes.hpp"

namespace axode {

/// The geometry (layout of three-vectors) in which one state is computed fastest: packed vectors if T is
/// double or float and the processor has AVX2, plain vectors otherwise.
template <class T> struct FastGeometry { using type = Plain<T>; };
#if defined(__AVX2__)  // Without AVX2 no register holds four numbers, and packing costs more than it gains.
template <std::floating_point T> struct FastGeometry<T> { using type = Packed<T>; };
#endif

/// The constants of body i (pose of its joint and inertia) in the geometry G.
template <class G, class T, class S>
[[gnu::always_inline]] inline decltype(auto) constants(const Tree<S>& tree, int i) {
  if constexpr (std::same_as<G, Packed<S>>)
    return (tree.packed.body[i]);
  else
    return BodyConstants<G>(cast<T>(tree.B[i]), cast<T>(tree.M[i]));
}

/// The inertias of bodies i, i + 1, ..., one in each lane.
template <class T, class S>
[[gnu::always_inline]] inline Inertia<typename Lanes<T>::Number> inertias_in_lanes(const Tree<S>& tree,
                                                                                   int i) {
  const auto constant = [&](int k) {
    const S* const at = tree.inertia_arrays.data() + k * tree.inertia_stride + i;
    if constexpr (std::floating_point<T>)
      return Lanes<T>::load(at);
    else
      return T(*at);
  };
  return {constant(9),
          {constant(0), constant(1), constant(2)},
          {constant(3), constant(4), constant(5), constant(6), constant(7), constant(8)}};
}

/// Whether joint i is a hinge with a coordinate of its own (not coupled), as most joints of machines are.
template <class S> bool is_hinge(const Tree<S>& tree, int i) { return tree->hinges[i] > 0; }

/// A rotation R and a vector r that describe the pose of a body. R takes coordinates in the body frame to the
/// axes of a reference frame, and r is a vector to the origin of the body, in these axes. The function that
/// computes them says which reference frame it is and from which point r begins.
template <class G> struct Placed {
  typename G::Matrix R;
  typename G::Vector r;
};
/// The rotation of body i, and the vector from the origin of its predecessor to its own origin. Both are in
/// the axes in which the rotation R_p of the predecessor is given.
template <class G, class T, class S>
[[gnu::always_inline]] inline Placed<G> place(const Tree<S>& tree, int i, const T* q,
                                              const JointAngles<T>& angles,
                                              const typename G::Matrix& R_p) noexcept {
  using Spread = typename G::Spread;
  typename G::Matrix R;
  typename G::Vector r;
  if (is_hinge(tree, i)) [[likely]] {
    const auto& body = constants<G, T>(tree, i);
    R = body.columns(angles.sine[i - 1], angles.cosine[i - 1]);
    r = R_p * Spread(body.r);
  } else if (tree->kind[i] == Subgroup::prismatic && !tree->coupled[i]) {
    const auto& body = constants<G, T>(tree, i);
    R = typename G::Matrix(body.B);
    r = R_p * Spread(typename G::Vector(body.r) + q[tree->iq[i]] * R.z);
  } else {
    const SE3<T> C = any_joint_pose(tree, i, q);
    R = typename G::Matrix(C.R);
    r = R_p * Spread(typename G::Vector(C.r));
  }
  return {{R_p * Spread(R.x), R_p * Spread(R.y), R_p * Spread(R.z)}, r};
}

/// Computes the poses of the internal frames (joint frames) of all bodies, and calls put(i, (R, r)) with the
/// rotation R and the position r of each body i. With From::inertial_frame, both are relative to the inertial
/// frame. With From::root, R is relative to the inertial frame, and r is the vector from the origin of the
/// root body (the first body on the path from the ground) in inertial axes. With From::root_axes, both are
/// relative to the frame of the root body. It takes 51 products and sums for a hinge.
template <class T, class G = typename FastGeometry<T>::type> struct FastPoses {
  enum class From { inertial_frame, root, root_axes };
  JointAngles<T> angles;
  Placed<G>* branch;

  explicit FastPoses(Arena& arena) : angles(arena), branch(arena.per_body<Placed<G>>()) {}

  /// Computes the poses at q and calls put() for bodies 1 to n, in this order.
  template <From from = From::inertial_frame, class S, class Put>
  [[gnu::always_inline]] void run(const Tree<S>& tree, const T* q, Put&& put) noexcept {
    angles.run(tree, q);
    const Placed<G> origin{typename G::Matrix(SO3<T>{}), typename G::Vector{}};
    Placed<G> last = branch[0] = origin;
    for (int i = 1; i <= tree->n; ++i) {
      const int p = tree->parent[i];
      if (p != i - 1) last = branch[p];
      if (from == From::root_axes && p == 0) {
        last = origin;
      } else {
        const Placed<G> next = place<G>(tree, i, q, angles, last.R);
        last.R = next.R;
        last.r = from == From::root && p == 0 ? typename G::Vector{} : last.r + next.r;
      }
      put(i, last);
      if (tree->branches[i]) branch[i] = last;
    }
  }
};
template <class T, class G> SE3<T> pose(const Placed<G>& at) { return {{at.R.x, at.R.y, at.R.z}, at.r}; }

}  // namespace axode
