#pragma once
#include <string>
#include <vector>

#include "axode/contact.hpp"
#include "axode/io.hpp"
#include "axode/model/kinds/shape_kinds.hpp"
#include "tests/support/vectors.hpp"

/// Mechanisms with shapes and reference values of contact, from the folder `contact` of the vectors.
namespace axode::test {

/// Names of the files of a folder of the vectors without their ending; `none` if there are none.
inline std::vector<std::string> vector_files(const char* folder) {
  std::vector<std::string> names;
  for (const auto& file : files_ending_in(vectors_folder() / folder, ".json"))
    names.push_back(file.stem().string());
  return names.empty() ? std::vector<std::string>{"none"} : names;
}

/// One file: its mechanism with the shapes on it, its margin and its threshold.
struct ContactCase {
  Json file;
  Model model;

  explicit ContactCase(const std::string& name)
      : file(read_json(vectors_folder() / "contact" / (name + ".json"))), model(build(file)) {}

  /// The shape of the model with a name of the file.
  static int shape_index(const ContactShapes& shapes, const std::string& name) {
    for (int i = 0; i < shapes.size(); ++i)
      if (shapes[i].name == name) return i;
    throw std::runtime_error("no shape " + name);
  }

  static ShapeDescription shape(const Json& json) {
    ShapeDescription out{.role = ShapeDescription::Role::collision, .name = json.at("name")};
    const std::string kind = json.at("kind");
    for (const ShapeTraits& traits : shape_kinds)
      if (traits.name == kind) out.kind = traits.kind;
    const auto value = [&](const char* key) { return json.contains(key) ? number(json.at(key)) : 0; };
    if (json.contains("size")) out.size = vec3(json.at("size"));
    out.radius = value("radius");
    out.length = value("length");
    if (json.contains("position")) out.pose.r = vec3(json.at("position"));
    if (json.contains("rotation")) out.pose.R = so3(json.at("rotation"));
    out.contact = {.friction = number(json.at("friction")),
                   .spin_friction = value("spin_friction"),
                   .rolling_friction = value("rolling_friction"),
                   .restitution = value("restitution")};
    return out;
  }

 private:
  static Model build(const Json& file) {
    Description d = read_drawing_text(file.at("model").text(), "model");
    for (const Json& json : file.at("shapes")) {
      const std::string body = json.at("body");
      std::vector<ShapeDescription>* shapes = &d.shapes;
      for (BodyDescription& candidate : d.bodies)
        if (candidate.name == body) shapes = &candidate.shapes;
      shapes->push_back(shape(json));
    }
    ContactDescription contact{.margin = number(file.at("margin")),
                               .threshold = number(file.at("threshold"))};
    if (file.contains("ignore"))
      for (const Json& pair : file.at("ignore")) contact.ignored.push_back({pair.at(0), pair.at(1)});
    d.contact = contact;
    return ModelBuilder(std::move(d)).build();
  }
};

}  // namespace axode::test
