#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "axode/io.hpp"
#include "axode/io/pose.hpp"
#include "axode/io/urdf/urdf_kinds.hpp"
#include "axode/io/xml_reader.hpp"
#include "axode/model/building/nearest_name.hpp"

namespace axode::io {
namespace {

std::span<const Grammar> urdf_grammar() {
  static const std::array<Grammar, 25> all{{
      {"robot", {"name", "version"}, {}, {"link", "joint", "loop_joint", "material"}},
      {"link", {"name"}, {"inertial"}, {"visual", "collision"}},
      {"inertial", {}, {"origin", "mass", "inertia"}},
      {"origin", {"xyz", "rpy", "quat_xyzw"}},
      {"mass", {"value"}},
      {"inertia", {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}},
      {"visual", {"name"}, {"origin", "geometry", "material"}},
      {"collision", {"name"}, {"origin", "geometry", "material"}},
      {"geometry", {}, {"box", "sphere", "cylinder", "capsule", "mesh"}},
      {"box", {"size"}},
      {"sphere", {"radius"}},
      {"cylinder", {"radius", "length"}},
      {"capsule", {"radius", "length"}},
      {"mesh", {"filename", "scale"}},
      {"joint",
       {"name", "type"},
       {"origin", "parent", "child", "axis", "calibration", "dynamics", "limit", "mimic",
        "safety_controller"}},
      {"loop_joint", {"name", "type"}, {"link1", "link2"}},
      {"link1", {"link", "xyz", "rpy", "quat_xyzw"}},
      {"link2", {"link", "xyz", "rpy", "quat_xyzw"}},
      {"parent", {"link"}},
      {"child", {"link"}},
      {"axis", {"xyz"}},
      {"dynamics", {"damping", "friction"}},
      {"limit", {"lower", "upper", "velocity", "effort", "acceleration", "deceleration", "jerk"}},
      {"mimic", {"joint", "multiplier", "offset"}},
      {"safety_controller", {"soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"}},
  }};
  return all;
}

constexpr const char* expand_first = "; this is a xacro file: expand it with xacro first";

class UrdfReader : XmlReader {
 public:
  UrdfReader(std::string_view text, std::string file, Strictness strictness)
      : XmlReader({"URDF", "a URDF", "robot", urdf_grammar(), false}, text, std::move(file), strictness) {
    description().name = "robot";
    description().source = {file_, 0};
  }

  Reading read() {
    tinyxml2::XMLDocument document;
    if (const XMLElement* robot = parse(document); robot != nullptr && !is_xacro(*robot)) {
      read_robot(*robot);
      assemble();
      report_ignored();
      report_massless();
      if (strictness_ == Strictness::lenient) forgive(result());
    }
    return take_result();
  }

 private:
  using Color = std::array<double, 4>;
  struct Link {
    BodyDescription body;
    bool has_parent = false;
  };
  struct Connection {
    std::string name, parent, child;
    SE3<> origin;
    JointDescription joint;
  };

  // ---------------------------------------------------------------- elements and attributes

  /// Whether an attribute has an expression ${...} of the macro language xacro; the first one is reported.
  bool is_xacro(const XMLElement& robot) {
    std::vector<const XMLElement*> open{&robot};
    while (!open.empty()) {
      const XMLElement& e = *open.back();
      open.pop_back();
      if (grammar_of(e.Name()) == nullptr) continue;
      for (const auto* a = e.FirstAttribute(); a != nullptr; a = a->Next()) {
        if (std::string_view(a->Value()).find("${") == std::string_view::npos) continue;
        error(Rule::syntax, "", tag(e) + " " + a->Name() + " is " + in_quotes(a->Value()) + expand_first,
              a->GetLineNum());
        return true;
      }
      for (const XMLElement* child = e.LastChildElement(); child != nullptr;
           child = child->PreviousSiblingElement())
        open.push_back(child);
    }
    return false;
  }

  double required_scalar(const XMLElement& e, const char* attribute, const std::string& owner) {
    return required(e, attribute, owner) == nullptr ? 0 : scalar(e, attribute, owner, 0);
  }

  SE3<> origin(const XMLElement& e, const std::string& owner) {
    const XMLElement* origin = child_of(e, "origin", owner);
    return origin == nullptr ? SE3<>{} : pose(*origin, owner);
  }
  /// The pose in the attributes xyz, and rpy or quat_xyzw, of an element; the identity if there are none.
  SE3<> pose(const XMLElement& e, const std::string& owner) {
    SE3<> pose;
    pose.r = vector(e, "xyz", owner).value_or(Vec3<>{});
    if (e.Attribute("rpy") != nullptr && e.Attribute("quat_xyzw") != nullptr)
      error(Rule::wrong_value, owner, tag(e) + " gives both rpy and quat_xyzw; one is enough",
            e.GetLineNum());
    if (const auto angles = numbers<3>(e, "rpy", owner))
      pose.R = roll_pitch_yaw(*angles, tag(e) + " rpy is", owner, e.GetLineNum());
    if (const auto x = numbers<4>(e, "quat_xyzw", owner)) {
      const auto R = from_quaternion({(*x)[0], (*x)[1], (*x)[2], (*x)[3]});
      if (!R)
        error(Rule::not_a_rotation, owner,
              tag(e) + " quat_xyzw has a norm that differs from 1 by more than 1e-6", e.GetLineNum());
      pose.R = R.value_or(SO3<>{});
    }
    return pose;
  }

  // ---------------------------------------------------------------- links

  void read_robot(const XMLElement& robot) {
    const std::string owner = "robot";
    inspect(robot, owner);
    if (const char* given = required(robot, "name", owner)) {  // the name may be empty
      if (printable(given)) {
        description().name = given;
      } else {
        error(Rule::wrong_value, owner, "its name holds a control character", robot.GetLineNum());
      }
    }
    description().source.line = robot.GetLineNum();
    for (const XMLElement* e : children(robot, "material")) read_material(*e, owner);
    name_what_is_called_ground(robot);
    for (const XMLElement* e : children(robot)) {
      const std::string_view element = e->Name();
      if (element == "link") read_link(*e);
      if (element == "joint") read_joint(*e);
      if (element == "loop_joint") read_loop(*e);
    }
    if (links_.empty() && robot.FirstChildElement("link") == nullptr) {
      const bool is_xacro = is_ignored("<xacro:");
      error(Rule::missing_element, owner,
            std::string("has no <link>; a robot needs at least one") + (is_xacro ? expand_first : ""),
            robot.GetLineNum());
    }
  }

  /// Renames, with a warning, a link `ground` that is the child of a joint: this is the inertial frame here.
  void name_what_is_called_ground(const XMLElement& robot) {
    std::unordered_set<std::string_view> names;
    const XMLElement* called = nullptr;
    for (const XMLElement* e : children(robot, "link"))
      if (const char* given = e->Attribute("name")) {
        names.insert(given);
        if (given == ground_) called = e;
      }
    const auto is_its_child = [&](const XMLElement* joint) {
      const XMLElement* child = joint->FirstChildElement("child");
      const char* given = child == nullptr ? nullptr : child->Attribute("link");
      return given != nullptr && given == ground_;
    };
    if (called == nullptr || std::ranges::none_of(children(robot, "joint"), is_its_child)) return;
    for (int k = 2; names.contains(ground_); ++k) ground_ = "ground_" + std::to_string(k);
    note(Severity::warning, Rule::duplicate_name, "link \"ground\"",
         "is called " + in_quotes(ground_) + " here, where \"ground\" is the inertial frame",
         called->GetLineNum());
  }
  std::string name_of_link(const XMLElement& e, const char* attribute, const std::string& owner) {
    const std::string given = name(e, attribute, owner);
    return given == "ground" ? ground_ : given;
  }

  void read_link(const XMLElement& e) {
    Link link;
    link.body.name = name_of_link(e, "name", "link");
    link.body.source = {file_, e.GetLineNum()};
    const std::string owner = "link \"" + link.body.name + '"';
    inspect(e, owner);
    if (const XMLElement* inertial = child_of(e, "inertial", owner))
      link.body.inertia = read_inertial(*inertial, owner);
    for (const XMLElement* shape : children(e)) {
      if (shape->Name() == std::string_view("visual"))
        read_shape(*shape, ShapeDescription::Role::visual, owner, link.body.shapes);
      if (shape->Name() == std::string_view("collision"))
        read_shape(*shape, ShapeDescription::Role::collision, owner, link.body.shapes);
    }
    if (link.body.name.empty()) return;
    if (!link_index_.emplace(link.body.name, links_.size()).second) {
      error(Rule::duplicate_name, owner, "the name is taken; names of links must differ", e.GetLineNum());
    } else {
      links_.push_back(std::move(link));
    }
  }

  std::optional<MassProperties> read_inertial(const XMLElement& e, const std::string& owner) {
    const std::size_t faults_before = faults().size();
    MassProperties result;
    const SE3<> frame = origin(e, owner);
    result.com = frame.r;
    result.axes = frame.R;
    if (const XMLElement* mass = required_child(e, "mass", owner))
      result.mass = required_scalar(*mass, "value", owner);
    if (const XMLElement* inertia = required_child(e, "inertia", owner)) {
      for (const auto& [attribute, entry] : inertia_entries)
        result.Theta.*entry = required_scalar(*inertia, attribute, owner);
    }
    if (faults().size() != faults_before) return std::nullopt;
    const Sym3<>& I = result.Theta;
    if (result.mass == 0 && norm(Vec3<>{I.xx, I.yy, I.zz}) + norm(Vec3<>{I.xy, I.xz, I.yz}) == 0) {
      massless_line_ = massless_count_++ == 0 ? e.GetLineNum() : massless_line_;
      return std::nullopt;
    }
    return result;
  }

  void read_shape(const XMLElement& e, ShapeDescription::Role role, const std::string& owner,
                  std::vector<ShapeDescription>& shapes) {
    inspect(e, owner);
    ShapeDescription shape{.role = role, .pose = origin(e, owner)};
    if (const XMLElement* material = e.FirstChildElement("material"))
      shape.color = read_material(*material, owner);
    read_geometry(e, std::move(shape), owner, shapes);
  }

  /// The colour of a material, its own or that of an earlier material of the same name.
  std::optional<Color> read_material(const XMLElement& e, const std::string& owner) {
    const char* name = e.Attribute("name");
    if (const XMLElement* color = e.FirstChildElement("color")) {
      const auto rgba = numbers<4>(*color, "rgba", owner, lenient_severity());
      if (rgba && name != nullptr) materials_.emplace(name, *rgba);
      return rgba;
    }
    const auto found = name == nullptr ? materials_.end() : materials_.find(name);
    return found == materials_.end() ? std::nullopt : std::optional(found->second);
  }

  // ---------------------------------------------------------------- joints

  /// Reads a <loop_joint>, an extension of URDF: a joint between frames on two links, about their z-axes.
  void read_loop(const XMLElement& e) {
    const std::size_t faults_before = faults().size();
    LoopDescription loop{.name = name(e, "name", "loop_joint"), .source = {file_, e.GetLineNum()}};
    const std::string owner = "loop \"" + loop.name + '"';
    inspect(e, owner);
    if (const char* type = required(e, "type", owner)) {
      const std::string_view wanted = type == std::string_view("continuous") ? "revolute" : type;
      const auto kind = std::ranges::find(loop_kinds, wanted, &LoopTraits::name);
      if (kind == loop_kinds.end() || !in_urdf(kind->kind)) {
        error(Rule::wrong_value, owner,
              "its type is " + in_quotes(type) +
                  "; it is one of \"fixed\", \"revolute\", \"prismatic\", \"cylindrical\", \"spherical\", "
                  "\"planar\" and \"translational\"",
              e.GetLineNum());
      } else {
        loop.kind = kind->kind;
      }
    }
    loop.frames.emplace();
    for (const std::size_t k : {0, 1}) {
      const XMLElement* end = required_child(e, k == 0 ? "link1" : "link2", owner);
      if (end == nullptr) continue;
      loop.between[k] = name_of_link(*end, "link", owner);
      (*loop.frames)[k] = pose(*end, owner);
    }
    if (faults().size() == faults_before) description().loops.push_back(std::move(loop));
  }

  void read_joint(const XMLElement& e) {
    Connection connection;
    JointDescription& joint = connection.joint;
    joint.name = connection.name = name(e, "name", "joint");
    joint.source = {file_, e.GetLineNum()};
    const std::string owner = "joint \"" + joint.name + '"';
    inspect(e, owner);
    if (const XMLElement* parent = required_child(e, "parent", owner))
      connection.parent = name_of_link(*parent, "link", owner);
    if (const XMLElement* child = required_child(e, "child", owner))
      connection.child = name_of_link(*child, "link", owner);
    connection.origin = origin(e, owner);
    // If the type is unknown, the numbers of the joint are checked nevertheless.
    static constexpr UrdfKind unknown{"", JointKind::revolute};
    const UrdfKind* known = kind_of(e, owner, urdf_kinds);
    const UrdfKind& kind = known == nullptr ? unknown : *known;
    joint.kind = kind.kind;
    read_axis(e, owner, joint);
    read_dof(e, owner, kind, joint);
    if (const XMLElement* mimic = child_of(e, "mimic", owner);
        mimic != nullptr && joint.kind == JointKind::fixed) {
      ignore("<mimic> of a fixed joint", mimic->GetLineNum());
    } else if (mimic != nullptr) {
      Coupling coupling{.leader = name(*mimic, "joint", owner)};
      coupling.ratio = scalar(*mimic, "multiplier", owner, 1);
      coupling.offset = scalar(*mimic, "offset", owner, 0);
      if (!coupling.leader.empty()) joint.coupling = std::move(coupling);
    }
    child_of(e, "safety_controller", owner);
    connections_.push_back(std::move(connection));
  }

  void read_axis(const XMLElement& e, const std::string& owner, JointDescription& joint) {
    Vec3<> axis{1, 0, 0};
    if (const XMLElement* given = child_of(e, "axis", owner);
        given != nullptr && required(*given, "xyz", owner))
      axis = vector(*given, "xyz", owner).value_or(axis);
    if (traits(joint.kind).has("axis")) joint.axis = axis;
  }

  /// Reads losses and limits, those of positions only of revolute and prismatic joints.
  void read_dof(const XMLElement& e, const std::string& owner, const UrdfKind& kind,
                JointDescription& joint) {
    const XMLElement* limit = child_of(e, "limit", owner);
    const XMLElement* dynamics = child_of(e, "dynamics", owner);
    Dof dof;
    if (dynamics != nullptr) {
      dof.damping = scalar(*dynamics, "damping", owner, 0);
      dof.friction = scalar(*dynamics, "friction", owner, 0);
    }
    const bool needs_limits = kind.type == "revolute" || kind.type == "prismatic";
    const auto warn = [&](std::string message, int line) {
      note(Severity::warning, Rule::missing_element, owner, std::move(message), line);
    };
    if (limit != nullptr) {
      constexpr double none = std::numeric_limits<double>::infinity();
      const auto bound_of = [&](const char* attribute, double otherwise) {
        return bound(*limit, attribute, owner, otherwise, std::numeric_limits<double>::max());
      };
      for (const char* attribute : {"velocity", "effort"})
        if (needs_limits && limit->Attribute(attribute) == nullptr)
          warn("<limit> has no " + std::string(attribute) + "; it is taken as unlimited",
               limit->GetLineNum());
      dof.velocity = bound_of("velocity", none);
      dof.effort = bound_of("effort", none);
      if (needs_limits) {
        dof.lower = bound_of("lower", 0);
        dof.upper = bound_of("upper", 0);
        if (limit->Attribute("lower") == nullptr && limit->Attribute("upper") == nullptr)
          warn("<limit> has neither lower nor upper; URDF takes both as 0", limit->GetLineNum());
      }
    } else if (needs_limits) {
      warn("is " + std::string(kind.type) + " and has no <limit>; it is taken as unlimited", e.GetLineNum());
    }
    if (limit != nullptr || dynamics != nullptr)
      joint.dof.assign(static_cast<std::size_t>(traits(kind.kind).dof), dof);
  }

  // ---------------------------------------------------------------- the tree

  std::string nearest(std::string_view link) {
    if (++suggestions_ > most_suggestions) return "";
    return did_you_mean(link, links_, [](const Link& l) { return l.body.name; });
  }

  /// Adds the bodies: first the root links, which are no child of a joint, then in the order of their joints.
  void assemble() {
    std::vector<BodyDescription> children;
    for (Connection& c : connections_) {
      const std::string owner = "joint \"" + c.name + '"';
      const int line = c.joint.source.line;
      if (!c.parent.empty() && !link_index_.contains(c.parent)) {
        error(
            Rule::unknown_predecessor, owner,
            "its parent is link " + in_quotes(c.parent) + ", which is not described" +
                (c.parent == "world" ? "; a URDF describes it by <link name=\"world\"/>" : nearest(c.parent)),
            line);
        c.parent = "ground";
      }
      if (c.child.empty()) continue;
      const auto found = link_index_.find(c.child);
      if (found == link_index_.end()) {
        error(Rule::unknown_predecessor, owner,
              "its child is link " + in_quotes(c.child) + ", which is not described" + nearest(c.child),
              line);
        continue;
      }
      Link& link = links_[found->second];
      if (link.has_parent) {
        error(Rule::two_predecessors, owner,
              "link " + in_quotes(c.child) +
                  " is already the child of another joint; in a tree every link has one parent",
              line);
        continue;
      }
      link.has_parent = true;
      link.body.predecessor = c.parent.empty() ? "ground" : c.parent;
      link.body.joint = std::move(c.joint);
      link.body.geometry = InBodyFrame{c.origin};
      children.push_back(std::move(link.body));
    }
    add_roots();
    for (BodyDescription& body : children) description().bodies.push_back(std::move(body));
  }

  /// Adds the root links, which are no child of a joint and are fixed to the ground; one with the name
  /// `ground` is the ground itself.
  void add_roots() {
    const bool name_is_free = std::none_of(connections_.begin(), connections_.end(),
                                           [&](const Connection& c) { return c.name == "fixed_base"; });
    std::string names;
    int count = 0;
    for (Link& link : links_) {
      if (link.has_parent) continue;
      if (++count <= 5) names += (count > 1 ? ", " : "") + in_quotes(link.body.name);
      if (link.body.name == "ground") {
        if (link.body.inertia)
          note(Severity::warning, Rule::unknown_element, "link \"ground\"",
               "is the inertial frame; its inertial is ignored", link.body.source.line);
        description().shapes = std::move(link.body.shapes);
        continue;
      }
      link.body.joint = {.name = count == 1 && name_is_free ? "fixed_base" : "", .source = link.body.source};
      link.body.geometry = InBodyFrame{};
      description().bodies.push_back(std::move(link.body));
    }
    if (count > 1)
      error(Rule::no_base, "robot",
            "has " + std::to_string(count) + " root links, " + names + (count > 5 ? ", ..." : "") +
                "; a URDF describes one tree",
            description().source.line);
  }

  void report_massless() {
    if (massless_count_ > 0)
      note(lenient_severity(), Rule::mass_not_positive, "<inertial>",
           "says that mass and inertia are 0; a massless link needs no <inertial>" + times(massless_count_),
           massless_line_);
  }

  std::unordered_map<std::string, Color> materials_;
  std::vector<Link> links_;
  std::vector<Connection> connections_;
  std::unordered_map<std::string, std::size_t> link_index_;
  std::string ground_ = "ground";  ///< the name that the link `ground` of the file has in the description
  int massless_count_ = 0, massless_line_ = 0;
  int suggestions_ = 0;
};

}  // namespace

Reading read_urdf(std::string_view text, const std::string& file, Strictness strictness) {
  return UrdfReader(text, file, strictness).read();
}

}  // namespace axode::io

namespace axode {

Description read_urdf_text(std::string_view text, const std::string& file_name, Strictness strictness) {
  return io::accept(io::read_urdf(text, file_name, strictness));
}

}  // namespace axode
