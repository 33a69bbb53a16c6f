#pragma once
#include <string>
#include <vector>

#include "axode/eigen.hpp"
#include "axode/model.hpp"
#include "axode/recursion/loads.hpp"
#include "tests/support/json_numbers.hpp"
#include "tests/support/shared_files.hpp"

/// Reference systems with reference values, from `<system>_model.json` and `<system>_state*.json`.
namespace axode::test {

inline Vec3<> vec3(const Json& a) { return {number(a.at(0)), number(a.at(1)), number(a.at(2))}; }
/// The rotation matrix with these rows; if they are longer, their first three entries count.
inline SO3<> so3(const Json& rows) {
  const auto column = [&](std::size_t k) {
    return Vec3<>{number(rows.at(0).at(k)), number(rows.at(1).at(k)), number(rows.at(2).at(k))};
  };
  return {column(0), column(1), column(2)};
}
inline SE3<> se3(const Json& rows) {
  return {so3(rows), {number(rows.at(0).at(3)), number(rows.at(1).at(3)), number(rows.at(2).at(3))}};
}
inline Sym3<> sym3(const Json& rows) {
  const SO3<> A = so3(rows);  // three columns
  return {A.x.x, A.y.y, A.z.z, A.y.x, A.z.x, A.z.y};
}
inline Screw<> screw_of(const Json& a) {
  return {{number(a.at(0)), number(a.at(1)), number(a.at(2))},
          {number(a.at(3)), number(a.at(4)), number(a.at(5))}};
}

/// The ways in which the tests describe a reference system to the library.
enum class Telling {
  joint_axes,      ///< axis and point in the body frame, B; inertia about the centre of mass in its own axes
  spatial_screws,  ///< Y and A; inertia about the origin of the body frame
  joint_frames,    ///< Z, S_prev and S_self; inertia about the centre of mass, in the construction frame
  mixed,           ///< the first three ways in turn, body by body
};
inline constexpr Telling tellings[] = {Telling::joint_axes, Telling::spatial_screws, Telling::joint_frames,
                                       Telling::mixed};

/// One reference system. Bodies are named "1", "2", ... and joints "joint 1", "joint 2", ... by their index
/// in the files.
struct ReferenceSystem {
  std::string name;
  Json model;
  std::vector<Json> states;

  explicit ReferenceSystem(const std::string& system) : name(system) {
    model = read_json(vectors_folder() / (system + "_model.json"));
    for (const auto& file : files_ending_in(vectors_folder(), ".json"))
      if (file.filename().string().starts_with(system + "_state")) states.push_back(read_json(file));
  }

  ReferenceSystem(const std::string& system, Json description)
      : name(system), model(std::move(description)) {}

  std::size_t n() const { return model.at("bodies").size(); }
  static std::string body_name(int index) { return index == 0 ? "ground" : std::to_string(index); }
  static std::string joint_name(int index) { return "joint " + std::to_string(index); }

  Model build(Telling telling, bool with_gravity = true) const {
    Description description{.name = name, .bodies = {}};
    description.gravity = with_gravity ? vec3(model.at("gravity")) : Vec3<>{};
    for (const Json& body : model.at("bodies")) {
      const int index = body.at("index");
      const Telling way = telling == Telling::mixed ? tellings[index % 3] : telling;
      description.bodies.push_back(described(body, index, way));
    }
    return ModelBuilder(std::move(description)).build();
  }

  /// The index in the model of the body that has an index in the files, which is that of its frame and its
  /// joint too; 0 is the ground.
  static int frame(const Model& built, int index) { return built.frame_index(body_name(index)); }

  /// Coordinates, velocities and other numbers for each joint, brought from the order of the files into that
  /// of the model.
  static std::vector<double> in_model_order(const Model& built, const Json& coordinates) {
    std::vector<double> out(static_cast<std::size_t>(built.nv()));
    for (int k = 0; k < built.nv(); ++k) out[place_of(built, k + 1)] = number(coordinates.at(k));
    return out;
  }
  /// Generalised forces, brought from the order of the model into that of the files.
  template <class T> static std::vector<T> in_file_order(const Model& built, const std::vector<T>& tau) {
    std::vector<T> out;
    for (int k = 0; k < built.nv(); ++k) out.push_back(tau[place_of(built, k + 1)]);
    return out;
  }
  /// Takes a quantity of every frame of the model and returns it for the bodies alone, in the order of the
  /// files.
  template <class Quantity>
  static std::vector<Quantity> in_file_order_of_bodies(const Model& built,
                                                       const std::vector<Quantity>& frames) {
    std::vector<Quantity> out;
    for (int i = 1; i <= built.n_bodies(); ++i)
      out.push_back(frames[static_cast<std::size_t>(frame(built, i))]);
    return out;
  }
  static std::size_t place_of(const Model& built, int index) {
    return static_cast<std::size_t>(built.joint(built.joint_index(joint_name(index))).iv);
  }

  std::vector<AppliedWrench<>> loads(const Model& built) const {
    std::vector<AppliedWrench<>> out;
    for (const Json& load : model.at("applied_wrenches")) {
      const std::string letter = load.at("rep");
      const Screw<> W = screw_of(load.at("W"));
      const std::string letters = "bshm";
      out.emplace_back(frame(built, load.at("body")), static_cast<Representation>(letters.find(letter)), W.w,
                       W.v);
    }
    return out;
  }

 private:
  static BodyDescription described(const Json& body, int index, Telling way) {
    BodyDescription out{.name = body_name(index), .predecessor = body_name(body.at("parent"))};
    const std::string type = body.at("joint_type");
    out.joint = {.name = joint_name(index),
                 .kind = type == "R"           ? JointKind::revolute
                         : type == "P"         ? JointKind::prismatic
                         : type == "H"         ? JointKind::helical
                         : type == "spherical" ? JointKind::spherical
                         : type == "planar"    ? JointKind::planar
                                               : JointKind::free};
    if (type == "H") out.joint.pitch = number(body.at("pitch"));
    MassProperties inertia{.mass = number(body.at("mass"))};
    const Vec3<> com = vec3(body.at("com"));
    if (way == Telling::joint_axes) {
      out.joint.axis = vec3(body.at("joint_axis")), out.joint.point = vec3(body.at("joint_point"));
      out.geometry = InBodyFrame{se3(body.at("B"))};
      inertia.com = com, inertia.Theta = sym3(body.at("Theta_c")), inertia.axes = so3(body.at("R_bc"));
    } else if (way == Telling::spatial_screws) {
      along(screw_of(body.at("Y")), out.joint);
      out.geometry = InConstructionFrame{se3(body.at("A"))};
      inertia.com = com, inertia.Theta = sym3(body.at("Theta_b")), inertia.about = InertiaAbout::frame_origin;
    } else if (!body.contains("A")) {
      if (body.contains("Z"))
        along(screw_of(body.at("Z")), out.joint);
      else if (out.joint.kind == JointKind::planar)
        out.joint.axis = {0, 0, 1};
      out.geometry = InJointFrames{se3(body.at("S_prev")), se3(body.at("S_self"))};
      inertia.com = com, inertia.Theta = sym3(body.at("Theta_c")), inertia.axes = so3(body.at("R_bc"));
    } else {
      along(screw_of(body.at("Z")), out.joint);
      out.geometry = InJointFrames{se3(body.at("S_prev")), se3(body.at("S_self"))};
      const SE3<> A = se3(body.at("A"));
      inertia.com = A * com, inertia.Theta = sym3(body.at("Theta_c")),
      inertia.axes = A.R * so3(body.at("R_bc"));
      inertia.in = GivenIn::construction_frame;
    }
    out.inertia = inertia;
    return out;
  }

  /// Sets the axis of a joint and a point on it to those of a joint screw.
  static void along(const Screw<>& X, JointDescription& joint) {
    const ScrewAxis<> axis = screw_axis(X);
    joint.axis = axis.e, joint.point = axis.p;
  }
};

}  // namespace axode::test
