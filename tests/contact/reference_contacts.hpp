#pragma once
#include <gtest/gtest.h>

#include "axode/contact/law/contact_dynamics.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/io.hpp"
#include "tests/contact/contact_case.hpp"
#include "tests/support/comparison.hpp"
#include "tests/support/shared_files.hpp"
#include "tests/support/vectors.hpp"

/// Mechanisms in contact with reference values, from every file of `contact/` in the folder of vectors.
namespace axode::test {

inline std::vector<double> to_vector(std::span<const double> x) { return {x.begin(), x.end()}; }

inline std::filesystem::path contact_folder() { return vectors_folder() / "contact"; }
inline const std::string no_case = "none";
inline std::vector<std::string> contact_cases() {
  std::vector<std::string> names;
  for (const auto& file : files_ending_in(contact_folder(), ".json")) names.push_back(file.stem().string());
  return names.empty() ? std::vector{no_case} : names;
}
inline std::string case_name(const testing::TestParamInfo<std::string>& name) { return name.param; }

struct ReferenceContacts {
  Json file;
  Description description;
  double threshold, margin;

  explicit ReferenceContacts(const std::string& name)
      : file(read_json(contact_folder() / (name + ".json"))),
        description(read_drawing_text(file.at("model").text(), name)),
        threshold(number(file.at("threshold"))),
        margin(number(file.at("margin"))) {
    each("shapes", [&](const Json& shape) {
      std::vector<ShapeDescription>* shapes = &description.shapes;
      for (BodyDescription& body : description.bodies)
        if (body.name == shape.at("body").text()) shapes = &body.shapes;
      shapes->push_back(ContactCase::shape(shape));
    });
    ContactDescription contact{.margin = margin, .threshold = threshold};
    each("ignore", [&](const Json& pair) { contact.ignored.push_back({pair.at(0), pair.at(1)}); });
    description.contact = contact;
    for (BodyDescription& body : description.bodies) {
      Dof dof;
      each("stops", [&](const Json& stop) {
        if (stop.at("joint").text() != body.name + "_joint") return;
        (number(stop.at("side")) > 0 ? dof.lower : dof.upper) = number(stop.at("limit"));
        dof.hard_stops = true;
      });
      each("dry", [&](const Json& dry) {
        if (dry.at("joint").text() == body.name + "_joint") dof.friction = number(dry.at("force"));
      });
      if (body.joint.kind == JointKind::revolute) body.joint.dof = {dof};
    }
  }
  Model build() const { return ModelBuilder(description).build(); }
  /// f(entry) for the entries of a list that may be absent.
  template <class F> void each(const char* list, const F& f) const {
    if (!file.contains(list)) return;
    for (const Json& entry : file.at(list)) f(entry);
  }
  static double number_or(const Json& entry, const char* key, double otherwise) {
    return entry.contains(key) ? number(entry.at(key)) : otherwise;
  }
  const Json& shape(const std::string& name) const {
    for (const Json& shape : file.at("shapes"))
      if (shape.at("name").text() == name) return shape;
    throw std::runtime_error("no shape " + name);
  }
  int contact_rows() const {
    for (const Json& shape : file.at("shapes"))
      if (number_or(shape, "rolling_friction", 0) > 0) return 6;
    return 3;
  }
  /// The contacts of a state as the file lists them.
  std::vector<Contact> contacts(const Model& model, const Json& state) const {
    std::vector<Contact> out;
    for (const Json& c : state.at("contacts")) {
      const Json &a = shape(c.at("a").text()), &b = shape(c.at("b").text());
      const auto body = [&](const Json& shape) {
        const std::string name = shape.at("body").text();
        return name == "ground" ? 0 : model.body_index(name);
      };
      const std::vector<double> mu = numbers(c.at("friction"));
      Contact contact{.a = body(a),
                      .b = body(b),
                      .point = vec3(c.at("point")),
                      .normal = vec3(c.at("normal")),
                      .gap = number(c.at("gap"))};
      contact.surface = {
          .friction = mu[0],
          .spin_friction = mu.size() > 2 ? mu[2] : 0,
          .rolling_friction = mu.size() > 4 ? mu[4] : 0,
          .restitution = std::max(number_or(a, "restitution", 0), number_or(b, "restitution", 0))};
      out.push_back(contact);
    }
    return out;
  }
  /// Whether a contact of a state is closed and its bodies approach: an impact, whose friction the method of
  /// the files takes against another velocity.
  bool begins_with_impact(const Model& model, const Json& state) const {
    ContactDynamics dynamics(model, contact_rows());
    const std::vector<Contact> touching = contacts(model, state);
    static_cast<void>(dynamics.solve(numbers(state.at("q")), numbers(state.at("v")), numbers(state.at("tau")),
                                     touching, {.h = 1e-3, .threshold = threshold}));
    std::vector<double> u(static_cast<std::size_t>(dynamics.system().problem().rows()));
    dynamics.system().times(numbers(state.at("v")).data(), u.data());
    for (std::size_t k = 0; k < touching.size(); ++k) {
      const int row = dynamics.system().problem().blocks()[k].first;
      if (touching[k].gap < 1e-9 && u[static_cast<std::size_t>(row)] < -1e-3) return true;
    }
    return false;
  }
  /// The options of a motion under the drive forces of a state, with joint losses.
  static SimulationOptions options_of(const Json& state) {
    SimulationOptions options;
    options.joint_losses = true;
    options.drive = [tau = numbers(state.at("tau"))](double, std::span<const double>, std::span<const double>,
                                                     std::span<double> out) {
      std::ranges::copy(tau, out.begin());
    };
    return options;
  }
};

}  // namespace axode::test
