#pragma once
#include <cstddef>
#include <vector>

#include "axode/model/subgroup.hpp"

namespace axode {

/// Bodies whose joints are of one kind: by_kind[begin] to by_kind[end - 1].
struct JointGroup {
  Subgroup kind;
  bool coupled;  ///< q_i = ratio q_j + offset; coupled groups come last
  int begin, end;
};

/// What a tree is made of, before anything is numbered: body 0 is the ground, its entries are of no use.
struct Connections {
  std::vector<int> parent;      ///< of each body, parent[i] < i
  std::vector<Subgroup> kind;   ///< of the joint that moves it
  std::vector<int> leader;      ///< the joint that it follows, which has no leader itself; 0: none
  std::vector<int> frame_body;  ///< the body that each named frame moves with
};

/// The integers of a tree: what hangs on what, and where the numbers of a joint stand. Body 0 is the ground;
/// the joint of body i is index i. It is made once, whole, and shared by the trees of all scalars.
struct Topology {
  explicit Topology(Connections connections);

  int n = 0, nq = 0, nv = 0;     ///< moving bodies, coordinates, velocities
  int n_screws = 0;              ///< joint screws: a column for each degree of freedom of every joint
  int depth = 0;                 ///< velocities on the longest path from the ground
  std::vector<int> parent;       ///< n + 1; parent[i] < i
  std::vector<Subgroup> kind;    ///< n + 1
  std::vector<char> coupled;     ///< n + 1
  std::vector<int> iq, iv;       ///< n + 1: first coordinate and velocity (of the leader for a coupled joint)
  std::vector<int> first_screw;  ///< n + 2: joint i has screws first_screw[i] to first_screw[i + 1] - 1
  std::vector<int>
      frame_body;  ///< frame f: 0 is the ground, 1..n the bodies as the user placed them, then extra

  std::vector<JointGroup> joint_groups;
  std::vector<int> by_kind;                            ///< n
  std::vector<int> coupled_bodies, quaternion_bodies;  ///< those whose joint is coupled; has a quaternion
  std::vector<int> subtree_end;  ///< n + 1: the bodies that joint i moves are i to subtree_end[i] - 1
  std::vector<int>
      velocity_end;  ///< nv: without couplings, what moves along with c is c to velocity_end[c] - 1
  /// nv: M = LᵀDL has entries L(c, velocity_parent[c]), ...; -1 at the end. It is the elimination tree of M from
  /// the last velocity to the first: without couplings the velocity that precedes on the path to the ground; a
  /// coupled joint ties the path of its leader to its own.
  std::vector<int> velocity_parent;

  /// Velocities that several joints share, on their way through an elimination from the leaves to the ground: one
  /// entry for each body between a joint that has the velocity and the body where the paths of all that have it meet.
  /// There it gives way, before the joint of that body does, unless that joint has it as well. Entries ties.begin[i] to
  /// ties.begin[i + 1] - 1 are those of body i, 0 for the ground. Those that come through one body or go on together
  /// are a group, next to each other; entries of different groups do not feel each other.
  struct Ties {
    std::vector<int> begin;     ///< n + 2
    std::vector<int> velocity;  ///< of each entry
    std::vector<int> up;        ///< the entry of the predecessor for the same velocity; -1 where it gives way
    std::vector<int> own;  ///< n + 1: the entry for the joint of the body itself; -1 where it shares none
    std::vector<int> group_begin, group_end;  ///< of each entry: the entries of its group
    std::vector<std::size_t> row;  ///< of each entry: its first pair, where it has one with each of its group
    std::size_t n_pairs = 0;
    std::vector<std::size_t>
        of_screws;  ///< n + 2: as begin, where body i has its entries once for each screw of its joint
  } ties;

  // For sweeps that take several bodies at once.
  std::vector<int> angle;  ///< iq of joints 1 to n, and 0 up to a multiple of the lanes of any SIMD register
  std::vector<char> branches;  ///< n + 1: whether a body other than the next one hangs on it
  std::vector<int> hinges;  ///< n + 2: how many hinges with coordinates of their own follow, from joint i on

  int n_frames() const { return static_cast<int>(frame_body.size()); }
};

}  // namespace axode
