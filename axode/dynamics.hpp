#pragma once
#include "axode/dynamics/closed_form/coriolis.hpp"
#include "axode/dynamics/closed_form/regressor.hpp"
#include "axode/dynamics/closed_form/terms.hpp"
#include "axode/dynamics/closed_form/twist_form.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/dynamics/inverse_dynamics.hpp"
#include "axode/dynamics/joint_wrenches.hpp"
#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "axode/dynamics/mass_matrix/mass_matrix_factor.hpp"
#include "axode/dynamics/mass_matrix/mass_matrix_partials.hpp"
#include "axode/dynamics/momentum/body_momenta.hpp"
#include "axode/dynamics/momentum/energy.hpp"
#include "axode/dynamics/momentum/momentum.hpp"
#include "axode/dynamics/momentum/momentum_form.hpp"
#include "axode/dynamics/momentum/spatial_momentum_form.hpp"
#include "axode/dynamics/operational_space.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/kinematics.hpp"

/// Forces from motion (inverse dynamics), and motion from forces (forward dynamics). Sizes of arguments and
/// exceptions are as in axode/kinematics.hpp. T is the scalar type. Rep is the representation of twists in
/// which the recursion runs: BodyFixed, Spatial, Hybrid or Mixed. If the results of a function do not depend
/// on it, Rep can also be Fast, the default, which stands for the fastest algorithm.
