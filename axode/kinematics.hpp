#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/center_of_mass.hpp"
#include "axode/kinematics/higher_order.hpp"
#include "axode/kinematics/inverse_kinematics.hpp"
#include "axode/kinematics/jacobian.hpp"
#include "axode/kinematics/jacobian_partials.hpp"
#include "axode/kinematics/joint_screws.hpp"
#include "axode/kinematics/poses.hpp"
#include "axode/kinematics/twists.hpp"

/// Where every body is and how it moves. T is the scalar of the workspace, double or float; Rep is BodyFixed,
/// Spatial, Hybrid or Mixed. q has nq, v and a have nv entries; results for frames have n_frames entries: the ground,
/// the bodies in the model's order, the other frames, each in the frame that the user placed. What is O(n) allocates
/// nothing. Throws std::invalid_argument for a wrong size or a quaternion off 1. A result may take the place of an
/// argument where that can be right, and is refused otherwise.
