#pragma once
#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "axode/contact/compliance.hpp"
#include "axode/contact/convex/convex_shape.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// A collision shape of a model, with its pose on the body that carries it.
struct ContactShape {
  std::string name;  ///< name of the shape, or `hand shape 2` for the second shape of the body `hand`
  ShapeKind kind{};
  int frame = 0;           ///< frame of the model on which the shape was described; a fixed body is a frame
  int body = 0;            ///< body that the shape moves with; 0 is the ground
  SE3<> pose;              ///< pose in the internal frame of the body, see Tree; of a mesh: pose of its hull
  ConvexShape convex;      ///< the shape as a convex set; not used for a plane
  Vec3<> half;             ///< half edges of a box or semi-axes of an ellipsoid, m
  double radius = 0;       ///< radius of a sphere, capsule or cylinder, m
  double half_length = 0;  ///< half the length of a cylinder, or of a capsule without its half balls, m
  ContactProperties surface;  ///< surface properties; friction is that of the mechanism if not given
};

/// Friction and restitution between two surfaces.
struct SurfacePair {
  double friction = 0;          ///< coefficient of sliding friction
  double spin_friction = 0;     ///< moment of drilling friction divided by the normal force, m
  double rolling_friction = 0;  ///< moment of rolling friction divided by the normal force, m
  double restitution = 0;       ///< 0 to 1; 0 if the contact is compliant
  Compliance compliance;        ///< of both surfaces together
};

/// The convex hull of a mesh. The vertices of `hull` are relative to `origin`, a point inside the hull whose
/// position is given in the frame of the shape, m.
struct MeshHull {
  Hull hull;
  Vec3<> origin;
};
/// Callback that returns the convex hull of the mesh of a shape, or throws std::invalid_argument if the mesh
/// has none. Its arguments are the shape, which has the path of the mesh, and the file of the model (drawing,
/// URDF, ...) that refers to the mesh. A relative path starts from the folder of this file. See
/// hull_of_mesh() in axode/view.hpp.
using MeshHulls = std::function<MeshHull(const ShapeDescription&, const Source&)>;

/// The collision shapes of a model: those of the ground first, then those of the bodies in the order of the
/// description. Copies are cheap and share the data.
class ContactShapes {
 public:
  /// Takes the collision shapes of a model. `hulls` returns the convex hulls that replace meshes. Throws
  /// std::invalid_argument for a mesh without a hull (or without `hulls`), a shape without a size, two planes
  /// that move relative to each other, and two compliant shapes that may touch and whose normal forces k dⁿ
  /// (1 + c d') have different exponents n of the depth d of overlap. Allocates.
  explicit ContactShapes(const Model& model, const MeshHulls& hulls = {});

  /// The number of moving bodies of the model from which the shapes were made.
  int n_bodies() const { return data_->n_bodies; }
  int size() const { return static_cast<int>(data_->shapes.size()); }
  const ContactShape& operator[](int i) const { return data_->shapes[i]; }

  /// The pairs of shapes (i, j), i < j, that may touch, in ascending order. Excluded are two shapes of one
  /// body, shapes of two moving bodies that are connected by a joint or by a loop joint other than a rod or a
  /// belt, and pairs that the description tells to ignore.
  std::span<const std::array<int, 2>> pairs() const { return data_->pairs; }
  bool may_touch(int i, int j) const { return data_->may_touch[i * data_->shapes.size() + j] != 0; }

  /// Combines two surfaces: geometric mean of the frictions, larger restitution, compliances in series.
  SurfacePair surface(int i, int j) const;

  /// The number of scalar constraints of a contact: 3 (normal and sliding friction), 4 if a shape has
  /// drilling friction, or 6 if a shape has rolling friction.
  int contact_rows() const;

  /// margin() is the gap below which a contact is considered, m. threshold() is the speed of approach below
  /// which no contact bounces, m/s.
  double margin() const { return data_->margin; }
  double threshold() const { return data_->threshold; }

 private:
  struct Data {
    std::vector<ContactShape> shapes;
    std::vector<std::unique_ptr<const Hull>> hulls;
    std::vector<std::array<int, 2>> pairs;
    std::vector<char> may_touch;  ///< whether shapes i and j may touch, size × size
    double margin = 0, threshold = 0;
    int n_bodies = 0;
  };
  std::shared_ptr<const Data> data_;
};

/// Throws std::invalid_argument if the shapes were made from a model with another number of bodies.
void check_shapes(const Model& model, const ContactShapes& shapes);

}  // namespace axode
