#pragma once
#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "axode/constraints/loops.hpp"

namespace axode {

/// A redundant loop equation: it depends on the other ones, so that the loops can carry a state of internal
/// stress without external forces.
struct RedundantRow {
  int row = 0;                 ///< index of the row in A
  std::string loop;            ///< name of the loop that has the row
  Eigen::VectorXd dependency;  ///< vector n (one entry for each row of A) with nᵀ A = 0 and n = 1 at this row
  std::string wrench;          ///< the wrench of the loop joint in this state of stress, described in words,
                               ///< in the inertial frame
};

/// Whether the velocities that satisfy A v = 0 belong to finite motions.
enum class Mobility {
  regular,   ///< all velocities with A v = 0 belong to finite motions
  branches,  ///< several motions meet in this configuration, and some velocities with A v = 0 belong to none
             ///< of them
  shaky,     ///< no velocity with A v = 0 belongs to a finite motion: the mobility is infinitesimal
};
std::string_view to_string(Mobility mobility);

struct LoopMobility {
  int degrees_of_freedom = 0;  ///< nv - rank, the degrees of freedom of velocities; positions have more if
                               ///< there are rolling contacts
  int rank = 0;                ///< rank of A
  std::vector<RedundantRow> redundant;
  std::vector<int> indeterminate;  ///< indices of rows of A whose multipliers are indeterminate because of
                                   ///< redundancy
  Mobility mobility{};
  Eigen::MatrixXd kernel;  ///< nv × degrees_of_freedom: an orthonormal basis of the velocities with A v = 0
};

/// Computes the rank of the loop equations A v = 0 at a closed configuration q, the degrees of freedom (nv
/// minus the rank), the redundant equations, and the mobility: whether the velocities with A v = 0 belong to
/// finite motions. If loops are open at q, equations that are redundant only while the loops are closed may
/// count as independent. Allocates; O(nv³). Throws std::invalid_argument for a wrong size of q and for
/// quaternions that are not of unit norm.
[[nodiscard]] LoopMobility loop_mobility(const Model& model, std::span<const double> q);

}  // namespace axode
