#pragma once
#include <array>
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// A column of A with non-zero entries in the rows of a loop: a joint screw, or a term of a coupling.
struct LoopColumn {
  int velocity;
  int screw = -1;     ///< number of the joint screw; -1 for a term of a coupling
  int body = 0;       ///< the body whose joint has the screw
  int side = 0;       ///< 1 on the path to the second body, -1 on that to the first
  double factor = 0;  ///< the factor of a term of a coupling
};

/// The constant part of a loop: the indices of its rows, and the paths in the tree that it closes.
struct LoopPath {
  LoopPath(const Tree<double>& tree, const Loop& joint);
  /// A coupling has no bodies: both its ends are the ground.
  LoopPath(const Tree<double>& tree, const LoopCoupling& coupling);

  /// Consecutive rows of A or of R.
  struct Range {
    int first, count;
    bool operator==(const Range&) const = default;
  };

  Range rows, residuals;  ///< the rows of this loop in A and in R
  std::array<Loop::End, 2> ends = {};
  std::array<int, 2> root{};        ///< the roots of its two bodies; 0 for the ground
  int meeting = 0;                  ///< the body where the two paths meet, 0 for the ground
  std::vector<LoopColumn> columns;  ///< the joint screws from the two bodies up to `meeting`, or the terms of
                                    ///< a coupling
  std::vector<int> bodies;          ///< all bodies on the paths to the ground, in descending order
  std::vector<int> velocities;      ///< velocities that are eliminated on these paths, ascending

 private:
  explicit LoopPath(const LoopRows& of)
      : rows{of.first_row, of.rows}, residuals{of.first_residual, of.residuals} {}
  void add_bodies(const Topology& topology, const std::vector<int>& from);
};

}  // namespace axode
