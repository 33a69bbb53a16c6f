#pragma once
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "tests/paper/motion.hpp"

/// How an equation of the paper is tested: both of its sides, for every body, on a chain and on a tree, at
/// random states. "i - 1" is the predecessor of body i, and the ground where it has none.
namespace axode::test::paper {

/// An equation holds where its sides differ by less than this, relative to the larger side.
inline constexpr double tolerance = 1e-12;
/// A wrong one differs by more than this somewhere.
inline constexpr double clearly_wrong = 1e-3;

/// One equation on the systems of one topology.
class Equation {
 public:
  /// The equation, or a member of it, as it is right; with the size of its terms where they may cancel to 0.
  void holds(const Matrix& l, const Matrix& r, double size = 0);
  /// The equation as it is printed where that is wrong.
  void fails(const Matrix& l, const Matrix& r);

  void at(std::string where) { where_ = std::move(where); }
  /// After all systems of a topology: something was evaluated, and a wrong form turned out wrong.
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

/// For every body of every system in every state: on chains, on trees, and on trees with joints of all kinds.
void each_body(const CheckOfBody& check);
/// Where the equation speaks of the one screw of a joint: on chains and trees of such joints.
void each_body_with_one_screw(const CheckOfBody& check);
/// For every body i and all frames j and k, the ground included.
void each_body_in_frames(const CheckInFrames& check);

}  // namespace axode::test::paper
