#pragma once
#include "axode/model/builder.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/edited.hpp"
#include "axode/model/inertial_parameters.hpp"
#include "axode/model/model.hpp"
