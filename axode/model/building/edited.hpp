#pragma once
#include <span>
#include <string_view>

#include "axode/model/model.hpp"

/// Functions that make a new model from another one, which does not change. An inertia that no mass
/// distribution has is only a warning of the new model. Cylindrical and universal joints become chains of two
/// joints.
namespace axode {

/// The mechanism with other inertial parameters π: 10 n_bodies numbers, see
/// axode/model/inertial_parameters.hpp. Y π, with the regressor Y, are the forces M a + C v + g of the new
/// model without armatures. A body that is fixed to a moving body remains as a frame; its inertia is part of
/// the parameters of the moving body. Throws std::invalid_argument for a wrong number of parameters and for a
/// body with a first moment of mass but the mass 0, and ModelError for numbers that are not finite and for
/// negative masses.
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
/// If `joint` is not a fixed joint, it connects the frame to the ground of `other`, which becomes a massless
/// body `<joint>.base` and coincides with the frame when the joint is at zero. Axis and point of the joint
/// are given in the frame. A joint without a name is called `<prefix>mount`.
///
/// Throws std::invalid_argument for an unknown frame, and for names that both mechanisms have, which the
/// message lists. Throws ModelError if the joint has faults or its names are taken.
Model append(const Model& model, std::string_view frame, const Model& other, std::string_view prefix = "",
             const JointDescription& joint = {});

/// The mechanism with another body as its root body, which is the body that is joined to the ground. The new
/// root body gets a joint on the ground with the name and kind (fixed or free) of the joint of the old root
/// body, and the joints on the path between the two bodies are reversed. All bodies, frames, loops and
/// springs keep their names, and with all joints at zero all bodies have the same poses as before.
///
/// A reversed joint of one velocity keeps its q, v, a and τ, limits, losses and couplings. For a reversed
/// spherical, planar or free joint, the pose C of its second joint frame in its first one becomes C' = C⁻¹,
/// its velocity v becomes v' = -Ad_C v, and the new forces τ' follow from τ = -Ad_Cᵀ τ'. If the joint on the
/// ground is free, its coordinates and velocities are the pose and twist of the new root body. The initial
/// state of joints whose coordinates change is left out with a warning. If the joint on the ground is free
/// and has no drive force, the mechanism moves as before; if it is fixed, the new root body is held instead
/// of the old one.
///
/// Throws std::invalid_argument for an unknown body, and for an old root body whose joint is neither fixed
/// nor free. Also throws std::invalid_argument if a joint of several velocities on the path or at the old
/// root body has limits, losses, springs or armatures, because these act along axes of the body that the
/// joint moves. Springs, damping and armatures of a spherical joint that are equal about all axes are
/// allowed.
Model rerooted(const Model& model, std::string_view body);

}  // namespace axode
