#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "axode/eigen.hpp"
#include "tests/lie/relative_error.hpp"
#include "tests/support/json_numbers.hpp"
#include "tests/support/shared_files.hpp"

/// Every field of se3_functions.json among the shared reference vectors.
namespace axode::test {
namespace {

Screw<> screw_of(const Json& field) {
  return from_eigen<Screw<>>(Eigen::Map<const Vector6<double>>(numbers(field).data()));
}

template <int Rows, int Cols> Eigen::Matrix<double, Rows, Cols> matrix_of(const Json& field) {
  const std::vector<double> entries = numbers(field);
  if (entries.size() != Rows * Cols) throw std::runtime_error("a field of another shape");
  Eigen::Matrix<double, Rows, Cols> matrix;
  for (int i = 0; i < Rows; ++i)
    for (int j = 0; j < Cols; ++j) matrix(i, j) = entries[static_cast<std::size_t>(Cols * i + j)];
  return matrix;
}

template <class Matrix>
void expect_close(const Matrix& computed, const Matrix& reference, const std::string& field) {
  EXPECT_LE((computed - reference).norm(), reference_bound * reference.norm()) << field;
}

TEST(PublicVectors, EveryFunctionOnSE3) {
  const std::filesystem::path file = vectors_folder() / "se3_functions.json";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << missing(vectors_folder(), "AXODE_VECTORS");
  const Json all = read_json(file);
  ASSERT_GE(all.at("cases").size(), 1u);
  for (const auto& c : all.at("cases")) {
    SCOPED_TRACE(c.at("label").text());
    const Screw<> X = screw_of(c.at("X")), Z = screw_of(c.at("Z"));
    const SE3<> C = exp(X);
    const auto field6 = [&](const char* key) { return matrix_of<6, 6>(c.at(key)); };
    expect_close(to_eigen(C), matrix_of<4, 4>(c.at("exp")), "exp");
    expect_close(Ad_matrix(C), field6("Ad_exp"), "Ad_exp");
    expect_close(ad_matrix(X), field6("ad"), "ad");
    expect_close(to_eigen(ad(X, Z)), matrix_of<6, 1>(c.at("bracket_XZ")), "bracket_XZ");
    EXPECT_NEAR(reciprocal_product(X, Z), number(c.at("reciprocal_XZ")), reference_bound);
    expect_close(dexp_matrix(X), field6("dexp"), "dexp");
    expect_close(ddexp_matrix(X, Z), field6("ddexp"), "ddexp");
    expect_close(dexp_inv_matrix(X), field6("dexp_inv"), "dexp_inv");
    expect_close(ddexp_inv_matrix(X, Z), field6("ddexp_inv"), "ddexp_inv");
    const Vector6<double> log_exp = matrix_of<6, 1>(c.at("log_exp"));
    Screw<> other = from_eigen<Screw<>>(log_exp);  // at half a turn the opposite axis is correct too
    if (std::abs(norm(other.w) - std::numbers::pi) < 1e-12) {
      other.w = -other.w;
      other.v = dexp_inv(other.w, C.r);
    }
    const double error = (to_eigen(log(C)) - log_exp).norm(),
                 error_other = (to_eigen(log(C)) - to_eigen(other)).norm();
    EXPECT_LE(std::min(error, error_other), reference_bound * log_exp.norm()) << "log_exp";
  }
}

}  // namespace
}  // namespace axode::test
