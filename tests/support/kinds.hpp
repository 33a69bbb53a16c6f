#pragma once
#include <vector>

#include "axode/model/kinds/joint_kinds.hpp"

/// The kinds of joints with a property, in the order of the table of kinds.
namespace axode::test {

template <class Property> std::vector<JointKind> kinds_that(const Property& has) {
  std::vector<JointKind> kinds;
  for (const JointTraits& it : joint_kinds)
    if (has(it)) kinds.push_back(it.kind);
  return kinds;
}
inline const std::vector<JointKind> all_kinds = kinds_that([](const JointTraits&) { return true; });
inline const std::vector<JointKind> moving_kinds =
    kinds_that([](const JointTraits& it) { return it.dof > 0; });

}  // namespace axode::test
