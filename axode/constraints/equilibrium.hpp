#pragma once
#include <string_view>
#include <vector>

#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

struct EquilibriumOptions {
  double tolerance = 1e-9;  ///< on the norm of the forces that are missing, N m and N
  int iterations = 100;     ///< at most
};

enum class EquilibriumStatus {
  solved,   ///< what is missing is within the tolerance
  stalled,  ///< no part of the last step was an improvement: there is no equilibrium near, most likely
  iteration_limit,  ///< the iterations were used up
  open,             ///< the loops do not close near q0
};
std::string_view to_string(EquilibriumStatus status);

struct EquilibriumResult {
  EquilibriumStatus status{};
  std::vector<double> q;  ///< the best configuration met
  double residual = 0;    ///< norm of the forces that are missing there, N m and N
  int iterations = 0;
};

/// A configuration near q0 in which the system stays at rest under the drive forces tau, none where tau is empty: one where
/// inverse dynamics at v = 0 and a = 0, gravity torques less the loads, is tau and what the springs and stops of the model add to
/// it (`LE`), and the loops, which are closed. Newton's method on the configuration
/// manifold with the exact ∂τ/∂q, along the velocities that the loops allow; a step is the smallest one where that is
/// singular, at most 1 rad or m for each velocity, closed by assemble(),
/// and halved until it is an improvement. Finds stable and unstable equilibria alike, and heeds no limits. Coulomb
/// friction, which would hold a whole range of configurations, is not counted, nor is damping. O(n³) for each iteration;
/// allocates. Throws std::invalid_argument for wrong sizes, a quaternion off 1, a load on a frame that does not exist and
/// numbers that are not finite.
[[nodiscard]] EquilibriumResult equilibrium(const Model& model, std::span<const double> q0,
                                            std::span<const double> tau = {}, const Loads<>& loads = {},
                                            const EquilibriumOptions& options = {});

}  // namespace axode
