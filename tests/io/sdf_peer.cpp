#if __has_include(<sdf/sdf.hh>)
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <sdf/sdf.hh>
#include <string>
#include <vector>

#include "axode/io.hpp"
#include "axode/lie/inertia.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/model/building/placement.hpp"
#include "tests/io/same_mechanism.hpp"

namespace axode::sdf_peer {
namespace {

/// A random model whose elements are placed relative to each other in every way that SDFormat has.
class RandomModel {
 public:
  explicit RandomModel(unsigned seed) : random_(seed) {}

  std::string text() {
    const std::string inner = model("m", 0);
    return "<sdf version='1.9'><world name='w'>" + inner + "</world></sdf>";
  }
  std::vector<std::string> links, joints;  ///< their paths within the model

 private:
  int below(int n) { return std::uniform_int_distribution(0, n - 1)(random_); }
  std::string number() { return to_text(std::uniform_real_distribution(-1.0, 1.0)(random_)); }
  std::string numbers(int n) {
    std::string all;
    for (int k = 0; k < n; ++k) all += number() + " ";
    return all;
  }
  std::string one_of(const std::vector<std::string>& names) {
    return names[static_cast<std::size_t>(below(static_cast<int>(names.size())))];
  }
  std::string pose(const std::vector<std::string>& known) {
    const bool degrees = below(2) == 0;
    return std::string("<pose ") + (degrees ? "degrees='true' " : "") +
           (known.empty() || below(2) == 0 ? "" : "relative_to='" + one_of(known) + "'") + ">" + numbers(6) +
           "</pose>";
  }

  std::string model(const std::string& path, int depth) {
    const std::string own = path.substr(path.rfind(':') == std::string::npos ? 0 : path.rfind(':') + 1),
                      scope = depth == 0 ? "" : path.substr(3) + "::";
    std::string out;
    std::vector<std::string> known{"__model__"}, own_links;
    for (int k = 0; k < 3; ++k) {
      const std::string l = "l" + std::to_string(k), f = "f" + std::to_string(k);
      out += "<link name='" + l + "'>" + pose(known) + "<inertial><pose>" + numbers(6) +
             "</pose><mass>2</mass><inertia><ixx>1</ixx><iyy>1.2</iyy><izz>0.9</izz><ixy>0.1</ixy><iyz>0.05</"
             "iyz>"
             "</inertia></inertial></link>";
      known.push_back(l), own_links.push_back(l), links.push_back(scope + l);
      out += "<frame name='" + f + "' attached_to='" + one_of(known) + "'>" + pose(known) + "</frame>";
      known.push_back(f);
    }
    if (depth < 2) {
      out += model(path + "::n", depth + 1);
      known.push_back("n"), known.push_back("n::l1"), own_links.push_back("n::l0");
    }
    const std::vector<std::string> types{"revolute", "prismatic", "universal", "ball", "fixed", "continuous"};
    for (std::size_t k = 1; k < own_links.size(); ++k) {
      const std::string j = "j" + std::to_string(k), type = one_of(types);
      const auto axis = [&](const char* name) {
        return std::string("<") + name + "><xyz" +
               (below(2) == 0 ? "" : " expressed_in='" + one_of(known) + "'") + ">" + numbers(3) +
               "</xyz></" + name + ">";
      };
      out += "<joint name='" + j + "' type='" + type + "'>" + pose(known) + "<parent>" + own_links[k - 1] +
             "</parent><child>" + own_links[k] + "</child>" + axis("axis") +
             (type == "universal" ? axis("axis2") : "") + "</joint>";
      joints.push_back(scope + j);
    }
    const std::string placed = below(2) == 0 ? "" : " placement_frame='" + one_of(known) + "'";
    return "<model name='" + own + "'" + (placed.find("n::") == std::string::npos ? placed : "") + ">" +
           pose({}) + out + "</model>";
  }

  std::mt19937 random_;
};

SE3<> ours(const ignition::math::Pose3d& C) {
  return {rotation(Quaternion<>{C.Rot().X(), C.Rot().Y(), C.Rot().Z(), C.Rot().W()}),
          {C.Pos().X(), C.Pos().Y(), C.Pos().Z()}};
}
Vec3<> ours(const ignition::math::Vector3d& a) { return {a.X(), a.Y(), a.Z()}; }

/// Converts an inertia to that about the origin of the link, along its axes.
Inertia<> ours(const ignition::math::Inertiald& theirs) {
  const ignition::math::Matrix3d Theta = theirs.Moi();  // about the centre of mass, in the axes of the link
  return inertia_from_com(
      theirs.MassMatrix().Mass(), ours(theirs.Pose().Pos()),
      Sym3<>{Theta(0, 0), Theta(1, 1), Theta(2, 2), Theta(0, 1), Theta(0, 2), Theta(1, 2)});
}

/// The pose in the world of a nested model, by its path in the outermost model. An empty path means that one.
SE3<> pose_of(const sdf::World& world, const std::string& path) {
  const sdf::Model* model = world.ModelByIndex(0);
  ignition::math::Pose3d pose;
  EXPECT_TRUE(model->SemanticPose().Resolve(pose, "world").empty());
  SE3<> C = ours(pose);
  for (std::string_view rest = path; !rest.empty();) {
    const std::size_t end = std::min(rest.find("::"), rest.size());
    model = model->ModelByName(std::string(rest.substr(0, end)));
    EXPECT_TRUE(model->SemanticPose().Resolve(pose, "__model__").empty());
    C = C * ours(pose);
    rest.remove_prefix(std::min(end + 2, rest.size()));
  }
  return C;
}
std::string model_of(const std::string& path) {
  const std::size_t end = path.rfind("::");
  return end == std::string::npos ? "" : path.substr(0, end);
}

TEST(SdfPeer, LinksMatterAndAxesAreWhereLibsdformatHasThem) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    RandomModel random(seed);
    const std::string text = random.text();
    sdf::Root root;
    const sdf::Errors errors = root.LoadSdfString(text);
    ASSERT_TRUE(errors.empty()) << errors[0].Message() << text;
    const sdf::World& world = *root.WorldByIndex(0);
    const sdf::Model& theirs = *world.ModelByIndex(0);
    const Description description = read_sdf_text(text, "random.sdf");
    const Model model = ModelBuilder(description).build();
    const auto frames = test::frames_at_zero(model);
    double mass = 0;
    for (const std::string& name : random.links) {
      const sdf::Link& link = *theirs.LinkByName(name);
      ignition::math::Pose3d pose;
      ASSERT_TRUE(link.SemanticPose().Resolve(pose, "__model__").empty());
      EXPECT_LT(test::disparity(frames.at(name), pose_of(world, model_of(name)) * ours(pose)), 1e-12)
          << name << " of " << text;
      mass += link.Inertial().MassMatrix().Mass();
      const BodyDescription& body = *std::ranges::find(description.bodies, name, &BodyDescription::name);
      EXPECT_LT(test::disparity(inertia_in({}, *body.inertia), ours(link.Inertial())), 1e-12)
          << name << " of " << text;
    }
    EXPECT_NEAR(model.total_mass(), mass, 1e-12);
    for (const std::string& name : random.joints) {
      const sdf::Joint& joint = *theirs.JointByName(name);
      if (joint.Type() == sdf::JointType::FIXED || joint.Type() == sdf::JointType::BALL) continue;
      ignition::math::Vector3d in_model;
      ASSERT_TRUE(joint.Axis(0)->ResolveXyz(in_model, "__model__").empty());
      const Vec3<> axis = pose_of(world, model_of(name)).R * ours(in_model);
      const bool two = joint.Type() == sdf::JointType::UNIVERSAL;
      const int i = model.joint_index(two ? name + ".first" : name);
      const Screw<>& X = model.body(i).X[0];
      const Vec3<> direction = model.body(i).A.R * (norm(X.w) > 0 ? X.w : X.v);
      EXPECT_LT(norm(direction - (1 / norm(axis)) * axis), 1e-12) << name << " of " << text;
    }
  }
}

}  // namespace
}  // namespace axode::sdf_peer

#else
#include <gtest/gtest.h>

TEST(SdfPeer, LinksMatterAndAxesAreWhereLibsdformatHasThem) {
  GTEST_SKIP() << "libsdformat is not installed";
}
#endif
