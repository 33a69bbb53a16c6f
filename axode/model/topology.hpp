#pragma once
#include <cstddef>
#include <vector>

#include "axode/model/subgroup.hpp"

namespace axode {

/// Bodies by_kind[begin] to by_kind[end - 1] of a Topology, with joints of one kind, all or none coupled.
struct JointGroup {
  Subgroup kind;
  bool coupled;  ///< whether the joints are coupled, q_i = ratio q_j + offset; coupled groups come last
  int begin, end;
};

/// The structure of a tree. The vectors are indexed by bodies, except frame_body, which is indexed by frames.
/// Body 0 is the ground; its entries of parent, kind and leader are not used.
struct Connections {
  std::vector<int> parent;     ///< predecessor of each body, parent[i] < i
  std::vector<Subgroup> kind;  ///< subgroup of the joint that moves the body
  /// The joint that the joint of a body follows, its leader, which must not follow another one; 0 if none.
  std::vector<int> leader;
  std::vector<int> frame_body;  ///< body that each named frame moves with
};

/// The integer data of a tree: its structure, and the indices of the coordinates, velocities and screws of
/// each joint. Body 0 is the ground, and joint i moves body i. Comments of members begin with the size of the
/// vector, such as "n + 1".
struct Topology {
  explicit Topology(Connections connections);

  int n = 0, nq = 0, nv = 0;     ///< moving bodies, coordinates, velocities
  int n_screws = 0;              ///< number of joint screws: one per degree of freedom of every joint
  int depth = 0;                 ///< height of the tree velocity_parent: velocities on its longest path
  std::vector<int> parent;       ///< n + 1; parent[i] < i
  std::vector<Subgroup> kind;    ///< n + 1
  std::vector<char> coupled;     ///< n + 1
  std::vector<int> iq, iv;       ///< n + 1: first coordinate and velocity of the joint, or of its leader
  std::vector<int> first_screw;  ///< n + 2: joint i has screws first_screw[i] to first_screw[i + 1] - 1
  std::vector<int> frame_body;   ///< body of frame f: 0 is the ground, 1 to n are the bodies, others follow

  std::vector<JointGroup> joint_groups;
  std::vector<int> by_kind;  ///< n: the bodies, sorted by the groups in joint_groups
  /// The bodies whose joint is coupled, and the bodies whose joint has a quaternion and is not coupled.
  std::vector<int> coupled_bodies, quaternion_bodies;
  std::vector<int> subtree_end;  ///< n + 1: the bodies that joint i moves are i to subtree_end[i] - 1
  /// n: the bodies, sorted by the number of joints between them and the ground. In this order, steps of a
  /// recursion that do not need each other's results follow each other, so that a processor overlaps them.
  std::vector<int> by_depth;
  /// nv: velocities c to velocity_end[c] - 1 (without couplings) are in the subtree that velocity c moves.
  std::vector<int> velocity_end;
  /// Size nv: the parent of each velocity in the elimination tree of the mass matrix M = LᵀDL, from which
  /// velocities are eliminated from the last to the first; -1 for a root of this tree. Row c of L is non-zero
  /// only in the columns velocity_parent[c], the parent of that velocity, and so on. Without couplings the
  /// parent is the preceding velocity on the path to the ground.
  std::vector<int> velocity_parent;

  /// Data for the elimination of velocities that several coupled joints share, in a sweep from the leaves to
  /// the ground. For each joint that shares a velocity, a path leads from the body that the joint moves
  /// towards the ground. All paths of a velocity end at the body where they meet; there the velocity is
  /// eliminated. A tie is a pair of a shared velocity and a body on one of its paths.
  ///
  /// Ties begin[i] to begin[i + 1] - 1 belong to body i; body 0 is the ground. The elimination couples two
  /// ties of a body only if they are in the same group. Two ties of a body are in the same group
  ///   - if a path of one velocity and a path of the other come to the body through the same child, or
  ///   - if each of the two velocities is that of the body's own joint, or has paths that go on from the body
  ///     to its predecessor.
  /// Groups that have a tie in common are one group. Ties of a group are consecutive. Vectors without a size
  /// in their comment have one entry per tie.
  struct Ties {
    std::vector<int> begin;     ///< n + 2: first tie of each body
    std::vector<int> velocity;  ///< velocity of each tie
    /// The tie of the predecessor for the same velocity; -1 if the velocity is eliminated at this body.
    std::vector<int> up;
    /// n + 1: the tie for the velocity of the body's own joint; -1 if its joint shares no velocity.
    std::vector<int> own;
    std::vector<int> group_begin, group_end;  ///< first tie of the group of each tie, and its end
    /// The first pair of each tie. A tie has one pair with each tie of its group, in the order of the group.
    std::vector<std::size_t> row;
    std::size_t n_pairs = 0;  ///< number of pairs of all ties
    /// n + 2: index of the first pair (tie of body i, screw of its joint) in arrays of all such pairs.
    std::vector<std::size_t> of_screws;
  } ties;

  // The following members are for kernels that process several bodies in one SIMD register.
  std::vector<int> angle;      ///< iq of joints 1 to n, padded with 0 to a multiple of 16 entries
  std::vector<char> branches;  ///< n + 1: whether the body has a child other than the next body
  std::vector<int> hinges;     ///< n + 2: length of the run of hinges that are not coupled, from joint i on

  int n_frames() const { return static_cast<int>(frame_body.size()); }
};

}  // namespace axode
