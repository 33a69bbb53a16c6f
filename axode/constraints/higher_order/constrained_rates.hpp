#pragma once
#include "axode/constraints/loops.hpp"
#include "axode/derivatives/rates.hpp"

namespace axode {

/// The time derivatives τ, τ', τ'', ... of the drive forces of a mechanism with loops (`tau`, K rows of nv)
/// along a motion (`rates`, K + 1 rows of nv: v, v', v'', ..., as inverse_kinematics_rates() has them), with
/// drives and loads as in inverse_dynamics(): of more drives than the mechanism needs the least τ, and its
/// derivatives. Returns the largest part of the required forces, by norm, of any order, that no drive can
/// produce. One linear system for each order, with the same matrix, (D3.14).
///
/// Throws std::invalid_argument for wrong sizes, more than 7 rows of forces, and a motion of which some
/// derivative does not keep a loop closed. Allocates; O(K (nv + m)³ + n K²) for m rows of loops.
[[nodiscard]] double inverse_dynamics_rates(const Model& model, LoopWorkspace<>& workspace, Numbers<double> q,
                                            Numbers<double> rates, std::span<double> tau,
                                            std::span<const int> drives = {},
                                            const Loads<double>& loads = {});

}  // namespace axode
