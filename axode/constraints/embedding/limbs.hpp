#pragma once
#include <vector>

#include "axode/constraints/loops/loop_path.hpp"

namespace axode {

/// A limb: a set of velocities of the spanning tree, and the loops that constrain them. Two velocities are in
/// the same limb if one loop constrains both, or if one is on the path of the other to the ground. The joints
/// on the path from the ground to a body called the platform are in no limb.
struct Limb {
  std::vector<int> velocities;  ///< indices of velocities, ascending; empty for a loop between the platform
                                ///< and the ground
  std::vector<int> loops;       ///< indices in loops().all, ascending
};

/// The division of a mechanism into limbs, the chains that carry a body called the platform. Without a
/// platform the limbs are parts of the mechanism that move independently.
struct Limbs {
  int platform = 0;           ///< the body that the limbs carry; 0 if there is none
  std::vector<int> carrying;  ///< velocities of the joints between the ground and the platform, ascending
  std::vector<Limb> limbs;    ///< all limbs with loops
  std::vector<int> outside;   ///< velocities that are in no limb, because no loop constrains them, and that
                              ///< are not `carrying`
};

/// Divides a mechanism into limbs, parts that are coupled only through the joints on the path in the spanning
/// tree from the ground to the body `platform` (1 to n, or 0 for none). `paths` has the paths of all loops in
/// the spanning tree.
Limbs limbs_of(const Model& model, const std::vector<LoopPath>& paths, int platform);

/// Divides a mechanism into limbs, parts that are coupled only through the joints on the path in the spanning
/// tree from the ground to a body called the platform. `paths` has the paths of all loops in the spanning
/// tree. A body belongs to a loop if it is on a path from the ground to a body that the loop joins or, for a
/// coupling, to a coupled joint. The candidates for the platform are the bodies that belong to at least two
/// loops, at most the 16 that belong to the most. The platform is the candidate for which an elimination of
/// all velocities, limb by limb, is estimated to cost least. There is no platform if the elimination costs
/// least without one. O(nv + m d) for m loop equations on paths of d joints.
Limbs limbs_of(const Model& model, const std::vector<LoopPath>& paths);

}  // namespace axode
