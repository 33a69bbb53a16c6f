#include "tests/paper/equation.hpp"

#include <algorithm>
#include <span>
#include <sstream>

namespace axode::test::paper {
namespace {

/// ‖l - r‖ / max(‖l‖, ‖r‖, size).
double residual(const Matrix& l, const Matrix& r, double size = 0) {
  const double difference = (l - r).norm();
  return difference == 0 ? 0 : difference / std::max({l.norm(), r.norm(), size});
}

/// The entries of a matrix as text, row by row.
std::string text_of(const Matrix& x) {
  std::ostringstream text;
  for (int r = 0; r < x.rows(); ++r) {
    for (int c = 0; c < x.cols(); ++c) text << x(r, c) << ' ';
    text << '\n';
  }
  return text.str();
}

void each_body_of(std::span<const Topology> topologies, const CheckOfBody& check) {
  for (const Topology topology : topologies) {
    Equation equation;
    for (int s = 0; s < systems_each; ++s)
      for (int state = 0; state < states_each; ++state) {
        const Motion motion(make_system(topology, s), state);
        for (int i = 1; i <= motion.n(); ++i) {
          equation.at(motion.model().name() + ", state " + std::to_string(state) + ", " +
                      motion.body(i).name);
          check(equation, motion, i);
        }
      }
    equation.conclude(topology);
  }
}

}  // namespace

void Equation::holds(const Matrix& l, const Matrix& r, double size) {
  const double error = residual(l, r, size);
  largest_ = std::max(largest_, error);
  ++sides_;
  EXPECT_LE(error, tolerance) << where_ << "\nleft\n" << text_of(l) << "right\n" << text_of(r);
}

void Equation::fails(const Matrix& l, const Matrix& r) {
  has_erratum_ = true;
  largest_of_erratum_ = std::max(largest_of_erratum_, residual(l, r));
}

void Equation::conclude(Topology topology) const {
  const std::string name(to_string(topology));
  EXPECT_GT(sides_, 0) << "nothing was evaluated on the " << name;
  testing::Test::RecordProperty("residual on the " + name, std::to_string(largest_ * 1e15) + "e-15");
  if (!has_erratum_) return;
  EXPECT_GT(largest_of_erratum_, clearly_wrong) << "the printed form holds on the " << name;
  testing::Test::RecordProperty("printed form on the " + name, std::to_string(largest_of_erratum_));
}

void each_body(const CheckOfBody& check) {
  constexpr Topology all[] = {Topology::chain, Topology::tree, Topology::many_dof_joints};
  each_body_of(all, check);
}

void each_body_with_one_screw(const CheckOfBody& check) { each_body_of(one_screw_joints, check); }

void each_body_in_frames(const CheckInFrames& check) {
  each_body([&](Equation& equation, const Motion& m, int i) {
    for (int j = 0; j <= m.n(); ++j)
      for (int k = 0; k <= m.n(); ++k) check(equation, m, i, j, k);
  });
}

}  // namespace axode::test::paper
