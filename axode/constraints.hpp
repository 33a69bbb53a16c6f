#pragma once
#include "axode/constraints/absolute/joint_state.hpp"
#include "axode/constraints/assembly.hpp"
#include "axode/constraints/constrained_derivatives.hpp"
#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/constraints/constrained_operational_space.hpp"
#include "axode/constraints/equilibrium.hpp"
#include "axode/constraints/independent/independent_equations.hpp"
#include "axode/constraints/independent/independent_linearization.hpp"
#include "axode/constraints/loops.hpp"
#include "axode/constraints/mobility.hpp"

/// Closed loops: rows and residuals of loop joints, dynamics, assembly, mobility, small motions; equilibria,
/// also of trees.
