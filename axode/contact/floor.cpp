#include "axode/contact/floor.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "axode/lie/so3.hpp"
#include "axode/model/building/builder.hpp"

namespace axode {

Model with_floor(const Model& model, double height) {
  if (!std::isfinite(height))
    throw std::invalid_argument("with_floor: the height is " + std::to_string(height) +
                                " m; it must be finite");
  const double g = norm(model.gravity());
  const Vec3<> up = g > 0 ? (-1 / g) * model.gravity() : Vec3<>{0, 0, 1};
  Description description = model.description();
  description.shapes.push_back({.role = ShapeDescription::Role::collision,
                                .name = "floor",
                                .kind = ShapeKind::plane,
                                .pose = {rotation_to(up), height * up}});
  return ModelBuilder(std::move(description)).build();
}

}  // namespace axode
