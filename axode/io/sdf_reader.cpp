#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <queue>
#include <unordered_map>
#include <utility>

#include "axode/io.hpp"
#include "axode/io/pose.hpp"
#include "axode/io/sdf_frames.hpp"
#include "axode/io/xml_reader.hpp"
#include "axode/model/joint_kinds.hpp"
#include "axode/model/nearest_name.hpp"
#include "axode/model/placement.hpp"
#include "axode/model/shape_kinds.hpp"

namespace axode::io {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t longest_path = 1000;

std::span<const Grammar> sdf_grammar() {
  static const std::array<Grammar, 22> all{{
      {"sdf", {"version"}, {}, {"world", "model"}},
      {"world", {"name"}, {"gravity"}, {"model", "frame", "joint", "include"}},
      {"model",
       {"name", "canonical_link", "placement_frame"},
       {"static", "pose"},
       {"link", "joint", "frame", "model", "include"}},
      {"frame", {"name", "attached_to"}, {"pose"}},
      {"link", {"name"}, {"pose", "inertial"}, {"visual", "collision"}},
      {"inertial", {"auto"}, {"mass", "pose", "inertia"}},
      {"inertia", {}, {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}},
      {"visual", {"name"}, {"pose", "geometry", "material", "transparency"}},
      {"collision", {"name"}, {"pose", "geometry"}},
      {"geometry", {}, {"box", "sphere", "cylinder", "capsule", "ellipsoid", "mesh", "empty"}},
      {"box", {}, {"size"}},
      {"sphere", {}, {"radius"}},
      {"cylinder", {}, {"radius", "length"}},
      {"capsule", {}, {"radius", "length"}},
      {"ellipsoid", {}, {"radii"}},
      {"mesh", {}, {"uri", "scale"}},
      {"joint",
       {"name", "type"},
       {"pose", "parent", "child", "axis", "axis2", "thread_pitch", "screw_thread_pitch", "gearbox_ratio",
        "gearbox_reference_body"}},
      {"axis", {}, {"xyz", "dynamics", "limit", "use_parent_model_frame", "mimic"}},
      {"axis2", {}, {"xyz", "dynamics", "limit", "use_parent_model_frame", "mimic"}},
      {"dynamics", {}, {"damping", "friction", "spring_reference", "spring_stiffness"}},
      {"limit", {}, {"lower", "upper", "effort", "velocity"}},
      {"mimic", {"joint", "axis"}, {"multiplier", "offset", "reference"}},
  }};
  return all;
}

/// A type of joint in SDFormat, with its kind in the tree and its kind if it closes a loop.
struct SdfKind {
  std::string_view type;
  JointKind kind;
  LoopKind loop;
};
constexpr std::array<SdfKind, 9> sdf_kinds{{
    {"revolute", JointKind::revolute, LoopKind::revolute},
    {"continuous", JointKind::revolute, LoopKind::revolute},  // without limits
    {"prismatic", JointKind::prismatic, LoopKind::prismatic},
    {"screw", JointKind::helical, LoopKind::helical},
    {"universal", JointKind::universal, LoopKind::universal},
    {"revolute2", JointKind::universal, LoopKind::universal},
    {"ball", JointKind::spherical, LoopKind::spherical},
    {"fixed", JointKind::fixed, LoopKind::fixed},
    {"gearbox", JointKind::fixed, LoopKind::fixed},  // becomes a coupling
}};

class SdfReader : XmlReader {
 public:
  SdfReader(std::string_view text, std::string file, Strictness strictness)
      : XmlReader({"an SDF file", "sdf", sdf_grammar()}, text, std::move(file), strictness) {
    description().name = "mechanism";
    description().source = {file_, 0};
  }

  Reading read() {
    tinyxml2::XMLDocument document;
    if (const XMLElement* sdf = parse(document)) {
      read_root(*sdf);
      frames_.resolve([this](Rule rule, const SdfFrames::Frame& frame, std::string message) {
        constexpr std::array<std::string_view, 5> what{"world", "model", "link", "joint", "frame"};
        error(rule, element(what[static_cast<std::size_t>(frame.kind)], frame.path), std::move(message),
              frame.line);
      });
      finish_shapes();
      assemble();
      report_ignored();
      if (without_inertial_ > 0)
        note(Severity::warning, Rule::missing_element, "<link>",
             "has no <inertial>; SDFormat gives it 1 kg and 1 kg m²" + times(without_inertial_),
             without_inertial_line_);
      if (strictness_ == Strictness::lenient) forgive(result());
    }
    return take_result();
  }

 private:
  using Kind = SdfFrames::Kind;
  struct Pose {
    SE3<> X;
    std::string relative_to;
  };
  struct Link {
    int frame = 0;
    BodyDescription body;
    std::vector<std::string> shape_frames = {};  ///< frame to which the pose of each shape is relative
    bool is_static = false;
  };
  struct Mimic {
    std::string leader, axis;
    double ratio = 1, offset = 0;
    int line = 0;
  };
  struct Axis {
    Vec3<> xyz{0, 0, 1};
    std::string expressed_in;
    Dof dof;
    std::optional<Mimic> mimic = {};
  };
  struct Connection {
    int frame = 0;
    std::string name, parent, child;
    const SdfKind* kind = nullptr;
    std::array<Axis, 2> axes = {};
    double pitch = 0, gear_ratio = 1;
    std::string gear_reference;
    bool is_static = false;
    int line = 0;
    int from = -1, to = -1;  ///< links of parent and child; -1 for the world
    bool in_tree = false, reversed = false;
  };

  // ---------------------------------------------------------------- elements and their texts

  /// The name of a path here and in messages. If the file has one model, the name of that model is left out.
  std::string shown(const std::string& path) const {
    return models_at_top_ == 1 && path.starts_with(top_) ? path.substr(top_.size()) : path;
  }
  std::string element(std::string_view what, const std::string& path) const {
    return std::string(what) + " \"" + shown(path) + '"';
  }

  static std::string text_of(const XMLElement& e) {
    for (const tinyxml2::XMLNode* node = e.FirstChild(); node != nullptr; node = node->NextSibling())
      if (const tinyxml2::XMLText* text = node->ToText()) {
        const std::string_view all = text->Value();
        const std::size_t first = all.find_first_not_of(" \t\r\n");
        if (first == std::string_view::npos) continue;
        return std::string(all.substr(first, all.find_last_not_of(" \t\r\n") + 1 - first));
      }
    return {};
  }
  /// The N numbers in a child element; empty if it is absent or, with a note, if it is wrong.
  template <std::size_t N>
  std::optional<std::array<double, N>> child_numbers(const XMLElement& e, const char* child,
                                                     const std::string& owner,
                                                     Severity severity = Severity::error) {
    const XMLElement* given = e.FirstChildElement(child);
    if (given == nullptr) return std::nullopt;
    return numbers<N>(text_of(*given), tag(*given), owner, given->GetLineNum(), severity);
  }
  double scalar(const XMLElement& e, const char* child, const std::string& owner, double otherwise) {
    const auto x = child_numbers<1>(e, child, owner);
    return x ? (*x)[0] : otherwise;
  }
  std::optional<Vec3<>> vector(const XMLElement& e, const char* child, const std::string& owner,
                               Severity severity = Severity::error) {
    const auto x = child_numbers<3>(e, child, owner, severity);
    return x ? std::optional(Vec3<>{(*x)[0], (*x)[1], (*x)[2]}) : std::nullopt;
  }
  bool truth(std::string_view text, const std::string& what, const std::string& owner, int line) {
    const bool yes = text == "true" || text == "1";
    if (!yes && text != "false" && text != "0")
      error(Rule::wrong_value, owner, what + " is " + in_quotes(text) + "; it is true or false", line);
    return yes;
  }
  bool child_truth(const XMLElement& e, const char* child, const std::string& owner) {
    const XMLElement* given = e.FirstChildElement(child);
    return given != nullptr && truth(text_of(*given), tag(*given), owner, given->GetLineNum());
  }
  std::string required_text(const XMLElement& e, const char* child, const std::string& owner) {
    const XMLElement* given = e.FirstChildElement(child);
    if (given != nullptr)
      return checked_name(text_of(*given).c_str(), tag(*given) + " is empty", owner, given->GetLineNum());
    error(Rule::missing_element, owner, tag(e) + " has no <" + child + ">; it needs one", e.GetLineNum());
    return {};
  }

  Pose pose(const XMLElement& e, const std::string& owner) {
    Pose result;
    const XMLElement* given = e.FirstChildElement("pose");
    if (given == nullptr) return result;
    const int line = given->GetLineNum();
    for (const char* attribute : {"relative_to", "frame"})  // It was called frame before 1.7.
      if (const char* other = given->Attribute(attribute)) result.relative_to = other;
    const char* format = given->Attribute("rotation_format");
    const bool quaternion = format != nullptr && std::string_view(format) == "quat_xyzw";
    if (format != nullptr && !quaternion && std::string_view(format) != "euler_rpy")
      error(Rule::wrong_value, owner,
            "<pose> rotation_format is " + in_quotes(format) + "; SDFormat knows euler_rpy and quat_xyzw",
            line);
    const char* degrees = given->Attribute("degrees");
    const bool in_degrees = degrees != nullptr && truth(degrees, "<pose> degrees", owner, line);
    if (quaternion && in_degrees)
      error(Rule::wrong_value, owner, "<pose> gives a quaternion in degrees; it has no angles", line);
    const std::string text = text_of(*given);
    const auto x = numbers(text, "<pose>", owner, line, Severity::error);
    if (!x || x->empty()) return result;  // An empty pose is the identity.
    const std::vector<double>& n = *x;
    if (n.size() != (quaternion ? 7U : 6U)) {
      wrong_count(text, "<pose>", quaternion ? "7 numbers" : "6 numbers", n.size(), owner, line,
                  Severity::error);
      return result;
    }
    result.X.r = {n[0], n[1], n[2]};
    if (quaternion) {
      const auto R = from_quaternion({n[3], n[4], n[5], n[6]});
      if (!R)
        error(Rule::not_a_rotation, owner, "the quaternion of <pose> is off norm 1 by more than 1e-6", line);
      result.X.R = R.value_or(SO3<>{});
    } else {
      const double unit = in_degrees ? std::numbers::pi / 180 : 1;
      result.X.R = from_roll_pitch_yaw(unit * Vec3<>{n[3], n[4], n[5]});
    }
    return result;
  }

  /// Adds the frame of an element of a model and returns its number; 0, with a fault, if its name is missing,
  /// reserved, too long or taken.
  int declare(const XMLElement& e, Kind kind, int model, const std::string& owner) {
    const std::string own = name(e, "name", owner);
    if (own.empty()) return 0;
    if (own == "world" || (own.size() >= 4 && own.starts_with("__") && own.ends_with("__"))) {
      error(Rule::wrong_value, owner, in_quotes(own) + " is a reserved name; choose another one",
            e.GetLineNum());
      return 0;
    }
    SdfFrames::Frame frame{.kind = kind, .model = model, .line = e.GetLineNum()};
    frame.path = model == 0 ? own : frames_[model].path + "::" + own;
    if (frame.path.size() > longest_path) {
      error(Rule::wrong_value, owner,
            "its name has " + std::to_string(frame.path.size()) +
                " bytes with those of the models that hold it; " + std::to_string(longest_path) +
                " are the most",
            e.GetLineNum());
      return 0;
    }
    const std::string path = frame.path;
    bool is_new = false;
    const int number = frames_.add(std::move(frame), &is_new);
    // Before 1.7 a joint could have the name of a link.
    if (!is_new && (version_ >= 7 || frames_[frames_.find(0, path)].kind == kind)) {
      error(Rule::duplicate_name, element(e.Name(), path),
            "the name is taken; names of links, joints, frames and models must differ", e.GetLineNum());
      return 0;
    }
    return number;
  }
  void set_pose(int frame, Pose given) {
    frames_[frame].X = given.X, frames_[frame].relative_to = std::move(given.relative_to);
  }

  // ---------------------------------------------------------------- worlds and models

  void read_root(const XMLElement& sdf) {
    inspect(sdf, "sdf");
    description().source.line = sdf.GetLineNum();
    read_version(sdf);
    const XMLElement* world = sdf.FirstChildElement("world");
    if (world != nullptr && world->NextSiblingElement("world") != nullptr)
      error(Rule::duplicate_element, "sdf", "holds more than one <world>; a mechanism stands in one",
            world->NextSiblingElement("world")->GetLineNum());
    const std::array<const XMLElement*, 2> places{&sdf, world};
    for (const XMLElement* place : places)
      for (const XMLElement* e = place == nullptr ? nullptr : place->FirstChildElement("model"); e != nullptr;
           e = e->NextSiblingElement("model")) {
        if (++models_at_top_ == 1 && e->Attribute("name") != nullptr)
          top_ = std::string(e->Attribute("name")) + "::";
      }
    for (const XMLElement* e = sdf.FirstChildElement("model"); e != nullptr;
         e = e->NextSiblingElement("model"))
      read_model(*e, 0, false);
    if (world != nullptr) read_world(*world);
    if (models_at_top_ == 1 && top_.size() > 2 && printable(top_))
      description().name = top_.substr(0, top_.size() - 2);
    if (models_at_top_ == 0)
      error(Rule::missing_element, "sdf", "has no <model>; a mechanism is one at least", sdf.GetLineNum());
    else if (links_.empty() && !has_link_)
      error(Rule::missing_element, "sdf", "has no <link>; a mechanism needs one at least", sdf.GetLineNum());
  }

  void read_version(const XMLElement& sdf) {
    const char* given = sdf.Attribute("version");
    const std::string_view text = given == nullptr ? "" : given;
    const Number minor = text.starts_with("1.") ? number(text.substr(2)) : Number{};
    if (given == nullptr) {
      note(lenient_severity(), Rule::missing_element, "sdf",
           "has no attribute version; it is read as one of 1.10", sdf.GetLineNum());
    } else if (minor.value >= 1 && minor.value < 1000 && minor.value == std::floor(minor.value)) {
      version_ = static_cast<int>(minor.value);
    } else {
      note(lenient_severity(), Rule::wrong_value, "sdf",
           "its version is " + in_quotes(text) + "; it is read as one of 1.10", sdf.GetLineNum());
    }
  }

  void read_world(const XMLElement& world) {
    inspect(world, "world");
    if (const char* given = world.Attribute("name"); given != nullptr && printable(given))
      description().name = given;
    description().gravity = vector(world, "gravity", "world").value_or(Vec3<>{0, 0, -9.8});
    read_children(world, 0, false, "world");
  }

  void read_children(const XMLElement& parent, int model, bool is_static, const std::string& owner) {
    for (const XMLElement* e = parent.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      const std::string_view what = e->Name();
      if (what == "link" && model != 0) read_link(*e, model, is_static);
      if (what == "joint") read_joint(*e, model, is_static);
      if (what == "frame") read_frame(*e, model);
      if (what == "model") read_model(*e, model, is_static);
      if (what == "include") read_include(*e, model, owner);
    }
  }

  void read_include(const XMLElement& e, int model, const std::string& owner) {
    const XMLElement* uri = e.FirstChildElement("uri");
    const std::string file = in_quotes(uri == nullptr ? "" : text_of(*uri));
    if (model == 0) {
      note(Severity::warning, Rule::unknown_element, "world",
           "includes " + file + ", which is another file and is not read", e.GetLineNum());
    } else {
      error(Rule::unknown_element, owner,
            "includes " + file + "; write out what it includes, as `gz sdf -p` does", e.GetLineNum());
    }
  }

  void read_model(const XMLElement& e, int parent, bool is_static) {
    const int number = declare(e, Kind::model, parent, "model");
    if (number == 0) return;
    const std::string owner = element("model", frames_[number].path);
    inspect(e, owner);
    set_pose(number, pose(e, owner));
    if (const char* canonical = e.Attribute("canonical_link")) frames_[number].attached_to = canonical;
    if (const char* placement = e.Attribute("placement_frame")) frames_[number].placement = placement;
    read_children(e, number, is_static || child_truth(e, "static", owner), owner);
  }

  void read_frame(const XMLElement& e, int model) {
    const int number = declare(e, Kind::frame, model, "frame");
    if (number == 0) return;
    const std::string owner = element("frame", frames_[number].path);
    inspect(e, owner);
    set_pose(number, pose(e, owner));
    if (const char* carrier = e.Attribute("attached_to")) frames_[number].attached_to = carrier;
    named_frames_.push_back(number);
  }

  // ---------------------------------------------------------------- links

  void read_link(const XMLElement& e, int model, bool is_static) {
    has_link_ = true;
    Link link{.frame = declare(e, Kind::link, model, "link"), .is_static = is_static};
    if (link.frame == 0) return;
    link.body.name = shown(frames_[link.frame].path);
    link.body.source = {file_, e.GetLineNum()};
    const std::string owner = "link \"" + link.body.name + '"';
    inspect(e, owner);
    set_pose(link.frame, pose(e, owner));
    link.body.inertia = read_inertial(e, owner, is_static);
    for (const XMLElement* shape = e.FirstChildElement(); shape != nullptr;
         shape = shape->NextSiblingElement()) {
      if (shape->Name() == std::string_view("visual"))
        read_shape(*shape, ShapeDescription::Role::visual, owner, link);
      if (shape->Name() == std::string_view("collision"))
        read_shape(*shape, ShapeDescription::Role::collision, owner, link);
    }
    link_of_frame_.emplace(link.frame, static_cast<int>(links_.size()));
    links_.push_back(std::move(link));
  }

  /// Reads <inertial>. The defaults of SDFormat are 1 kg, 1 kg m² about each axis, and the centre of mass at
  /// the origin of the link.
  std::optional<MassProperties> read_inertial(const XMLElement& link, const std::string& owner,
                                              bool is_static) {
    const std::size_t faults_before = faults().size();
    MassProperties result{.mass = 1, .Theta = {1, 1, 1, 0, 0, 0}};
    const XMLElement* e = child_of(link, "inertial", owner);
    if (e == nullptr) {
      if (!is_static)
        without_inertial_line_ = without_inertial_++ == 0 ? link.GetLineNum() : without_inertial_line_;
      return result;
    }
    if (const char* automatic = e->Attribute("auto");
        automatic != nullptr && truth(automatic, "<inertial> auto", owner, e->GetLineNum()))
      error(Rule::wrong_value, owner, "<inertial> is to follow from the shapes; give mass and inertia",
            e->GetLineNum());
    const Pose frame = pose(*e, owner);
    if (!frame.relative_to.empty())
      error(Rule::wrong_value, owner, "the <pose> of <inertial> is relative to the link and to nothing else",
            e->GetLineNum());
    result.com = frame.X.r, result.axes = frame.X.R;
    const auto missing = [&](const char* child, const char* taken) {
      note(Severity::warning, Rule::missing_element, owner,
           std::string("<inertial> has no <") + child + ">; SDFormat takes " + taken, e->GetLineNum());
    };
    if (e->FirstChildElement("mass") == nullptr) missing("mass", "1 kg");
    result.mass = scalar(*e, "mass", owner, 1);
    if (const XMLElement* inertia = child_of(*e, "inertia", owner)) {
      Sym3<>& Theta = result.Theta;
      const std::array<std::pair<const char*, double*>, 6> entries{{{"ixx", &Theta.xx},
                                                                    {"ixy", &Theta.xy},
                                                                    {"ixz", &Theta.xz},
                                                                    {"iyy", &Theta.yy},
                                                                    {"iyz", &Theta.yz},
                                                                    {"izz", &Theta.zz}}};
      for (const auto& [child, entry] : entries) {
        if (*entry != 0 && inertia->FirstChildElement(child) == nullptr) missing(child, "1 kg m²");
        *entry = scalar(*inertia, child, owner, *entry);
      }
    } else {
      missing("inertia", "1 kg m² about each axis");
    }
    if (has_error_since(faults_before)) return std::nullopt;
    return result;
  }
  bool has_error_since(std::size_t first) {
    return std::any_of(faults().begin() + static_cast<std::ptrdiff_t>(first), faults().end(),
                       [](const Fault& f) { return f.severity == Severity::error; });
  }

  /// Reads a shape. As shapes do not affect the motion, wrong dimensions and colours are errors of a strict
  /// reader only. A shape that is not complete is left out.
  void read_shape(const XMLElement& e, ShapeDescription::Role role, const std::string& owner, Link& link) {
    inspect(e, owner);
    Pose given = pose(e, owner);
    ShapeDescription shape{.role = role, .pose = given.X};
    if (const char* own = e.Attribute("name"); own != nullptr && printable(own)) shape.name = own;
    shape.color = read_color(e, owner);
    const XMLElement* geometry = required_child(e, "geometry", owner);
    if (geometry == nullptr) return;
    for (const XMLElement* g = geometry->FirstChildElement(); g != nullptr; g = g->NextSiblingElement()) {
      const auto kind = std::ranges::find(shape_kinds, std::string_view(g->Name()), &ShapeTraits::name);
      if (kind == shape_kinds.end()) continue;
      inspect(*g, owner);
      if (!read_dimensions(*g, *kind, owner, shape)) continue;
      link.body.shapes.push_back(shape);
      link.shape_frames.push_back(given.relative_to);
    }
  }

  /// Reads the kind and the dimensions of a shape; false if a dimension is missing or wrong.
  bool read_dimensions(const XMLElement& e, const ShapeTraits& kind, const std::string& owner,
                       ShapeDescription& shape) {
    shape.kind = kind.kind;
    bool complete = true;
    const auto is_there = [&](const char* child) {
      if (e.FirstChildElement(child) != nullptr) return true;
      note(lenient_severity(), Rule::missing_element, owner,
           tag(e) + " has no <" + child + ">; a shape without one is ignored", e.GetLineNum());
      return complete = false;
    };
    const auto length = [&](const char* child) {
      const auto x = is_there(child) ? child_numbers<1>(e, child, owner, lenient_severity()) : std::nullopt;
      complete &= x.has_value();
      return x ? (*x)[0] : 0;
    };
    if (!kind.size.empty()) {
      const char* child = kind.kind == ShapeKind::ellipsoid ? "radii" : "size";
      const auto size = is_there(child) ? vector(e, child, owner, lenient_severity()) : std::nullopt;
      complete &= size.has_value();
      shape.size = size.value_or(Vec3<>{});
    }
    if (kind.radius) shape.radius = length("radius");
    if (kind.length) shape.length = length("length");
    if (kind.kind == ShapeKind::mesh) {
      shape.file = required_text(e, "uri", owner);
      shape.scale = vector(e, "scale", owner, lenient_severity()).value_or(Vec3<>{1, 1, 1});
      complete = !shape.file.empty();
    }
    return complete;
  }

  std::optional<std::array<double, 4>> read_color(const XMLElement& e, const std::string& owner) {
    const XMLElement* material = e.FirstChildElement("material");
    const XMLElement* diffuse = material == nullptr ? nullptr : material->FirstChildElement("diffuse");
    if (diffuse == nullptr) return std::nullopt;
    const int line = diffuse->GetLineNum();
    const std::string text = text_of(*diffuse);
    const auto x = numbers(text, "<diffuse>", owner, line, lenient_severity());
    if (!x) return std::nullopt;
    if (x->size() != 3 && x->size() != 4) {
      wrong_count(text, "<diffuse>", "3 or 4 numbers", x->size(), owner, line, lenient_severity());
      return std::nullopt;
    }
    return std::array<double, 4>{(*x)[0], (*x)[1], (*x)[2],
                                 (x->size() == 4 ? (*x)[3] : 1) * (1 - scalar(e, "transparency", owner, 0))};
  }

  void finish_shapes() {
    for (Link& link : links_)
      for (std::size_t k = 0; k < link.body.shapes.size(); ++k) {
        const std::string& other = link.shape_frames[k];
        if (other.empty()) continue;
        const int model = frames_[link.frame].model, found = frames_.find(model, other);
        if (found < 0) {
          error(Rule::unknown_frame_body, "link \"" + link.body.name + '"',
                "the pose of a shape is relative to " + in_quotes(other) + ", which is not described" +
                    frames_.nearest(model, other),
                link.body.source.line);
          continue;
        }
        SE3<>& X = link.body.shapes[k].pose;
        X = relative(frames_[link.frame].pose, frames_[found].pose) * X;
      }
  }

  // ---------------------------------------------------------------- joints

  void read_joint(const XMLElement& e, int model, bool is_static) {
    Connection c{.frame = declare(e, Kind::joint, model, "joint"), .is_static = is_static};
    if (c.frame == 0) return;
    c.name = shown(frames_[c.frame].path);
    c.line = e.GetLineNum();
    const std::string owner = "joint \"" + c.name + '"';
    inspect(e, owner);
    set_pose(c.frame, pose(e, owner));
    c.parent = required_text(e, "parent", owner);
    c.child = frames_[c.frame].attached_to = required_text(e, "child", owner);
    c.kind = kind_of(e, owner);
    if (c.kind == nullptr) return;
    const bool gearbox = c.kind->type == "gearbox", two = c.kind->kind == JointKind::universal || gearbox;
    if (gearbox || (c.kind->kind != JointKind::fixed && c.kind->kind != JointKind::spherical))
      read_axis(e, "axis", owner, c, 0);
    if (two) read_axis(e, "axis2", owner, c, 1);
    if (c.kind->kind == JointKind::helical) c.pitch = read_pitch(e, owner);
    if (gearbox) {
      c.gear_ratio = scalar(e, "gearbox_ratio", owner, 1);
      c.gear_reference = required_text(e, "gearbox_reference_body", owner);
    }
    connections_.push_back(std::move(c));
  }

  const SdfKind* kind_of(const XMLElement& e, const std::string& owner) {
    const char* type = required(e, "type", owner);
    if (type == nullptr) return nullptr;
    for (const SdfKind& kind : sdf_kinds)
      if (kind.type == type) return &kind;
    error(
        Rule::wrong_value, owner,
        "type is " + in_quotes(type) +
            "; SDFormat knows revolute, continuous, prismatic, screw, universal, revolute2, ball, fixed and "
            "gearbox" +
            did_you_mean(std::string_view(type).substr(0, 30), sdf_kinds,
                         [](const SdfKind& k) { return k.type; }),
        e.GetLineNum());
    return nullptr;
  }

  /// The pitch of a screw joint in m/rad. A positive `screw_thread_pitch` (m per turn) is a right-handed
  /// thread, and a positive `thread_pitch` (rad/m) a left-handed one.
  double read_pitch(const XMLElement& e, const std::string& owner) {
    if (e.FirstChildElement("screw_thread_pitch") != nullptr ||
        e.FirstChildElement("thread_pitch") == nullptr)
      return scalar(e, "screw_thread_pitch", owner, 1) / (2 * std::numbers::pi);
    const double turns = scalar(e, "thread_pitch", owner, 1);
    if (turns == 0)
      error(Rule::wrong_value, owner, "<thread_pitch> is 0 rad/m; a screw turns as it moves on",
            e.GetLineNum());
    return turns == 0 ? 0 : -1 / turns;
  }

  void read_axis(const XMLElement& joint, const char* which, const std::string& owner, Connection& c,
                 std::size_t number) {
    const XMLElement* e = required_child(joint, which, owner);
    if (e == nullptr) return;
    Axis& axis = c.axes[number];
    axis.xyz = vector(*e, "xyz", owner).value_or(Vec3<>{0, 0, 1});
    const XMLElement* xyz = e->FirstChildElement("xyz");
    if (xyz != nullptr && xyz->Attribute("expressed_in") != nullptr)
      axis.expressed_in = xyz->Attribute("expressed_in");
    const bool in_model = e->FirstChildElement("use_parent_model_frame") == nullptr
                              ? version_ <= 4
                              : child_truth(*e, "use_parent_model_frame", owner);
    if (axis.expressed_in.empty() && in_model) axis.expressed_in = "__model__";
    Dof& dof = axis.dof;
    if (const XMLElement* limit = child_of(*e, "limit", owner)) {
      dof.lower = bound(*limit, "lower", owner, -infinity);
      dof.upper = bound(*limit, "upper", owner, infinity);
      for (const auto& [child, most] :
           {std::pair{"effort", &dof.effort}, std::pair{"velocity", &dof.velocity}}) {
        const double given = bound(*limit, child, owner, infinity);
        *most = given < 0 ? infinity : given;  // SDFormat does not enforce a negative limit.
      }
    }
    if (c.kind->type == "continuous") dof.lower = -infinity, dof.upper = infinity;
    if (const XMLElement* dynamics = child_of(*e, "dynamics", owner)) {
      dof.damping = scalar(*dynamics, "damping", owner, 0);
      dof.friction = scalar(*dynamics, "friction", owner, 0);
      dof.stiffness = scalar(*dynamics, "spring_stiffness", owner, 0);
      dof.rest = scalar(*dynamics, "spring_reference", owner, 0);
    }
    if (const XMLElement* mimic = child_of(*e, "mimic", owner)) read_mimic(*mimic, owner, axis);
  }

  /// Reads <mimic>: q = multiplier (q_leader - reference) + offset.
  void read_mimic(const XMLElement& e, const std::string& owner, Axis& axis) {
    Mimic mimic{.leader = name(e, "joint", owner), .axis = "axis", .line = e.GetLineNum()};
    if (const char* which = e.Attribute("axis")) mimic.axis = which;
    mimic.ratio = scalar(e, "multiplier", owner, 1);
    mimic.offset = scalar(e, "offset", owner, 0) - mimic.ratio * scalar(e, "reference", owner, 0);
    if (mimic.axis != "axis" && mimic.axis != "axis2")
      error(Rule::wrong_value, owner, "<mimic> axis is " + in_quotes(mimic.axis) + "; it is axis or axis2",
            mimic.line);
    else if (!mimic.leader.empty())
      axis.mimic = std::move(mimic);
  }

  /// A limit. Magnitudes of 1e16 and more, and inf, mean that there is none.
  double bound(const XMLElement& e, const char* child, const std::string& owner, double otherwise) {
    const XMLElement* given = e.FirstChildElement(child);
    const Number x = given == nullptr ? Number{} : number(text_of(*given));
    if (x.broken == Rule::non_finite_number && std::isinf(x.value)) return x.value;
    const double value = scalar(e, child, owner, otherwise);
    return std::abs(value) < 1e16 ? value : std::copysign(infinity, value);
  }

  // ---------------------------------------------------------------- the mechanism

  /// The link that moves with the frame of that name, as a joint sees it; -1 if this is the world or a link
  /// of a static model. The result is empty, with a fault, if there is no such frame.
  std::optional<int> link_meant(const Connection& c, const std::string& name, const char* role) {
    if (name.empty()) return std::nullopt;
    const int model = frames_[c.frame].model, frame = frames_.find(model, name);
    if (frame < 0) {
      error(Rule::unknown_predecessor, "joint \"" + c.name + '"',
            std::string("its ") + role + " is " + in_quotes(name) + ", which is not described" +
                frames_.nearest(model, name),
            c.line);
      return std::nullopt;
    }
    const auto link = link_of_frame_.find(frames_[frame].moves_with);
    return link == link_of_frame_.end() || links_[static_cast<std::size_t>(link->second)].is_static
               ? -1
               : link->second;
  }

  /// Adds the bodies to the description: first those to which no joint of the tree leads, then the others in
  /// the order of their joints in the file. Adds loops, couplings and frames, too.
  void assemble() {
    for (Link& it : links_) it.body.name = named_here(it.body.name, it.body.source.line);
    std::erase_if(connections_, [this](const Connection& c) {
      if (c.is_static) ignore("joint of a static model", c.line);
      return c.is_static;
    });
    std::erase_if(connections_, [this](Connection& c) { return !connect(c); });
    for (std::size_t k = 0; k < connections_.size(); ++k)
      connection_of_frame_.emplace(connections_[k].frame, k);
    const std::vector<std::size_t> roots = grow_tree();
    for (std::size_t k = 0; k < connections_.size(); ++k)
      if (const Connection& c = connections_[k]; c.in_tree && c.kind->kind == JointKind::revolute)
        hinges_.emplace(std::minmax(c.from, c.to), k);
    add_roots(roots);
    for (const Connection& c : connections_)
      if (c.in_tree) add_body(c);
    for (const Connection& c : connections_) {
      if (c.kind->type == "gearbox") {
        add_gearbox(c);
      } else if (!c.in_tree) {
        add_loop(c);
      }
      add_couplings(c);
    }
    for (const int k : named_frames_) add_frame(k);
  }

  /// The name of a body or frame here. `ground` is the name of the inertial frame, so that a body or frame of
  /// this name gets another one, with a warning.
  std::string named_here(const std::string& name, int line) {
    if (name != "ground") return name;
    std::string other = name;
    for (int k = 2; other == name || frames_.find(0, (models_at_top_ == 1 ? top_ : "") + other) >= 0; ++k)
      other = name + "_" + std::to_string(k);
    note(Severity::warning, Rule::duplicate_name, in_quotes(name),
         "is called " + in_quotes(other) + " here, where \"ground\" is the inertial frame", line);
    return other;
  }

  /// Finds the links of a joint; false, with a fault, if they are missing or cannot be connected.
  bool connect(Connection& c) {
    const std::string owner = "joint \"" + c.name + '"';
    const auto parent = link_meant(c, c.parent, "parent"), child = link_meant(c, c.child, "child");
    if (!parent || !child) return false;
    c.from = *parent, c.to = *child;
    if (c.to < 0) {
      error(Rule::unknown_predecessor, owner,
            "its child is the world, or stands still in it; that must be the parent", c.line);
    } else if (c.from == c.to) {
      error(Rule::cycle, owner, "its parent and its child are both link \"" + link(c.to).body.name + '"',
            c.line);
    }
    return c.to >= 0 && c.from != c.to;
  }
  Link& link(int k) { return links_[static_cast<std::size_t>(k)]; }

  /// Marks the joints of a spanning tree of all links and returns its root links, to which no joint leads.
  /// Joints are taken in the order of the file; a joint is reversed, from child to parent, only if no other
  /// joint reaches a new link. The joints that remain close loops.
  std::vector<std::size_t> grow_tree() {
    std::vector<std::vector<std::size_t>> joints_at(links_.size() + 1);  // The last entry is the world.
    const auto at = [&](int k) { return k < 0 ? links_.size() : static_cast<std::size_t>(k); };
    std::vector<char> is_child(links_.size(), 0), reached(links_.size() + 1, 0);
    for (std::size_t k = 0; k < connections_.size(); ++k) {
      const Connection& c = connections_[k];
      if (c.kind->type == "gearbox") continue;
      joints_at[at(c.from)].push_back(k), joints_at[at(c.to)].push_back(k);
      is_child[at(c.to)] = 1;
    }
    using Step = std::pair<bool, std::size_t>;  // whether the joint is reversed, and its number
    std::priority_queue<Step, std::vector<Step>, std::greater<>> ahead;
    const auto reach = [&](std::size_t k) {
      reached[k] = 1;
      for (const std::size_t j : joints_at[k]) ahead.emplace(at(connections_[j].to) == k, j);
    };
    const auto follow = [&] {
      while (!ahead.empty()) {
        const auto [reversed, j] = ahead.top();
        ahead.pop();
        Connection& c = connections_[j];
        const std::size_t next = at(reversed ? c.from : c.to);
        if (reached[next] != 0) continue;
        c.in_tree = true, c.reversed = reversed;
        reach(next);
      }
    };
    std::vector<std::size_t> roots;
    reach(links_.size());
    follow();
    for (const bool with_parent : {false, true})
      for (std::size_t k = 0; k < links_.size(); ++k)
        if (reached[k] == 0 && !links_[k].is_static && (is_child[k] != 0) == with_parent) {
          roots.push_back(k);
          reach(k), follow();
        }
    return roots;
  }

  /// Adds the root links with free joints. Links of static models become frames and shapes of the ground.
  void add_roots(const std::vector<std::size_t>& roots) {
    const bool name_is_free =
        std::ranges::none_of(connections_, [](const Connection& c) { return c.name == "free_base"; });
    for (const std::size_t k : roots) {
      Link& root = links_[k];
      root.body.joint = {.name = roots.size() == 1 && name_is_free ? "free_base" : "",
                         .kind = JointKind::free,
                         .source = root.body.source};
      root.body.geometry = InBodyFrame{frames_[root.frame].pose};
      add(root);
    }
    for (Link& it : links_) {
      if (!it.is_static) continue;
      const SE3<>& A = frames_[it.frame].pose;
      description().frames.push_back(
          {.name = it.body.name, .body = "ground", .pose = A, .source = it.body.source});
      for (ShapeDescription& shape : it.body.shapes) {
        shape.pose = A * shape.pose;
        description().shapes.push_back(std::move(shape));
      }
    }
  }
  void add(Link& link) {
    const std::string name = link.body.name;
    description().bodies.push_back(std::move(link.body));
    link.body.name = name;
  }

  /// An axis of a joint in the axes of the world. If the frame in which it is expressed is not described, a
  /// fault is noted and the joint's own frame is used.
  Vec3<> axis_of(const Connection& c, std::size_t number) {
    const Axis& axis = c.axes[number];
    int in = c.frame;
    if (!axis.expressed_in.empty()) {
      const int model = frames_[c.frame].model;
      in = frames_.find(model, axis.expressed_in);
      if (in < 0) {
        error(Rule::unknown_frame_body, "joint \"" + c.name + '"',
              "an axis is expressed in " + in_quotes(axis.expressed_in) + ", which is not described" +
                  frames_.nearest(model, axis.expressed_in),
              c.line);
        in = c.frame;
      }
    }
    return frames_[in].pose.R * axis.xyz;
  }

  void add_body(const Connection& c) {
    const int moved = c.reversed ? c.from : c.to, carrier = c.reversed ? c.to : c.from;
    Link& it = link(moved);
    const SE3<>& A = frames_[it.frame].pose;
    const SE3<> A_carrier = carrier < 0 ? SE3<>{} : frames_[link(carrier).frame].pose;
    it.body.predecessor = carrier < 0 ? "ground" : link(carrier).body.name;
    it.body.geometry = InBodyFrame{relative(A_carrier, A)};
    JointDescription& joint = it.body.joint;
    joint = {.name = c.name, .kind = c.kind->kind, .pitch = c.pitch, .source = {file_, c.line}};
    const int dof = traits(joint.kind).dof;
    joint.point = relative(A, frames_[c.frame].pose).r;
    if (traits(joint.kind).axis) {
      // In a reversed joint the second axis comes first, and the axes have the opposite directions.
      const auto in_body = [&](std::size_t k) {
        const Vec3<> axis = transpose(A.R) * axis_of(c, k);
        return c.reversed ? -axis : axis;
      };
      const std::size_t first = c.reversed && dof == 2 ? 1 : 0;
      joint.axis = in_body(first);
      joint.dof = {c.axes[first].dof};
      if (dof == 2) joint.second_axis = in_body(1 - first), joint.dof.push_back(c.axes[1 - first].dof);
    }
    if (dof == 1 && c.axes[0].mimic)
      joint.coupling =
          Coupling{coordinate_of(c, *c.axes[0].mimic), c.axes[0].mimic->ratio, c.axes[0].mimic->offset};
    add(it);
  }

  void add_loop(const Connection& c) {
    LoopDescription loop{.name = c.name, .kind = c.kind->loop, .pitch = c.pitch, .source = {file_, c.line}};
    loop.between = {c.from < 0 ? "ground" : link(c.from).body.name, link(c.to).body.name};
    loop.point = frames_[c.frame].pose.r;
    if (c.kind->kind != JointKind::fixed && c.kind->kind != JointKind::spherical) loop.axis = axis_of(c, 0);
    if (traits(loop.kind).has("second_axis")) loop.second_axis = axis_of(c, 1);
    const auto says_more = [](const Axis& axis) {
      const Dof& d = axis.dof;
      return std::isfinite(d.lower) || std::isfinite(d.upper) || d.damping != 0 || d.friction != 0 ||
             d.stiffness != 0 || axis.mimic;
    };
    if (std::ranges::any_of(c.axes, says_more))
      note(Severity::warning, Rule::unknown_element, "joint \"" + c.name + '"',
           "closes a loop and has no coordinate; its limits, dynamics and mimics are not carried over",
           c.line);
    description().loops.push_back(std::move(loop));
  }

  /// The name of the coordinate that a mimic follows.
  std::string coordinate_of(const Connection& c, const Mimic& mimic) {
    const auto found = connection_of_frame_.find(frames_.find(frames_[c.frame].model, mimic.leader));
    if (found == connection_of_frame_.end()) return mimic.leader;
    const Connection& leader = connections_[found->second];
    if (leader.kind->kind != JointKind::universal) return leader.name;
    return leader.name + ((mimic.axis == "axis2") != leader.reversed ? ".second" : ".first");
  }

  /// Adds a coupling for each axis of a universal joint that follows another coordinate.
  void add_couplings(const Connection& c) {
    if (c.kind->kind != JointKind::universal || !c.in_tree) return;
    for (std::size_t k = 0; k < 2; ++k) {
      if (!c.axes[k].mimic) continue;
      const Mimic& mimic = *c.axes[k].mimic;
      CouplingDescription coupling{.offset = mimic.offset, .source = {file_, mimic.line}};
      coupling.terms = {{c.name + ((k == 1) != c.reversed ? ".second" : ".first"), 1},
                        {coordinate_of(c, mimic), -mimic.ratio}};
      description().couplings.push_back(std::move(coupling));
    }
  }

  /// Adds the coupling of a gearbox: relative to the reference body, the child turns by -ratio times the
  /// angle of the parent.
  void add_gearbox(const Connection& c) {
    const auto reference = link_meant(c, c.gear_reference, "reference body");
    if (!reference) return;
    CouplingDescription gears{.name = c.name, .source = {file_, c.line}};
    const std::array<std::pair<int, double>, 2> sides{{{c.from, c.gear_ratio}, {c.to, 1.0}}};
    for (std::size_t k = 0; k < 2; ++k) {
      const auto& [turning, factor] = sides[k];
      const Vec3<> axis = axis_of(c, k);
      const auto found = hinges_.find(std::minmax(*reference, turning));
      const Connection* hinge = found == hinges_.end() ? nullptr : &connections_[found->second];
      const Vec3<> its = hinge == nullptr ? Vec3<>{} : axis_of(*hinge, 0);
      if (hinge == nullptr || !(norm(cross(its, axis)) <= 1e-6 * norm(its) * norm(axis))) {
        error(Rule::coupling_kind, "joint \"" + c.name + '"',
              "is a gearbox; its " + std::string(k == 0 ? "parent" : "child") +
                  " needs a revolute joint of the same axis to the reference body",
              c.line);
        return;
      }
      const double along = (dot(its, axis) < 0) == (hinge->from == *reference) ? -1 : 1;
      gears.terms.emplace_back(hinge->name, along * factor);
    }
    description().couplings.push_back(std::move(gears));
  }

  void add_frame(int number) {
    const SdfFrames::Frame& frame = frames_[number];
    const auto carrier = link_of_frame_.find(frame.moves_with);
    FrameDescription named{
        .name = named_here(shown(frame.path), frame.line), .body = "ground", .source = {file_, frame.line}};
    named.pose = frame.pose;
    if (carrier != link_of_frame_.end() && !link(carrier->second).is_static) {
      named.body = link(carrier->second).body.name;
      named.pose = relative(frames_[link(carrier->second).frame].pose, frame.pose);
    }
    description().frames.push_back(std::move(named));
  }

  SdfFrames frames_;
  std::vector<Link> links_;
  std::vector<Connection> connections_;
  std::unordered_map<int, int> link_of_frame_;
  std::unordered_map<int, std::size_t> connection_of_frame_;
  std::map<std::pair<int, int>, std::size_t> hinges_;  ///< revolute joints of the tree, by links
  std::vector<int> named_frames_;
  std::string top_;  ///< name of the first model at the top, and `::`
  int models_at_top_ = 0;
  int version_ = 10;
  bool has_link_ = false;
  int without_inertial_ = 0, without_inertial_line_ = 0;
};

}  // namespace

Reading read_sdf(std::string_view text, const std::string& file, Strictness strictness) {
  return SdfReader(text, file, strictness).read();
}

}  // namespace axode::io

namespace axode {

Description read_sdf_text(std::string_view text, const std::string& file_name, Strictness strictness) {
  return io::accept(io::read_sdf(text, file_name, strictness));
}

}  // namespace axode
