#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "axode/io.hpp"
#include "axode/model/builder.hpp"
#include "tests/io/same_mechanism.hpp"

namespace axode {
namespace {

constexpr int n = 10000;
constexpr double seconds_allowed =
    20;  // a chain is read in less than 1 s; work that grows as n² takes minutes

class Watch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::string number(int i) { return std::to_string(i); }

/// inner(i) stands inside the joint that moves link i.
template <class Inner> std::string urdf_chain(Inner inner) {
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
  const Watch watch;
  const std::string text = urdf_chain([](int) { return "<origin xyz=\"0.1 0 0\" rpy=\"0.1 0.2 0.3\"/>"; });
  const Model model = ModelBuilder(read_urdf_text(text, "chain.urdf")).build();
  EXPECT_EQ(model.n_bodies(), n);
  const Model drawn = ModelBuilder(read_drawing_text(test::drawing_of(model), "chain.toml")).build();
  EXPECT_LT(test::disparity(model, drawn), 1e-9);
  EXPECT_EQ(ModelBuilder(read_urdf_text(test::urdf_of(drawn), "again.urdf")).build().n_bodies(), n);
  EXPECT_LT(watch.seconds(), 3 * seconds_allowed);
}

TEST(LongChains, TenThousandMimicJointsOneAfterAnotherFollowTheFirst) {
  const Watch watch;
  const std::string text =
      urdf_chain([](int i) { return i == n ? "" : "<mimic joint=\"j" + number(i + 1) + "\"/>"; });
  const Model model = ModelBuilder(read_urdf_text(text, "chain.urdf")).build();
  EXPECT_EQ(model.nv(), 1);
  EXPECT_EQ(model.joint(1).leader->joint, n);
  EXPECT_LT(watch.seconds(), seconds_allowed);
}

TEST(LongChains, ACycleOfTenThousandIsAFaultWithAShortMessage) {
  const Watch watch;
  std::string text = "format = \"axode drawing 1\"\n";
  for (int i = 0; i < n; ++i)
    text +=
        "[[body]]\nname = \"b" + number(i) + "\"\non = \"b" + number((i + 1) % n) + "\"\njoint = \"fixed\"\n";
  try {
    ModelBuilder(read_drawing_text(text, "cycle.toml")).build();
    FAIL() << "built";
  } catch (const ModelError& error) {
    ASSERT_EQ(error.faults().size(), 1U);
    EXPECT_EQ(error.faults()[0].rule, Rule::cycle);
    EXPECT_LT(error.faults()[0].message.size(), 500U);
  }
  EXPECT_LT(watch.seconds(), seconds_allowed);
}

TEST(LongChains, TenThousandUnknownNamesAreTenThousandFaultsInTime) {
  const Watch watch;
  std::string text = "format = \"axode drawing 1\"\n";
  for (int i = 0; i < n; ++i)
    text += "[[body]]\nname = \"b" + number(i) + "\"\non = \"c" + number(i) +
            "\"\njoint = { kind = \"prismatic\", axis = \"x\", follows = { joint = \"k" + number(i) +
            "\" } }\n";
  try {
    ModelBuilder(read_drawing_text(text, "unknown.toml")).build();
    FAIL() << "built";
  } catch (const ModelError& error) {
    EXPECT_EQ(error.faults().size(), 2U * n);
  }
  EXPECT_LT(watch.seconds(), seconds_allowed);
}

TEST(LongChains, TenThousandBodiesOnTheGround) {
  const Watch watch;
  std::string text = "format = \"axode drawing 1\"\n";
  for (int i = 0; i < n; ++i)
    text += "[[body]]\nname = \"b" + number(i) +
            "\"\njoint = { kind = \"prismatic\", axis = \"x\" }\n[[frame]]\nname = \"f" + number(i) +
            "\"\non = \"b" + number(i) + "\"\n";
  const Model model = ModelBuilder(read_drawing_text(text, "star.toml")).build();
  const Model again = ModelBuilder(read_urdf_text(test::urdf_of(model), "star.urdf")).build();
  EXPECT_EQ(again.n_frames(), model.n_frames());
  EXPECT_LT(watch.seconds(), seconds_allowed);
}

}  // namespace
}  // namespace axode
