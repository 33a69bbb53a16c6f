#include "axode/model/topology.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <set>
#include <utility>

namespace axode {
namespace {

constexpr std::size_t most_lanes = 16;  // of any SIMD register

std::size_t size(int n) { return static_cast<std::size_t>(n); }

/// Coordinates and velocities in the order of the bodies; a coupled joint has those of its leader.
void number_coordinates(const std::vector<int>& leader, Topology& t) {
  t.iq.assign(size(t.n + 1), 0), t.iv.assign(size(t.n + 1), 0);
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
      t.iq[i] = t.iq[leader[i]], t.iv[i] = t.iv[leader[i]];
      t.coupled_bodies.push_back(i);
    }
  }
}

/// Runs of bodies of one kind; coupled joints last.
void sort_by_kind(Topology& t) {
  t.by_kind.resize(size(t.n));
  std::iota(t.by_kind.begin(), t.by_kind.end(), 1);
  const auto key = [&](int i) { return std::pair(t.coupled[i] != 0, t.kind[i]); };
  std::stable_sort(t.by_kind.begin(), t.by_kind.end(), [&](int i, int j) { return key(i) < key(j); });
  for (int begin = 0; begin < t.n;) {
    int end = begin;
    while (end < t.n && key(t.by_kind[end]) == key(t.by_kind[begin])) ++end;
    const auto [coupled, kind] = key(t.by_kind[begin]);
    t.runs.push_back({kind, coupled, begin, end});
    begin = end;
  }
}

void find_subtrees(Topology& t) {
  t.branches.resize(size(t.n + 1)), t.subtree_end.resize(size(t.n + 1));
  for (int i = t.n; i >= 0; --i) {
    t.subtree_end[i] = std::max(t.subtree_end[i], i + 1);
    const int p = t.parent[i];
    if (p != i - 1) t.branches[p] = 1;
    t.subtree_end[p] = std::max(t.subtree_end[p], t.subtree_end[i]);
  }
  for (int i = 1; i <= t.n; ++i)
    for (int s = t.first_screw[i]; s < t.first_screw[i + 1] && !t.coupled[i]; ++s)
      t.velocity_end.push_back(t.subtree_end[i] <= t.n ? t.iv[t.subtree_end[i]] : t.nv);
}

/// For each velocity later ones that it is tied to, enough of them for the elimination tree: all velocities on one
/// path are tied to each other, for which it takes the next one only.
std::vector<std::vector<int>> later_neighbours(const Topology& t) {
  std::vector<std::vector<int>> later(size(t.nv));
  std::multiset<int> path;  // velocities from the ground to the body where the walk is
  std::vector<int> open;    // the bodies on it
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

/// Liu's algorithm: the root of every subtree that velocity c reaches becomes its child; paths are shortened on the
/// way.
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

/// The body where the paths from i and j to the ground meet.
int meeting_point(const Topology& t, int i, int j) {
  while (i != j) {
    int& later = i > j ? i : j;
    later = t.parent[later];
  }
  return i;
}

void find_ties(const std::vector<int>& leader, Topology& t) {
  std::vector<int> meets(size(t.n + 1), -1);  // by leader: where all that share its velocity meet
  for (const int i : t.coupled_bodies) {
    int& at = meets[leader[i]];
    at = meeting_point(t, at < 0 ? leader[i] : at, i);
  }
  std::vector<std::vector<int>> leaders(size(t.n + 1));  // of the velocities that pass through a body
  for (int i = t.n; i > 0; --i) {
    const int own = leader[i] > 0 ? leader[i] : i;
    std::vector<int>& here = leaders[i];
    if (meets[own] >= 0) here.push_back(own);
    std::sort(here.begin(), here.end());
    here.erase(std::unique(here.begin(), here.end()), here.end());
    for (const int l : here)
      if (meets[l] != i) leaders[t.parent[i]].push_back(l);
  }
  std::sort(leaders[0].begin(), leaders[0].end());
  leaders[0].erase(std::unique(leaders[0].begin(), leaders[0].end()), leaders[0].end());

  Topology::Ties& ties = t.ties;
  ties.begin = ties.square = ties.of_screws = {0};
  const auto entry = [&](int i, int l) {
    const std::vector<int>& here = leaders[i];
    return ties.begin[i] + static_cast<int>(std::lower_bound(here.begin(), here.end(), l) - here.begin());
  };
  for (int i = 0; i <= t.n; ++i) {
    const int own = leader[i] > 0 ? leader[i] : i;
    ties.own.push_back(i > 0 && meets[own] >= 0 ? entry(i, own) : -1);
    for (const int l : leaders[i]) {
      ties.velocity.push_back(t.iv[l]);
      ties.up.push_back(meets[l] == i ? -1 : entry(t.parent[i], l));
    }
    const int count = static_cast<int>(leaders[i].size());
    ties.begin.push_back(ties.begin.back() + count);
    ties.square.push_back(ties.square.back() + count * count);
    ties.of_screws.push_back(ties.of_screws.back() +
                             count * (i > 0 ? t.first_screw[i + 1] - t.first_screw[i] : 0));
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
