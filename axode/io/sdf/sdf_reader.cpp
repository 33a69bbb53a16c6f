#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "axode/io.hpp"
#include "axode/io/pose.hpp"
#include "axode/io/sdf/sdf_mechanism.hpp"
#include "axode/model/kinds/joint_kinds.hpp"

namespace axode::io {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t longest_path = 1000;

std::span<const Grammar> sdf_grammar() {
  static const std::array<Grammar, 27> all{{
      {"sdf", {"version"}, {}, {"world", "model"}},
      {"world", {"name"}, {"gravity"}, {"model", "frame", "joint", "include"}},
      {"model",
       {"name", "canonical_link", "placement_frame"},
       {"static", "pose"},
       {"link", "joint", "frame", "model", "include"}},
      {"frame", {"name", "attached_to"}, {"pose"}},
      {"link", {"name"}, {"pose", "inertial", "gravity", "kinematic"}, {"visual", "collision"}},
      {"inertial", {"auto"}, {"mass", "pose", "inertia"}},
      {"inertia", {}, {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}},
      {"visual", {"name"}, {"pose", "geometry", "material", "transparency"}},
      {"collision", {"name"}, {"pose", "geometry", "surface"}},
      {"surface", {}, {"friction", "bounce"}},
      {"friction", {}, {"ode"}},
      {"ode", {}, {"mu"}},
      {"bounce", {}, {"restitution_coefficient"}},
      {"geometry", {}, {"box", "sphere", "cylinder", "capsule", "ellipsoid", "plane", "mesh", "empty"}},
      {"plane", {}, {"normal", "size"}},
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

class SdfReader : SdfMechanism {
 public:
  SdfReader(std::string_view text, std::string file, Strictness strictness)
      : SdfMechanism({"SDFormat", "an SDF file", "sdf", sdf_grammar(), true}, text, std::move(file),
                     strictness) {
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
  struct Pose {
    SE3<> X;
    std::string relative_to;
  };

  // ---------------------------------------------------------------- elements and their texts

  bool truth(std::string_view text, const std::string& what, const std::string& owner, int line) {
    const bool yes = text == "true" || text == "1";
    if (!yes && text != "false" && text != "0")
      error(Rule::wrong_value, owner, what + " is " + in_quotes(text) + "; it is true or false", line);
    return yes;
  }
  bool child_truth(const XMLElement& e, const char* child, const std::string& owner, bool otherwise = false) {
    const XMLElement* given = e.FirstChildElement(child);
    return given == nullptr ? otherwise : truth(text_of(*given), tag(*given), owner, given->GetLineNum());
  }

  Pose pose(const XMLElement& e, const std::string& owner) {
    Pose result;
    const XMLElement* given = e.FirstChildElement("pose");
    if (given == nullptr) return result;
    const int line = given->GetLineNum();
    for (const char* attribute : {"relative_to", "frame"})  // the attribute was called frame before version
                                                            // 1.7
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
    if (!x || x->empty()) return result;  // an empty pose is the identity
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
        error(Rule::not_a_rotation, owner,
              "the norm of the quaternion of <pose> differs from 1 by more than 1e-6", line);
      result.X.R = R.value_or(SO3<>{});
    } else {
      const double unit = in_degrees ? std::numbers::pi / 180 : 1;
      result.X.R =
          roll_pitch_yaw({unit * n[3], unit * n[4], unit * n[5]}, "the angles of <pose> are", owner, line);
    }
    return result;
  }

  /// Adds a frame for a model, link, joint or named frame inside a model, and returns its number; 0, with a
  /// fault, if its name is missing, reserved, too long or taken.
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
    // Before version 1.7, a joint could have the same name as a link.
    if (!is_new && (version_ >= 7 || frames_[frames_.find(0, path)].kind == kind)) {
      error(Rule::duplicate_name, element(e.Name(), path),
            "the name is taken; names of links, joints, frames and models must differ", e.GetLineNum());
      return 0;
    }
    return number;
  }
  void read_pose(const XMLElement& e, const std::string& owner, int frame) {
    Pose given = pose(e, owner);
    frames_[frame].X = given.X;
    frames_[frame].relative_to = std::move(given.relative_to);
  }

  // ---------------------------------------------------------------- worlds and models

  void read_root(const XMLElement& sdf) {
    inspect(sdf, "sdf");
    description().source.line = sdf.GetLineNum();
    read_version(sdf);
    const XMLElement* world = sdf.FirstChildElement("world");
    if (world != nullptr && world->NextSiblingElement("world") != nullptr)
      error(Rule::duplicate_element, "sdf", "holds more than one <world>; a mechanism is in one world",
            world->NextSiblingElement("world")->GetLineNum());
    const std::vector<const XMLElement*> models = children(sdf, "model");
    std::vector<const XMLElement*> at_top = models;
    if (world != nullptr) std::ranges::copy(children(*world, "model"), std::back_inserter(at_top));
    models_at_top_ = at_top.size();
    if (!at_top.empty() && at_top[0]->Attribute("name") != nullptr)
      top_ = std::string(at_top[0]->Attribute("name")) + "::";
    for (const XMLElement* e : models) read_model(*e, 0, false);
    if (world != nullptr) read_world(*world);
    if (models_at_top_ == 1 && top_.size() > 2 && printable(top_))
      description().name = top_.substr(0, top_.size() - 2);
    if (models_at_top_ == 0)
      error(Rule::missing_element, "sdf", "has no <model>; a mechanism needs at least one", sdf.GetLineNum());
    else if (links_.empty() && !has_link_)
      error(Rule::missing_element, "sdf", "has no <link>; a mechanism needs at least one", sdf.GetLineNum());
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
    for (const XMLElement* e : children(parent)) {
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
    read_pose(e, owner, number);
    if (const char* canonical = e.Attribute("canonical_link")) frames_[number].attached_to = canonical;
    if (const char* placement = e.Attribute("placement_frame")) frames_[number].placement = placement;
    read_children(e, number, is_static || child_truth(e, "static", owner), owner);
  }

  void read_frame(const XMLElement& e, int model) {
    const int number = declare(e, Kind::frame, model, "frame");
    if (number == 0) return;
    const std::string owner = element("frame", frames_[number].path);
    inspect(e, owner);
    read_pose(e, owner, number);
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
    read_pose(e, owner, link.frame);
    link.body.inertia = read_inertial(e, owner, is_static);
    const auto differs = [&](const char* message) {
      if (!is_static) note(Severity::warning, Rule::unknown_element, owner, message, e.GetLineNum());
    };
    if (!child_truth(e, "gravity", owner, true)) differs("has no weight in SDFormat; in axode it has one");
    if (child_truth(e, "kinematic", owner)) differs("is kinematic in SDFormat; in axode forces move it");
    for (const XMLElement* shape : children(e)) {
      if (shape->Name() == std::string_view("visual"))
        read_shape(*shape, ShapeDescription::Role::visual, owner, link);
      if (shape->Name() == std::string_view("collision"))
        read_shape(*shape, ShapeDescription::Role::collision, owner, link);
    }
    link_of_frame_.emplace(link.frame, static_cast<int>(links_.size()));
    links_.push_back(std::move(link));
  }

  /// Reads <inertial>. Defaults are 1 kg, 1 kg m² about each axis, and the mass at the link's origin.
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
      error(Rule::wrong_value, owner,
            "the <pose> of <inertial> is relative to the link and must not name another frame",
            e->GetLineNum());
    result.com = frame.X.r;
    result.axes = frame.X.R;
    const auto missing = [&](const char* child, const char* taken) {
      note(Severity::warning, Rule::missing_element, owner,
           std::string("<inertial> has no <") + child + ">; SDFormat takes " + taken, e->GetLineNum());
    };
    if (e->FirstChildElement("mass") == nullptr) missing("mass", "1 kg");
    result.mass = scalar(*e, "mass", owner, 1);
    if (const XMLElement* inertia = child_of(*e, "inertia", owner)) {
      for (const auto& [child, member] : inertia_entries) {
        double& entry = result.Theta.*member;
        if (entry != 0 && inertia->FirstChildElement(child) == nullptr) missing(child, "1 kg m²");
        entry = scalar(*inertia, child, owner, entry);
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

  void read_shape(const XMLElement& e, ShapeDescription::Role role, const std::string& owner, Link& link) {
    inspect(e, owner);
    const Pose given = pose(e, owner);
    ShapeDescription shape{.role = role, .pose = given.X, .color = read_color(e, owner)};
    if (role == ShapeDescription::Role::collision) read_surface(e, owner, shape.contact);
    read_geometry(e, std::move(shape), owner, link.body.shapes);
    link.shape_frames.resize(link.body.shapes.size(), given.relative_to);
  }

  /// Reads the coefficients of friction and restitution of a collision element.
  void read_surface(const XMLElement& e, const std::string& owner, ContactProperties& contact) {
    const XMLElement* surface = child_of(e, "surface", owner);
    if (surface == nullptr) return;
    const XMLElement* friction = child_of(*surface, "friction", owner);
    const XMLElement* ode = friction == nullptr ? nullptr : child_of(*friction, "ode", owner);
    if (ode != nullptr && value(*ode, "mu")) contact.friction = scalar(*ode, "mu", owner, 0);
    if (const XMLElement* bounce = child_of(*surface, "bounce", owner))
      contact.restitution = scalar(*bounce, "restitution_coefficient", owner, 0);
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

  // ---------------------------------------------------------------- joints

  void read_joint(const XMLElement& e, int model, bool is_static) {
    Connection c{.frame = declare(e, Kind::joint, model, "joint"), .is_static = is_static};
    if (c.frame == 0) return;
    c.name = shown(frames_[c.frame].path);
    c.line = e.GetLineNum();
    const std::string owner = "joint \"" + c.name + '"';
    inspect(e, owner);
    read_pose(e, owner, c.frame);
    c.parent = required_text(e, "parent", owner);
    c.child = frames_[c.frame].attached_to = required_text(e, "child", owner);
    c.kind = kind_of(e, owner, sdf_kinds);
    if (c.kind == nullptr) return;
    const bool gearbox = c.kind->type == "gearbox";
    if (gearbox || traits(c.kind->kind).has("axis")) read_axis(e, "axis", owner, c, 0);
    if (gearbox || traits(c.kind->kind).has("second_axis")) read_axis(e, "axis2", owner, c, 1);
    if (traits(c.kind->kind).has("pitch")) c.pitch = read_pitch(e, owner);
    if (gearbox) {
      c.gear_ratio = scalar(e, "gearbox_ratio", owner, 1);
      c.gear_reference = required_text(e, "gearbox_reference_body", owner);
    }
    connections_.push_back(std::move(c));
  }

  /// The pitch of a screw joint in m/rad. It is given by <screw_thread_pitch> (m per turn, right-handed) or,
  /// if this is absent, by <thread_pitch> (rad/m, left-handed). If both are absent, it is 1 m per turn.
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
      const auto bound_of = [&](const char* child, double otherwise) {
        return bound(*limit, child, owner, otherwise, 1e16);
      };
      dof.lower = bound_of("lower", -infinity);
      dof.upper = bound_of("upper", infinity);
      for (const auto& [child, most] :
           {std::pair{"effort", &dof.effort}, std::pair{"velocity", &dof.velocity}}) {
        const double given = bound_of(child, infinity);
        *most = given < 0 ? infinity : given;  // in SDFormat a negative limit means that there is none
      }
    }
    if (c.kind->type == "continuous") {
      dof.lower = -infinity;
      dof.upper = infinity;
    }
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
