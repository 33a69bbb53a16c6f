#include <algorithm>
#include <array>
#include <numbers>
#include <optional>
#include <utility>

#include "axode/io.hpp"
#include "axode/io/drawing/drawing_contact.hpp"
#include "axode/io/drawing/drawing_drive.hpp"
#include "axode/io/drawing/drawing_loops.hpp"
#include "axode/io/drawing/drawing_motion.hpp"
#include "axode/io/drawing/drawing_springs.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/model/kinds/joint_kinds.hpp"
#include "axode/model/kinds/shape_kinds.hpp"

namespace axode::io {
namespace {

constexpr auto kind_names = names_of(joint_kinds);
constexpr auto shape_names = names_of(shape_kinds);

/// The form in which the geometry of a body is given: A, B, or S_prev and S_self.
enum class GeometryForm { construction, body, joint };

/// Reads the geometry of a body, which is given in one of three ways: by its pose A in the inertial frame, by
/// its pose B in the frame of the predecessor, or by its joint frames S_prev on the predecessor and S_self on
/// itself. Returns the way.
GeometryForm read_geometry(Table& table, BodyDescription& body) {
  const bool has_A = table.has("A"), has_B = table.has("B"), has_frame = table.has("frame");
  const bool has_S = table.has("S_prev") || table.has("S_self");
  if (has_A + has_B + has_S + has_frame > 1)
    table.error(Rule::wrong_value,
                "mixes frame, A, B and S_prev, S_self; a body is placed in one of these ways");
  const SE3<> A = table.pose("A").value_or(SE3<>{}), B = table.pose("B").value_or(SE3<>{});
  const SE3<> S_prev = table.pose("S_prev").value_or(SE3<>{}),
              S_self = table.pose("S_self").value_or(SE3<>{});
  if (has_S) {
    body.geometry = InJointFrames{S_prev, S_self};
    return GeometryForm::joint;
  }
  if (has_B) {
    body.geometry = InBodyFrame{B};
    return GeometryForm::body;
  }
  body.geometry = InConstructionFrame{A};
  return GeometryForm::construction;
}

constexpr std::array<std::string_view, 11> dof_keys{"limits",   "velocity", "effort",     "damping",
                                                    "friction", "armature", "gear_loss",  "gear_loss_back",
                                                    "spring",   "stop",     "restitution"};

/// Reads the table `what` (`spring` or `stop`) of a joint, with numbers `stiffness` and, optionally, `key`.
void read_elastic(Table& table, std::string_view what, double& stiffness, std::string_view key,
                  double& other) {
  auto inner = table.table(what);
  if (!inner) return;
  inner->rename(std::string(what) + " of " + table.element());
  if (!inner->has("stiffness")) inner->missing("stiffness", "give it in N m/rad or N/m");
  stiffness = inner->number("stiffness").value_or(0);
  other = inner->number(key).value_or(0);
  inner->finish();
}

/// Reads the stops of a joint, which are elastic (a table) or hard (the text "hard"), and their restitution.
void read_stops(Table& table, Dof& dof) {
  constexpr std::array<std::string_view, 1> hard{"hard"};
  const toml::Value* stop = table.look("stop");
  if (stop != nullptr && stop->text() != nullptr)
    dof.hard_stops = table.choice("stop", hard).has_value();
  else
    read_elastic(table, "stop", dof.stop_stiffness, "damping", dof.stop_damping);
  dof.restitution = table.number("restitution").value_or(0);
}

Dof read_dof(Table& table) {
  Dof dof;
  if (const auto limits = table.numbers<2>("limits", true)) {
    dof.lower = (*limits)[0];
    dof.upper = (*limits)[1];
  }
  dof.velocity = table.number("velocity", true).value_or(dof.velocity);
  dof.effort = table.number("effort", true).value_or(dof.effort);
  dof.damping = table.number("damping").value_or(0);
  dof.friction = table.number("friction").value_or(0);
  dof.armature = table.number("armature").value_or(0);
  dof.gear_loss = table.number("gear_loss").value_or(0);
  dof.gear_loss_back = table.number("gear_loss_back");
  read_elastic(table, "spring", dof.stiffness, "rest", dof.rest);
  read_stops(table, dof);
  return dof;
}

/// Reads limits, losses, spring and stops of each degree of freedom; several are in the array `dof`.
void read_dofs(Table& table, JointDescription& joint) {
  if (traits(joint.kind).dof == 1) {
    table.refuse("dof", "this joint has one degree of freedom; write limits, velocity, ... beside its axis");
    if (std::any_of(dof_keys.begin(), dof_keys.end(), [&](std::string_view key) { return table.has(key); }))
      joint.dof = {read_dof(table)};
    else
      read_dof(table);
    return;
  }
  for (const std::string_view key : dof_keys)
    table.refuse(key, joint.kind == JointKind::fixed
                          ? "a fixed joint does not move"
                          : "this joint has several degrees of freedom; describe each in dof = [{...}, ...]");
  for (Table& inner :
       table.tables("dof", "it needs one table, { limits = ..., ... }, for each degree of freedom")) {
    joint.dof.push_back(read_dof(inner));
    inner.finish();
  }
}

/// Reads axes, point and pitch of a joint, and reports those that are missing or that its kind does not have.
void read_screw(Table& table, GeometryForm form, JointDescription& joint) {
  const JointKind kind = joint.kind;
  const std::string a_kind = "a " + std::string(to_string(kind)) + " joint";
  const auto axis = [&](std::string_view key, bool needed, Vec3<>& into) {
    if (needed && !table.has(key) && form != GeometryForm::joint)
      table.missing(key, a_kind + " needs one, such as [0, 0, 1] or \"z\"");
    into = table.direction(key).value_or(into);
  };
  const bool has_axis = traits(kind).has("axis"), has_point = traits(kind).has("point");
  if (has_axis) {
    axis("axis", true, joint.axis);
  } else {
    table.refuse("axis", a_kind + " has no axis");
  }
  if (traits(kind).has("second_axis")) {
    axis("second_axis", true, joint.second_axis);
  } else {
    table.refuse("second_axis", a_kind + " has no second axis");
  }
  if (!has_axis && !has_point) {
    table.refuse("point", a_kind + " has no point");
  } else {
    if (has_point && form == GeometryForm::construction && !table.has("point"))
      table.missing("point", a_kind + " needs one: [x, y, z] of a point on its axis, or of its centre");
    joint.point = table.vector("point").value_or(Vec3<>{});
  }
  if (traits(kind).has("pitch") && table.has("pitch") == table.has("lead"))
    table.error(Rule::missing_element, "needs either pitch, m/rad, or lead, m for each turn");
  joint.pitch = table.number("pitch").value_or(0);
  if (!traits(kind).has("pitch")) {
    table.refuse("lead", a_kind + " has no lead");
  } else if (const auto lead = table.number("lead")) {
    joint.pitch = *lead / (2 * std::numbers::pi);
  }
}

/// Reads a joint whose kind is missing or unknown, so that faults in its numbers are reported as well.
void read_of_unknown_kind(Table& table) {
  for (const char* const key : {"axis", "second_axis"}) table.direction(key);
  table.vector("point");
  for (const char* const key : {"pitch", "lead"}) table.number(key);
  read_dof(table);
  table.flag("passive");
  for (const char* const key : {"dof", "follows"}) table.take(key);
}

void read_joint(Table& body_table, GeometryForm form, BodyDescription& body) {
  const toml::Value* node = body_table.take("joint");
  if (node == nullptr) {
    body_table.missing("joint",
                       "say how it moves, such as joint = { kind = \"revolute\", ... }, or \"fixed\"");
    return;
  }
  body.joint.source = {body.source.file, node->line};
  if (node->text() != nullptr) {  // the joint is the name of a kind, without further keys
    constexpr std::array<std::string_view, 2> plain{"fixed", "free"};
    if (const auto kind = body_table.choice("joint", plain))
      body.joint.kind = *kind == 0 ? JointKind::fixed : JointKind::free;
    return;
  }
  auto table = body_table.table("joint");
  if (!table) return;
  body.joint.name = table->text("name").value_or("");
  table->rename("joint \"" + (body.joint.name.empty() ? body.name + "_joint" : body.joint.name) + '"');
  const bool given = table->has("kind");
  const auto kind = table->choice("kind", kind_names);
  if (!given) table->missing("kind", "give one, such as \"revolute\" or \"prismatic\"");
  if (!kind) {
    read_of_unknown_kind(*table);
    table->finish();
    return;
  }
  body.joint.kind = joint_kinds[*kind].kind;
  table->refuse("motion", "a table [[motion]] with of = " +
                              in_quotes(body.joint.name.empty() ? body.name + "_joint" : body.joint.name) +
                              " prescribes how the joint moves");
  read_screw(*table, form, body.joint);
  read_dofs(*table, body.joint);
  if (body.joint.kind == JointKind::fixed) {
    table->refuse("passive", "a fixed joint does not move");
  } else {
    const bool said = table->has("passive"), passive = table->flag("passive");
    if (said) body.joint.passive = passive;
  }
  if (auto follows = table->table("follows")) {
    Coupling coupling{.leader = follows->name("joint", "name the joint that leads")};
    coupling.ratio = follows->number("ratio").value_or(1);
    coupling.offset = follows->number("offset").value_or(0);
    follows->finish();
    if (!coupling.leader.empty()) body.joint.coupling = std::move(coupling);
  }
  table->finish();
}

std::optional<MassProperties> read_inertia(Table& table, GeometryForm form) {
  MassProperties given;
  const bool has_mass = table.has("mass");
  given.in = form == GeometryForm::construction ? GivenIn::construction_frame : GivenIn::body_frame;
  if (const auto in = table.choice("inertia_in", frame_names))
    given.in = *in == 0 ? GivenIn::construction_frame : GivenIn::body_frame;
  constexpr std::array<std::string_view, 2> points{"com", "origin"};
  if (const auto about = table.choice("inertia_about", points))
    given.about = *about == 0 ? InertiaAbout::center_of_mass : InertiaAbout::frame_origin;
  if (auto axes = table.table("inertia_axes")) {
    given.axes = axes->rotation();
    axes->finish();
  }
  for (const std::string_view key : {"com", "inertia"}) {
    if (has_mass && !table.has(key))
      table.missing(key, "a body with a mass needs com and inertia; that of a point mass is [0, 0, 0]");
    if (!has_mass && table.has(key))
      table.error(Rule::missing_element,
                  "has " + std::string(key) + " but no mass; a massless body has neither", table.take(key));
  }
  const auto mass = table.number("mass");
  const auto com = table.vector("com");
  const auto Theta = table.symmetric("inertia");
  if (!mass || !com || !Theta) return std::nullopt;
  given.mass = *mass;
  given.com = *com;
  given.Theta = *Theta;
  return given;
}

/// Reads the key `frame`, which is allowed for a body that is given in the inertial frame at q = 0. It moves
/// the origin of the body frame to the point of the joint or to the centre of mass.
void move_frame(Table& table, BodyDescription& body) {
  constexpr std::array<std::string_view, 2> places{"joint", "com"};
  const toml::Value* at = table.look("frame");
  const auto place = table.choice("frame", places);
  auto* drawn = std::get_if<InConstructionFrame>(&body.geometry);
  if (!place || drawn == nullptr) return;
  if (*place == 0) {
    const toml::Value* joint = table.look("joint");
    const bool has_point = joint != nullptr && joint->table() != nullptr && joint->table()->contains("point");
    // If the kind needs a point, its absence has been reported already.
    if (!has_point && !traits(body.joint.kind).has("point"))
      table.error(
          Rule::wrong_value,
          "frame is \"joint\", and its " + std::string(to_string(body.joint.kind)) + " joint has no point",
          at);
    drawn->A = {{}, body.joint.point};
  } else {
    if (!body.inertia || body.inertia->in != GivenIn::construction_frame) {
      table.error(Rule::wrong_value, "frame is \"com\"; it needs mass and com, in the construction frame",
                  at);
      return;
    }
    drawn->A = {{}, body.inertia->com};
  }
}

constexpr std::array<std::string_view, 6> shape_sizes{"size",   "semi_axes", "radius",
                                                      "length", "file",      "scale"};

bool has_key(const ShapeTraits& kind, std::string_view key) {
  if (key == "radius") return kind.radius;
  if (key == "length") return kind.length;
  return key == kind.size || (kind.kind == ShapeKind::mesh && (key == "file" || key == "scale"));
}

/// Reads a table of a shape, whose kind is `given_kind` or that of its key `kind`. Empty if it has faults.
std::optional<ShapeDescription> read_shape(Table& table, const std::string& owner,
                                           std::optional<ShapeKind> given_kind = {}) {
  ShapeDescription shape;
  const std::size_t faults = table.faults();
  table.rename((given_kind ? "mesh of " : "shape of ") + owner);
  shape.name = table.text("name").value_or("");
  constexpr std::array<std::string_view, 2> roles{"visual", "collision"};
  if (table.choice("role", roles) == 1U) shape.role = ShapeDescription::Role::collision;
  if (!given_kind) {
    if (!table.has("kind")) table.missing("kind", "give one, such as \"box\" or \"mesh\"");
    if (const auto kind = table.choice("kind", shape_names)) given_kind = shape_kinds[*kind].kind;
  }
  shape.pose = table.pose();
  shape.color = table.color("color");
  read_surface(table, shape);
  if (given_kind) {
    const ShapeTraits& kind = traits(shape.kind = *given_kind);
    const std::string a_kind = "a " + std::string(kind.name);
    for (const std::string_view key : shape_sizes) {
      if (!has_key(kind, key)) {
        table.refuse(key, a_kind + " has none");
      } else if (key != "scale" && key != "file" && !table.has(key)) {
        table.missing(key, a_kind + " needs one, in m");
      }
    }
    if (!kind.size.empty()) shape.size = table.vector(kind.size).value_or(shape.size);
    if (kind.radius) shape.radius = table.number("radius").value_or(0);
    if (kind.length) shape.length = table.number("length").value_or(0);
    if (kind.kind == ShapeKind::mesh) {
      shape.file = table.name("file", "name the file of the mesh");
      shape.scale = table.vector("scale").value_or(shape.scale);
    }
  } else {  // if the kind is not known, the keys of its size are not known either
    for (const std::string_view key : shape_sizes) table.take(key);
  }
  const bool complete = table.faults() == faults;
  table.finish();
  return complete ? std::optional(std::move(shape)) : std::nullopt;
}

void read_shapes(Table& owner, const std::string& element, const std::string& key,
                 std::vector<ShapeDescription>& shapes) {
  for (Table& shape : owner.tables("shape", "write [[" + key + "]] before its keys"))
    if (auto read = read_shape(shape, element)) shapes.push_back(std::move(*read));
}

/// Reads the name of a body or frame, by which, or else by its `number`, faults in its table are reported.
std::string read_name(Table& table, const std::string& kind, std::size_t number) {
  table.rename(kind + " " + std::to_string(number + 1));
  std::string name = table.name("name", "every " + kind + " needs one");
  if (!name.empty()) table.rename(kind + " \"" + name + '"');
  return name;
}

bool read_body(Table& table, std::size_t number, BodyDescription& body) {
  body.name = read_name(table, "body", number);
  body.predecessor = table.text("on").value_or("ground");
  const GeometryForm form = read_geometry(table, body);
  read_joint(table, form, body);
  body.inertia = read_inertia(table, form);
  move_frame(table, body);
  read_shapes(table, table.element(), "body.shape", body.shapes);
  for (Table& mesh : table.tables("mesh", "write [[body.mesh]] before its keys"))
    if (auto read = read_shape(mesh, table.element(), ShapeKind::mesh))
      body.shapes.push_back(std::move(*read));
  table.finish();
  return true;
}

bool read_frame(Table& table, std::size_t number, FrameDescription& frame) {
  frame.name = read_name(table, "frame", number);
  frame.body = table.name("on", "name the body that carries it, or \"ground\"");
  if (frame.body.empty()) frame.body = "ground";
  frame.in = table.choice("in", frame_names) == 1U ? GivenIn::body_frame : GivenIn::construction_frame;
  frame.pose = table.pose();
  table.finish();
  return true;
}

/// Reads the array of tables with the given key in the table `top` of the file. read(table, number, item)
/// fills `item` from the table with the index `number` (from 0) in the array, and returns whether the item is
/// complete. Items that are not complete are left out.
template <class Item, class Read>
void read_all(Table& top, std::string_view key, const Read& read, std::vector<Item>& items) {
  std::size_t number = 0;
  const std::string name(key), rule = "write [[" + name + "]] before the keys of each " + name;
  for (Table& table : top.tables(key, rule)) {
    Item item;
    item.source = {table.file(), table.line()};
    if (read(table, number++, item)) items.push_back(std::move(item));
  }
}

void read_top(Table& top, Description& description) {
  constexpr std::array<std::string_view, 1> formats{"axode drawing 1"};
  if (!top.has("format")) top.missing("format", "a drawing begins with format = \"axode drawing 1\"");
  top.choice("format", formats);
  description.name = top.text("name").value_or(description.name);
  description.gravity = top.vector("gravity").value_or(description.gravity);
  read_all(top, "body", read_body, description.bodies);
  read_all(top, "frame", read_frame, description.frames);
  read_shapes(top, "the ground", "shape", description.shapes);
  read_all(top, "spring", read_spring, description.springs);
  read_all(top, "loop", read_loop, description.loops);
  read_all(top, "coupling", read_coupling, description.couplings);
  read_all(top, "motion", read_motion, description.motions);
  read_all(top, "drive", read_drive, description.drives);
  read_state(top, description.state);
  read_contact(top, description);
  top.finish();
}

}  // namespace

Reading read_drawing(std::string_view text, const std::string& file, Strictness strictness) {
  Reading result;
  result.description.source = {file, 0};
  if (auto fault = not_text(text, file)) {
    result.faults.push_back(std::move(*fault));
    return result;
  }
  const toml::Document document = toml::parse(text);
  if (!document.failure) return read_drawing(document.root(), file, strictness);
  Notes{result.faults, file, strictness}.error(Rule::syntax, "", document.failure->message,
                                               document.failure->line);
  return result;
}

Reading read_drawing(const toml::Value& drawing, const std::string& file, Strictness strictness) {
  Reading result;
  result.description.source = {file, 0};
  const Notes notes{result.faults, file, strictness};
  Table top(notes, drawing, "drawing");
  read_top(top, result.description);
  if (strictness == Strictness::lenient) forgive(result);
  return result;
}

}  // namespace axode::io

namespace axode {

Description read_drawing_text(std::string_view text, const std::string& file_name, Strictness strictness) {
  return io::accept(io::read_drawing(text, file_name, strictness));
}

}  // namespace axode
