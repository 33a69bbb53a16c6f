#pragma once
#include "axode/drives/drive_law.hpp"
#include "axode/drives/drive_system.hpp"
#include "axode/drives/elastic_feed_forward.hpp"
#include "axode/drives/linearization.hpp"

/// Drives with states of their own: motors, controllers, friction with bristles and cylinders, which act in
/// simulations; and feed-forward for motors with springs to their joints.
