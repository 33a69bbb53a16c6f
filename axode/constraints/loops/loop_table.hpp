#pragma once
#include <span>
#include <vector>

#include "axode/constraints/loops/loop_joint.hpp"
#include "axode/constraints/loops/loop_path.hpp"

namespace axode {

/// The loops of a mechanism as the constraints read them, made once: each joint with its type, and couplings,
/// which are constant rows of velocities.
struct LoopTable {
  using Range = LoopPath::Range;
  /// Consecutive velocities that feel the same rows as they give way.
  struct VelocityBlock {
    int first, count;
    std::vector<Range> rows;
  };

  explicit LoopTable(const Model& model);

  std::vector<LoopPath> paths;  ///< those of the joints, and after them those of the couplings
  std::vector<LoopJoint> joints;
  std::vector<VelocityBlock> row_blocks,
      residual_blocks;     ///< of rows of A, and of those that have a residual
  std::vector<char> ends;  ///< n + 1: whether a loop joint ends at a body

  std::span<const LoopPath> of_couplings() const { return std::span(paths).subspan(joints.size()); }
  /// f(k, joint) for every loop joint, with its type.
  template <class F> void each(const F& f) const {
    for (std::size_t k = 0; k < joints.size(); ++k)
      std::visit([&](const auto& joint) { f(k, joint); }, joints[k]);
  }
};

}  // namespace axode
