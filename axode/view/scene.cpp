#include "axode/view/scene.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <unordered_map>

#include "axode/constraints/assembly.hpp"
#include "axode/lie/quaternion.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"
#include "axode/model/kinds/joint_kinds.hpp"
#include "axode/model/kinds/shape_kinds.hpp"
#include "axode/view/mesh_file.hpp"
#include "axode/view/stand_ins.hpp"

namespace axode {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Vec3<>& a) { return {a.x, a.y, a.z}; }
Json json_of(const SE3<>& C) {
  const Quaternion<> a = quaternion(C.R);
  return {C.r.x, C.r.y, C.r.z, a.x, a.y, a.z, a.w};
}
/// A limit as JSON; null if it is infinite.
Json limit(double x) { return std::isfinite(x) ? Json(x) : Json(); }

std::string in_base64(std::string_view bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const auto byte = [&](std::size_t at) {
      return at < bytes.size() ? static_cast<unsigned char>(bytes[at]) : 0U;
    };
    const unsigned three = byte(k) << 16 | byte(k + 1) << 8 | byte(k + 2);
    for (const int shift : {18, 12, 6, 0}) out += digits[three >> shift & 63];
  }
  if (bytes.size() % 3 != 0) out.replace(out.size() - (3 - bytes.size() % 3), 3, 3 - bytes.size() % 3, '=');
  return out;
}

Json json_of(const Joint& joint) {
  Json limits = Json::array(), leader;
  for (const Dof& dof : joint.dof) limits.push_back({limit(dof.lower), limit(dof.upper)});
  if (joint.leader)
    leader = {
        {"joint", joint.leader->joint}, {"ratio", joint.leader->ratio}, {"offset", joint.leader->offset}};
  return {{"name", joint.name},   {"kind", to_string(joint.kind)},
          {"pitch", joint.pitch}, {"iq", joint.iq},
          {"nq", joint.nq},       {"iv", joint.iv},
          {"nv", joint.nv},       {"leader", leader},
          {"limits", limits},     {"passive", joint.passive}};
}

/// The ground and the bodies as JSON, with their joints and their inertias about the centre of mass.
Json bodies_of(const Model& model) {
  Json bodies = Json::array({{{"name", "ground"}}});
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Body& body = model.body(i);
    const bool has_mass = body.M.m != 0;
    const Sym3<> Theta = has_mass ? inertia_about_com(body.M) : Sym3<>{};
    bodies.push_back({{"name", body.name},
                      {"predecessor", body.predecessor},
                      {"S_prev", json_of(body.S_prev)},
                      {"S_self", json_of(body.S_self)},
                      {"A", json_of(body.A)},
                      {"mass", body.M.m},
                      {"com", json_of(has_mass ? center_of_mass(body.M) : Vec3<>{})},
                      {"inertia", {Theta.xx, Theta.yy, Theta.zz, Theta.xy, Theta.xz, Theta.yz}},
                      {"joint", json_of(model.joint(i))}});
  }
  return bodies;
}

/// The named frames as JSON, without those of the ground and of the moving bodies.
Json frames_of(const Model& model) {
  Json frames = Json::array();
  for (const Frame& frame : model.frames().subspan(static_cast<std::size_t>(model.n_bodies()) + 1))
    frames.push_back({{"name", frame.name}, {"body", frame.body}, {"pose", json_of(frame.pose)}});
  return frames;
}

/// The loop joints as JSON, with the pose of the joint frame in the frame of each of the two bodies.
Json loops_of(const Model& model) {
  Json loops = Json::array();
  for (const Loop& loop : model.loops().joints) {
    Json ends = Json::array();
    for (const Loop::End& end : loop.ends)
      ends.push_back({{"body", end.body}, {"pose", json_of(model.body(end.body).S_self * end.F)}});
    loops.push_back({{"name", loop.name},
                     {"kind", to_string(loop.kind)},
                     {"ends", ends},
                     {"pitch", loop.pitch},
                     {"size", loop.size},
                     {"wheel", loop.wheel}});
  }
  return loops;
}

/// The lines of a model as JSON: first the segments between successive points of the springs that act along a
/// line or over several points (tendons), then the lines along which drives act. Points are in the frames of
/// their bodies. The stiffness of a segment is that of the spring at the deflection 0.
Json lines_of(const Model& model) {
  Json lines = Json::array();
  const auto end_of = [&](const Spring::Path::Point& end) {
    const Frame& frame = model.frame(end.frame);
    return Json{{"body", frame.body}, {"point", json_of(frame.pose * end.point)}};
  };
  for (const Spring& spring : model.springs().elements) {
    const auto* path = std::get_if<Spring::Path>(&spring.geometry);
    if (path == nullptr) continue;
    const bool straight = path->points.size() == 2;
    for (std::size_t k = 1; k < path->points.size(); ++k)
      lines.push_back({{"ends", {end_of(path->points[k - 1]), end_of(path->points[k])}},
                       {"stiffness", curve_value(spring.law, 0.0).slope},
                       {"rest", straight ? spring.law.rest : 0},
                       {"damping", spring.law.damping},
                       {"driven", false}});
  }
  for (const Spring::Path& line : model.springs().drive_lines)
    lines.push_back({{"ends", {end_of(line.points[0]), end_of(line.points[1])}},
                     {"stiffness", 0},
                     {"rest", 0},
                     {"damping", 0},
                     {"driven", true}});
  return lines;
}

Json couplings_of(const Model& model) {
  Json couplings = Json::array();
  for (const LoopCoupling& coupling : model.loops().couplings) {
    Json terms = Json::array();
    for (const LoopCoupling::Term& term : coupling.terms) terms.push_back({term.coordinate, term.factor});
    couplings.push_back({{"name", coupling.name}, {"terms", terms}, {"offset", coupling.offset}});
  }
  return couplings;
}

/// The shapes of a model and the meshes that they use, as JSON. Each mesh file is read once.
class Shapes {
 public:
  explicit Shapes(const Model& model) : visuals_(static_cast<std::size_t>(model.n_bodies()) + 1) {
    std::unordered_map<std::string_view, int> frame;
    for (int f = 0; f < model.n_frames(); ++f) frame.emplace(model.frame(f).name, f);
    const Description& description = model.description();
    for (const ShapeDescription& shape : description.shapes)
      add(shape, Frame{"ground", 0, {}}, description.source);
    for (const BodyDescription& body : description.bodies)
      for (const ShapeDescription& shape : body.shapes)
        add(shape, model.frame(frame.at(body.name)),
            body.source.file.empty() ? description.source : body.source);
    for (const view::StandIn& other : view::stand_ins(model, seen_bodies())) {
      Json json = json_of(other.shape, other.body, other.shape.pose, /*stand_in=*/true);
      if (other.form == view::StandIn::Form::hull) {
        json["kind"] = "hull";
        json["radius"] = other.shape.radius;
        for (const Vec3<>& point : other.hull) json["points"].push_back(axode::json_of(point));
      } else if (other.form == view::StandIn::Form::thread) {
        json["kind"] = "thread";
        json["lead"] = other.lead;
      } else if (other.form == view::StandIn::Form::socket) {
        json["kind"] = "socket";
      }
      shapes.push_back(std::move(json));
    }
    for (const auto& [why, element, first, source, count] : missing_)
      contents.warnings.push_back(to_string(
          {Severity::warning, Rule::unreadable_file, element,
           "mesh \"" + first + "\" is not shown: " + why +
               (count > 1 ? " (" + std::to_string(count) + " meshes, the first here)" : std::string()),
           source}));
  }

  Json shapes = Json::array(), meshes = Json::array();
  SceneContents contents;

 private:
  void add(const ShapeDescription& shape, const Frame& on, const Source& referenced_from) {
    Json json = json_of(shape, on.body, on.pose * shape.pose, false);
    if (shape.kind == ShapeKind::mesh) {
      const std::optional<std::size_t> mesh = mesh_of(shape.file, on.name, referenced_from);
      if (!mesh) {
        if (shape.role == ShapeDescription::Role::visual) ++visuals_[on.body].lost;
        return;
      }
      json["mesh"] = *mesh;
    }
    if (shape.role == ShapeDescription::Role::visual) {
      ++visuals_[on.body].shown;
    } else if (shape.kind != ShapeKind::plane) {
      visuals_[on.body].collision.push_back(shapes.size());
    }
    shapes.push_back(std::move(json));
  }

  /// Determines whether the ground and each body can be seen. If most visual shapes of a body are meshes that
  /// cannot be shown, its collision shapes are shown instead; if it has none, it counts as not seen.
  std::vector<bool> seen_bodies() {
    std::vector<bool> seen;
    for (const Visuals& body : visuals_) {
      const bool is_lost = body.lost > 0 && body.lost >= body.shown;
      if (is_lost) {
        for (const std::size_t k : body.collision) {
          Json solid = shapes[k];
          solid["role"] = to_string(ShapeDescription::Role::visual);
          solid["color"] = Json();
          shapes.push_back(std::move(solid));
        }
      }
      seen.push_back(is_lost ? !body.collision.empty() : body.shown > 0);
    }
    return seen;
  }

  static Json json_of(const ShapeDescription& shape, int body, const SE3<>& pose, bool stand_in) {
    Json json{{"body", body},
              {"pose", axode::json_of(pose)},
              {"role", to_string(shape.role)},
              {"name", shape.name},
              {"kind", to_string(shape.kind)}};
    const ShapeTraits& kind = traits(shape.kind);
    if (!kind.size.empty()) json["size"] = axode::json_of(shape.size);
    if (kind.radius) json["radius"] = shape.radius;
    if (kind.length) json["length"] = shape.length;
    if (shape.kind == ShapeKind::mesh) json["scale"] = axode::json_of(shape.scale);
    json["color"] = shape.color ? Json(*shape.color) : Json();
    json["stand_in"] = stand_in;
    return json;
  }

  /// Meshes that are not shown for a reason `why`: their number, and element, name and source of the first.
  struct Missing {
    std::string why, element, first;
    Source source;
    int count = 1;
  };

  /// The index of a mesh in the list `meshes` of the scene; if it cannot be shown, the result is empty and
  /// the reason is added to missing_.
  std::optional<std::size_t> mesh_of(const std::string& name, const std::string& body,
                                     const Source& referenced_from) {
    const auto [known, is_new] = named_.emplace(std::pair(referenced_from.file, name), std::nullopt);
    if (!is_new) return known->second;
    const auto warn = [&](const std::string& why) {
      const auto same = std::ranges::find(missing_, why, &Missing::why);
      if (same != missing_.end()) {
        ++same->count;
      } else {
        missing_.push_back({why, "body \"" + body + '"', name, referenced_from});
      }
    };
    const FoundMesh found = find_mesh(name, referenced_from);
    if (!found.error.empty()) {
      warn(found.error);
      return std::nullopt;
    }
    const auto [read, is_unread] = read_.emplace(found.file, std::nullopt);
    if (is_unread) {
      const MeshFile mesh = read_mesh(found.file);
      bytes_ += mesh.bytes.size();
      if (!mesh.error.empty()) {
        warn(mesh.error);
      } else if (bytes_ > largest_meshes) {
        bytes_ -= mesh.bytes.size();
        warn("the meshes before it and it have more than " + std::to_string(largest_meshes >> 20) + " MiB");
      } else {
        read->second = meshes.size();
        meshes.push_back({{"file", found.file.filename().string()},
                          {"format", mesh.format},
                          {"data", in_base64(mesh.bytes)}});
        contents.meshes.push_back({found.file.string(), mesh.bytes.size()});
      }
    }
    return known->second = read->second;
  }

  /// The shapes of one body: the number of visual shapes that are shown, the number of visual meshes that
  /// cannot be shown (`lost`), and the indices of its collision shapes in the list `shapes` of the scene.
  struct Visuals {
    int shown = 0, lost = 0;
    std::vector<std::size_t> collision = {};
  };
  std::vector<Visuals> visuals_;  ///< of the ground and of each body
  /// The index, in the list `meshes` of the scene, of each mesh that was looked up, or empty for a mesh that
  /// cannot be shown. The keys of named_ are the describing file and the mesh's name there; the keys of read_
  /// are paths of mesh files.
  std::map<std::pair<std::string, std::string>, std::optional<std::size_t>> named_;
  std::map<std::filesystem::path, std::optional<std::size_t>> read_;
  std::size_t bytes_ = 0;  ///< bytes of all meshes in `meshes`
  std::vector<Missing> missing_;
};

/// The numbers as JSON, divided into `count` rows of equal length.
Json rows_of(std::span<const double> numbers, std::size_t count) {
  Json rows = Json::array();
  for (std::size_t k = 0; k < count; ++k) {
    const std::span<const double> row = numbers.subspan(k * numbers.size() / count, numbers.size() / count);
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  }
  return rows;
}

/// The six numbers for each of `count` times and each body as JSON; null if there are no numbers.
Json screws_of(std::span<const double> numbers, std::size_t count, int bodies) {
  if (numbers.empty()) return {};
  Json times = Json::array();
  for (std::size_t k = 0; k < count; ++k)
    times.push_back(rows_of(numbers.subspan(k * numbers.size() / count, numbers.size() / count),
                            static_cast<std::size_t>(bodies)));
  return times;
}

/// The part of a motion that has the states 0, stride, 2 stride, ... and the last state.
ShownMotion thinned(const Model& model, const ShownMotion& motion, std::size_t stride) {
  ShownMotion out;
  const auto copy = [&](const std::vector<double>& from, std::vector<double>& to, int width, std::size_t k) {
    if (from.empty()) return;
    const auto first = from.begin() + static_cast<std::ptrdiff_t>(k) * width;
    to.insert(to.end(), first, first + width);
  };
  for (std::size_t k = 0; k < motion.t.size(); ++k) {
    if (k % stride != 0 && k + 1 != motion.t.size()) continue;
    copy(motion.t, out.t, 1, k);
    copy(motion.q, out.q, model.nq(), k);
    copy(motion.v, out.v, model.nv(), k);
    copy(motion.a, out.a, model.nv(), k);
    copy(motion.tau, out.tau, model.nv(), k);
    if (!motion.contacts.empty()) out.contacts.push_back(motion.contacts[k]);
    if (!motion.loads.empty()) out.loads.push_back(motion.loads[k]);
  }
  out.contact_shapes = motion.contact_shapes;
  return out;
}

constexpr std::size_t numbers_of_contact = 17;

/// The points of contact at each time of a motion as JSON; null if they are unknown. A point is a list of 17
/// numbers: the indices of the shapes a and b, the position (m), the unit normal from a to b, the gap (m),
/// the force (N) and the moment (N m) on b at this point, the coefficient of friction, and the status (0
/// open, 1 stick, 2 slide). The vectors are in the inertial frame.
Json contacts_of(const ShownMotion& motion) {
  if (motion.contacts.empty()) return {};
  Json times = Json::array();
  for (const std::vector<ContactForce>& contacts : motion.contacts) {
    Json points = Json::array();
    for (const ContactForce& x : contacts) {
      Json numbers{x.a, x.b};
      for (const Vec3<>& a : {x.point, x.normal}) numbers.insert(numbers.end(), {a.x, a.y, a.z});
      numbers.push_back(x.gap);
      for (const Vec3<>& a : {x.force, x.moment}) numbers.insert(numbers.end(), {a.x, a.y, a.z});
      numbers.push_back(x.friction);
      numbers.push_back(static_cast<int>(x.branch));
      points.push_back(std::move(numbers));
    }
    times.push_back(std::move(points));
  }
  return times;
}

/// Frames as JSON: the name of each frame, the body to which it is fixed, and its origin in the frame of the
/// body.
Json places_of(const Model& model, const std::vector<int>& frames) {
  Json places = Json::array();
  for (const int f : frames) {
    const Frame& frame = model.frame(f);
    places.push_back({{"name", frame.name}, {"body", frame.body}, {"point", json_of(frame.pose.r)}});
  }
  return places;
}

/// The motion `whole` as JSON; null if it has no times. If it has more than longest_motion numbers, some of
/// its states are left out and a warning is added.
Json motion_of(const Model& model, const ShownMotion& whole, std::vector<std::string>& warnings) {
  if (whole.t.empty()) return {};
  check(model, whole);
  const auto nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv()),
             width = 11 + nq + 2 * nv + 18 * static_cast<std::size_t>(model.n_bodies());
  std::size_t numbers_in_all = whole.t.size() * width;
  for (const std::vector<ContactForce>& contacts : whole.contacts)
    numbers_in_all += numbers_of_contact * contacts.size();
  for (const std::vector<AppliedWrench<>>& loads : whole.loads) numbers_in_all += 6 * loads.size();
  const std::size_t stride = (numbers_in_all + longest_motion - 1) / longest_motion;
  if (stride > 1)
    warnings.push_back(to_string(
        {Severity::warning,
         Rule::wrong_value,
         "motion",
         "has " + std::to_string(whole.t.size()) + " states; one in " + std::to_string(stride) + " is shown",
         {}}));
  const ShownMotion motion = thinned(model, whole, stride);
  const view::MotionNumbers numbers = view::numbers_of(model, motion);
  const std::size_t N = motion.t.size();
  Json series = Json::array();
  bool all_finite = finite(numbers.twists) && finite(numbers.wrenches) && finite(numbers.momenta) &&
                    finite(numbers.loop_wrenches) && finite(numbers.tensions) && finite(numbers.loads);
  for (const auto& [name, unit, labels, values] : numbers.series) {
    all_finite = all_finite && finite(values);
    series.push_back({{"name", name}, {"unit", unit}, {"labels", labels}, {"values", rows_of(values, N)}});
  }
  if (!all_finite)
    throw std::invalid_argument(
        "motion: its numbers are so large that energies, momenta or wrenches overflow");
  return {
      {"t", motion.t},
      {"q", rows_of(motion.q, N)},
      {"v", rows_of(motion.v, N)},
      {"tau", motion.tau.empty() ? Json() : rows_of(motion.tau, N)},
      {"series", series},
      {"contact_shapes", motion.contact_shapes},
      {"contacts", contacts_of(motion)},
      {"twists", screws_of(numbers.twists, N, model.n_bodies())},
      {"wrenches", screws_of(numbers.wrenches, N, model.n_bodies())},
      {"momenta", screws_of(numbers.momenta, N, model.n_bodies())},
      {"loop_wrenches", screws_of(numbers.loop_wrenches, N, static_cast<int>(model.loops().joints.size()))},
      {"load_frames", places_of(model, numbers.load_frames)},
      {"loads", screws_of(numbers.loads, N, static_cast<int>(numbers.load_frames.size()))},
      {"tensions", numbers.tensions.empty() ? Json() : rows_of(numbers.tensions, N)}};
}

/// Writes JSON with escapes instead of <, > and &, so that it can be embedded in HTML.
void write_escaped(const std::string& text, std::ostream& out) {
  std::size_t from = 0;
  for (std::size_t at; (at = text.find_first_of("<>&", from)) != std::string::npos; from = at + 1) {
    out.write(&text[from], static_cast<std::streamsize>(at - from));
    out << (text[at] == '<' ? "\\u003c" : text[at] == '>' ? "\\u003e" : "\\u0026");
  }
  out.write(&text[from], static_cast<std::streamsize>(text.size() - from));
}

}  // namespace

std::vector<double> first_configuration(const Model& model, const std::function<bool()>& monitor) {
  std::vector<double> q = initial_state(model).q;
  if (model.loops().empty() && model.motions().empty()) return q;
  AssemblyResult closed = assemble(model, q, {}, {.monitor = monitor});
  return closed.status == AssemblyStatus::closed ? std::move(closed.q) : q;
}

SceneContents write_scene(const Model& model, std::span<const double> q, std::ostream& out,
                          const SceneOptions& options) {
  check_configuration(model, q);
  if (!finite(q)) throw std::invalid_argument("q: it must be finite");
  Shapes shapes(model);
  std::vector<std::string> warnings;
  for (const Fault& fault : model.warnings()) warnings.push_back(to_string(fault));
  warnings.insert(warnings.end(), shapes.contents.warnings.begin(), shapes.contents.warnings.end());
  Json motion = motion_of(model, options.motion, warnings);
  Json scene{{"format", "axode scene 1"},
             {"name", model.name()},
             {"gravity", json_of(model.gravity())},
             {"nq", model.nq()},
             {"nv", model.nv()},
             {"bodies", bodies_of(model)},
             {"frames", frames_of(model)},
             {"shapes", std::move(shapes.shapes)},
             {"meshes", std::move(shapes.meshes)},
             {"loops", loops_of(model)},
             {"couplings", couplings_of(model)},
             {"lines", lines_of(model)},
             {"q", std::vector<double>(q.begin(), q.end())},
             {"warnings", warnings},
             {"motion", std::move(motion)},
             {"coordinate_names", coordinate_names(model)},
             {"velocity_names", velocity_names(model)}};
  if (!options.live.empty()) scene["live"] = options.live;
  write_escaped(scene.dump(-1, ' ', /*ensure_ascii=*/true, Json::error_handler_t::replace), out);
  shapes.contents.warnings = std::move(warnings);
  return std::move(shapes.contents);
}

SceneContents write_page(std::string_view empty_page, const Model& model, std::span<const double> q,
                         std::ostream& out, const SceneOptions& options) {
  constexpr std::string_view before = R"(<script id="scene" type="application/json">)",
                             place = "null</script>";
  const std::size_t at = empty_page.find(before);
  if (at == std::string_view::npos || !empty_page.substr(at + before.size()).starts_with(place))
    throw std::invalid_argument(
        "empty_page is not the page of the viewer: it lacks the marker that a scene replaces; rebuild "
        "axode_viewer");
  out << empty_page.substr(0, at + before.size());
  SceneContents contents = write_scene(model, q, out, options);
  out << empty_page.substr(at + before.size() + place.find('<'));
  return contents;
}

}  // namespace axode
