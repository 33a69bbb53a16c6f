#pragma once
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>

#include "axode/contact.hpp"
#include "axode/io.hpp"
#include "axode/model/configuration.hpp"
#include "bench/subjects.hpp"

/// A quadruped that stands on four balls, for axode and its peers.
namespace axode::bench {

struct Standing {
  static constexpr double h = 2e-3, stiffness = 20, damping = 0.5, radius = 0.016;
  Model model;
  std::vector<double> q;  ///< feet on the floor, knees bent
};

/// solo12 with balls for feet and a floor. There is none if the folder of robots is missing.
inline std::vector<Standing> standing_robots() {
  const char* set = std::getenv("AXODE_ROBOTS");
  const std::filesystem::path file = std::filesystem::path(set ? set : AXODE_SHARED_ROBOTS) / "solo12.urdf";
  if (!std::filesystem::exists(file)) return {};
  Description description = load(file, Base::free).description();
  description.name = "solo12";
  ShapeDescription shape{.role = ShapeDescription::Role::collision, .kind = ShapeKind::plane};
  shape.contact.friction = 0.6;
  description.shapes = {shape};
  shape.kind = ShapeKind::sphere;
  shape.radius = Standing::radius;
  for (BodyDescription& body : description.bodies) {
    body.shapes.clear();
    if (body.name.ends_with("_FOOT")) body.shapes = {shape};
  }
  description.contact = ContactDescription{};
  const Model model = ModelBuilder(std::move(description)).build();
  std::vector<double> q = neutral(model);
  const auto joint = [&](const std::string& name) -> double& {
    return q[static_cast<std::size_t>(model.joint(model.joint_index(name)).iq)];
  };
  for (const char* leg : {"FL", "FR", "HL", "HR"}) {
    const double side = leg[0] == 'F' ? 1 : -1;
    joint(std::string(leg) + "_HFE") = side * 0.7;
    joint(std::string(leg) + "_KFE") = -side * 1.4;
  }
  Distances distances(model);
  double lowest = std::numeric_limits<double>::infinity();
  for (const ShapeDistance& foot : distances.evaluate(q)) lowest = std::min(lowest, foot.distance);
  q[6] -= lowest;
  return {{model, q}};
}

}  // namespace axode::bench
