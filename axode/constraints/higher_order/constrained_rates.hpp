#pragma once
#include "axode/constraints/loops.hpp"
#include "axode/derivatives/rates.hpp"

namespace axode {

/// Computes the drive forces τ of a mechanism with loops and their time derivatives τ', τ'', ... (`tau`, K
/// rows of nv numbers, 1 to 7 rows) along a motion, which is given by q and the rates v, v', v'', ...
/// (`rates`, K + 1 rows of nv numbers). `drives` has the indices of the velocities on which drives act; if it
/// is empty, all joints that are not passive have drives. If there are more drives than the mechanism needs,
/// the τ with the least Euclidean norm is computed, and the other rows are its time derivatives. One linear
/// system is solved for each order, all with the same matrix (D3.14). Returns the norm of the forces that no
/// drive can produce, divided by the norm of all required forces, for the order for which this ratio is
/// largest. Forces within rounding of the terms of which they are sums count as 0.
///
/// Throws std::invalid_argument for wrong sizes, more than 7 rows of forces, numbers that are not finite, and
/// a motion of which some derivative does not keep a loop closed. Allocates; O(K (nv + m)³ + n K²) for n
/// bodies and m loop equations.
[[nodiscard]] double inverse_dynamics_rates(const Model& model, LoopWorkspace<>& workspace, Numbers<double> q,
                                            Numbers<double> rates, std::span<double> tau,
                                            std::span<const int> drives = {},
                                            const Loads<double>& loads = {});

}  // namespace axode
