#pragma once
#include "axode/fast/poses.hpp"
#include "axode/recursion/forward_kinematics.hpp"

/// What the functions of this floor take of a workspace, besides the recursions themselves.
namespace axode {

template <class T> struct FramePoses {
  SE3<T>* C;  ///< of the internal frames
  FastPoses<T> poses;
  explicit FramePoses(Arena& arena) : C(arena.per_body<SE3<T>>()), poses(arena) {}
};

/// Bodies and what is behind them, about the centre of mass of the whole.
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
