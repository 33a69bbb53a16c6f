#pragma once
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/driven/drive_sensitivities.hpp"
#include "axode/integration/drives.hpp"
#include "axode/integration/methods.hpp"
#include "axode/integration/prescribed/kinematic_motion.hpp"
#include "axode/integration/reconstruction.hpp"
#include "axode/integration/references/profiles.hpp"
#include "axode/integration/references/sampled_trajectory.hpp"
#include "axode/integration/sensitivities.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/integration/trajectory.hpp"

/// Motion in time: integration on Lie groups (section 7).
