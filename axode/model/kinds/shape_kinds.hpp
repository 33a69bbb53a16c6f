#pragma once
#include <algorithm>
#include <array>
#include <string_view>

#include "axode/model/description.hpp"

namespace axode {

/// A row of the table of shapes, with everything that depends only on the kind.
struct ShapeTraits {
  ShapeKind kind;
  std::string_view name;
  std::string_view size;  ///< name of the three lengths in `size`; empty if the kind has none
  bool radius, length;    ///< whether the kind has a radius, and a length
  bool in_urdf;           ///< whether URDF has an element for the shape
};

inline constexpr std::array<ShapeTraits, 7> shape_kinds{{
    {ShapeKind::box, "box", "size", false, false, true},
    {ShapeKind::sphere, "sphere", "", true, false, true},
    {ShapeKind::cylinder, "cylinder", "", true, true, true},
    {ShapeKind::capsule, "capsule", "", true, true, true},
    {ShapeKind::ellipsoid, "ellipsoid", "semi_axes", false, false, false},
    {ShapeKind::mesh, "mesh", "", false, false, true},
    {ShapeKind::plane, "plane", "", false, false, false},
}};

constexpr const ShapeTraits& traits(ShapeKind kind) {
  return *std::find_if(shape_kinds.begin(), shape_kinds.end(),
                       [&](const ShapeTraits& t) { return t.kind == kind; });
}
constexpr std::string_view to_string(ShapeKind kind) { return traits(kind).name; }
constexpr std::string_view to_string(ShapeDescription::Role role) {
  return role == ShapeDescription::Role::visual ? "visual" : "collision";
}

}  // namespace axode
