#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "axode/contact/contact_force.hpp"
#include "axode/lie/representation_change.hpp"
#include "axode/model/model.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// A motion to be shown, row by row: N times t (s), N × nq coordinates q and N × nv velocities v.
struct ShownMotion {
  std::vector<double> t, q, v;
  std::vector<double> a, tau;  ///< accelerations and drive forces, N × nv; empty if not known
  std::vector<std::vector<ContactForce>> contacts;  ///< points of contact, N lists; empty if not known
  std::vector<std::string> contact_shapes;          ///< names of shapes; `contacts` has indices into it
  /// Wrenches that act on frames in addition to gravity, drives, springs and contacts: a list for each time,
  /// or empty if there are none.
  std::vector<std::vector<AppliedWrench<>>> loads;
};

/// Checks whether a motion fits the model. Throws std::invalid_argument if a size is wrong, if the times do
/// not increase, if a number is not finite, if a quaternion is not of unit norm, or if a contact or a load
/// has the index of a shape or frame that does not exist.
void check(const Model& model, const ShownMotion& motion);

namespace view {

/// The wrench of a load on a frame with the pose C, in the representation Rep.
template <class Rep> Wrench<Rep> wrench_in(const AppliedWrench<>& load, const SE3<>& C) {
  return with_representation(load.representation, [&](auto given) {
    return change<Rep>(C, Wrench<decltype(given)>{load.m, load.f});
  });
}

/// The frames on which loads act at some time, each of them once, in the order of the model.
std::vector<int> loaded_frames(std::span<const std::vector<AppliedWrench<>>> loads);

/// Quantities that are computed from a motion and shown in addition to its states.
struct MotionNumbers {
  struct Series {
    std::string name, unit;
    std::vector<std::string> labels;
    std::vector<double> values;  ///< a row for each time, with a number for each label
  };
  std::vector<Series> series;
  /// Twists of the bodies, wrenches that their joints transmit, and momenta of the bodies, all spatial: six
  /// numbers for each time and body. `wrenches` is empty if they cannot be computed: if the accelerations are
  /// not known, if the motion has contacts of a shape whose name the model does not have, or, in a model with
  /// loops, if the drive forces are not known or the constraint forces of the loops cannot be computed.
  std::vector<double> twists, wrenches, momenta;
  /// Wrenches (spatial) that the loop joints exert on their second bodies: six numbers for each time and loop
  /// joint. Empty if the model has no loop joints, or if `wrenches` is empty because the wrenches of the
  /// joints of the tree cannot be computed.
  std::vector<double> loop_wrenches;
  /// load_frames are the frames on which loads act, and `loads` has the sum of the loads on each of them as a
  /// spatial wrench: six numbers for each time and frame.
  std::vector<int> load_frames;
  std::vector<double> loads;
  /// Tensions in springs that act along a path of points, N: a number for each time and each straight segment
  /// of a path. A negative tension pushes the ends of the segment apart.
  std::vector<double> tensions;
};
/// Computes the numbers that are shown with a motion: energies, the total momentum about the inertial origin,
/// the twists and momenta of the bodies, the wrenches that joints and loop joints transmit, the sums of the
/// loads on frames, the tensions in springs, and the normal forces of contacts. The loads of the motion are
/// taken into account.
MotionNumbers numbers_of(const Model& model, const ShownMotion& motion);

}  // namespace view
}  // namespace axode
