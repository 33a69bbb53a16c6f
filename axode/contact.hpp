#pragma once
#include "axode/contact/contact_finder.hpp"
#include "axode/contact/contact_point.hpp"
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/distances.hpp"

/// Contact: collision shapes, the points where they touch, distances.
