#include "axode/contact/with_shapes.hpp"

#include <stdexcept>
#include <string>

#include "axode/lie/se3.hpp"
#include "axode/model/building/builder.hpp"

namespace axode {

Model with_shapes(const Model& model, const ShapeNumbers& numbers) {
  Description description = model.description();
  std::vector<ShapeDescription*> shapes;
  const auto collect = [&](std::vector<ShapeDescription>& of) {
    for (ShapeDescription& shape : of)
      if (shape.role == ShapeDescription::Role::collision) shapes.push_back(&shape);
  };
  collect(description.shapes);
  for (BodyDescription& body : description.bodies) collect(body.shapes);
  const auto check = [&](const char* name, std::span<const double> given, std::size_t each) {
    if (!given.empty() && given.size() != each * shapes.size())
      throw std::invalid_argument("with_shapes: " + std::string(name) + " has " +
                                  std::to_string(given.size()) + " numbers; model \"" + model.name() +
                                  "\" needs " + std::to_string(each * shapes.size()) + ", " +
                                  std::to_string(each) + " for each collision shape");
  };
  check("friction", numbers.friction, 1);
  check("restitution", numbers.restitution, 1);
  check("placement", numbers.placement, 6);
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    if (!numbers.friction.empty()) shapes[k]->contact.friction = numbers.friction[k];
    if (!numbers.restitution.empty()) shapes[k]->contact.restitution = numbers.restitution[k];
    if (numbers.placement.empty()) continue;
    const double* const x = &numbers.placement[6 * k];
    shapes[k]->pose = shapes[k]->pose * exp(Screw<>{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}});
  }
  return ModelBuilder(std::move(description)).build();
}

}  // namespace axode
