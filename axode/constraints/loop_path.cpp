#include "axode/constraints/loop_path.hpp"

#include <functional>
#include <set>

#include "axode/kinematics/path.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {
namespace {

void add_path(const Topology& topology, int i, std::set<int, std::greater<>>& bodies) {
  for (; i > 0; i = topology.parent[i]) bodies.insert(i);
}

}  // namespace

LoopPath::LoopPath(const Tree<double>& tree, const Loop& of)
    : loop(&of), rows{of.first_row, of.rows()}, residuals{of.first_residual, of.residuals()} {
  const Topology& topology = *tree.topology();
  std::set<int, std::greater<>> on_paths;
  for (const Loop::Term& term : of.terms) {
    columns.push_back({.velocity = term.velocity, .factor = term.factor});
    add_path(topology, body_of_velocity(topology, term.velocity), on_paths);
  }
  if (of.terms.empty()) {
    meeting = common_predecessor(tree, of.ends[0].body, of.ends[1].body);
    for (std::size_t e = 0; e < 2; ++e) {
      add_path(topology, of.ends[e].body, on_paths);
      for (int i = of.ends[e].body; i > 0; i = topology.parent[i]) root[e] = i;
      for (int i = of.ends[e].body; i != meeting; i = topology.parent[i])
        for (int s = topology.first_screw[i]; s < topology.first_screw[i + 1]; ++s)
          columns.push_back({topology.iv[i] + s - topology.first_screw[i], s, i, e == 1 ? 1 : -1});
    }
  }
  bodies.assign(on_paths.begin(), on_paths.end());
  const Topology::Ties& ties = topology.ties;
  std::set<int> give_way;
  for (const int i : bodies) {
    if (ties.own[i] < 0)
      for (int s = topology.first_screw[i]; s < topology.first_screw[i + 1]; ++s)
        give_way.insert(topology.iv[i] + s - topology.first_screw[i]);
    for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t)
      if (ties.up[t] < 0) give_way.insert(ties.velocity[t]);
  }
  for (int t = ties.begin[0]; t < ties.begin[1]; ++t) give_way.insert(ties.velocity[t]);
  velocities.assign(give_way.begin(), give_way.end());
}

}  // namespace axode
