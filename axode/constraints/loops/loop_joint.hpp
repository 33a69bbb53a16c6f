#pragma once
#include <array>
#include <variant>

#include "axode/constraints/loops/belt.hpp"
#include "axode/constraints/loops/rod.hpp"
#include "axode/constraints/loops/rolling_contact.hpp"
#include "axode/constraints/loops/subgroup_closure.hpp"
#include "axode/constraints/loops/universal.hpp"
#include "axode/model/loops.hpp"

namespace axode {

/// The types of loop joints; loop_frames.hpp lists the members that a type must have.
using LoopJoint =
    std::variant<loops::SubgroupClosure, loops::Universal, loops::Rod, loops::RollingContact, loops::Belt>;

/// Makes the loop joint of a kind. The other arguments are the members of Loop with these names.
constexpr LoopJoint loop_joint(LoopKind kind, double pitch, double size, bool wheel,
                               const std::array<double, 2>& radii = {}) {
  if (kind == LoopKind::universal) return loops::Universal{size};
  if (kind == LoopKind::rod) return loops::Rod{size};
  if (kind == LoopKind::belt) return loops::Belt{radii};
  if (kind == LoopKind::rolling) return loops::RollingContact{size, wheel};
  return loops::SubgroupClosure{traits(kind).free, pitch};
}

/// Whether the table loop_kinds has the numbers of equations and residuals of each loop joint's C++ type.
constexpr bool loop_kinds_have_the_rows_of_their_types() {
  for (const LoopTraits& kind : loop_kinds) {
    const auto agrees = [&](const auto& joint) {
      return joint.rows() == kind.rows && joint.residuals() == kind.residuals;
    };
    if (!std::visit(agrees, loop_joint(kind.kind, 0, 0, false))) return false;
  }
  return true;
}
static_assert(loop_kinds_have_the_rows_of_their_types());

}  // namespace axode
