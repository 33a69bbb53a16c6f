#pragma once
#include "axode/contact/contact_finder.hpp"
#include "axode/contact/contact_force.hpp"
#include "axode/contact/contact_point.hpp"
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/contacts_at_rest.hpp"
#include "axode/contact/distances.hpp"
#include "axode/contact/floor.hpp"
#include "axode/contact/with_shapes.hpp"

/// Contact: collision shapes, the points at which they touch, contact forces at rest, and distances.
