#include "axode/contact/contact_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "axode/model/kinds/shape_kinds.hpp"

namespace axode {
namespace {

[[noreturn]] void refuse(const std::string& shape, const std::string& why) {
  throw std::invalid_argument("shape \"" + shape + "\" " + why);
}

/// Throws std::invalid_argument if a size of the shape is not positive; a capsule may have the length 0.
void check_sizes(const ShapeDescription& it, const std::string& name) {
  const ShapeTraits& kind = traits(it.kind);
  const auto need_positive = [&](std::string_view what, double x) {
    if (!(x > 0))
      refuse(name, "touches nothing: its " + std::string(what) + " is " + to_text(x) +
                       " m; the sizes of a collision shape must be positive");
  };
  if (!kind.size.empty()) need_positive(kind.size, std::min({it.size.x, it.size.y, it.size.z}));
  if (kind.radius) need_positive("radius", it.radius);
  if (kind.length && it.kind != ShapeKind::capsule) need_positive("length", it.length);
  if (kind.length && !(it.length >= 0))
    refuse(name, "has the length " + to_text(it.length) + " m; it must not be negative");
}

ConvexShape convex(const ContactShape& shape) {
  switch (shape.kind) {
    case ShapeKind::box: return box_shape(shape.half);
    case ShapeKind::sphere: return sphere_shape(shape.radius);
    case ShapeKind::cylinder: return cylinder_shape(shape.radius, shape.half_length);
    case ShapeKind::capsule: return capsule_shape(shape.radius, shape.half_length);
    case ShapeKind::ellipsoid: return ellipsoid_shape(shape.half);
    case ShapeKind::mesh:
    case ShapeKind::plane: break;
  }
  return {};
}

/// Collects the collision shapes of a model from its description.
struct Compilation {
  const Model& model;
  const MeshHulls& mesh_hulls;
  const ContactDescription common;
  std::vector<ContactShape> shapes = {};
  std::vector<std::unique_ptr<const Hull>> hulls = {};

  /// Makes the convex shape of a mesh. The vertices of its hull are relative to a point inside the hull, and
  /// the pose of `shape` is moved to this point.
  ConvexShape hull_of(const ShapeDescription& it, const std::string& body, const Source& source,
                      ContactShape& shape) {
    const std::string mesh = "of body \"" + body + "\" is the mesh \"" + it.file + "\"";
    if (!mesh_hulls)
      refuse(shape.name, mesh +
                             ", whose hull is not known; describe it by boxes, spheres, capsules, cylinders "
                             "or ellipsoids, or give hull_of_mesh to ContactShapes");
    try {
      MeshHull found = mesh_hulls(it, source);
      shape.pose = shape.pose * SE3<>{{}, found.origin};
      hulls.push_back(std::make_unique<const Hull>(std::move(found.hull)));
    } catch (const std::invalid_argument& error) {
      refuse(shape.name, mesh + ", which has no hull: " + error.what());
    }
    return hull_shape(*hulls.back());
  }

  void add(const ShapeDescription& it, const std::string& body, const Source& source, int number) {
    if (it.role != ShapeDescription::Role::collision) return;
    const int frame = model.frame_index(body);
    ContactShape shape{.name = it.name.empty() ? body + " shape " + std::to_string(number) : it.name,
                       .kind = it.kind,
                       .frame = frame,
                       .body = model.frame(frame).body,
                       .pose = model.tree<double>().frame_offset[frame] * it.pose,
                       .surface = it.contact};
    check_sizes(it, shape.name);
    const double half = it.kind == ShapeKind::box ? 0.5 : 1;
    shape.half = half * it.size;
    shape.radius = it.radius;
    shape.half_length = it.length / 2;
    shape.convex = it.kind == ShapeKind::mesh ? hull_of(it, body, source, shape) : convex(shape);
    if (!shape.surface.friction) shape.surface.friction = common.friction;
    shapes.push_back(std::move(shape));
  }

  void add_all() {
    const Description& d = model.description();
    int number = 0;
    for (const ShapeDescription& it : d.shapes) add(it, "ground", d.source, ++number);
    for (const BodyDescription& body : d.bodies) {
      number = 0;
      const Source& source = body.source.file.empty() ? d.source : body.source;
      for (const ShapeDescription& it : body.shapes) add(it, body.name, source, ++number);
    }
  }

  int body_of(const std::string& frame) const { return model.frame(model.frame_index(frame)).body; }

  /// The pairs of moving bodies that a joint (not a rod or a belt) connects, the smaller index first.
  std::set<std::pair<int, int>> joined_bodies() const {
    std::set<std::pair<int, int>> joined;
    const auto join = [&](const std::string& one, const std::string& other) {
      const auto pair = std::minmax({body_of(one), body_of(other)});
      if (pair.first > 0 && pair.first != pair.second) joined.insert(pair);
    };
    for (const BodyDescription& body : model.description().bodies) join(body.name, body.predecessor);
    for (const LoopDescription& loop : model.description().loops)
      if (!traits(loop.kind).has("points")) join(loop.between[0], loop.between[1]);
    return joined;
  }
};

}  // namespace

ContactShapes::ContactShapes(const Model& model, const MeshHulls& hulls) {
  Compilation compilation{model, hulls, model.description().contact.value_or(ContactDescription{})};
  compilation.add_all();
  Data data;
  data.shapes = std::move(compilation.shapes);
  data.hulls = std::move(compilation.hulls);
  data.n_bodies = model.n_bodies();
  data.margin = compilation.common.margin;
  data.threshold = compilation.common.threshold;

  std::vector<std::array<int, 2>> ignored;
  for (const auto& [one, other] : compilation.common.ignored)
    ignored.push_back({model.frame_index(one), model.frame_index(other)});
  const std::set<std::pair<int, int>> joined = compilation.joined_bodies();
  const std::size_t n = data.shapes.size();
  const auto may_touch = [&](const ContactShape& a, const ContactShape& b) {
    if (a.body == b.body || joined.contains(std::minmax({a.body, b.body}))) return false;
    return std::ranges::none_of(ignored, [&](const auto& pair) {
      return (pair[0] == a.frame && pair[1] == b.frame) || (pair[0] == b.frame && pair[1] == a.frame);
    });
  };
  data.may_touch.resize(n * n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const ContactShape &a = data.shapes[i], &b = data.shapes[j];
      if (!may_touch(a, b)) continue;
      if (a.kind == ShapeKind::plane && b.kind == ShapeKind::plane)
        refuse(a.name, "and shape \"" + b.name +
                           "\" are planes that move against each other, and two half-spaces cannot be kept "
                           "apart; name their bodies in `ignored`");
      if (a.surface.stiffness && b.surface.stiffness && a.surface.exponent != b.surface.exponent)
        refuse(a.name, "has the exponent " + to_text(a.surface.exponent) + " of its stiffness, and shape \"" +
                           b.name + "\", which it may touch, " + to_text(b.surface.exponent) +
                           "; compliant shapes that touch need the same exponent");
      data.pairs.push_back({static_cast<int>(i), static_cast<int>(j)});
      data.may_touch[i * n + j] = data.may_touch[j * n + i] = 1;
    }
  data_ = std::make_shared<const Data>(std::move(data));
}

void check_shapes(const Model& model, const ContactShapes& shapes) {
  if (shapes.n_bodies() == model.n_bodies()) return;
  throw std::invalid_argument("the collision shapes are those of a model with " +
                              std::to_string(shapes.n_bodies()) + " bodies, and model \"" + model.name() +
                              "\" has " + std::to_string(model.n_bodies()) + "; make them from this model");
}

SurfacePair ContactShapes::surface(int i, int j) const {
  const ContactProperties &a = (*this)[i].surface, &b = (*this)[j].surface;
  const auto compliance_of = [](const ContactProperties& it) {
    return Compliance{it.stiffness.value_or(0), it.exponent, it.damping};
  };
  const Compliance compliance = in_series(compliance_of(a), compliance_of(b));
  const auto mean = [](double x, double y) { return std::min(std::sqrt(x * y), most_friction); };
  return {mean(*a.friction, *b.friction), mean(a.spin_friction, b.spin_friction),
          mean(a.rolling_friction, b.rolling_friction),
          compliance ? 0 : std::max(a.restitution, b.restitution), compliance};
}

int ContactShapes::contact_rows() const {
  int rows = 3;
  for (const ContactShape& shape : data_->shapes) {
    if (shape.surface.rolling_friction > 0) return 6;
    if (shape.surface.spin_friction > 0) rows = 4;
  }
  return rows;
}

}  // namespace axode
