#include "axode/model/edited.hpp"

#include <stdexcept>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "axode/model/builder.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/inertial_parameters.hpp"
#include "axode/model/placement.hpp"

namespace axode {
namespace {

/// The mass properties of a body that has the inertia M in its frame.
MassProperties mass_properties(const Inertia<>& M) {
  return {.mass = M.m,
          .com = M.m == 0 ? Vec3<>{} : center_of_mass(M),
          .Theta = M.Theta,
          .about = InertiaAbout::frame_origin};
}

/// Throws std::invalid_argument where two mechanisms have names in common, the second one's with a prefix.
void check_names_differ(const Description& one, const Description& other, const std::string& prefix) {
  std::unordered_set<std::string> places, joints;  // bodies and frames share their names
  for (const BodyDescription& body : one.bodies) places.insert(body.name), joints.insert(joint_name(body));
  for (const FrameDescription& frame : one.frames) places.insert(frame.name);
  std::string both;
  const auto check = [&](const std::unordered_set<std::string>& taken, const std::string& name) {
    if (taken.contains(prefix + name)) both += (both.empty() ? "\"" : ", \"") + prefix + name + '"';
  };
  for (const BodyDescription& body : other.bodies) check(places, body.name), check(joints, joint_name(body));
  for (const FrameDescription& frame : other.frames) check(places, frame.name);
  if (!both.empty())
    throw std::invalid_argument("append: both models have " + both +
                                "; give a prefix that makes them differ");
}

Model built(Description description) { return ModelBuilder(std::move(description)).build(); }

}  // namespace

Model with_parameters(const Model& model, std::span<const double> pi) {
  check_size("pi", pi.size(), 10 * static_cast<std::size_t>(model.n_bodies()), "10 * n_bodies");
  std::unordered_map<std::string_view, const Frame*> frames;
  for (const Frame& frame : model.frames()) frames.emplace(frame.name, &frame);
  Description description = expand(model.description());
  for (BodyDescription& body : description.bodies) {
    const int i = frames.at(body.name)->body;
    if (i == 0) continue;
    body.inertia.reset();
    if (model.body(i).name != body.name) continue;
    const auto own = pi.subspan(10 * static_cast<std::size_t>(i - 1)).first<10>();
    const Inertia<> M = inertia_of(own);
    if (M.m == 0 && (M.h.x != 0 || M.h.y != 0 || M.h.z != 0))
      throw std::invalid_argument("pi: body \"" + body.name +
                                  "\" has a first moment of mass but the mass 0; give it a mass");
    if (inertial_parameters(M) != inertial_parameters(Inertia<>{})) body.inertia = mass_properties(M);
  }
  return built(std::move(description));
}

Model with_gravity(const Model& model, const Vec3<>& g) { return ModelBuilder(model).gravity(g).build(); }

Model with_payload(const Model& model, std::string_view frame, const Inertia<>& M, std::string_view name) {
  const Frame& at = model.frame(model.frame_index(frame));
  const BodyDescription payload{.name = std::string(name),
                                .predecessor = model.body(at.body).name,
                                .geometry = InBodyFrame{at.pose},
                                .inertia = mass_properties(M)};
  BodyDescription alone = payload;
  alone.predecessor = "ground";
  ModelBuilder("payload").add(std::move(alone)).build();
  Description description = expand(model.description());
  description.bodies.push_back(payload);
  return built(std::move(description));
}

Model append(const Model& model, std::string_view frame, const Model& other, std::string_view prefix) {
  const Frame& at = model.frame(model.frame_index(frame));
  const std::string carrier = model.body(at.body).name;
  const auto renamed = [&](const std::string& name) { return std::string(prefix) + name; };
  Description description = expand(model.description());
  Description mounted = in_joint_frames(other.description());
  check_names_differ(description, mounted, std::string(prefix));
  for (BodyDescription& body : mounted.bodies) {
    body.joint.name = renamed(joint_name(body));
    body.name = renamed(body.name);
    if (body.joint.coupling) body.joint.coupling->leader = renamed(body.joint.coupling->leader);
    if (body.predecessor == "ground") {
      body.predecessor = carrier;
      if (auto* fixed = std::get_if<InBodyFrame>(&body.geometry)) {
        fixed->B = at.pose * fixed->B;
      } else {
        SE3<>& S_prev = std::get<InJointFrames>(body.geometry).S_prev;
        S_prev = at.pose * S_prev;
      }
    } else {
      body.predecessor = renamed(body.predecessor);
    }
    description.bodies.push_back(std::move(body));
  }
  for (FrameDescription& mark : mounted.frames) {
    mark.name = renamed(mark.name);
    mark.pose = mark.body == "ground" ? at.pose * mark.pose : mark.pose;
    mark.body = mark.body == "ground" ? carrier : renamed(mark.body);
    description.frames.push_back(std::move(mark));
  }
  for (SpringDescription& spring : mounted.springs) {
    for (std::size_t k = 0; k < 2; ++k) {
      const bool on_ground = spring.between[k] == "ground";
      if (on_ground) spring.points[k] = at.pose * spring.points[k];
      spring.between[k] = on_ground ? carrier : renamed(spring.between[k]);
    }
    description.springs.push_back(std::move(spring));
  }
  description.warnings.insert(description.warnings.end(), mounted.warnings.begin(), mounted.warnings.end());
  return built(std::move(description));
}

}  // namespace axode
