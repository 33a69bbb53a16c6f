#pragma once
#include "axode/fmi/fmu.hpp"
