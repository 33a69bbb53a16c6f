#pragma once
#include "axode/fast/inverse_dynamics.hpp"
#include "axode/lie/six.hpp"
#include "axode/recursion/articulated_bodies.hpp"
#include "axode/recursion/forward_dynamics.hpp"
#include "axode/recursion/inverse_dynamics.hpp"
#include "axode/recursion/spatial_tree.hpp"

/// Scratch memory of the functions in this folder, in addition to that of the recursions.
namespace axode {

/// Bias forces: inverse dynamics with zero accelerations, C v + g - Q.
template <class Rep, class T> struct BiasForces {
  InverseDynamicsRecursion<Rep, T> recursion;
  T* zero;

  explicit BiasForces(Arena& arena) : recursion(arena), zero(arena.per_velocity<T>()) {}

  /// Computes the bias forces `tau` (nv) at velocities v under gravity g and the loads, with damping and
  /// friction at the velocities v_losses if loads.joint_losses is set. A null v or v_losses is 0.
  void run(const Tree<T>& tree, const T* q, const T* v, const T* v_losses, const Loads<T>& loads,
           const Vec3<T>& g, T* tau) noexcept {
    for (int c = 0; c < tree->nv; ++c) zero[c] = T(0);
    recursion.run(tree, q, v ? v : zero, zero, loads, g);
    recursion.project(tree, v_losses ? v_losses : zero, zero, loads.joint_losses, tau);
  }
};

/// Scratch memory for the response M⁻¹ Jᵀ of a frame with the Jacobian J to impulses.
template <class Rep, class T> struct FrameResponse {
  ArticulatedBodies<Rep, T> bodies;
  Twist<Rep, T>*J, *Y;
  T* x;

  explicit FrameResponse(Arena& arena)
      : bodies(arena),
        J(arena.per_velocity<Twist<Rep, T>>()),
        Y(arena.per_velocity<Twist<Rep, T>>()),
        x(arena.per_velocity<T>()) {}
};

/// Scratch memory for momenta of a tree: joint screws and inertias in spatial representation, twists of the
/// bodies and momenta of their subtrees, and one number for each velocity.
template <class T> struct MovingMass {
  SpatialTree<T> spatial;
  SubtreeMomenta<T> momenta;
  T* own;

  explicit MovingMass(Arena& arena) : spatial(arena), momenta(arena), own(arena.per_velocity<T>()) {}
  MovingMass(Arena& arena, const Tree<T>& tree, const T* q, const T* v) noexcept : MovingMass(arena) {
    spatial.run(tree, q);
    momenta.run(spatial, v);
  }
};

/// Scratch memory for the equations of motion in the state (q, V) with the twists V of all bodies: velocities
/// and accelerations of the joints, and accelerations of the bodies.
template <class Rep, class T> struct StateForm {
  BodyPoses<T> C;
  Twist<Spatial, T>* V_s;
  ForwardDynamicsRecursion<Rep, T> dynamics;
  TreeMotion<Rep, T> motion;
  T *v, *a;

  explicit StateForm(Arena& arena)
      : C(arena),
        V_s(arena.per_body<Twist<Spatial, T>>()),
        dynamics(arena),
        motion(arena),
        v(arena.per_velocity<T>()),
        a(arena.per_velocity<T>()) {}
};

/// Scratch memory for the poses and the body-fixed motion of all bodies.
template <class T> struct PosesAndMotion {
  BodyPoses<T> C;
  TreeMotion<BodyFixed, T> motion;

  explicit PosesAndMotion(Arena& arena) : C(arena), motion(arena) {}
};

/// Scratch memory for a Coriolis matrix C = Jᵀ (M J' + B J): the joint screws, and for each body its inertia,
/// its twist and its block of B. J and M are the spatial Jacobian and the spatial inertia of all bodies, and
/// J' is the time derivative of J. B is block diagonal, and depends on the form of C: the 6×6 block of body i
/// with the inertia M_i and the twist V_i maps a twist X to a wrench, for example to -ad_{V_i}ᵀ M_i X.
template <class T> struct CoriolisBodies {
  SpatialTree<T> spatial;
  Twist<Spatial, T>* V;
  TwistToWrench<Spatial, T>* B;

  explicit CoriolisBodies(Arena& arena)
      : spatial(arena),
        V(arena.per_body<Twist<Spatial, T>>()),
        B(arena.per_body<TwistToWrench<Spatial, T>>()) {}
};

}  // namespace axode
