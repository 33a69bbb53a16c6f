#pragma once
#include <vector>

#include "axode/constraints/loops/loop_path.hpp"

namespace axode {

/// A limb: a set of velocities that neither loops nor the tree connect to velocities of other limbs, except
/// through the joints between the ground and the platform.
struct Limb {
  std::vector<int> velocities;  ///< indices of velocities, ascending; empty for a loop between the platform
                                ///< and the ground
  std::vector<int> loops;       ///< indices in loops().all, ascending
};

/// The division of a mechanism with loops into limbs that carry a platform. Without a platform the limbs are
/// parts of the mechanism that move independently.
struct Limbs {
  int platform = 0;           ///< the body that the limbs carry; 0 if there is none
  std::vector<int> carrying;  ///< velocities of the joints between the ground and the platform, ascending
  std::vector<Limb> limbs;    ///< all limbs with loops
  std::vector<int> outside;   ///< velocities that are in no limb, because no loop constrains them, and that
                              ///< are not `carrying`
};

/// Divides a mechanism into limbs, parts that are coupled to each other only through the joints between the
/// ground and the body `platform`, 1 to n. If `platform` is 0, there is none, and the limbs are not coupled.
/// `paths` has the paths in the spanning tree of all loops.
Limbs limbs_of(const Model& model, const std::vector<LoopPath>& paths, int platform);

/// Divides a mechanism into limbs, parts that are coupled to each other only through the joints of a
/// platform. Chooses the platform for which the computations limb by limb cost least, among the 16 bodies
/// that are on the paths to the ground of most loops; there may also be no platform. O(nv + m d) for m loop
/// equations on paths of d joints.
Limbs limbs_of(const Model& model, const std::vector<LoopPath>& paths);

}  // namespace axode
