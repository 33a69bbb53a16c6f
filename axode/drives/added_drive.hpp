#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "axode/drives/drive_law.hpp"

namespace axode {

/// A drive besides those that the description of a mechanism has, with a law of its own.
struct AddedDrive {
  std::string name;
  std::vector<std::pair<std::string, double>> joints;  ///< joints of one velocity with their factors
  std::shared_ptr<const DriveLaw> law;
  std::function<double(double t)> input = {};  ///< continuous; empty: 0
};

}  // namespace axode
