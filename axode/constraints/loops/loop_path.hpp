#pragma once
#include <array>
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// A column of a loop's part of the Jacobian of the loop equations. It belongs to a joint screw, or to a term
/// of a coupling of joints.
struct LoopColumn {
  int velocity;
  int screw = -1;     ///< index of the joint screw; -1 for a term of a coupling
  int body = 0;       ///< body whose joint has the screw
  int side = 0;       ///< 1 if the body is on the path to the loop's second body, -1 if it is on the path to
                      ///< the first
  double factor = 0;  ///< factor of a term of a coupling
};

/// The indices of the equations of a loop, and the paths in the spanning tree that it closes.
struct LoopPath {
  LoopPath(const Tree<double>& tree, const Loop& joint);
  /// Makes the path of a coupling. A coupling has no bodies: both its ends are the ground.
  LoopPath(const Tree<double>& tree, const LoopCoupling& coupling);

  /// Consecutive rows of A (velocity level) or of R (position level).
  struct Range {
    int first, count;
    bool operator==(const Range&) const = default;
  };

  Range rows, residuals;  ///< rows of this loop in A and in R
  std::array<Loop::End, 2> ends = {};
  std::array<int, 2> root{};        ///< first body on the path from the ground to each end; 0 for the ground
  int meeting = 0;                  ///< body where the paths from the two bodies to the ground meet; 0 if it
                                    ///< is the ground
  std::vector<LoopColumn> columns;  ///< joint screws from the two bodies up to `meeting`, or terms of a
                                    ///< coupling
  std::vector<int> bodies;          ///< all bodies on the paths from the two bodies, or from the joints of a
                                    ///< coupling, to the ground, in descending order
  std::vector<int> velocities;      ///< indices of velocities that are eliminated on these paths, ascending

 private:
  explicit LoopPath(const LoopRows& of)
      : rows{of.first_row, of.rows}, residuals{of.first_residual, of.residuals} {}
  void add_bodies(const Topology& topology, const std::vector<int>& from);
};

}  // namespace axode
