#pragma once
#include <span>
#include <vector>

#include "axode/constraints/loops/loop_joint.hpp"
#include "axode/constraints/loops/loop_path.hpp"

namespace axode {

/// The loop joints of a mechanism with their types, and a LoopPath for each loop joint and each coupling of
/// joints: the paths in the spanning tree from its two bodies, or from the joints of the coupling, to the
/// ground.
struct LoopTable {
  using Range = LoopPath::Range;
  /// Consecutive velocities (rows of Y = D^-½ L⁻ᵀ Aᵀ) with non-zero entries for the same loop rows.
  struct VelocityBlock {
    int first, count;
    std::vector<Range> rows;
  };

  explicit LoopTable(const Model& model);

  std::vector<LoopPath> paths;  ///< one path for each loop joint, then one for each coupling
  std::vector<LoopJoint> joints;
  std::vector<VelocityBlock> row_blocks, residual_blocks;  ///< blocks of velocities for the rows A and for
                                                           ///< the rows R
  std::vector<char> ends;                                  ///< whether a loop joint ends at each body, n + 1
                                                           ///< entries

  std::span<const LoopPath> of_couplings() const { return std::span(paths).subspan(joints.size()); }
  /// Calls f(k, joint) for every loop joint k, with `joint` in its own type.
  template <class F> void each(const F& f) const {
    for (std::size_t k = 0; k < joints.size(); ++k) {
      const auto call = [&](const auto* joint) {
        if (joint) f(k, *joint);
      };
      [&]<class... Types>(const std::variant<Types...>& joint) {
        (call(std::get_if<Types>(&joint)), ...);
      }(joints[k]);
    }
  }
};

}  // namespace axode
