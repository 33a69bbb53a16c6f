#include "axode/contact/floor.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "axode/lie/so3.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/scalar/text.hpp"

namespace axode {

Model with_floor(const Model& model, double height) {
  if (!std::isfinite(height))
    throw std::invalid_argument("with_floor: the height is " + to_text(height) + " m; it must be finite");
  const auto may_touch = [](const BodyDescription& body) {
    return std::ranges::find(body.shapes, ShapeDescription::Role::collision, &ShapeDescription::role) !=
           body.shapes.end();
  };
  if (model.nv() > 0 && std::ranges::none_of(model.description().bodies, may_touch))
    throw std::invalid_argument(
        "with_floor: no body of model \"" + model.name() +
        "\" has a collision shape, so that nothing could touch the floor; give a body "
        "a shape with role = \"collision\"");
  const double g = norm(model.gravity());
  const Vec3<> up = g > 0 ? (-1 / g) * model.gravity() : Vec3<>{0, 0, 1};
  Description description = model.description();
  if (!description.contact) description.contact.emplace();
  description.shapes.push_back({.role = ShapeDescription::Role::collision,
                                .name = "floor",
                                .kind = ShapeKind::plane,
                                .pose = {rotation_to(up), height * up}});
  return ModelBuilder(std::move(description)).build();
}

}  // namespace axode
