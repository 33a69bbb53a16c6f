#pragma once
#include "axode/dynamics/body_momenta.hpp"
#include "axode/dynamics/coriolis.hpp"
#include "axode/dynamics/energy.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/dynamics/inverse_dynamics.hpp"
#include "axode/dynamics/joint_wrenches.hpp"
#include "axode/dynamics/mass_matrix.hpp"
#include "axode/dynamics/mass_matrix_factor.hpp"
#include "axode/dynamics/mass_matrix_partials.hpp"
#include "axode/dynamics/momentum.hpp"
#include "axode/dynamics/momentum_form.hpp"
#include "axode/dynamics/operational_space.hpp"
#include "axode/dynamics/regressor.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/dynamics/terms.hpp"
#include "axode/dynamics/twist_form.hpp"
#include "axode/kinematics.hpp"

/// Forces from motion, and motion from forces. Conventions as in axode/kinematics.hpp: T is the scalar of the
/// workspace, Rep the representation in which the recursion runs. If results do not depend on Rep, it is Fast
/// by default, which takes the least time.
