#pragma once
#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "axode/model/subgroup.hpp"

/// The kinds of joints in descriptions, and a table with everything that depends on the kind alone.
namespace axode {

enum class JointKind {
  fixed,
  revolute,
  prismatic,
  helical,
  cylindrical,  ///< becomes `<name>.rotation` and `<name>.translation` with a massless body in between
  universal,    ///< becomes `<name>.first` and `<name>.second` with a massless body in between
  spherical,
  planar,
  free,
};

/// Two joints in a row, with a massless body between them, that a joint is made of.
struct JointChain {
  JointKind first, second;
  std::string_view first_name, carrier, second_name;  ///< what the names of the joint end with for each part
};

struct JointTraits {
  JointKind kind;
  std::string_view name;
  int dof;  ///< degrees of freedom
  /// Subgroup of SE(3) of the joint, or of the second joint of a chain. That of a fixed joint is not used.
  Subgroup subgroup;
  /// The members of JointDescription that determine where the joint is and how it moves. The axis of a planar
  /// joint is the normal.
  std::array<std::string_view, 3> keys;
  int angles;  ///< its first degrees of freedom that are angles and can have limits
  std::optional<JointChain> chain = {};

  constexpr bool has(std::string_view key) const {
    return std::find(keys.begin(), keys.end(), key) != keys.end();
  }
};

inline constexpr std::array<JointTraits, 9> joint_kinds{{
    {JointKind::fixed, "fixed", 0, Subgroup::revolute, {}, 0},
    {JointKind::revolute, "revolute", 1, Subgroup::revolute, {"axis", "point"}, 1},
    {JointKind::prismatic, "prismatic", 1, Subgroup::prismatic, {"axis"}, 0},
    {JointKind::helical, "helical", 1, Subgroup::helical, {"axis", "point", "pitch"}, 1},
    {JointKind::cylindrical,
     "cylindrical",
     2,
     Subgroup::prismatic,
     {"axis", "point"},
     1,
     JointChain{JointKind::revolute, JointKind::prismatic, "rotation", "sleeve", "translation"}},
    {JointKind::universal,
     "universal",
     2,
     Subgroup::revolute,
     {"axis", "second_axis", "point"},
     2,
     JointChain{JointKind::revolute, JointKind::revolute, "first", "cross", "second"}},
    {JointKind::spherical, "spherical", 3, Subgroup::spherical, {"point"}, 0},
    {JointKind::planar, "planar", 3, Subgroup::planar, {"axis", "point"}, 1},
    {JointKind::free, "free", 6, Subgroup::free, {}, 0},
}};

constexpr const JointTraits& traits(JointKind kind) {
  return *std::find_if(joint_kinds.begin(), joint_kinds.end(),
                       [&](const JointTraits& t) { return t.kind == kind; });
}
/// Whether the frame of a joint is the frame of its body, because neither an axis nor a point determines it.
constexpr bool is_at_body_frame(JointKind kind) {
  return !traits(kind).has("axis") && !traits(kind).has("point");
}
/// Whether velocities are components along several axes of a frame that an axis or a point determines in
/// part, so that it matters where its other axes point.
constexpr bool has_oriented_frame(JointKind kind) {
  return traits(kind).dof > 1 && !traits(kind).chain && !is_at_body_frame(kind);
}
/// Whether a joint has one degree of freedom, so that it can follow another joint or lead one.
constexpr bool can_couple(JointKind kind) { return traits(kind).dof == 1; }

constexpr std::string_view to_string(JointKind kind) { return traits(kind).name; }
constexpr std::string_view to_string(Subgroup kind) {
  return std::find_if(joint_kinds.begin() + 1, joint_kinds.end(),
                      [&](const JointTraits& t) { return t.subgroup == kind; })
      ->name;
}

}  // namespace axode
