#pragma once
#include <span>
#include <string_view>

#include "axode/model/model.hpp"

/// Functions that make a new model from another one, which does not change. An inertia that no mass
/// distribution has is only a warning of the new model. Cylindrical and universal joints become chains of two
/// joints.
namespace axode {

/// The mechanism with other inertial parameters π: 10 n_bodies numbers, see
/// axode/model/inertial_parameters.hpp. The drive forces of the new model are Y π with the regressor Y.
/// Bodies that are fixed to a moving body remain as frames; their inertia is part of its parameters. Throws
/// std::invalid_argument for a wrong number of parameters and for a body with a first moment of mass but the
/// mass 0, and ModelError for numbers that are not finite and for negative masses.
Model with_parameters(const Model& model, std::span<const double> pi);

/// The mechanism with another gravity g, m/s² in inertial axes. Throws ModelError if g is not finite.
Model with_gravity(const Model& model, const Vec3<>& g);

/// The mechanism with an additional body that is fixed to a frame of the model. Its inertia M (mass, first
/// moment of mass, rotational inertia about the origin) is given in this frame. A frame `name` is added
/// there. Throws std::invalid_argument for an unknown frame, and ModelError for a name that is taken, a
/// negative mass, and numbers that are not finite.
Model with_payload(const Model& model, std::string_view frame, const Inertia<>& M,
                   std::string_view name = "payload");

/// The mechanism `model` with the mechanism `other` mounted on one of its frames, such as a hand on the
/// flange of an arm. The frame replaces the ground of `other`, and the gravity of `other` is not used. The
/// prefix is put before the names of all bodies, joints, frames, springs, loops, couplings, motions and
/// drives of `other`.
///
/// If `joint` is not a fixed joint, the ground of `other` moves on the frame by this joint. It becomes a
/// massless body `<joint>.base`, which coincides with the frame when the joint is at zero. Axis and point of
/// the joint are given in the frame. A joint without a name is called `<prefix>mount`.
///
/// Throws std::invalid_argument for an unknown frame, and for names that both mechanisms have, which the
/// message lists. Throws ModelError if the joint has faults or its names are taken.
Model append(const Model& model, std::string_view frame, const Model& other, std::string_view prefix = "",
             const JointDescription& joint = {});

/// The mechanism with another body as its root. The body becomes a child of the ground, with a joint that has
/// the name and kind (fixed or free) of the joint of the old root, and the joints on the path between the two
/// bodies are reversed. All bodies, frames, loops and springs keep their names, and with all joints at zero
/// all bodies are where they were drawn.
///
/// A joint of one velocity keeps its q, v, a and τ, limits, losses and couplings. For a spherical, planar or
/// free joint on the path, the pose C of its second joint frame in its first one is replaced by C' = C⁻¹.
/// Velocities and forces follow from v' = -Ad_C v and τ = -Ad_Cᵀ τ'. A free root has the pose and twist of
/// the new root body as coordinates and velocities. The initial state of joints whose coordinates change is
/// left out with a warning. If the root is free and its joint has no drive force, the motion is the same; if
/// it is fixed, the new root is held instead of the old one.
///
/// Throws std::invalid_argument for an unknown body, and for a root whose joint is neither fixed nor free.
/// Also throws std::invalid_argument if a joint with several velocities on the path has limits, losses,
/// springs or armatures, because these act along axes of the body that the joint moves; springs, damping and
/// armatures of a spherical joint that are equal about all axes are allowed.
Model rerooted(const Model& model, std::string_view body);

}  // namespace axode
