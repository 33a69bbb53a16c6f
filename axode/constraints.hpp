#pragma once
#include "axode/constraints/absolute/joint_state.hpp"
#include "axode/constraints/assembly.hpp"
#include "axode/constraints/constrained_derivatives.hpp"
#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/constraints/constrained_operational_space.hpp"
#include "axode/constraints/embedding/platform_placement.hpp"
#include "axode/constraints/embedding/task_rates.hpp"
#include "axode/constraints/embedding/task_singularities.hpp"
#include "axode/constraints/embedding/task_space.hpp"
#include "axode/constraints/equilibrium.hpp"
#include "axode/constraints/higher_order/constrained_rates.hpp"
#include "axode/constraints/higher_order/inverse_kinematics_rates.hpp"
#include "axode/constraints/independent/independent_equations.hpp"
#include "axode/constraints/independent/independent_linearization.hpp"
#include "axode/constraints/local_mobility/local_mobility.hpp"
#include "axode/constraints/loops.hpp"
#include "axode/constraints/mobility.hpp"
#include "axode/constraints/prescribed/prescribed_motion.hpp"

/// Mechanisms with closed loops: constraint equations, dynamics, assembly (finding configurations with closed
/// loops), mobility, linearised motions, and parallel manipulators in task space. Also prescribed motions and
/// equilibria.
