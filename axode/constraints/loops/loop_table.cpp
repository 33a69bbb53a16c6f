#include "axode/constraints/loops/loop_table.hpp"

namespace axode {
namespace {

using Ranges = std::vector<LoopPath::Range>;

/// Appends a range to a list of ranges. If it is adjacent to the last one, the two are merged.
void add(const LoopPath::Range& range, Ranges& to) {
  if (!to.empty() && to.back().first + to.back().count == range.first) {
    to.back().count += range.count;
  } else {
    to.push_back(range);
  }
}

/// Divides the velocities into blocks of consecutive velocities that occur in the same loop equations. `rows`
/// selects the velocity equations (rows of A in A v = 0) or the position equations (rows of R in r' = R v,
/// where r are the residuals of the loop closure).
std::vector<LoopTable::VelocityBlock> blocks(const std::vector<LoopPath>& paths, int nv,
                                             LoopPath::Range LoopPath::*rows) {
  std::vector<Ranges> of_velocity(static_cast<std::size_t>(nv));
  for (const LoopPath& path : paths)
    for (const int c : path.velocities) add(path.*rows, of_velocity[static_cast<std::size_t>(c)]);
  std::vector<LoopTable::VelocityBlock> all;
  for (int c = 0; c < nv; ++c) {
    const Ranges& own = of_velocity[static_cast<std::size_t>(c)];
    if (all.empty() || all.back().rows != own) all.push_back({c, 0, own});
    ++all.back().count;
  }
  return all;
}

}  // namespace

LoopTable::LoopTable(const Model& model) : ends(static_cast<std::size_t>(model.n_bodies() + 1)) {
  const Tree<double>& tree = model.tree<double>();
  for (const Loop& loop : model.loops().joints) {
    paths.emplace_back(tree, loop);
    joints.push_back(loop_joint(loop.kind, loop.pitch, loop.size, loop.wheel, loop.radii));
    for (const Loop::End& end : loop.ends) ends[static_cast<std::size_t>(end.body)] = 1;
  }
  for (const LoopCoupling& coupling : model.loops().couplings) paths.emplace_back(tree, coupling);
  row_blocks = blocks(paths, model.nv(), &LoopPath::rows);
  residual_blocks = blocks(paths, model.nv(), &LoopPath::residuals);
}

}  // namespace axode
