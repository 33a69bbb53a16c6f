#include <gtest/gtest.h>

#include <ctime>
#include <string>

#include "axode/io.hpp"
#include "axode/model/building/builder.hpp"
#include "tests/io/same_mechanism.hpp"

namespace axode {
namespace {

constexpr int most = 10000;

/// Expects that with(n) takes a time that is proportional to n: for the largest n about four times as long as
/// for a quarter of it, and not sixteen times as for n². It measures processor time, on which other programs
/// have little effect, and one success in three attempts is enough.
template <class With> void expect_linear(const With& with) {
  const auto seconds = [&](int n) {
    const std::clock_t start = std::clock();
    with(n);
    return static_cast<double>(std::clock() - start);
  };
  double ratio = 16;
  for (int attempt = 0; attempt < 3 && ratio >= 10 && !testing::Test::HasFailure(); ++attempt) {
    const double quarter = seconds(most / 4);
    ratio = seconds(most) / quarter;
  }
  EXPECT_LT(ratio, 10);
}

std::string number(int i) { return std::to_string(i); }

/// A chain of n links as a URDF file. The text inner(i) is inside the joint that moves link i.
template <class Inner> std::string urdf_chain(int n, Inner inner) {
  std::string text = "<robot name=\"chain\">\n<link name=\"b0\"/>\n";
  for (int i = 1; i <= n; ++i)
    text += "<link name=\"b" + number(i) +
            "\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" "
            "iyz=\"0\"/>"
            "</inertial></link>\n<joint name=\"j" +
            number(i) + "\" type=\"continuous\"><parent link=\"b" + number(i - 1) + "\"/><child link=\"b" +
            number(i) + "\"/>" + inner(i) + "</joint>\n";
  return text + "</robot>\n";
}

TEST(LongChains, AUrdfOfTenThousandLinksIsReadBuiltAndWritten) {
  expect_linear([](int n) {
    const std::string text =
        urdf_chain(n, [](int) { return "<origin xyz=\"0.1 0 0\" rpy=\"0.1 0.2 0.3\"/>"; });
    const Model model = ModelBuilder(read_urdf_text(text, "chain.urdf")).build();
    EXPECT_EQ(model.n_bodies(), n);
    const Model drawn = ModelBuilder(read_drawing_text(test::drawing_of(model), "chain.toml")).build();
    EXPECT_LT(test::disparity(model, drawn), 1e-9);
    EXPECT_EQ(ModelBuilder(read_urdf_text(test::urdf_of(drawn), "again.urdf")).build().n_bodies(), n);
  });
}

TEST(LongChains, TenThousandMimicJointsOneAfterAnotherFollowTheFirst) {
  expect_linear([](int n) {
    const std::string text =
        urdf_chain(n, [=](int i) { return i == n ? "" : "<mimic joint=\"j" + number(i + 1) + "\"/>"; });
    const Model model = ModelBuilder(read_urdf_text(text, "chain.urdf")).build();
    EXPECT_EQ(model.nv(), 1);
    EXPECT_EQ(model.joint(1).leader->joint, n);
  });
}

TEST(LongChains, TenThousandBodiesOnTheGround) {
  expect_linear([](int n) {
    std::string text = "format = \"axode drawing 1\"\n";
    for (int i = 0; i < n; ++i)
      text += "[[body]]\nname = \"b" + number(i) +
              "\"\njoint = { kind = \"prismatic\", axis = \"x\" }\n[[frame]]\nname = \"f" + number(i) +
              "\"\non = \"b" + number(i) + "\"\n";
    const Model model = ModelBuilder(read_drawing_text(text, "star.toml")).build();
    const Model again = ModelBuilder(read_urdf_text(test::urdf_of(model), "star.urdf")).build();
    EXPECT_EQ(again.n_frames(), model.n_frames());
  });
}

}  // namespace
}  // namespace axode
