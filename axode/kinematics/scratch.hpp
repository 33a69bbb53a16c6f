#pragma once
#include "axode/fast/packed_store.hpp"
#include "axode/recursion/forward_kinematics.hpp"

/// Scratch memory of the functions in kinematics/, in addition to the memory of the recursions.
namespace axode {

/// Computes the poses of all bodies, and from them the poses of frames that are fixed to the bodies.
template <class T> struct FramePoses {
  using G = typename FastGeometry<T>::type;
  FastPoses<T> poses;
  Placed<G>* body;

  explicit FramePoses(Arena& arena) : poses(arena), body(arena.per_body<Placed<G>>()) {}

  void run(const Tree<T>& tree, const T* q) noexcept {
    body[0] = {typename G::Matrix(SO3<T>{}), typename G::Vector{}};
    poses.run(tree, q, [&](int i, const Placed<G>& at) { body[i] = at; });
  }
  /// The pose C_i F of a frame that has pose F in the internal frame of body i.
  Placed<G> operator()(int i, const SE3<T>& F) const noexcept {
    using Spread = typename G::Spread;
    const Placed<G>& C = body[i];
    return {{C.R * Spread(F.R.x), C.R * Spread(F.R.y), C.R * Spread(F.R.z)}, C.r + C.R * Spread(F.r)};
  }
};

/// Memory for the poses C and twists V of the bodies, the inertias M of their subtrees, and the time
/// derivatives dM of these inertias. All are in inertial axes. Their reference point is fixed in space, at
/// the present position of the centre of mass of the whole system.
template <class T> struct SubtreeInertias {
  BodyPoses<T> C;
  Inertia<T>*M, *dM;
  Twist<Spatial, T>* V;
  explicit SubtreeInertias(Arena& arena)
      : C(arena),
        M(arena.per_body<Inertia<T>>()),
        dM(arena.per_body<Inertia<T>>()),
        V(arena.per_body<Twist<Spatial, T>>()) {}
};

}  // namespace axode
