#include "axode/lie/cayley.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/lie/lines.hpp"
#include "tests/lie/random_quantities.hpp"
#include "tests/lie/relative_error.hpp"
#include "tests/support/json_numbers.hpp"
#include "tests/support/shared_files.hpp"

/// Cayley's map: its laws on random screws, and every reference file of it.
namespace axode::test {
namespace {

// ------------------------------------------------------------------------------- reference vectors

constexpr double last_digits = 1e-15;  // of the largest entry of a quantity

std::filesystem::path cayley_folder() { return vectors_folder() / "paper_questions"; }
/// The files of the folder whose cases have values of Cayley's map.
std::vector<std::string> cayley_files() {
  std::vector<std::string> names;
  for (const auto& file : files_ending_in(cayley_folder(), ".json")) {
    const Json all = read_json(file);
    if (all.contains("cases") && all.at("cases").size() > 0 && all.at("cases").at(0).contains("dcay"))
      names.push_back(file.stem().string());
  }
  return names.empty() ? std::vector<std::string>{"none"} : names;
}

/// The largest difference to a reference, relative to its largest entry.
double largest_error(const Eigen::MatrixXd& x, const Json& reference) {
  const std::vector<double> expected = numbers(reference);
  EXPECT_EQ(static_cast<std::size_t>(x.size()), expected.size());
  double error = 0, size = 0;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const double entry = expected[static_cast<std::size_t>(k)];
    error = std::max(error, std::abs(x(k / x.cols(), k % x.cols()) - entry));
    size = std::max(size, std::abs(entry));
  }
  return error == 0 ? 0 : error / size;
}

class CayleyVectors : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Vectors, CayleyVectors, testing::ValuesIn(cayley_files()),
                         [](const auto& file) { return file.param; });

TEST_P(CayleyVectors, EveryQuantityToTheLastDigits) {
  if (GetParam() == "none") GTEST_SKIP() << missing(cayley_folder(), "AXODE_VECTORS");
  const Json file = read_json(cayley_folder() / (GetParam() + ".json"));
  double worst = 0;
  for (const Json& c : file.at("cases")) {
    SCOPED_TRACE(c.at("label").text());
    const auto screw_at = [&](const char* key) {
      return from_eigen<Screw<>>(Eigen::Map<const Vector6<double>>(numbers(c.at(key)).data()));
    };
    const Screw<> X = screw_at("X"), Z = screw_at("Z"), U = screw_at("U");
    const auto expect = [&](const char* key, const Eigen::MatrixXd& x) {
      const double error = largest_error(x, c.at(key));
      EXPECT_LE(error, last_digits) << key;
      worst = std::max(worst, error);
    };
    expect("cay", to_eigen(cay(X)));
    expect("dcay", matrix6([&](const Screw<>& z) { return dcay(X, z); }));
    expect("dcay_inv", matrix6([&](const Screw<>& z) { return dcay_inv(X, z); }));
    expect("ddcay", to_eigen(ddcay(X, U, Z)));
    expect("ddcay_inv", to_eigen(ddcay_inv(X, U, Z)));
    expect("cay_of_ad", Ad_matrix(cay_of_ad(X)));
    expect("dcay_inv_of_ad", matrix6([&](const Screw<>& z) { return dcay_inv_of_ad(X, z); }));
  }
  RecordProperty("largest_error", testing::PrintToString(worst));
}

// -------------------------------------------------------------------------------------------- laws

/// Rotations by up to 150 degrees, with an angle 2 atan(‖w‖/2).
template <class T> class Cayley : public testing::Test {
 protected:
  static constexpr int samples = 300;
  static constexpr T tolerance = test::tolerance<T>;
  Random<T> random;

  Screw<T> coordinates() {
    const Vec3<T> w = random.rotation_vector(T(0), T(7));
    return {w, random.vector()};
  }
};
TYPED_TEST_SUITE(Cayley, Scalars, ScalarNames);

TYPED_TEST(Cayley, IsTheRationalFunctionOfTheMatrix) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Screw<T> X = this->coordinates();
    const Eigen::Matrix4<T> one = Eigen::Matrix4<T>::Identity(), half = hat(X) / T(2);
    EXPECT_LE(norm_of_entries(Eigen::Matrix4<T>((one - half) * to_eigen(cay(X)) - (one + half))),
              this->tolerance);
    const Matrix6<T> one_6 = Matrix6<T>::Identity(), half_6 = ad_matrix(X) / T(2);
    EXPECT_LE(norm_of_entries(Matrix6<T>((one_6 - half_6) * Ad_matrix(cay_of_ad(X)) - (one_6 + half_6))),
              T(4) * this->tolerance);
    EXPECT_LE(distance(rotation(cay_quaternion(X.w)), cay_SO3(X.w)), this->tolerance);
    EXPECT_LE(distance(cay_of_ad(X).R, cay(X).R), T(0));
  }
}

TYPED_TEST(Cayley, TurnsByTwiceTheArcTangentOfHalfTheLength) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Vec3<T> e = this->random.direction();
    const T angle = this->random.number(T(0), T(3));
    EXPECT_LE(distance(cay_SO3(T(2) * std::tan(angle / T(2)) * e), exp_SO3(angle * e)), this->tolerance);
  }
}

TYPED_TEST(Cayley, AgreesWithExpToSecondOrder) {
  using T = TypeParam;
  const Screw<T> X{{T(0.3), T(-0.5), T(0.8)}, {T(1), T(0.4), T(-0.6)}};
  const auto cubes = [&](T s) {  // of the difference to exp, by the matrix X̂³/12
    const Eigen::Matrix4<T> A = hat(s * X);
    const Eigen::Matrix4<T> difference = to_eigen(cay(s * X)) - to_eigen(exp(s * X)),
                            cube = A * A * A / T(12);
    return norm_of_entries(Eigen::Matrix4<T>(difference - cube)) / norm_of_entries(cube);
  };
  EXPECT_LE(cubes(T(0.1)), T(0.11));
  EXPECT_LE(cubes(T(0.02)), T(0.025));
}

TYPED_TEST(Cayley, InvertsByTheSignAndByItsInverse) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Screw<T> X = this->coordinates();
    EXPECT_LE(distance(cay(X) * cay(-X), SE3<T>{}), this->tolerance);
    EXPECT_LE(distance(cay_of_ad(X) * cay_of_ad(-X), SE3<T>{}), this->tolerance);
    EXPECT_LE(relative_error(cay_inv(cay(X)), X), this->tolerance);
    EXPECT_LE(relative_error(cay_of_ad_inv(cay_of_ad(X)), X), this->tolerance);
    EXPECT_LE(relative_error(log_cay(X), log(cay(X))), this->tolerance);
  }
}

TYPED_TEST(Cayley, DcayIsTheRightTrivialisedDerivative) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Screw<T> X = this->coordinates(), U = this->random.screw();
    EXPECT_LE(relative_error(dcay(X, U), right_trivialised(slope(cay(line(X, U))), cay(X))), this->tolerance);
    const SE3<T> C = cay_of_ad(X);
    const Screw<T> tangent = right_trivialised(slope(cay_of_ad(line(X, U))), C);
    EXPECT_LE(relative_error(dcay_of_ad(X, U), tangent), this->tolerance);
    EXPECT_LE(distance(dcay(X.w, U.w), dcay(X, U).w), T(0));
    EXPECT_LE(relative_error(Ad(cay(X), dcay(-X, U)), dcay(X, U)), this->tolerance);
    EXPECT_LE(relative_error(Ad(C, dcay_of_ad(-X, U)), dcay_of_ad(X, U)), this->tolerance);
  }
}

TYPED_TEST(Cayley, InverseOfDcayInvertsIt) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Screw<T> X = this->coordinates(), Z = this->random.screw();
    const T conditioned = T(10) * this->tolerance;
    EXPECT_LE(relative_error(dcay_inv(X, dcay(X, Z)), Z), conditioned);
    EXPECT_LE(relative_error(dcay_inv_of_ad(X, dcay_of_ad(X, Z)), Z), conditioned);
    EXPECT_LE(relative_error(dcay_inv(X.w, dcay(X.w, Z.w)), Z.w), conditioned);
  }
}

TYPED_TEST(Cayley, DirectionalDerivativesAreThoseOfTaylorSeries) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Screw<T> X = this->coordinates();
    const Screw<T> U = this->random.screw(), Z = this->random.screw(), zero{};
    const auto X_t = line(X, U), Z_t = line(Z, zero);
    EXPECT_LE(distance(ddcay(X, U, Z), slope(dcay(X_t, Z_t))), this->tolerance);
    EXPECT_LE(relative_error(ddcay_inv(X, U, Z), slope(dcay_inv(X_t, Z_t))), this->tolerance);
    EXPECT_LE(distance(ddcay_of_ad(X, U, Z), slope(dcay_of_ad(X_t, Z_t))), this->tolerance);
    EXPECT_LE(relative_error(ddcay_inv_of_ad(X, U, Z), slope(dcay_inv_of_ad(X_t, Z_t))), this->tolerance);
    EXPECT_LE(distance(ddcay(X.w, U.w, Z.w), ddcay(X, U, Z).w), T(0));
    EXPECT_LE(distance(ddcay_inv(X.w, U.w, Z.w), ddcay_inv(X, U, Z).w), this->tolerance);
  }
}

TYPED_TEST(Cayley, TransposeIsDualToDcay) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Screw<T> X = this->coordinates(), Z = this->random.screw(), W = this->random.screw();
    const auto power = [](const Screw<T>& a, const Screw<T>& b) { return dot(a.w, b.w) + dot(a.v, b.v); };
    EXPECT_NEAR(power(dcay_transpose(X, W), Z), power(W, dcay(X, Z)), this->tolerance);
  }
}

// Cayley's map is rational, so that the compiler computes it.
constexpr SE3<> quarter_turn_by_cayley = cay(Screw<>{{0, 0, 2}, {4, 0, 1}});
static_assert(quarter_turn_by_cayley.R.x.x == 0 && quarter_turn_by_cayley.R.x.y == 1);
static_assert(quarter_turn_by_cayley.r.x == 2 && quarter_turn_by_cayley.r.z == 1);
static_assert(cay_of_ad(Screw<>{{0, 0, 2}, {4, 0, 1}}).r.z == 0.5);  // shorter along the axis

}  // namespace
}  // namespace axode::test
