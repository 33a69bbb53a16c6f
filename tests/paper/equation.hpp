#pragma once
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "tests/paper/motion.hpp"

/// The tests of the paper's equations: both sides are evaluated for every body, on chains and on trees, at
/// random states. "i - 1" is the predecessor of body i, or the ground if it has none.
namespace axode::test::paper {

/// An equation holds if its sides differ by less than this, relative to the larger side.
inline constexpr double tolerance = 1e-12;
/// An equation is wrong if its sides differ by more than this in at least one case.
inline constexpr double clearly_wrong = 1e-3;

/// One equation, evaluated on the systems of one topology.
class Equation {
 public:
  /// Expects that both sides of the correct equation, or of a part of it, are equal. `size` is the size of
  /// their terms, for equations in which these may cancel to 0.
  void holds(const Matrix& l, const Matrix& r, double size = 0);
  /// Records the sides of the equation as it is printed, if that is wrong; they must differ in at least one
  /// case.
  void fails(const Matrix& l, const Matrix& r);

  void at(std::string where) { where_ = std::move(where); }
  /// Called after all systems of a topology: expects that sides were evaluated, and that a wrong form turned
  /// out to be wrong.
  void conclude(Topology topology) const;

 private:
  std::string where_;
  int sides_ = 0;
  bool has_erratum_ = false;
  double largest_ = 0, largest_of_erratum_ = 0;
};

inline constexpr int systems_each = 3, states_each = 2;
inline constexpr Topology one_screw_joints[] = {Topology::chain, Topology::tree};

using CheckOfBody = std::function<void(Equation&, const Motion&, int i)>;
using CheckInFrames = std::function<void(Equation&, const Motion&, int i, int j, int k)>;

/// Calls check for every body of every system in every state: on chains, on trees, and on trees with joints
/// of all kinds.
void each_body(const CheckOfBody& check);
/// The same on chains and trees whose joints have one screw each, for equations about the screw of a joint.
void each_body_with_one_screw(const CheckOfBody& check);
/// Calls check for every body i and all frames j and k, the ground included.
void each_body_in_frames(const CheckInFrames& check);

}  // namespace axode::test::paper
