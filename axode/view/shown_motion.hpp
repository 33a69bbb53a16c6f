#pragma once
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "axode/contact/contact_force.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// A motion that a page shows, row by row: N times t (s), N × nq coordinates q and N × nv velocities v.
struct ShownMotion {
  std::vector<double> t, q, v;
  std::vector<double> a, tau;  ///< accelerations and drive forces, N × nv; empty if not known
  std::vector<std::vector<ContactForce>> contacts;  ///< points of contact, N lists; empty if not known
  std::vector<std::string> contact_shapes;          ///< names of the shapes by the numbers in `contacts`
};

/// Checks a motion. Throws std::invalid_argument with the name of the argument if a size does not fit the
/// model, if times do not increase, if a number is not finite, or if a quaternion is not of unit norm.
void check(const Model& model, const ShownMotion& motion);

namespace view {

/// Quantities of a motion that are shown in addition to its states.
struct MotionNumbers {
  struct Series {
    std::string name, unit;
    std::vector<std::string> labels;
    std::vector<double> values;  ///< one row for each time, with one number for each label
  };
  std::vector<Series> series;
  /// Spatial twists of the bodies, wrenches that their joints transmit, and momenta: six numbers for each
  /// time and body. `wrenches` is empty if the accelerations are not known, or if the mechanism has loops and
  /// the drive forces are not known.
  std::vector<double> twists, wrenches, momenta;
  /// Spatial wrenches of the loop joints on their second bodies: six numbers for each time and loop joint.
  /// They are empty if `wrenches` is.
  std::vector<double> loop_wrenches;
  /// Tensions of the springs between points, N: one for each time and spring. A negative one pushes.
  std::vector<double> tensions;
};
/// Computes energies, total momentum (about the inertial origin), twists, wrenches, momenta and tensions of a
/// motion.
MotionNumbers numbers_of(const Model& model, const ShownMotion& motion);

}  // namespace view
}  // namespace axode
