#pragma once
#include <array>
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// A velocity that a loop feels: the column of A that belongs to a joint screw, or to a term of a coupling.
struct LoopColumn {
  int velocity;
  int screw = -1;     ///< -1 for a term of a coupling
  int body = 0;       ///< whose joint has the screw
  int side = 0;       ///< 1 on the path to the second body, -1 on that to the first
  double factor = 0;  ///< of a term
};

/// The constant part of a loop: its rows, and the paths on the tree that it closes.
struct LoopPath {
  LoopPath(const Tree<double>& tree, const Loop& joint);
  /// A coupling has no ends: they are at the ground.
  LoopPath(const Tree<double>& tree, const LoopCoupling& coupling);

  /// Rows of A, or of those that have a residual.
  struct Range {
    int first, count;
    bool operator==(const Range&) const = default;
  };

  Range rows, residuals;  ///< of this loop
  std::array<Loop::End, 2> ends = {};
  std::array<int, 2> root{};        ///< of its bodies; 0 for the ground
  int meeting = 0;                  ///< the body where the two paths meet, 0 for the ground
  std::vector<LoopColumn> columns;  ///< up to there
  std::vector<int> bodies;          ///< on the paths to the ground, the last ones first
  std::vector<int> velocities;      ///< that give way there

 private:
  explicit LoopPath(const LoopRows& of)
      : rows{of.first_row, of.rows}, residuals{of.first_residual, of.residuals} {}
  void add_bodies(const Topology& topology, const std::vector<int>& from);
};

}  // namespace axode
