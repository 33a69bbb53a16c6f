#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/lie/relative_error.hpp"
#include "tests/support/json_numbers.hpp"

/// exp, log, dexp, dexp⁻¹ and their derivatives against values computed in 90 digits from definitions
/// (tools/make_lie_reference.py), for every angle from 0 to π. The SO(3) functions are the angular parts.
namespace axode::test {
namespace {

Vec3<> vector_at(const std::vector<double>& x, std::size_t k) { return {x[k], x[k + 1], x[k + 2]}; }
Screw<> screw_of(const std::vector<double>& x) { return {vector_at(x, 0), vector_at(x, 3)}; }

struct Case {
  Screw<> X, Z, U;
  SE3<> exp;
  Quaternion<> quaternion;
  Screw<> dexp, dexp_inv, ddexp, ddexp_inv;
  Screw<> other_log;  // the logarithm with the opposite axis at half a turn; X at other angles
};

std::vector<Case> cases() {
  std::vector<Case> all;
  const Json file = read_json(AXODE_SOURCE_DIR "/tests/data/lie_reference.json");
  for (const auto& c : file.at("cases")) {
    const auto screw_at = [&](const char* key) { return screw_of(numbers(c.at(key))); };
    const std::vector<double> C = numbers(c.at("exp")), q = numbers(c.at("quaternion"));
    const SO3<> R = transpose(SO3<>{vector_at(C, 0), vector_at(C, 3), vector_at(C, 6)});
    all.push_back({screw_at("X"),
                   screw_at("Z"),
                   screw_at("U"),
                   {R, vector_at(C, 9)},
                   {q[0], q[1], q[2], q[3]},
                   screw_at("dexp"),
                   screw_at("dexp_inv"),
                   screw_at("ddexp"),
                   screw_at("ddexp_inv"),
                   screw_at(c.contains("other_log") ? "other_log" : "X")});
  }
  return all;
}

/// Expects that the error of every case is below the bound, and reports the largest one.
template <class Error> void expect_below_bound(const Error& error) {
  static const std::vector<Case> all = cases();
  ASSERT_GT(all.size(), 100u);
  double largest = 0;
  for (const Case& c : all) {
    const double e = error(c);
    EXPECT_LE(e, reference_bound) << "at X = " << testing::PrintToString(as_span(to_eigen(c.X)));
    largest = std::max(largest, e);
  }
  testing::Test::RecordProperty("largest_error", testing::PrintToString(largest));
}

TEST(LieReference, ExpSE3IsThePowerSeries) {
  expect_below_bound([](const Case& c) {
    return std::max(relative_error(exp(c.X).R, c.exp.R), relative_error(exp(c.X).r, c.exp.r));
  });
}
TEST(LieReference, LogSE3InvertsExp) {
  expect_below_bound([](const Case& c) {
    return std::min(relative_error(log(c.exp), c.X), relative_error(log(c.exp), c.other_log));
  });
}
TEST(LieReference, DexpSE3IsItsSeries) {
  expect_below_bound([](const Case& c) { return relative_error(dexp(c.X, c.Z), c.dexp); });
}
TEST(LieReference, DexpInverseSE3SolvesDexp) {
  expect_below_bound([](const Case& c) { return relative_error(dexp_inv(c.X, c.Z), c.dexp_inv); });
}
TEST(LieReference, DirectionalDerivativeOfDexpSE3) {
  expect_below_bound([](const Case& c) { return relative_error(ddexp(c.X, c.U, c.Z), c.ddexp); });
}
TEST(LieReference, DirectionalDerivativeOfDexpInverseSE3) {
  expect_below_bound([](const Case& c) { return relative_error(ddexp_inv(c.X, c.U, c.Z), c.ddexp_inv); });
}
TEST(LieReference, LogSO3InvertsExp) {
  expect_below_bound([](const Case& c) {
    return std::min(relative_error(log_SO3(c.exp.R), c.X.w), relative_error(log_SO3(c.exp.R), c.other_log.w));
  });
}
TEST(LieReference, DexpSO3IsItsSeries) {
  expect_below_bound([](const Case& c) { return relative_error(dexp(c.X.w, c.Z.w), c.dexp.w); });
}
TEST(LieReference, DexpInverseSO3SolvesDexp) {
  expect_below_bound([](const Case& c) { return relative_error(dexp_inv(c.X.w, c.Z.w), c.dexp_inv.w); });
}
TEST(LieReference, DirectionalDerivativeOfDexpSO3) {
  expect_below_bound([](const Case& c) { return relative_error(ddexp(c.X.w, c.U.w, c.Z.w), c.ddexp.w); });
}
TEST(LieReference, DirectionalDerivativeOfDexpInverseSO3) {
  expect_below_bound(
      [](const Case& c) { return relative_error(ddexp_inv(c.X.w, c.U.w, c.Z.w), c.ddexp_inv.w); });
}
TEST(LieReference, ExpQuaternionIsThePowerSeries) {
  expect_below_bound([](const Case& c) { return relative_error(exp_quaternion(c.X.w), c.quaternion); });
}
TEST(LieReference, LogQuaternionInvertsExp) {
  expect_below_bound([](const Case& c) {
    return std::min(relative_error(log_quaternion(c.quaternion), c.X.w),
                    relative_error(log_quaternion(c.quaternion), c.other_log.w));
  });
}
TEST(LieReference, RotationOfAQuaternion) {
  expect_below_bound([](const Case& c) { return relative_error(rotation(c.quaternion), c.exp.R); });
}

}  // namespace
}  // namespace axode::test
