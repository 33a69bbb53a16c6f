#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "axode/drives/drive_law.hpp"

namespace axode {

/// A drive that a simulation adds to those of the mechanism. It acts along Σ factor q of its `joints`.
struct AddedDrive {
  std::string name;
  std::vector<std::pair<std::string, double>> joints;  ///< names of joints with one velocity, and factors
  std::shared_ptr<const DriveLaw> law;
  std::function<double(double t)> input = {};  ///< input u, continuous in t (s); empty: 0
};

}  // namespace axode
