#include "axode/scalar/trace.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "axode/lie/se3.hpp"

namespace axode::test {
namespace {

using Operation = Tape::Operation;

/// Evaluates what a tape has recorded. The numbers x are the inputs of array 0.
class Values {
 public:
  Values(const Tape& tape, const std::vector<double>& x) {
    for (const Tape::Node& node : tape.nodes()) values_.push_back(value(node, x));
  }
  double operator()(const Trace& a) const { return a.factor() * at(a.node()); }
  bool operator()(const Trace::Condition& a) const {
    return a.is_constant() ? a.constant() : at(a.node()) != 0;
  }

 private:
  double at(int node) const { return values_[static_cast<std::size_t>(node)]; }
  double value(const Tape::Node& node, const std::vector<double>& x) const {
    using enum Tape::Operation;
    switch (node.operation) {
      case one: return 1;
      case input: return x[static_cast<std::size_t>(node.b)];
      case scale: return node.factor * at(node.a);
      case sum: return at(node.a) + node.factor * at(node.b);
      case product: return at(node.a) * at(node.b);
      case reciprocal: return 1 / at(node.a);
      case root: return std::sqrt(at(node.a));
      case sine: return std::sin(at(node.a));
      case cosine: return std::cos(at(node.a));
      case angle: return std::atan2(at(node.a), at(node.b));
      case choice: return at(node.condition) != 0 ? at(node.a) : at(node.b);
      case less: return at(node.a) < at(node.b);
      case less_equal: return at(node.a) <= at(node.b);
      case both: return at(node.a) != 0 && at(node.b) != 0;
      case either: return at(node.a) != 0 || at(node.b) != 0;
      case negation: return at(node.a) == 0;
    }
    return 0;
  }
  std::vector<double> values_;
};

/// Expects that two traces are the same number by the same operations.
void expect_same(const Trace& a, const Trace& b) {
  EXPECT_EQ(a.node(), b.node());
  EXPECT_EQ(a.factor(), b.factor());
}
/// Expects that a trace is the constant c.
void expect_constant(const Trace& a, double c) {
  EXPECT_TRUE(a.is_constant());
  EXPECT_EQ(a.factor(), c);
}

struct TraceOfNumbers : testing::Test {
  Tape tape;
  Trace x = tape.input(0, 0), y = tape.input(0, 1), z = tape.input(0, 2);
  std::size_t recorded() const { return tape.nodes().size(); }
};

TEST_F(TraceOfNumbers, FoldsConstants) {
  const std::size_t before = recorded();
  expect_constant(Trace(2) * Trace(3) + Trace(1), 7);
  expect_constant(Trace(1) / Trace(4), 0.25);
  expect_constant(sqrt(Trace(9)) - Trace(3), 0);
  expect_constant(sin(Trace(0)), 0);
  expect_constant(cos(Trace(0)), 1);
  expect_constant(atan2(Trace(0), Trace(1)), 0);
  expect_constant(select(Trace(1) < Trace(2), Trace(5), Trace(6)), 5);
  expect_constant(x * Trace(0), 0);
  expect_constant(x - x, 0);
  expect_constant(x * Trace(0.1) + x * Trace(0.2) - x * Trace(0.3), 0);  // 5e-17 x in floating point
  expect_same(x + Trace(0), x);
  expect_same(Trace(0) - x, -x);
  expect_same(Trace(1) * x, x);
  expect_same(Trace(-1) * x, -x);
  expect_same(-(-x), x);
  expect_same(x / Trace(0.5), x + x);
  EXPECT_EQ(recorded(), before) << "nothing of this is computed";
}

TEST_F(TraceOfNumbers, RecordsEveryOperationOnce) {
  const Trace sum = x + y, product = x * y, mixed = x * y + z * sin(x);
  const std::size_t before = recorded();
  expect_same(y + x, sum);
  expect_same(y * x, product);
  expect_same(sin(x) * z + y * x, mixed);
  expect_same((x + y) * Trace(2), sum + sum);
  EXPECT_EQ(recorded(), before);
}

TEST_F(TraceOfNumbers, PullsSignsAndFactorsOut) {
  const Trace difference = x - y, product = x * y, combination = x + Trace(0.5) * y, s = sin(x), c = cos(x),
              quotient = x / y, chosen = select(x < y, x, y);
  const std::size_t before = recorded();
  expect_same(y - x, -difference);
  expect_same((-x) * (-y), product);
  expect_same((Trace(2) * x) * (Trace(-3) * y), Trace(-6) * product);
  expect_same(Trace(-2) * y - Trace(4) * x, Trace(-4) * combination);
  expect_same(sin(-x), -s);
  expect_same(cos(-x), c);
  expect_same((-x) / (Trace(2) * y), Trace(-0.5) * quotient);
  expect_same(select(x < y, -x, -y), -chosen);
  EXPECT_EQ(recorded(), before);
}

TEST_F(TraceOfNumbers, CancelsWhatWasAddedOrMultiplied) {
  const Trace sum = Trace(3) * x + y, quotient = (x * y) / x;
  expect_same(sum - y, Trace(3) * x);
  expect_same(sum - Trace(3) * x, y);
  expect_same(quotient, y);
  expect_same(Trace(1) / (Trace(1) / x), x);
  expect_constant((x * z) / (z * x), 1);
}

TEST_F(TraceOfNumbers, LeavesChoicesToTheProgram) {
  const Trace smaller = select(x < y, x, y), clipped = select(!(x <= Trace(2)) || z > x, Trace(2), x);
  const Trace::Condition between = x > y && y >= z;
  for (const std::vector<double>& at : {std::vector<double>{1, 2, 0}, {2, 1, 0}, {3, 3, 3}, {1, 1, 5}}) {
    const Values value(tape, at);
    EXPECT_EQ(value(smaller), std::min(at[0], at[1]));
    EXPECT_EQ(value(clipped), at[0] > 2 || at[2] > at[0] ? 2 : at[0]);
    EXPECT_EQ(value(between), at[0] > at[1] && at[1] >= at[2]);
  }
  const Trace::Condition always = true, unknown = x < y;
  EXPECT_TRUE((always || unknown).constant());
  EXPECT_EQ((always && unknown).node(), unknown.node());
  expect_same(select(unknown, x, x), x);
  static_assert(
      !std::is_convertible_v<Trace::Condition, bool> && !std::is_constructible_v<bool, Trace::Condition>,
      "no branch is taken on it");
}

TEST_F(TraceOfNumbers, ComputesWhatDoublesCompute) {
  const auto computed = [](auto a, auto b, auto c) {
    using T = decltype(a);
    const SE3<T> A{{{cos(a), sin(a), T(0)}, {-sin(a), cos(a), T(0)}, {T(0), T(0), T(1)}}, {b, c, T(1)}},
        B{{}, {c, T(0), b * b}};
    const Vec3<T> r = (A * B * inverse(A)).r;
    return (sqrt(T(2) + sin(r.x)) / (T(2) + r.y * r.y) - atan2(r.z, a)) * T(0.3) +
           select(b < c, r.x * b, r.y - b);
  };
  const Trace recorded = computed(x, y, z);
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> uniform(0.1, 1.5);
  for (int trial = 0; trial < 1000; ++trial) {
    const std::vector<double> at{uniform(engine), uniform(engine), uniform(engine)};
    const double expected = computed(at[0], at[1], at[2]);
    EXPECT_NEAR(Values(tape, at)(recorded), expected, 1e-14 * std::max(1.0, std::abs(expected)));
  }
  // Numbers of few bits, with which every operation is exact in any order.
  const auto exact = [](auto a, auto b, auto c) {
    using T = decltype(a);
    return (a - T(2) * b) * (c + T(0.5) * a) - b * c * T(-4) + (a + b) / T(8);
  };
  const Trace few_bits = exact(x, y, z);
  EXPECT_EQ(Values(tape, {3, -5, 7})(few_bits), exact(3.0, -5.0, 7.0));
}

TEST(TapeOfAThread, IsOneAtATime) {
  {
    const Tape tape;
    EXPECT_THROW(Tape(), std::logic_error);
  }
  Trace stray;
  {
    Tape tape;
    stray = tape.input(0, 0);
  }
  EXPECT_THROW(sin(stray), std::logic_error) << "there is no tape any more";
}

}  // namespace
}  // namespace axode::test
