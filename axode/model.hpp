#pragma once
#include "axode/model/building/builder.hpp"
#include "axode/model/building/edited.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/inertial_parameters.hpp"
#include "axode/model/model.hpp"
