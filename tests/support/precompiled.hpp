#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "axode/axode.hpp"
#include "axode/eigen.hpp"
#include "axode/io.hpp"
