#pragma once
#include "axode/constraints.hpp"
#include "axode/derivatives.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration.hpp"
#include "axode/kinematics.hpp"
#include "axode/lie.hpp"
#include "axode/model.hpp"
