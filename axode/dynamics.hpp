#pragma once
#include "axode/dynamics/coriolis.hpp"
#include "axode/dynamics/energy.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/dynamics/mass_matrix.hpp"
#include "axode/dynamics/momentum.hpp"
#include "axode/dynamics/regressor.hpp"
#include "axode/kinematics.hpp"

/// Forces from motion. Conventions as in axode/kinematics.hpp: T is the scalar of the workspace, Rep the
/// representation in which the recursion runs; all four give the same generalised forces.
namespace axode {

/// τ = M(q) a + C(q, v) v + g(q) - (applied forces): the drive forces that make the accelerations a, by the
/// recursive Newton-Euler algorithm (sections 4.1 to 4.3, eqs. aVbRec2 to cWhRec with erratum 22). tau has nv
/// entries, N m or N. Armature is part of it; damping and friction only where loads.joint_losses asks. O(n),
/// no allocation. Throws std::invalid_argument for a wrong size, a quaternion off 1 or a load on a frame that
/// does not exist.
template <class Rep = Fast, class T>
void inverse_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                      std::type_identity_t<std::span<T>> tau,
                      const std::type_identity_t<Loads<T>>& loads = {});

/// The wrench that each joint transmits from the predecessor to the body, all six components: drive and
/// reaction. W has n_bodies entries; W[i - 1] belongs to joint i, in the representation Rep of body i's
/// frame. Otherwise as inverse_dynamics.
template <class Rep = BodyFixed, class T>
void joint_wrenches(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                    std::type_identity_t<std::span<Wrench<Rep, T>>> W,
                    const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
