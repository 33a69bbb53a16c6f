#pragma once
#include <array>
#include <functional>
#include <string>
#include <unordered_map>
#include <vector>

#include "tests/laws/law.hpp"

/// The correspondence between two models of one mechanism: which joints and which frames are the same, by
/// their names.
namespace axode::test {

using NameOfOther = std::function<std::string(const std::string&)>;

class Correspondence {
 public:
  /// `name_in_b` gives the name in `b` of a joint or frame of `a`. If `b` has no joint or frame of that name,
  /// the one of `a` has no counterpart.
  Correspondence(
      const Model& a, const Model& b, const NameOfOther& name_in_b = [](const std::string& s) { return s; });

  /// The index in `b` of the joint or frame with index i in `a`, or -1 if `b` has none.
  int joint(int i) const { return joint_[static_cast<std::size_t>(i)]; }
  int frame(int f) const { return frame_[static_cast<std::size_t>(f)]; }

  /// The state of `b` in which every joint has the coordinates that it has in the state of `a`, and every
  /// load the same components. Joints of `b` that `a` lacks are neutral and at rest.
  State<double> carry(const State<double>& state) const;

  /// The generalised forces of those joints that both models have, of `a` and of `b`, in the same order.
  std::array<std::vector<double>, 2> common(const std::vector<double>& tau_a,
                                            const std::vector<double>& tau_b) const;
  /// Picks from a list of quantities of all frames of `b` those of the frames of `a`, in the order of `a`.
  /// Every frame of `a` must have a counterpart.
  std::vector<Six> of_frames(const std::vector<Six>& in_b) const;

 private:
  /// Calls f(joint of a, joint of b) for each joint of both models that has coordinates of its own.
  template <class F> void each_joint(const F& f) const {
    for (int i = 1; i <= a_.n_bodies(); ++i)
      if (!a_.joint(i).leader && joint(i) > 0) f(a_.joint(i), b_.joint(joint(i)));
  }

  Model a_, b_;
  std::vector<int> joint_, frame_;
};

/// Where the frames of one description of a mechanism are in those of another one: the pose of its
/// construction frame, and the poses of the frames of bodies and of named frames that are not the same in
/// both.
struct Shift {
  SE3<> construction_frame = {};
  std::unordered_map<std::string, SE3<>> frames = {};

  SE3<> of(const std::string& frame) const {
    const auto found = frames.find(frame);
    return found == frames.end() ? SE3<>{} : found->second;
  }
};

/// The second description of a mechanism, with all that the first one has on its joints and between its
/// bodies: drives, springs, stops, loops and couplings. Joints of the second one that the first one lacks
/// stay as they are. The loops of the first one are given by frames.
Description with_parts_of(const Description& first, Description second, const Shift& shift = {});

/// Changes all loads of a state into the spatial representation, where they do not depend on the body frames.
void make_loads_spatial(const Model& model, State<double>& state);

/// The displacement of a joint in its joint frame from its coordinates, and the coordinates from such a
/// displacement.
SE3<> displacement(Subgroup kind, double pitch, const double* q);
std::vector<double> coordinates(Subgroup kind, const SE3<>& D);
/// The screw S v of joint velocities v, and the components Sᵀ X of a screw or a wrench X along the columns of
/// S.
Screw<> joint_screw(Subgroup kind, double pitch, const double* v);
std::vector<double> components(Subgroup kind, double pitch, const Screw<>& X);

}  // namespace axode::test
