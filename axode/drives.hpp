#pragma once
#include "axode/drives/drive_law.hpp"
#include "axode/drives/drive_system.hpp"
#include "axode/drives/elastic_feed_forward.hpp"
#include "axode/drives/linearization.hpp"

/// Drives with states of their own, which act in simulations: motors, controllers, friction with bristles,
/// and hydraulic cylinders. Also the feed-forward for motors on elastic joints.
