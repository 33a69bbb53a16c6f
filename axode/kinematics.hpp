#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/center_of_mass.hpp"
#include "axode/kinematics/higher_order/higher_order.hpp"
#include "axode/kinematics/higher_order/jacobian_partials.hpp"
#include "axode/kinematics/higher_order/joint_screws.hpp"
#include "axode/kinematics/inverse_kinematics.hpp"
#include "axode/kinematics/jacobian.hpp"
#include "axode/kinematics/poses.hpp"
#include "axode/kinematics/twists.hpp"

/// Poses and motions of bodies and frames. T is the scalar type, double or float; Rep, the representation of
/// twists, is BodyFixed, Spatial, Hybrid or Mixed. q has nq, v and a have nv entries. Results for frames have
/// n_frames entries: the ground, the bodies, and the other frames. Functions that are documented as O(n)
/// allocate nothing. The functions throw std::invalid_argument for an argument of a wrong size, for a
/// quaternion that is not of unit norm, and for a result that shares memory with an argument, if the result
/// would be wrong.
