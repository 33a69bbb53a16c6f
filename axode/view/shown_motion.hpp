#pragma once
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// A motion that is to be shown, row by row: N times (s), N × nq and N × nv numbers.
struct ShownMotion {
  std::vector<double> t, q, v;
  std::vector<double> a, tau;  ///< or empty, where they are not known
};

/// Throws std::invalid_argument that names what does not fit the model: sizes, times that do not increase, numbers that are
/// not finite, quaternions off 1.
void check(const Model& model, const ShownMotion& motion);

namespace view {

/// What is shown of a motion besides its states.
struct MotionNumbers {
  struct Series {
    std::string name, unit;
    std::vector<std::string> labels;
    std::vector<double> values;  ///< a row for each time
  };
  std::vector<Series> series;
  /// Twists of the bodies, wrenches that their joints transmit, and momenta: spatial, six numbers for each body and time.
  /// There are no wrenches where accelerations, or in loops drive forces, are not known.
  std::vector<double> twists, wrenches, momenta;
};
MotionNumbers numbers_of(const Model& model, const ShownMotion& motion);

}  // namespace view
}  // namespace axode
