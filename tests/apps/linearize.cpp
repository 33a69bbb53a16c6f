#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <numbers>

#include "axode/derivatives.hpp"
#include "axode/eigen.hpp"
#include "axode/io.hpp"
#include "axode/model/configuration.hpp"
#include "tests/apps/run_command.hpp"

/// `axode linearize` prints and writes the linear system that the library computes, and the modes of this
/// system.
namespace axode::test {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;
using testing::Not;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Eigen::MatrixXd;

Json answer(std::vector<std::string> arguments, const std::string& state = "") {
  arguments.insert(arguments.begin(), "linearize");
  arguments.insert(arguments.end(), {"--format", "json"});
  if (!state.empty()) arguments.insert(arguments.end(), {"--state", "-"});
  const Outcome outcome = axode(arguments, state);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  return outcome.code == 0 ? Json::parse(outcome.out) : Json();
}
MatrixXd matrix(const Json& rows) {
  MatrixXd out(rows.size(), rows.empty() ? 0 : rows[0].size());
  for (Eigen::Index i = 0; i < out.rows(); ++i)
    for (Eigen::Index k = 0; k < out.cols(); ++k) out(i, k) = rows[i][k];
  return out;
}
std::vector<double> numbers(const Json& list) { return list.get<std::vector<double>>(); }

/// A mechanism that is written into a file of its own.
class Drawn {
 public:
  explicit Drawn(const std::string& bodies)
      : file_(folder_.write("drawn.toml", "format = \"axode drawing 1\"\nname = \"drawn\"\n" + bodies)) {}
  const std::string& file() const { return file_; }

 private:
  TemporaryFolder folder_;
  std::string file_;
};

/// A mass of 2 kg that hangs 0.5 m below its hinge.
const char* const pendulum = R"([[body]]
name = "bob"
joint = { name = "hinge", kind = "revolute", axis = "-y", point = [0, 0, 0], damping = 0.7 }
mass = 2
com = [0, 0, -0.5]
inertia = [0, 0, 0]
)";
const double omega = std::sqrt(9.81 / 0.5);  // rad/s

TEST(Linearize, HasTheMatricesOfTheLibrary) {
  const std::string state = R"({"v": {"ball": [0.1, 0.2, 0.3], "air bearing": [1, 2, 3]}, "tau": {"jack": 5},
    "loads": [{"frame": "table", "representation": "hybrid", "wrench": [1, 2, 3, 4, 5, 6]}]})";
  const Json shown = answer({robot("machine.toml"), "--joint-losses"}, state);
  const Model model = load(robot("machine.toml"));
  const AppliedWrench<> W(model.frame_index("table"), Representation::hybrid, {1, 2, 3}, {4, 5, 6});
  RowMajor A(2 * model.nv(), 2 * model.nv()), B(2 * model.nv(), model.nv());
  Workspace<> workspace(model);
  ASSERT_TRUE(linearize(model, workspace, numbers(shown["q"]), numbers(shown["v"]), numbers(shown["tau"]),
                        {as_span(A), as_span(B)}, {{&W, 1}, true})
                  .ok());
  EXPECT_EQ(matrix(shown["A"]), A);
  EXPECT_EQ(matrix(shown["B"]), B);
  EXPECT_EQ(shown["v"][static_cast<std::size_t>(model.joint(model.joint_index("air bearing")).iv)], 1);
  EXPECT_EQ(shown["velocities"], Json(velocity_names(model)));
  EXPECT_EQ(shown["joint_losses"], true);
}

TEST(Linearize, FindsTheFrequencyAndTheDampingOfAPendulum) {
  const Drawn drawn(pendulum);
  const Json free = answer({drawn.file()}), damped = answer({drawn.file(), "--joint-losses"});
  EXPECT_EQ(free["stability"], "marginal");
  ASSERT_EQ(free["modes"].size(), 1);
  EXPECT_NEAR(free["modes"][0]["natural_frequency"], omega, 1e-13);
  EXPECT_EQ(free["modes"][0]["damping_ratio"], 0);
  EXPECT_EQ(free["modes"][0]["shape"], (Json{{1.0, 0.0}}));
  EXPECT_EQ(damped["stability"], "stable");
  EXPECT_NEAR(damped["modes"][0]["natural_frequency"], omega, 1e-13);
  EXPECT_NEAR(damped["modes"][0]["damping_ratio"], 0.7 / (2 * 0.5 * omega), 1e-13);
  const Outcome table = axode({"linearize", drawn.file()});
  EXPECT_THAT(table.out, HasSubstr("dv' hinge     -19.62"));
  EXPECT_THAT(table.out, HasSubstr("1  oscillates  0.704968  4.42945              0  hinge 1.00"));
  EXPECT_THAT(table.out, Not(HasSubstr("no equilibrium")));
}

TEST(Linearize, FindsTheTimeConstantsOfAPendulumOnItsHead) {
  const Drawn drawn(pendulum);
  const Json shown = answer({drawn.file(), "--equilibrium"}, R"({"q": [3]})");
  EXPECT_NEAR(shown["q"][0], std::numbers::pi, 1e-9);
  EXPECT_EQ(shown["stability"], "unstable");
  ASSERT_EQ(shown["modes"].size(), 2);
  double sum = 0;
  for (const Json& mode : shown["modes"]) {
    EXPECT_NEAR(mode["time_constant"], 1 / omega, 1e-13);
    sum += mode["eigenvalue"][0].get<double>();
  }
  EXPECT_NEAR(sum, 0, 1e-13);
  EXPECT_THAT(axode({"linearize", drawn.file(), "--equilibrium", "--state", "-"}, R"({"q": [3]})").out,
              HasSubstr("unstable: 1 mode grows"));
}

TEST(Linearize, HoldsAConfigurationOrSaysThatItIsNone) {
  const Drawn drawn(pendulum);
  const std::string aside = R"({"q": {"hinge": 0.5}})";
  const Json held = answer({drawn.file(), "--hold"}, aside), let_go = answer({drawn.file()}, aside);
  EXPECT_NEAR(held["tau"][0], 9.81 * std::sin(0.5), 1e-14);
  EXPECT_NEAR(held["a"][0], 0, 1e-14);
  EXPECT_NEAR(held["modes"][0]["natural_frequency"], omega * std::sqrt(std::cos(0.5)), 1e-13);
  EXPECT_NEAR(let_go["a"][0], -omega * omega * std::sin(0.5), 1e-13);
  EXPECT_THAT(axode({"linearize", drawn.file(), "--state", "-"}, aside).out, HasSubstr("no equilibrium"));
}

TEST(Linearize, NamesRigidModes) {
  const Drawn drawn(
      "gravity = [0, 0, 0]\n[[body]]\nname = \"body\"\njoint = { name = \"drift\", kind = \"free\" }\n"
      "mass = 1\ncom = [0, 0, 0]\ninertia = [1, 2, 3]\n");
  const Json shown = answer({drawn.file()});
  EXPECT_EQ(shown["zero_eigenvalues"], 12);
  ASSERT_EQ(shown["modes"].size(), 6);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(shown["modes"][k]["rigid"], true);
    EXPECT_EQ(shown["modes"][k]["shape"][k], (Json{1.0, 0.0}));
  }
  EXPECT_THAT(axode({"linearize", drawn.file()}).out, HasSubstr("6  rigid  drift[5] 1.00"));
}

/// Expects that every mode (λ, δ) solves λ x = A x with x = (δ, λδ + ad_v δ), and that no mode is missing.
TEST(Linearize, EveryModeIsOneOfTheMatrix) {
  for (const char* const file : {"double_pendulum.toml", "arm7.toml", "machine.toml", "humanoid.urdf"}) {
    SCOPED_TRACE(file);
    const Json shown = answer({robot(file), "--joint-losses", "--hold"});
    const MatrixXd A = matrix(shown["A"]);
    const Eigen::Index nv = A.rows() / 2;
    Eigen::Index count = shown["zero_eigenvalues"].get<Eigen::Index>();
    for (const Json& mode : shown["modes"]) {
      const std::complex<double> lambda(mode["eigenvalue"][0], mode["eigenvalue"][1]);
      Eigen::VectorXcd x(2 * nv);
      for (Eigen::Index k = 0; k < nv; ++k) x[k] = {mode["shape"][k][0], mode["shape"][k][1]};
      x.tail(nv) = lambda * x.head(nv);  // at rest
      EXPECT_LE((A * x - lambda * x).norm(), 1e-7 * std::max(1.0, A.norm())) << mode["eigenvalue"];
      if (lambda != 0.0) count += lambda.imag() > 0 ? 2 : 1;
    }
    EXPECT_EQ(count, A.rows());
  }
}

TEST(Linearize, WritesJsonCsvAndNumpy) {
  const TemporaryFolder folder;
  const std::string json = folder.file("a.json"), csv = folder.file("a.csv"), npz = folder.file("a.npz");
  const Outcome outcome = axode({"linearize", "--output", json, "--output", csv, "--output", npz,
                                 robot("double_pendulum.toml"), "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(contents(json), outcome.out);
  const Json shown = Json::parse(outcome.out);
  MatrixXd AB(4, 6);
  AB << matrix(shown["A"]), matrix(shown["B"]);

  std::istringstream lines(contents(csv));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, R"("","delta pin","delta elbow","dv pin","dv elbow","dtau pin","dtau elbow")");
  for (const char* const name : {"delta' pin", "delta' elbow", "dv' pin", "dv' elbow"}) {
    std::getline(lines, line);
    const std::string start = '"' + std::string(name) + '"';
    ASSERT_THAT(line, testing::StartsWith(start + ","));
    std::istringstream row(line.substr(start.size()));
    const Eigen::Index i =
        line.find("delta") == 1 ? (line.find("pin") == 8 ? 0 : 1) : (line.find("pin") == 5 ? 2 : 3);
    for (Eigen::Index k = 0; k < 6; ++k) {
      char comma = 0;
      double number = 0;
      row >> comma >> number;
      EXPECT_EQ(number, AB(i, k));
    }
  }

  // The .npz is a ZIP archive that stores two arrays without compression.
  const std::string bytes = contents(npz);
  EXPECT_EQ(bytes.substr(0, 4), "PK\x03\x04");
  for (const char* const name : {"A", "B"}) {
    const MatrixXd expected = matrix(shown[name]);
    const std::size_t start = bytes.find("\x93NUMPY", bytes.find(std::string(name) + ".npy"));
    ASSERT_NE(start, std::string::npos);
    const std::string file = bytes.substr(start);
    EXPECT_EQ(file.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
    const std::size_t header =
        static_cast<unsigned char>(file[8]) + 256u * static_cast<unsigned char>(file[9]);
    EXPECT_EQ((10 + header) % 64, 0);
    EXPECT_THAT(file.substr(10, header),
                testing::StartsWith("{'descr': '<f8', 'fortran_order': False, 'shape': (4, " +
                                    std::to_string(expected.cols()) + "), }"));
    EXPECT_EQ(file[9 + header], '\n');
    for (std::size_t k = 0; k < static_cast<std::size_t>(expected.size()); ++k) {
      std::uint64_t bits = 0;
      for (std::size_t b = 8; b-- > 0;)
        bits = bits << 8 | static_cast<unsigned char>(file[10 + header + 8 * k + b]);
      const auto columns = static_cast<std::size_t>(expected.cols());
      EXPECT_EQ(std::bit_cast<double>(bits),
                expected(static_cast<Eigen::Index>(k / columns), static_cast<Eigen::Index>(k % columns)));
    }
  }
}

TEST(Linearize, SaysTheSizesOfLargeMatrices) {
  const Outcome outcome = axode({"linearize", robot("humanoid.urdf"), "--base", "free", "--hold"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("A is 74 x 74 and B is 74 x 37; --output writes them to a file"));
}

TEST(Linearize, OfWhatDoesNotMoveIsEmpty) {
  const Drawn drawn(
      "[[body]]\nname = \"table\"\njoint = { kind = \"fixed\" }\nmass = 1\ncom = [0, 0, 0]\n"
      "inertia = [1, 1, 1]\n");
  const Json shown = answer({drawn.file(), "--equilibrium"});
  EXPECT_EQ(shown["A"], Json::array());
  EXPECT_EQ(shown["modes"], Json::array());
  EXPECT_EQ(axode({"linearize", drawn.file()}).code, 0);
}

TEST(Linearize, CountsLoops) {
  const std::string rods = robot("bricard.toml");
  const Json hanging = answer({rods, "--equilibrium"});
  ASSERT_EQ(hanging["independent"].size(), 1);
  ASSERT_EQ(hanging["A"].size(), 2);
  EXPECT_EQ(hanging["B"][1].size(), 5);
  EXPECT_NEAR(hanging["modes"][0]["natural_frequency"], 1.2413, 1e-4);
  EXPECT_THAT(numbers(hanging["a"]), testing::Each(testing::DoubleNear(0, 1e-8)));
  const Outcome shown = axode({"linearize", rods});
  EXPECT_EQ(shown.code, 0);
  EXPECT_THAT(shown.out, HasSubstr("delta' hinge"));

  const Model platform = load(robot("gough.toml"));
  const Json held = answer({robot("gough.toml"), "--hold"});
  EXPECT_EQ(held["independent"].size(), 6);
  EXPECT_THAT(numbers(held["a"]), testing::Each(testing::DoubleNear(0, 1e-8)));
  for (const Joint& joint : platform.joints())
    for (int k = 0; k < joint.nv; ++k) EXPECT_EQ(held["tau"][joint.iv + k] == 0, joint.passive) << joint.name;
}

TEST(Linearize, IsNotThereWhereTheMassMatrixIsSingular) {
  const Drawn massless(
      "[[body]]\nname = \"ghost\"\njoint = { name = \"slide\", kind = \"prismatic\", axis = \"z\" }\n");
  const Outcome outcome = axode({"linearize", massless.file()});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.err, HasSubstr("\"slide\""));
}

}  // namespace
}  // namespace axode::test
