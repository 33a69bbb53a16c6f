#pragma once
#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "axode/constraints/loops.hpp"

namespace axode {

/// A redundant row of A: a stress that the loops can carry without external forces.
struct RedundantRow {
  int row = 0;                 ///< its index in A
  std::string loop;            ///< the name of its loop
  Eigen::VectorXd dependency;  ///< n (rows) with nᵀ A = 0 and n = 1 at this row
  std::string wrench;          ///< the wrench of that stress in the loop, in words, in the inertial frame
};

/// Whether the velocities that satisfy A v = 0 belong to finite motions.
enum class Mobility {
  regular,   ///< all of them do
  branches,  ///< several motions meet here, and some velocities belong to none
  shaky,     ///< none of them do: the mobility is infinitesimal
};
std::string_view to_string(Mobility mobility);

struct LoopMobility {
  int degrees_of_freedom = 0;  ///< nv - rank, for velocities; rolling contacts leave more for positions
  int rank = 0;                ///< rank of A
  std::vector<RedundantRow> redundant;
  std::vector<int> indeterminate;  ///< rows whose multipliers are not determined, by redundancy
  Mobility mobility{};
  Eigen::MatrixXd kernel;  ///< nv × degrees_of_freedom: an orthonormal basis of A v = 0
};

/// Computes rank and degrees of freedom of a closed configuration. If q is not closed, redundancy by geometry
/// may be missed: the numbers are those of the rows at q. Allocates; O(nv³). Throws std::invalid_argument for
/// a wrong q.
[[nodiscard]] LoopMobility loop_mobility(const Model& model, std::span<const double> q);

}  // namespace axode
