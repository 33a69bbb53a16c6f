#pragma once
#include <span>
#include <string_view>

#include "axode/model/model.hpp"

/// New models from old ones, which never change. All build leniently: what no matter can have is a warning of the new
/// model, as estimates and the files of real robots have it. Cylindrical and universal joints become their chains of two.
/// See also ModelBuilder(model), and `reduced`, in axode/model/builder.hpp.
namespace axode {

/// The same mechanism with other inertial parameters (axode/model/inertial_parameters.hpp), 10 n_bodies numbers, so
/// that Y pi with the regressor Y are its drive forces. What is fixed to a moving body stays as a massless frame: its
/// inertia is part of that body's parameters. Throws std::invalid_argument for a wrong size and for a body with a moment
/// but no mass, ModelError for numbers that are not finite and for negative masses.
Model with_parameters(const Model& model, std::span<const double> pi);

/// The same mechanism in another gravity, m/s² in the construction frame. Throws ModelError where it is not finite.
Model with_gravity(const Model& model, const Vec3<>& g);

/// The same mechanism with a body of inertia M, given in a frame of the model, fixed to that frame; `name` becomes a
/// frame, too. Throws std::invalid_argument for an unknown frame, ModelError for a name that is taken and for an inertia
/// that no matter can have.
Model with_payload(const Model& model, std::string_view frame, const Inertia<>& M,
                   std::string_view name = "payload");

/// The mechanism with another one mounted on one of its frames, which takes the place of the other's ground; a hand on
/// the flange of an arm. The prefix goes before all names of bodies, joints, frames and loops of the other one, whose gravity
/// does not matter. Bodies are numbered depth-first as ever, so the other's coordinates need not be the last ones.
///
/// If a joint is given that is not fixed, the other's ground moves on the frame by it: it is a massless body `<joint>.base`, which
/// coincides with the frame with the joint at zero. Axis and point are given in the frame; a joint without a name is called
/// `<prefix>mount`, and its coupling names a joint of the first mechanism.
///
/// Throws std::invalid_argument for an unknown frame, and that lists the names which both have; ModelError for a joint that is
/// described wrongly or whose names are taken.
Model append(const Model& model, std::string_view frame, const Model& other, std::string_view prefix = "",
             const JointDescription& joint = {});

/// Returns the same mechanism with another body as its root: the body takes the place of the root of its
/// tree, on the ground by a joint of the same name and kind (fixed or free), and the joints between the two
/// are passed the other way round. All bodies, frames, loops and springs keep their names, and with all
/// joints at zero all bodies are where they were drawn.
///
/// A joint of one velocity keeps its q, v, a and τ, limits, losses and couplings. A spherical, planar or free joint on the path has
/// the inverse displacement: C' = C⁻¹ between its joint frames, v' = -Ad_C v, and τ = -Ad_Cᵀ τ'. A free root has the pose and twist
/// of the body. joint_state() (axode/constraints/joint_state.hpp) of all poses and twists of a state is that state in the new
/// coordinates. If the root is free and its joint has no drive force, the motion is the same; if it is fixed, the new root is held in
/// the place of the old one.
///
/// Throws std::invalid_argument for an unknown body, for a root on any other joint, and for limits, losses, springs and armatures of
/// joints with several velocities on the path, which act along axes of the body that is moved.
Model rerooted(const Model& model, std::string_view body);

}  // namespace axode
