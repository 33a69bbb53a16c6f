#pragma once
#include "axode/constraints/embedding/task_space.hpp"

namespace axode {

/// Inverse dynamics of any order of a parallel manipulator: computes the drive forces τ and their time
/// derivatives τ', τ'', ... (`tau`, K rows of nv numbers, 1 to 7 rows) along a motion. The motion is given by
/// the configuration q, the task velocities V (components of the platform's twist, then velocities of joints
/// that it does not determine) and their derivatives V', V'', ... (`rates`, K + 1 rows with one number for
/// each task velocity). `motion`, unless it is empty, receives the joint velocities and their derivatives v,
/// v', v'', ... (K + 1 rows of nv numbers). Small linear systems are solved for each chain that carries the
/// platform (D18.13, D18.14).
///
/// There must be as many drives as task velocities, and no loop equation may be redundant; otherwise the
/// returned verdict is drives_singular. The verdict also reports singular limbs and numbers that are not
/// finite. Throws std::invalid_argument for wrong sizes. Allocates; O(K² (nv + m d) + K³ n) for n bodies and
/// m loop equations on paths of d joints.
[[nodiscard]] TaskVerdict inverse_dynamics_rates(TaskSpace& space, std::span<const double> q,
                                                 std::span<const double> rates, std::span<double> tau,
                                                 std::span<double> motion = {},
                                                 const Loads<double>& loads = {});

}  // namespace axode
