#pragma once
#include <cstddef>
#include <vector>

#include "axode/model/subgroup.hpp"

namespace axode {

/// Bodies whose joints are of one kind: by_kind[begin] to by_kind[end - 1].
struct JointGroup {
  Subgroup kind;
  bool coupled;  ///< whether the joints are coupled, q_i = ratio q_j + offset; coupled groups come last
  int begin, end;
};

/// The bodies and joints of a tree before its coordinates are numbered. Body 0 is the ground; its entries are
/// not used.
struct Connections {
  std::vector<int> parent;     ///< predecessor of each body, parent[i] < i
  std::vector<Subgroup> kind;  ///< subgroup of the joint that moves the body
  /// Joint that the joint of the body follows, which has no leader itself; 0 if there is none.
  std::vector<int> leader;
  std::vector<int> frame_body;  ///< body that each named frame moves with
};

/// The integers of a tree: its structure, and the indices of the coordinates, velocities and screws of each
/// joint. Body 0 is the ground; joint i moves body i. A topology is made once and shared by the trees of all
/// scalars.
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
  std::vector<int> frame_body;   ///< body of frame f: 0 is the ground, 1 to n are the bodies, others follow

  std::vector<JointGroup> joint_groups;
  std::vector<int> by_kind;  ///< n
  /// Bodies whose joint is coupled, and bodies whose joint has a quaternion.
  std::vector<int> coupled_bodies, quaternion_bodies;
  std::vector<int> subtree_end;  ///< n + 1: the bodies that joint i moves are i to subtree_end[i] - 1
  /// nv entries: without couplings the velocities of the subtree that c moves are c to velocity_end[c] - 1.
  std::vector<int> velocity_end;
  /// nv entries: M = LᵀDL has the entries L(c, velocity_parent[c]), ...; -1 at the end. This is the
  /// elimination tree of M from the last velocity to the first. Without couplings it is the preceding
  /// velocity on the path to the ground; a coupled joint joins the path of its leader with its own.
  std::vector<int> velocity_parent;

  /// Velocities that several joints share, during an elimination from the leaves to the ground. There is one
  /// entry for each body between a joint that has the velocity and the body where the paths of all these
  /// joints meet. There the velocity is eliminated, before the joint of that body, unless that joint has it
  /// as well. Entries ties.begin[i] to ties.begin[i + 1] - 1 belong to body i, 0 for the ground. Entries that
  /// come through one body or go on together are consecutive and form a group; entries of different groups
  /// are not coupled.
  struct Ties {
    std::vector<int> begin;     ///< n + 2
    std::vector<int> velocity;  ///< velocity of each entry
    /// The entry of the predecessor for the same velocity; -1 if the velocity is eliminated at this body.
    std::vector<int> up;
    /// n + 1: the entry for the joint of the body itself; -1 if this shares no velocity.
    std::vector<int> own;
    std::vector<int> group_begin, group_end;  ///< the entries of the group of each entry
    /// The first pair of each entry, which has one with each entry of its group.
    std::vector<std::size_t> row;
    std::size_t n_pairs = 0;
    /// n + 2: offsets like `begin`, but with the entries of body i repeated for each screw of its joint.
    std::vector<std::size_t> of_screws;
  } ties;

  // The following members are for sweeps that take several bodies at once.
  std::vector<int> angle;  ///< iq of joints 1 to n, and 0 up to a multiple of the lanes of any SIMD register
  std::vector<char> branches;  ///< n + 1: whether a body other than the next one hangs on the body
  std::vector<int> hinges;  ///< n + 2: how many hinges with coordinates of their own follow, from joint i on

  int n_frames() const { return static_cast<int>(frame_body.size()); }
};

}  // namespace axode
