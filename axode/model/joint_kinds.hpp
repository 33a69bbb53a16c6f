#pragma once
#include <algorithm>
#include <array>

#include "axode/model/description.hpp"
#include "axode/model/subgroup.hpp"

/// The table of joint kinds: who needs to know something about a kind of joint asks here.
namespace axode {

struct JointTraits {
  JointKind kind;
  std::string_view name;
  int dof;            ///< degrees of freedom
  Subgroup subgroup;  ///< of the joint next to the body, where the kind stands for two
  bool axis;          ///< whether it has one; for planar the normal
  bool point;         ///< whether it matters where it is
};

inline constexpr std::array<JointTraits, 9> joint_kinds{{
    {JointKind::fixed, "fixed", 0, Subgroup::revolute, false, false},  // of no subgroup
    {JointKind::revolute, "revolute", 1, Subgroup::revolute, true, true},
    {JointKind::prismatic, "prismatic", 1, Subgroup::prismatic, true, false},
    {JointKind::helical, "helical", 1, Subgroup::helical, true, true},
    {JointKind::cylindrical, "cylindrical", 2, Subgroup::prismatic, true, true},
    {JointKind::universal, "universal", 2, Subgroup::revolute, true, true},
    {JointKind::spherical, "spherical", 3, Subgroup::spherical, false, true},
    {JointKind::planar, "planar", 3, Subgroup::planar, true, true},
    {JointKind::free, "free", 6, Subgroup::free, false, false},
}};

constexpr const JointTraits& traits(JointKind kind) {
  return *std::find_if(joint_kinds.begin(), joint_kinds.end(),
                       [&](const JointTraits& t) { return t.kind == kind; });
}
/// Whether it has one degree of freedom, so that it can follow another joint or lead one.
constexpr bool can_couple(JointKind kind) { return traits(kind).dof == 1; }

constexpr std::string_view to_string(JointKind kind) { return traits(kind).name; }
constexpr std::string_view to_string(Subgroup kind) {
  return std::find_if(joint_kinds.begin() + 1, joint_kinds.end(),
                      [&](const JointTraits& t) { return t.subgroup == kind; })
      ->name;
}

}  // namespace axode
