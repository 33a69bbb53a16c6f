#pragma once
#include <algorithm>
#include <array>
#include <string>
#include <string_view>

/// Words that other formats have for keys and values of a drawing (the TOML format of this library), such as
/// "link" for "body". Messages about unknown keys suggest the right word.
namespace axode::io {

struct ForeignTerm {
  std::string_view theirs, ours;  ///< a word of other formats, and the key, dotted key or value of a drawing
                                  ///< with the same meaning
};

// clang-format off
inline constexpr auto foreign_terms = std::to_array<ForeignTerm>({
    // keys of the file
    {"link", "body"}, {"links", "body"}, {"bodies", "body"}, {"joint", "body.joint"},
    {"joints", "body.joint"},
    {"site", "frame"}, {"sites", "frame"}, {"robot", "name"}, {"model", "name"}, {"g", "gravity"},
    {"constraint", "loop"}, {"constraints", "loop"}, {"loops", "loop"}, {"equality", "loop"},
    {"couplings", "coupling"}, {"gear", "coupling"},
    {"drives", "drive"}, {"motor", "drive"}, {"motors", "drive"}, {"actuator", "drive"},
    {"actuators", "drive"},
    {"motions", "motion"}, {"trajectory", "motion"}, {"joint", "of"}, {"rod", "of"},
    {"initial_state", "state"}, {"initial", "state"}, {"keyframe", "state"}, {"qpos", "q"}, {"qvel", "v"},
    // the body or frame on which something hangs
    {"parent", "on"}, {"parent_link", "on"}, {"predecessor", "on"}, {"base", "on"}, {"body", "on"},
    {"link", "on"},
    // positions and rotations of joints, frames and bodies
    {"origin", "point"}, {"xyz", "point"}, {"pos", "point"}, {"position", "point"}, {"anchor", "point"},
    {"centre", "center"}, {"center", "point"}, {"centre", "point"},
    {"origin", "position"}, {"xyz", "position"}, {"pos", "position"}, {"point", "position"},
    {"r", "position"},
    {"rotation_matrix", "rotation"}, {"R", "rotation"}, {"orientation", "rotation"}, {"quat", "quaternion"},
    {"euler", "rpy"},
    {"origin", "A"}, {"pose", "A"}, {"xyz", "A.position"}, {"pos", "A.position"}, {"position", "A.position"},
    {"rotation", "A.rotation"}, {"orientation", "A.rotation"}, {"quaternion", "A.quaternion"},
    {"quat", "A.quaternion"}, {"rpy", "A.rpy"}, {"euler", "A.rpy"},
    // keys of a body
    {"center_of_mass", "com"}, {"centre_of_mass", "com"}, {"cog", "com"}, {"ipos", "com"},
    {"moment_of_inertia", "inertia"}, {"rotational_inertia", "inertia"}, {"diaginertia", "inertia"},
    {"fullinertia", "inertia"}, {"visual", "shape"}, {"collision", "shape"}, {"geometry", "shape"},
    {"geom", "shape"}, {"shapes", "shape"}, {"filename", "file"}, {"uri", "file"}, {"rgba", "color"},
    {"colour", "color"}, {"half_size", "size"}, {"radii", "semi_axes"},
    // keys of a joint
    {"type", "kind"}, {"direction", "axis"}, {"normal", "axis"}, {"range", "limits"},
    {"lower", "limits"}, {"upper", "limits"}, {"max_velocity", "velocity"},
    {"velocity_limit", "velocity"}, {"speed", "velocity"}, {"max_effort", "effort"},
    {"effort_limit", "effort"},
    {"torque", "effort"}, {"force", "effort"}, {"frictionloss", "friction"}, {"rotor_inertia", "armature"},
    {"stiffness", "spring"}, {"spring_stiffness", "spring"}, {"springref", "rest"},
    {"spring_reference", "rest"},
    {"mimic", "follows"}, {"leader", "joint"}, {"multiplier", "ratio"},
    // keys of a joint in the table of its body
    {"type", "joint.kind"}, {"kind", "joint.kind"}, {"axis", "joint.axis"}, {"point", "joint.point"},
    {"limits", "joint.limits"}, {"limit", "joint.limits"}, {"effort", "joint.effort"},
    {"velocity", "joint.velocity"}, {"damping", "joint.damping"}, {"friction", "joint.friction"},
    {"armature", "joint.armature"}, {"gear_loss", "joint.gear_loss"},
    {"follows", "joint.follows"}, {"mimic", "joint.follows"},
    // kinds of joints and loops
    {"hinge", "revolute"}, {"continuous", "revolute"}, {"slide", "prismatic"}, {"slider", "prismatic"},
    {"screw", "helical"}, {"ball", "spherical"}, {"cardan", "universal"}, {"floating", "free"},
    {"weld", "fixed"},
    {"distance", "rod"},
});
// clang-format on

/// A text such as `; it is called "on" here` for a word that means a key in `known` elsewhere, or "".
template <class Range> std::string own_term_for(std::string_view word, const Range& known) {
  const auto is_ours = [&](const ForeignTerm& other) {
    const std::string_view key = other.ours.substr(0, other.ours.find('.'));
    return other.theirs == word && std::find(known.begin(), known.end(), key) != known.end();
  };
  const auto found = std::find_if(foreign_terms.begin(), foreign_terms.end(), is_ours);
  return found == foreign_terms.end() ? "" : "; it is called \"" + std::string(found->ours) + "\" here";
}

}  // namespace axode::io
