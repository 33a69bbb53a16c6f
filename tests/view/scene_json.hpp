#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "axode/eigen.hpp"
#include "axode/io.hpp"
#include "axode/model/kinds/joint_kinds.hpp"
#include "axode/view.hpp"

/// A scene, read in the way in which a page reads it.
namespace axode::test {

using Json = nlohmann::json;

inline Model shipped(const std::string& file) { return load(AXODE_SOURCE_DIR "/examples/robots/" + file); }

/// A mechanism that comes with the library, without the shapes of its drawing.
inline Model without_shapes(const std::string& file, Base base = Base::as_described) {
  Description d = load(AXODE_SOURCE_DIR "/examples/robots/" + file, base).description();
  d.shapes.clear();
  for (BodyDescription& body : d.bodies) body.shapes.clear();
  return ModelBuilder(std::move(d)).build();
}

inline Json scene_of(const Model& model, std::span<const double> q, const SceneOptions& options = {}) {
  std::ostringstream out;
  write_scene(model, q, out, options);
  return Json::parse(out.str());
}

inline Eigen::Isometry3d pose_from(const Json& x) {
  Eigen::Isometry3d C = Eigen::Isometry3d::Identity();
  C.linear() =
      Eigen::Quaterniond(x[6].get<double>(), x[3].get<double>(), x[4].get<double>(), x[5].get<double>())
          .toRotationMatrix();
  C.translation() = Eigen::Vector3d(x[0].get<double>(), x[1].get<double>(), x[2].get<double>());
  return C;
}

inline SE3<> pose_of(const Json& x) { return from_eigen<SE3<>>(pose_from(x).matrix()); }

/// The displacement J(q) of the frame of a body by its joint.
inline Eigen::Isometry3d motion_of(const Json& bodies, const Json& joint, std::span<const double> q) {
  const bool coupled = !joint["leader"].is_null();
  const Json& own = coupled ? bodies[joint["leader"]["joint"].get<std::size_t>()]["joint"] : joint;
  std::vector<double> x(q.begin() + own["iq"].get<int>(),
                        q.begin() + own["iq"].get<int>() + own["nq"].get<int>());
  if (coupled) x = {joint["leader"]["ratio"].get<double>() * x[0] + joint["leader"]["offset"].get<double>()};
  const auto named = std::ranges::find(joint_kinds, joint["kind"].get<std::string>(), &JointTraits::name);
  return with_subgroup(named->subgroup, joint["pitch"].get<double>(), [&](const auto& of) {
    return Eigen::Isometry3d(to_eigen(of.pose(SE3<>{}, x.data())));
  });
}

/// The poses of the ground and the bodies, computed from the scene alone.
inline std::vector<Eigen::Isometry3d> poses_of(const Json& scene, std::span<const double> q) {
  const Json& bodies = scene["bodies"];
  std::vector<Eigen::Isometry3d> C{Eigen::Isometry3d::Identity()};
  for (std::size_t i = 1; i < bodies.size(); ++i)
    C.push_back(C[bodies[i]["predecessor"].get<std::size_t>()] * pose_from(bodies[i]["S_prev"]) *
                motion_of(bodies, bodies[i]["joint"], q) * pose_from(bodies[i]["S_self"]).inverse());
  return C;
}

}  // namespace axode::test
