#include <cmath>
#include <limits>
#include <set>

#include "axode/constraints/local_mobility/local_mobility.hpp"
#include "axode/constraints/loops.hpp"
#include "axode/io.hpp"
#include "axode/model/configuration.hpp"
#include "tests/support/comparison.hpp"
#include "tests/support/json_numbers.hpp"
#include "tests/support/shared_files.hpp"

/// Constraints of higher order, mobility and branches of the mechanisms in mobility/*.json.
namespace axode::test {
namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

const std::string no_files = "none";

std::vector<std::string> mechanisms() {
  std::vector<std::string> names;
  for (const auto& file : files_ending_in(vectors_folder() / "mobility", ".json"))
    names.push_back(file.stem().string());
  return names.empty() ? std::vector{no_files} : names;
}

bool is_true(const Json& value) { return value.text() == "true"; }
int number_or_zero(const Json& value) { return value.text() == "null" ? 0 : int(value); }

Eigen::MatrixXd matrix(const Json& rows, Eigen::Index columns) {
  const std::vector<double> all = numbers(rows);
  return Eigen::Map<const Rows>(all.data(), static_cast<Eigen::Index>(all.size()) / columns, columns);
}

class MobilityOfReferenceMechanisms : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == no_files) GTEST_SKIP() << missing(vectors_folder() / "mobility", "AXODE_VECTORS");
  }

  struct Case {
    Json file;
    Model model;
    std::vector<double> q;
    std::vector<ClosureCoordinate> coordinates;
    Eigen::MatrixXd order;  ///< a permutation: columns of the file from those of the library

    explicit Case(const std::string& name)
        : file(read_json(vectors_folder() / "mobility" / (name + ".json"))),
          model(ModelBuilder(read_drawing_text(file.at("drawing").text(), name)).build()),
          q(neutral(model)),
          coordinates(closure_coordinates(model)) {
      const Json& joints = file.at("joints");
      const auto n = static_cast<Eigen::Index>(joints.size());
      EXPECT_EQ(coordinates.size(), joints.size());
      order.setZero(n, n);
      for (Eigen::Index c = 0; c < n; ++c)
        for (Eigen::Index k = 0; k < n; ++k)
          if (coordinates[static_cast<std::size_t>(c)].name ==
              joints.at(static_cast<std::size_t>(k)).at("name").text())
            order(c, k) = 1;
      EXPECT_EQ(order.sum(), static_cast<double>(n)) << "every joint of the file is a coordinate";
    }
    Eigen::Index n() const { return order.rows(); }
    LocalMobility found() const { return local_mobility(model, q, {.length = number(file.at("length"))}); }
    std::set<std::string> names(const std::vector<int>& which) const {
      std::set<std::string> out;
      for (const int c : which) out.insert(coordinates[static_cast<std::size_t>(c)].name);
      return out;
    }
    static std::set<std::string> names(const Json& list) {
      std::set<std::string> out;
      for (const Json& name : list) out.insert(name.text());
      return out;
    }
  };

  static bool has_the_words_of(const Case& at, const MotionBranch& branch, const Json& expected) {
    return branch.dimension == int(expected.at("dimension")) &&
           branch.cusp() == is_true(expected.at("cusp")) &&
           branch.multiple == is_true(expected.at("multiple")) &&
           branch.differential_mobility_beside == int(expected.at("differential_mobility_beside")) &&
           at.names(branch.dead) == Case::names(expected.at("dead")) &&
           at.names(branch.idle) == Case::names(expected.at("idle")) && branch.closes && branch.settled;
  }
  /// The difference from a curve of the file relative to the bounds of its schema, for one sign of the
  /// parameter.
  static double distance(const Case& at, const MotionBranch& branch, const Json& expected, double sign) {
    // The files have tangents of double branches to half of the digits only: idle joints move by 5e-9.
    const double half = is_true(expected.at("multiple")) ? 1e-7 : 0;
    const auto compared = [&](const char* key, const Eigen::VectorXd& x, double digits) {
      const double bound = std::max(digits, half);
      const Eigen::VectorXd reference = matrix(expected.at(key), at.n()).transpose();
      return (at.order.transpose() * x - reference).norm() / (bound * std::max(1.0, reference.norm()));
    };
    if (branch.cusp())
      return std::max(compared("tangent", branch.series.col(2), 1e-10),
                      compared("cusp_coefficient", sign * branch.series.col(3), 1e-10));
    return std::max({compared("tangent", sign * branch.series.col(1), 1e-10),
                     compared("second", 2 * branch.series.col(2), 1e-10),
                     compared("third", sign * 6 * branch.series.col(3), 1e-6)});
  }
  static double distance_of_surfaces(const Case& at, const MotionBranch& branch, const Json& expected) {
    const Eigen::MatrixXd T = matrix(expected.at("tangent_space"), at.n()),
                          II = matrix(expected.at("second_form"), at.n()), own = branch.T * at.order;
    const Eigen::MatrixXd Q = T * own.transpose();
    const Eigen::Index D = T.rows();
    Eigen::MatrixXd turned = Eigen::MatrixXd::Zero(D * D, at.n());
    for (Eigen::Index k = 0; k < D * D * D * D; ++k) {
      const Eigen::Index a = k % D, b = k / D % D, c = k / (D * D) % D, d = k / (D * D * D);
      turned.row(a * D + b) += Q(a, c) * Q(b, d) * branch.II.row(c * D + d) * at.order;
    }
    return std::max((T.transpose() * T - own.transpose() * own).norm() / 1e-9,
                    (turned - II).norm() / (1e-8 * std::max(1.0, II.norm())));
  }
  static bool is(const Case& at, const MotionBranch& branch, const Json& expected) {
    if (!has_the_words_of(at, branch, expected)) return false;
    const double far = branch.dimension > 1
                           ? distance_of_surfaces(at, branch, expected)
                           : std::min(distance(at, branch, expected, 1), distance(at, branch, expected, -1));
    return far < 1;
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, MobilityOfReferenceMechanisms, testing::ValuesIn(mechanisms()),
                         [](const auto& info) { return info.param; });

TEST_P(MobilityOfReferenceMechanisms, ConstraintsOfHigherOrder) {
  const Case at(GetParam());
  const Json& given = at.file.at("constraints");
  const Eigen::MatrixXd derivatives = at.order * matrix(given.at("derivatives"), at.n()).transpose();
  const std::vector<Eigen::MatrixXd> H = closure_derivatives(at.model, at.q, derivatives);
  ASSERT_EQ(H.size(), given.at("H").size());
  Comparison comparison("H", 1e-11);
  for (std::size_t l = 0; l < H.size(); ++l)
    comparison.expect_equal(H[l], Eigen::MatrixXd(matrix(given.at("H").at(l), 6).transpose()));
}

TEST_P(MobilityOfReferenceMechanisms, RanksOrdersAndWords) {
  const Case at(GetParam());
  const LocalMobility found = at.found();
  const Json& file = at.file;
  EXPECT_EQ(found.rank, int(file.at("rank")));
  EXPECT_EQ(found.differential_mobility, int(file.at("differential_mobility")));
  const Json& orders = file.at("mobility_by_order");
  for (std::size_t k = 0; k < std::min(orders.size(), found.mobility_by_order.size()); ++k)
    EXPECT_EQ(found.mobility_by_order[k], int(orders.at(k))) << "order " << k + 1;
  EXPECT_GE(found.mobility_by_order.size(), 5U);
  EXPECT_EQ(found.settled_at_order, int(file.at("settled_at_order")));
  EXPECT_EQ(found.local_mobility, int(file.at("local_mobility")));
  EXPECT_EQ(found.rigid_at_order, number_or_zero(file.at("rigid_at_order")));
  const int lowest = found.conditions.empty() ? 0 : found.conditions.front().degree;
  EXPECT_EQ(lowest, file.contains("lowest_degree") ? int(file.at("lowest_degree")) : 0);
  EXPECT_EQ(std::ranges::count(found.conditions, lowest, &MobilityCondition::degree),
            file.contains("forms_of_lowest_degree") ? int(file.at("forms_of_lowest_degree")) : 0);
  EXPECT_EQ(found.branch_point, is_true(file.at("branch_point")));
  EXPECT_EQ(found.cusp, is_true(file.at("cusp")));
  EXPECT_EQ(found.kinematotropic, is_true(file.at("kinematotropic")));
  EXPECT_EQ(found.kinematic_singularity, is_true(file.at("kinematic_singularity")));
  EXPECT_EQ(found.shaky, is_true(file.at("shaky")));
  EXPECT_TRUE(found.settled);
  EXPECT_EQ(found.probe.missed, 0);
}

TEST_P(MobilityOfReferenceMechanisms, Branches) {
  const Case at(GetParam());
  const LocalMobility found = at.found();
  const Json& expected = at.file.at("branches");
  ASSERT_EQ(found.branches.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k)
    EXPECT_EQ(std::ranges::count_if(
                  found.branches, [&](const MotionBranch& branch) { return is(at, branch, expected.at(k)); }),
              1)
        << "branch " << k;
}

/// The file's points are closed for the library, and lie on the branch up to terms that it does not have.
TEST_P(MobilityOfReferenceMechanisms, Points) {
  const Case at(GetParam());
  const LocalMobility found = at.found();
  LoopWorkspace<> workspace(at.model);
  std::vector<double> r(static_cast<std::size_t>(at.model.loops().residuals));
  for (const Json& expected : at.file.at("branches"))
    for (const Json& point : expected.at("points")) {
      const Eigen::VectorXd x = at.order * matrix(point.at("q"), at.n()).transpose();
      const Eigen::VectorXd dv = x.head(at.model.nv());
      loop_residual<double>(at.model, workspace,
                            integrate(at.model, at.q, {dv.data(), std::size_t(dv.size())}), r);
      EXPECT_LT(largest(r), 1e-13);
      double near = std::numeric_limits<double>::infinity();
      for (const MotionBranch& branch : found.branches) {
        if (!is(at, branch, expected) || branch.dimension > 1) continue;
        for (const double sign : {1.0, -1.0}) {
          const double s = sign * number(point.at("parameter"));
          Eigen::VectorXd y = Eigen::VectorXd::Zero(at.n());
          for (Eigen::Index k = branch.series.cols() - 1; k > 0; --k) y = s * (y + branch.series.col(k));
          near = std::min(near, (y - x).norm());
        }
      }
      if (int(expected.at("dimension")) == 1) {
        EXPECT_LT(near, 1e-2 * x.norm());
      }
    }
}

}  // namespace
}  // namespace axode::test
