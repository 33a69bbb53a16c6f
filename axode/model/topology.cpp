#include "axode/model/topology.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <set>
#include <utility>

namespace axode {
namespace {

constexpr std::size_t most_lanes = 16;  // largest number of lanes of any SIMD register

std::size_t size(int n) { return static_cast<std::size_t>(n); }

/// Numbers the coordinates, velocities and screws of joints; a coupled joint has the numbers of its leader.
void number_coordinates(const std::vector<int>& leader, Topology& t) {
  t.iq.assign(size(t.n + 1), 0);
  t.iv.assign(size(t.n + 1), 0);
  t.first_screw = {0, 0};
  for (int i = 1; i <= t.n; ++i)
    with_subgroup(t.kind[i], 0.0, [&](const auto& joint) {
      t.first_screw.push_back(t.n_screws += joint.nv);
      if (leader[i] > 0) return;
      t.iq[i] = std::exchange(t.nq, t.nq + joint.nq);
      t.iv[i] = std::exchange(t.nv, t.nv + joint.nv);
      if (joint.nq > joint.nv) t.quaternion_bodies.push_back(i);
    });
  for (int i = 1; i <= t.n; ++i) {
    t.coupled.push_back(leader[i] > 0);
    if (leader[i] > 0) {
      t.iq[i] = t.iq[leader[i]];
      t.iv[i] = t.iv[leader[i]];
      t.coupled_bodies.push_back(i);
    }
  }
}

/// Sorts the bodies by the subgroup of their joint, coupled joints after all others, and finds the groups.
void sort_by_kind(Topology& t) {
  t.by_kind.resize(size(t.n));
  std::iota(t.by_kind.begin(), t.by_kind.end(), 1);
  const auto key = [&](int i) { return std::pair(t.coupled[i] != 0, t.kind[i]); };
  std::stable_sort(t.by_kind.begin(), t.by_kind.end(), [&](int i, int j) { return key(i) < key(j); });
  for (int begin = 0; begin < t.n;) {
    int end = begin;
    while (end < t.n && key(t.by_kind[end]) == key(t.by_kind[begin])) ++end;
    const auto [coupled, kind] = key(t.by_kind[begin]);
    t.joint_groups.push_back({kind, coupled, begin, end});
    begin = end;
  }
}

void find_subtrees(Topology& t) {
  t.branches.resize(size(t.n + 1));
  t.subtree_end.resize(size(t.n + 1));
  for (int i = t.n; i >= 0; --i) {
    t.subtree_end[i] = std::max(t.subtree_end[i], i + 1);
    const int p = t.parent[i];
    if (p != i - 1) t.branches[p] = 1;
    t.subtree_end[p] = std::max(t.subtree_end[p], t.subtree_end[i]);
  }
  for (int i = 1; i <= t.n; ++i)
    for (int s = t.first_screw[i]; s < t.first_screw[i + 1] && !t.coupled[i]; ++s)
      t.velocity_end.push_back(t.subtree_end[i] <= t.n ? t.iv[t.subtree_end[i]] : t.nv);
  std::vector<int> depth(size(t.n + 1));
  for (int i = 1; i <= t.n; ++i) depth[i] = depth[t.parent[i]] + 1;
  t.by_depth.resize(size(t.n));
  std::iota(t.by_depth.begin(), t.by_depth.end(), 1);
  std::stable_sort(t.by_depth.begin(), t.by_depth.end(), [&](int i, int j) { return depth[i] < depth[j]; });
}

/// For each velocity c, velocities with larger indices to which the mass matrix couples c, because their
/// joints and that of c are on one path from a body to the ground. Of each path, only the velocity with the
/// next larger index is listed; the algorithm that computes the elimination tree needs no others.
std::vector<std::vector<int>> later_neighbours(const Topology& t) {
  std::vector<std::vector<int>> later(size(t.nv));
  std::multiset<int> path;  // velocities from the ground to the body where the walk is
  std::vector<int> open;    // the bodies on this path
  const auto each_velocity = [&](int i, const auto& f) {
    for (int s = t.first_screw[i]; s < t.first_screw[i + 1]; ++s) f(t.iv[i] + s - t.first_screw[i]);
  };
  for (int i = 1; i <= t.n; ++i) {
    for (; !open.empty() && open.back() != t.parent[i]; open.pop_back())
      each_velocity(open.back(), [&](int c) { path.erase(path.find(c)); });
    open.push_back(i);
    each_velocity(i, [&](int c) {
      const auto next = path.upper_bound(c), same = path.lower_bound(c);
      if (next != path.end()) later[c].push_back(*next);
      if (same != path.begin()) later[*std::prev(same)].push_back(c);
      path.insert(c);
    });
  }
  return later;
}

/// Computes velocity_parent, the elimination tree of the mass matrix, by the algorithm of Liu, and the depth
/// of this tree. Velocities c are added from the largest index to the smallest. When c is added, it becomes
/// the parent of the roots of all trees that contain a velocity to which the mass matrix couples c.
void find_velocity_parents(Topology& t) {
  const std::vector<std::vector<int>> later = later_neighbours(t);
  std::vector<int> root(size(t.nv), -1);
  t.velocity_parent = root;
  for (int c = t.nv - 1; c >= 0; --c)
    for (int k : later[c]) {
      while (root[k] != -1 && root[k] != c) k = std::exchange(root[k], c);
      if (root[k] == -1) root[k] = t.velocity_parent[k] = c;
    }
  std::vector<int> depth(size(t.nv));
  for (int c = 0; c < t.nv; ++c) {
    depth[c] = t.velocity_parent[c] < 0 ? 1 : depth[t.velocity_parent[c]] + 1;
    t.depth = std::max(t.depth, depth[c]);
  }
}

/// A path from the body of a joint towards the ground that comes to a given body or begins at it. The joint
/// is `leader`, or a joint that is coupled to `leader` and shares its velocity. `from` is the child of the
/// body through which the path comes, or the body itself if the path begins at it. `joints` is the number of
/// joints whose paths have joined in it.
struct Arrival {
  int leader, from, joints;
};

/// For each body, the paths of coupled joints that begin at it, pass through it or end at it, sorted by their
/// leaders. A path begins at the body of a leader l, a joint to which others are coupled, or of a joint that
/// is coupled to l and shares its velocity. It leads towards the ground and ends at the body meets[l], where
/// the paths of all joints with the leader l have met, whose number is joints[l]. Paths with the same leader
/// that meet before count as one from there on.
std::vector<std::vector<Arrival>> arrivals(const std::vector<int>& leader, const std::vector<int>& joints,
                                           const Topology& t, std::vector<int>& meets) {
  std::vector<std::vector<Arrival>> all(size(t.n + 1));
  for (int i = t.n; i >= 0; --i) {
    std::vector<Arrival>& here = all[i];
    const int own = leader[i] > 0 ? leader[i] : i;
    if (i > 0 && joints[own] > 0) here.push_back({own, i, 1});
    std::sort(here.begin(), here.end(), [](Arrival a, Arrival b) { return a.leader < b.leader; });
    for (std::size_t begin = 0, end = 0; begin < here.size(); begin = end) {
      Arrival on{here[begin].leader, i, 0};
      while (end < here.size() && here[end].leader == on.leader) on.joints += here[end++].joints;
      if (on.joints == joints[on.leader])
        meets[on.leader] = i;
      else
        all[t.parent[i]].push_back(on);
    }
  }
  return all;
}

/// The ties of body i: the velocities that coupled joints share and that have a path to the body. For each
/// joint that shares a velocity, a path leads from the body that the joint moves towards the ground, up to
/// the body where all paths of the velocity meet. For each tie, `leaders` has the joint to which the velocity
/// belongs, and `group` the smallest index of a tie in the same group. Two ties are in the same group
///   - if a path of one velocity and a path of the other come to the body through the same child, or
///   - if each of the two velocities is that of the body's own joint, or has paths that go on from the body
///     to its predecessor.
/// Groups that have a tie in common are one group. In the elimination of velocities, inertias couple ties of
/// the same group only.
struct Groups {
  std::vector<int> leaders, group;

  /// `first_from` is scratch memory with an entry -1 for each body, before and after the call.
  Groups(const std::vector<Arrival>& here, const std::vector<int>& meets, int i,
         std::vector<int>& first_from) {
    for (const auto& [leader, from, joints] : here) {
      const int k = static_cast<int>(leaders.size()) - (!leaders.empty() && leaders.back() == leader);
      if (k == static_cast<int>(leaders.size())) {
        leaders.push_back(leader);
        group.push_back(k);
      }
      unite(k, first_from[from] < 0 ? k : first_from[from]);
      first_from[from] = k;
      if (meets[leader] == i) continue;
      unite(k, first_from[i] < 0 ? k : first_from[i]);  // unites the velocities that continue to the
                                                        // predecessor with that of the body's own joint
      first_from[i] = k;
    }
    for (int k = 0; k < static_cast<int>(group.size()); ++k) group[k] = root(k);
    for (const Arrival& path : here) first_from[path.from] = -1;
    first_from[i] = -1;
  }

 private:
  int root(int k) {
    while (group[k] != k) k = group[k] = group[group[k]];
    return k;
  }
  void unite(int a, int b) {
    a = root(a);
    b = root(b);
    group[std::max(a, b)] = std::min(a, b);
  }
};

void find_ties(const std::vector<int>& leader, Topology& t) {
  std::vector<int> joints(size(t.n + 1), 0);  // for each leader: the number of joints with its velocity, or 0
                                              // if it has no other
  for (const int i : t.coupled_bodies) joints[leader[i]] += joints[leader[i]] == 0 ? 2 : 1;
  std::vector<int> meets(size(t.n + 1), -1);  // for each leader: the body where their paths meet
  const std::vector<std::vector<Arrival>> here = arrivals(leader, joints, t, meets);
  std::vector<int> first_from(size(t.n + 1), -1);
  std::vector<std::vector<std::pair<int, int>>> entries(size(t.n + 1));  // for each body: pairs (leader,
                                                                         // entry), in the order of leaders
  const auto entry = [&](int i, int l) {
    return std::lower_bound(entries[i].begin(), entries[i].end(), std::pair(l, 0))->second;
  };
  Topology::Ties& ties = t.ties;
  ties.begin = {0};
  ties.of_screws = {0};
  for (int i = 0; i <= t.n; ++i) {
    const Groups groups(here[i], meets, i, first_from);
    const std::size_t count = groups.leaders.size();
    std::vector<int> order(count);
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return groups.group[a] < groups.group[b]; });
    for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
      while (end < count && groups.group[order[end]] == groups.group[order[begin]]) ++end;
      for (std::size_t k = begin; k < end; ++k) {
        const int l = groups.leaders[order[k]];
        entries[i].emplace_back(l, ties.begin[i] + static_cast<int>(k));
        ties.velocity.push_back(t.iv[l]);
        ties.up.push_back(meets[l] == i ? -1 : entry(t.parent[i], l));
        ties.group_begin.push_back(ties.begin[i] + static_cast<int>(begin));
        ties.group_end.push_back(ties.begin[i] + static_cast<int>(end));
        ties.row.push_back(std::exchange(ties.n_pairs, ties.n_pairs + (end - begin)));
      }
    }
    std::sort(entries[i].begin(), entries[i].end());
    const int own = leader[i] > 0 ? leader[i] : i;
    ties.own.push_back(i > 0 && meets[own] >= 0 ? entry(i, own) : -1);
    ties.begin.push_back(ties.begin.back() + static_cast<int>(count));
    ties.of_screws.push_back(ties.of_screws.back() +
                             count * size(i > 0 ? t.first_screw[i + 1] - t.first_screw[i] : 0));
  }
}

}  // namespace

Topology::Topology(Connections connections)
    : n(static_cast<int>(connections.parent.size()) - 1),
      parent(std::move(connections.parent)),
      kind(std::move(connections.kind)),
      coupled{0},
      frame_body(std::move(connections.frame_body)) {
  number_coordinates(connections.leader, *this);
  sort_by_kind(*this);
  find_subtrees(*this);
  find_velocity_parents(*this);
  find_ties(connections.leader, *this);
  angle.assign(iq.begin() + 1, iq.end());
  angle.resize((angle.size() + most_lanes - 1) / most_lanes * most_lanes);
  hinges.resize(size(n + 2));
  for (int i = n; i > 0; --i)
    hinges[i] = kind[i] == Subgroup::revolute && !coupled[i] ? hinges[i + 1] + 1 : 0;
}

}  // namespace axode
