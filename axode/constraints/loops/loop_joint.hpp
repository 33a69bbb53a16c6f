#pragma once
#include <variant>

#include "axode/constraints/loops/rod.hpp"
#include "axode/constraints/loops/rolling_contact.hpp"
#include "axode/constraints/loops/subgroup_closure.hpp"
#include "axode/constraints/loops/universal.hpp"
#include "axode/model/loops.hpp"

namespace axode {

/// The types of loop joints; loop_frames.hpp lists the members that a type must have.
using LoopJoint = std::variant<loops::SubgroupClosure, loops::Universal, loops::Rod, loops::RollingContact>;

/// Makes the loop joint of a kind; `size` is Loop::size.
constexpr LoopJoint loop_joint(LoopKind kind, double pitch, double size, bool wheel) {
  if (kind == LoopKind::universal) return loops::Universal{size};
  if (kind == LoopKind::rod) return loops::Rod{size};
  if (kind == LoopKind::rolling) return loops::RollingContact{size, wheel};
  return loops::SubgroupClosure{traits(kind).free, pitch};
}

/// Whether the table of kinds has the numbers of rows that the types of loop joints have.
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
