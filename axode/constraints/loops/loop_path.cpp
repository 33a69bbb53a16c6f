#include "axode/constraints/loops/loop_path.hpp"

#include <functional>
#include <set>

#include "axode/kinematics/path.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

LoopPath::LoopPath(const Tree<double>& tree, const Loop& joint) : LoopPath(joint) {
  const Topology& topology = *tree.topology();
  ends = joint.ends;
  meeting = common_predecessor(tree, ends[0].body, ends[1].body);
  for (std::size_t e = 0; e < 2; ++e) {
    for (int i = ends[e].body; i > 0; i = topology.parent[i]) root[e] = i;
    for (int i = ends[e].body; i != meeting; i = topology.parent[i])
      for (int s = topology.first_screw[i]; s < topology.first_screw[i + 1]; ++s)
        columns.push_back({topology.iv[i] + s - topology.first_screw[i], s, i, e == 1 ? 1 : -1});
  }
  add_bodies(topology, {ends[0].body, ends[1].body});
}

LoopPath::LoopPath(const Tree<double>& tree, const LoopCoupling& coupling) : LoopPath(coupling) {
  const Topology& topology = *tree.topology();
  std::vector<int> moved;
  for (const LoopCoupling::Term& term : coupling.terms) {
    columns.push_back({.velocity = term.velocity, .factor = term.factor});
    moved.push_back(body_of_velocity(topology, term.velocity));
  }
  add_bodies(topology, moved);
}

/// Finds the bodies on the paths from the bodies `from` to the ground, and adds them to `bodies`. Adds to
/// `velocities` the indices of the velocities that the articulated-body algorithm eliminates at these bodies.
void LoopPath::add_bodies(const Topology& topology, const std::vector<int>& from) {
  std::set<int, std::greater<>> on_paths;
  for (const int last : from)
    for (int i = last; i > 0; i = topology.parent[i]) on_paths.insert(i);
  bodies.assign(on_paths.begin(), on_paths.end());
  const Topology::Ties& ties = topology.ties;
  std::set<int> eliminated;
  for (const int i : bodies) {
    if (ties.own[i] < 0)
      for (int s = topology.first_screw[i]; s < topology.first_screw[i + 1]; ++s)
        eliminated.insert(topology.iv[i] + s - topology.first_screw[i]);
    for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t)
      if (ties.up[t] < 0) eliminated.insert(ties.velocity[t]);
  }
  for (int t = ties.begin[0]; t < ties.begin[1]; ++t) eliminated.insert(ties.velocity[t]);
  velocities.assign(eliminated.begin(), eliminated.end());
}

}  // namespace axode
