#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "tests/laws/law.hpp"

/// Two models of one mechanism: which joint and which frame of the one is which of the other, by name.
namespace axode::test {

using NameOfOther = std::function<std::string(const std::string&)>;

class Correspondence {
 public:
  /// `name_in_b` says what a joint or frame of `a` is called in `b`. What `b` does not have has no
  /// counterpart.
  Correspondence(
      const Model& a, const Model& b, const NameOfOther& name_in_b = [](const std::string& s) { return s; });

  /// The joint or frame of `b`, or -1.
  int joint(int i) const { return joint_[static_cast<std::size_t>(i)]; }
  int frame(int f) const { return frame_[static_cast<std::size_t>(f)]; }

  /// The state of `a` as one of `b`: the same coordinates of each joint, the same components of each load.
  /// Joints of `b` without a counterpart stay neutral and at rest.
  State<double> carry(const State<double>& state) const;

  /// Of generalised forces of `a` and of `b`, those of the joints that both have, in one order.
  std::array<std::vector<double>, 2> common(const std::vector<double>& tau_a,
                                            const std::vector<double>& tau_b) const;
  /// Of quantities of the frames of `b`, those of the frames of `a`, in the order of `a`; all have a counterpart.
  std::vector<Six> of_frames(const std::vector<Six>& in_b) const;

 private:
  /// f(joint of a, joint of b) for those with coordinates of their own.
  template <class F> void each_joint(const F& f) const {
    for (int i = 1; i <= a_.n_bodies(); ++i)
      if (!a_.joint(i).leader && joint(i) > 0) f(a_.joint(i), b_.joint(joint(i)));
  }

  Model a_, b_;
  std::vector<int> joint_, frame_;
};

/// Loads in the spatial representation, in which they do not depend on where body frames are.
void make_loads_spatial(const Model& model, State<double>& state);

/// The displacement of a joint in its joint frame, and the coordinates of such a displacement.
SE3<> displacement(Subgroup kind, double pitch, const double* q);
std::vector<double> coordinates(Subgroup kind, const SE3<>& D);
/// S v, and the components Sᵀ X of a screw or wrench along the columns of S.
Screw<> joint_screw(Subgroup kind, double pitch, const double* v);
std::vector<double> components(Subgroup kind, double pitch, const Screw<>& X);

}  // namespace axode::test
