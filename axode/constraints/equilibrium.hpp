#pragma once
#include <string_view>
#include <vector>

#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

struct EquilibriumOptions {
  double tolerance = 1e-9;  ///< bound on the norm of the unbalanced forces, N m and N
  int iterations = 100;     ///< largest number of iterations
};

enum class EquilibriumStatus {
  solved,           ///< the unbalanced forces are within the tolerance
  stalled,          ///< no part of the last step reduced the unbalanced forces: probably no equilibrium is
                    ///< near
  iteration_limit,  ///< the iterations were used up
  open,             ///< no configuration near q0 that closes the loops was found
};
std::string_view to_string(EquilibriumStatus status);

struct EquilibriumResult {
  EquilibriumStatus status{};
  std::vector<double> q;  ///< the best configuration found
  double residual = 0;    ///< norm of the unbalanced forces at q, N m and N
  int iterations = 0;
};

/// Finds a configuration near q0 in which the system stays at rest under the drive forces tau (nv; 0 if it is
/// empty): the loops are closed, and the unbalanced forces are 0. These are the inverse dynamics at v = 0 and
/// a = 0 (Müller, eq. `LE`) minus tau and the forces of springs, mechanical stops and loops.
///
/// The method is Newton's on the configuration manifold, with the exact derivative of the unbalanced forces
/// by q along the velocities that the loops allow; if this derivative is singular, the least step is taken. A
/// step is at most 1 rad or m along each velocity, and is halved until the norm of the unbalanced forces
/// decreases. Equilibria may be stable or unstable. Limits of coordinates, damping and Coulomb friction are
/// ignored.
///
/// O(n³) for each iteration; allocates. Throws std::invalid_argument for wrong sizes, quaternions that are
/// not of unit norm, a load on a frame that does not exist, numbers that are not finite, options that are not
/// positive, and drives with states of their own, such as motors and cylinders.
[[nodiscard]] EquilibriumResult equilibrium(const Model& model, std::span<const double> q0,
                                            std::span<const double> tau = {}, const Loads<>& loads = {},
                                            const EquilibriumOptions& options = {});

}  // namespace axode
