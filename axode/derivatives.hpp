#pragma once
#include "axode/derivatives/forward_dynamics_derivatives.hpp"
#include "axode/derivatives/geometry_derivatives.hpp"
#include "axode/derivatives/inverse_dynamics_derivatives.hpp"
#include "axode/derivatives/linearization.hpp"
#include "axode/derivatives/momentum_form_derivatives.hpp"
#include "axode/derivatives/motion_derivatives.hpp"
#include "axode/derivatives/products/products.hpp"
#include "axode/derivatives/rates.hpp"
#include "axode/derivatives/second_order/hessian.hpp"
#include "axode/derivatives/second_order/second_derivatives.hpp"
#include "axode/derivatives/spring_derivatives.hpp"
#include "axode/derivatives/term_derivatives.hpp"

/// Derivatives of the dynamics with respect to the state, time, geometry and inertia (section 6).
