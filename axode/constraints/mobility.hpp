#pragma once
#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "axode/constraints/loops.hpp"

namespace axode {

/// A row that others imply: a stress that the loops can carry by themselves.
struct RedundantRow {
  int row = 0;                 ///< of A
  std::string loop;            ///< to which it belongs
  Eigen::VectorXd dependency;  ///< n (rows) with nᵀ A = 0 and n = 1 at this row
  std::string wrench;          ///< what the loop carries for nothing, in words, in the inertial frame
};

/// What velocities that the loops allow are.
enum class Mobility {
  regular,   ///< all of them begin motions
  branches,  ///< several motions meet here, and some velocities belong to none
  shaky,     ///< velocities of first order alone: nothing moves
};
std::string_view to_string(Mobility mobility);

struct LoopMobility {
  int degrees_of_freedom = 0;  ///< nv - rank, of velocities; of places there are more where wheels roll
  int rank = 0;                ///< of A
  std::vector<RedundantRow> redundant;
  std::vector<int> indeterminate;  ///< rows whose multipliers redundancy leaves open
  Mobility mobility{};
  Eigen::MatrixXd kernel;  ///< nv × degrees_of_freedom: an orthonormal basis of the velocities that A allows
};

/// Rank and freedom of a closed configuration; of one that is not closed the numbers are those of its rows, which is
/// another matter where redundancy is by geometry. Allocates, O(nv³). Throws std::invalid_argument for a wrong q.
[[nodiscard]] LoopMobility loop_mobility(const Model& model, std::span<const double> q);

}  // namespace axode
