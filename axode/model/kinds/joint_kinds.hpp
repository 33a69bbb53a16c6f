#pragma once
#include <algorithm>
#include <array>

#include "axode/model/description.hpp"
#include "axode/model/subgroup.hpp"

/// The table of joint kinds, with everything that depends on the kind alone.
namespace axode {

struct JointTraits {
  JointKind kind;
  std::string_view name;
  int dof;  ///< degrees of freedom
  /// Subgroup of SE(3) of the joint, or of the second half of a cylindrical or universal joint. That of a
  /// fixed joint is not used.
  Subgroup subgroup;
  bool axis;   ///< whether the joint has an axis; for planar joints it is the normal
  bool point;  ///< whether the position of the joint matters
  int angles;  ///< its first degrees of freedom that are angles and can have limits
};

inline constexpr std::array<JointTraits, 9> joint_kinds{{
    {JointKind::fixed, "fixed", 0, Subgroup::revolute, false, false, 0},
    {JointKind::revolute, "revolute", 1, Subgroup::revolute, true, true, 1},
    {JointKind::prismatic, "prismatic", 1, Subgroup::prismatic, true, false, 0},
    {JointKind::helical, "helical", 1, Subgroup::helical, true, true, 1},
    {JointKind::cylindrical, "cylindrical", 2, Subgroup::prismatic, true, true, 1},
    {JointKind::universal, "universal", 2, Subgroup::revolute, true, true, 2},
    {JointKind::spherical, "spherical", 3, Subgroup::spherical, false, true, 0},
    {JointKind::planar, "planar", 3, Subgroup::planar, true, true, 1},
    {JointKind::free, "free", 6, Subgroup::free, false, false, 0},
}};

constexpr const JointTraits& traits(JointKind kind) {
  return *std::find_if(joint_kinds.begin(), joint_kinds.end(),
                       [&](const JointTraits& t) { return t.kind == kind; });
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
