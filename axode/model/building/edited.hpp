#pragma once
#include <span>
#include <string_view>

#include "axode/model/model.hpp"

/// New models made from other ones, which never change. All are built leniently: inertias that no mass
/// distribution has are warnings of the new model, because estimates and files of real robots have them.
/// Cylindrical and universal joints become chains of two joints. See also ModelBuilder(model) and `reduced`
/// in axode/model/building/builder.hpp.
namespace axode {

/// The mechanism with other inertial parameters π (axode/model/inertial_parameters.hpp), 10 n_bodies numbers.
/// The drive forces of the new model are Y π with the regressor Y. Bodies that are fixed to a moving body
/// stay as massless frames, as their inertia is part of the parameters of that body. Throws
/// std::invalid_argument for a wrong size and for a body with a moment but no mass, ModelError for numbers
/// that are not finite and for negative masses.
Model with_parameters(const Model& model, std::span<const double> pi);

/// The mechanism in another gravity, m/s² in the construction frame. Throws ModelError if it is not finite.
Model with_gravity(const Model& model, const Vec3<>& g);

/// The mechanism with a body of inertia M, given in a frame of the model, fixed to that frame; `name` becomes
/// a frame as well. Throws std::invalid_argument for an unknown frame, ModelError for a name that is taken
/// and for an inertia that no mass distribution has.
Model with_payload(const Model& model, std::string_view frame, const Inertia<>& M,
                   std::string_view name = "payload");

/// The mechanism with another one mounted on one of its frames, such as a hand on the flange of an arm. The
/// frame replaces the ground of the other mechanism, and the gravity of the other one is not used. The prefix
/// is put before all names of bodies, joints, frames, loops and motions of the other one. Bodies are numbered
/// depth-first, so that the coordinates of the other one need not be the last ones.
///
/// If a joint other than a fixed one is given, the ground of the other mechanism moves on the frame by this
/// joint. It becomes a massless body `<joint>.base`, which coincides with the frame at zero of the joint.
/// Axis and point are given in the frame. A joint without a name is called `<prefix>mount`; its coupling
/// names a joint of the first mechanism.
///
/// Throws std::invalid_argument for an unknown frame, and for names that both mechanisms have, which it
/// lists; ModelError for a joint that is described wrongly or whose names are taken.
Model append(const Model& model, std::string_view frame, const Model& other, std::string_view prefix = "",
             const JointDescription& joint = {});

/// The mechanism with another body as its root. The body hangs on the ground by a joint with the name and
/// kind (fixed or free) of the joint of the old root, and the joints between the two bodies are reversed. All
/// bodies, frames, loops and springs keep their names, and with all joints at zero all bodies are where they
/// were drawn.
///
/// A joint of one velocity keeps its q, v, a and τ, limits, losses and couplings. A spherical, planar or free
/// joint on the path has the inverse displacement: C' = C⁻¹ between its joint frames, v' = -Ad_C v, and τ =
/// -Ad_Cᵀ τ'. A free root has the pose and twist of the body. joint_state()
/// (axode/constraints/absolute/joint_state.hpp) converts the poses and twists of a state into the new
/// coordinates; the initial state of such joints is left out with a warning. If the root is free and its
/// joint has no drive force, the motion is the same; if it is fixed, the new root is held instead of the old
/// one.
///
/// Throws std::invalid_argument for an unknown body, for a root on any other joint, and for limits, losses,
/// springs and armatures of joints with several velocities on the path, because these act along axes of the
/// body that is moved.
Model rerooted(const Model& model, std::string_view body);

}  // namespace axode
