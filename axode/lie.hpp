#pragma once
#include "axode/lie/inertia.hpp"
#include "axode/lie/quaternion.hpp"
#include "axode/lie/representation_change.hpp"
#include "axode/lie/screw_geometry.hpp"
#include "axode/lie/se3.hpp"
#include "axode/lie/solids.hpp"
#include "axode/lie/twist.hpp"
