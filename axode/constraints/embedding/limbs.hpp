#pragma once
#include <vector>

#include "axode/constraints/loops/loop_path.hpp"

namespace axode {

/// A limb: velocities that neither loops nor the tree connect to those of another limb, except through the
/// joints between the ground and the platform.
struct Limb {
  std::vector<int> velocities;  ///< ascending; empty for a loop between the platform and the ground
  std::vector<int> loops;       ///< numbers in loops().all, ascending
};

/// A mechanism with loops as limbs that carry a platform. Without a platform the limbs are parts of the
/// mechanism that move independently.
struct Limbs {
  int platform = 0;           ///< the body that the limbs carry; 0 if there is none
  std::vector<int> carrying;  ///< velocities of the joints between the ground and the platform, ascending
  std::vector<Limb> limbs;    ///< all limbs with loops
  std::vector<int> outside;   ///< velocities that no loop concerns and that are not `carrying`
};

/// Divides a mechanism into the limbs that carry a given platform, a body from 1 to n; 0 stands for none.
Limbs limbs_of(const Model& model, const std::vector<LoopPath>& paths, int platform);

/// Divides a mechanism into limbs such that eliminations limb by limb cost least. The platform is one of the
/// 16 bodies that most loops have on their paths to the ground, or none. O(nv + m d) for m rows on paths of d
/// joints.
Limbs limbs_of(const Model& model, const std::vector<LoopPath>& paths);

}  // namespace axode
