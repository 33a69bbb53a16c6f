#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "axode/io.hpp"
#include "axode/io/foreign_terms.hpp"
#include "axode/io/pose.hpp"
#include "axode/io/reading.hpp"
#include "axode/io/toml.hpp"
#include "axode/model/joint_kinds.hpp"
#include "axode/model/loops.hpp"
#include "axode/model/nearest_name.hpp"
#include "axode/model/placement.hpp"
#include "axode/model/shape_kinds.hpp"

namespace axode::io {
namespace {

/// A value as messages show it.
std::string shown(const toml::Value& value) {
  if (const auto* text = value.text()) return in_quotes(*text);
  if (const auto* x = value.number()) return to_text(*x);
  if (const auto* flag = value.flag()) return *flag ? "true" : "false";
  if (const auto* array = value.array()) return "an array of " + std::to_string(array->size());
  return value.table() != nullptr ? "a table" : "a date";
}

/// The faults of one file.
struct Notes {
  std::vector<Fault>& faults;
  std::string file;

  void error(Rule rule, std::string element, std::string message, int line) const {
    faults.push_back({Severity::error, rule, std::move(element), std::move(message), {file, line}});
  }
};

/// One table of a drawing. Each key that the table may have is read once; finish() reports all other keys.
class Table {
 public:
  Table(const Notes& notes, const toml::Value& table, std::string element)
      : notes_(notes), entries_(*table.table()), line_(table.line), element_(std::move(element)) {}

  int line() const { return line_; }
  bool has(std::string_view key) const { return entries_.contains(key); }
  const toml::Value* look(std::string_view key) const {
    const auto found = entries_.find(key);
    return found == entries_.end() ? nullptr : found->second.value;
  }
  void rename(std::string element) { element_ = std::move(element); }
  const std::string& element() const { return element_; }
  /// The number of faults in the file so far.
  std::size_t faults() const { return notes_.faults.size(); }

  const toml::Value* take(std::string_view key) {
    known_.push_back(key);
    return look(key);
  }
  void error(Rule rule, std::string message, const toml::Value* at = nullptr) const {
    notes_.error(rule, element_, std::move(message), at == nullptr ? line() : at->line);
  }
  void wrong(std::string_view key, const toml::Value& value, std::string_view need) const {
    error(Rule::wrong_value, std::string(key) + " is " + shown(value) + "; " + std::string(need), &value);
  }
  void missing(std::string_view key, std::string_view need) const {
    error(Rule::missing_element, "has no " + std::string(key) + "; " + std::string(need));
  }
  /// Reports a key that this table must not have although other tables of its kind have it.
  void refuse(std::string_view key, std::string_view reason) {
    if (const toml::Value* node = take(key))
      error(Rule::unknown_element, std::string(key) + " has no meaning here: " + std::string(reason), node);
  }
  void finish() const {
    for (const auto& [key, entry] : entries_) {
      if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
      std::string nearest = own_term_for(key, known_);
      if (nearest.empty()) nearest = did_you_mean(key, known_, [](std::string_view k) { return k; });
      notes_.error(Rule::unknown_element, element_, "key " + in_quotes(key) + " is not known" + nearest,
                   entry.line);
    }
  }

  std::optional<std::string> text(std::string_view key) {
    const toml::Value* node = take(key);
    if (node == nullptr) return std::nullopt;
    const std::string* value = node->text();
    if (value != nullptr && printable(*value)) return *value;
    wrong(key, *node, value == nullptr ? "it needs a text in quotes" : "it must not hold control characters");
    return std::nullopt;
  }
  /// A name that the table must have; empty, with a fault, if it is missing.
  std::string name(std::string_view key, std::string_view need) {
    const bool given = has(key);
    const auto value = text(key);
    if (!given) missing(key, need);
    if (value && value->empty())
      error(Rule::missing_name, std::string(key) + " is empty; " + std::string(need));
    return value.value_or("");
  }
  template <std::size_t N>
  std::optional<std::size_t> choice(std::string_view key, const std::array<std::string_view, N>& choices) {
    const toml::Value* node = take(key);
    if (node == nullptr) return std::nullopt;
    if (const auto* value = node->text()) {
      const auto found = std::find(choices.begin(), choices.end(), *value);
      if (found != choices.end()) return static_cast<std::size_t>(found - choices.begin());
    }
    std::string list = N == 1 ? "it must be " : "it is one of ";
    for (std::size_t k = 0; k < N; ++k)
      list += (k == 0 ? "" : k + 1 == N ? " or " : ", ") + in_quotes(choices[k]);
    const auto* value = node->text();
    if (value != nullptr && N > 1) {
      const std::string called = own_term_for(*value, choices);
      list += called.empty() ? did_you_mean(*value, choices, [](std::string_view c) { return c; }) : called;
    }
    wrong(key, *node, list);
    return std::nullopt;
  }

  std::optional<double> number(std::string_view key, bool may_be_infinite = false) {
    const toml::Value* node = take(key);
    if (node == nullptr) return std::nullopt;
    const double* x = node->number();
    if (x == nullptr) wrong(key, *node, "it needs a number");
    return x != nullptr && finite(key, *node, *x, may_be_infinite) ? std::optional(*x) : std::nullopt;
  }
  bool flag(std::string_view key) {
    const toml::Value* node = take(key);
    if (node == nullptr) return false;
    if (node->flag() == nullptr) wrong(key, *node, "it needs true or false");
    return node->flag() != nullptr && *node->flag();
  }
  template <std::size_t N>
  std::optional<std::array<double, N>> numbers(std::string_view key, bool may_be_infinite = false) {
    const toml::Value* node = take(key);
    if (node == nullptr) return std::nullopt;
    std::array<double, N> out{};
    const auto* array = node->array();
    bool good = array != nullptr && array->size() == N;
    for (std::size_t k = 0; good && k < N; ++k) {
      const double* x = (*array)[k]->number();
      good = x != nullptr;
      if (good && !finite(key, *(*array)[k], *x, may_be_infinite)) return std::nullopt;
      if (good) out[k] = *x;
    }
    if (good) return out;
    wrong(key, *node, "it needs " + std::to_string(N) + " numbers in brackets");
    return std::nullopt;
  }
  std::optional<Vec3<>> vector(std::string_view key) {
    const auto x = numbers<3>(key);
    return x ? std::optional(Vec3<>{(*x)[0], (*x)[1], (*x)[2]}) : std::nullopt;
  }
  /// Red, green, blue and opacity. The opacity may be left out and is 1 then.
  std::optional<std::array<double, 4>> color(std::string_view key) {
    const toml::Value* node = look(key);
    if (node == nullptr || node->array() == nullptr || node->array()->size() != 3) return numbers<4>(key);
    const auto x = numbers<3>(key);
    return x ? std::optional(std::array<double, 4>{(*x)[0], (*x)[1], (*x)[2], 1}) : std::nullopt;
  }
  /// A direction, given by three numbers or by the name of an axis, such as "-x".
  std::optional<Vec3<>> direction(std::string_view key) {
    const toml::Value* node = look(key);
    if (node == nullptr || node->text() == nullptr) return vector(key);
    constexpr std::array<std::string_view, 6> names{"x", "y", "z", "-x", "-y", "-z"};
    const auto chosen = choice(key, names);
    if (!chosen) return std::nullopt;
    const double sign = *chosen < 3 ? 1 : -1;
    const std::size_t k = *chosen % 3;
    return Vec3<>{k == 0 ? sign : 0, k == 1 ? sign : 0, k == 2 ? sign : 0};
  }
  /// N rows of three numbers.
  template <std::size_t N>
  std::optional<std::array<Vec3<>, N>> rows(std::string_view key, std::string_view need) {
    const toml::Value* node = take(key);
    if (node == nullptr) return std::nullopt;
    std::array<Vec3<>, N> m{};
    const auto* given = node->array();
    bool good = given != nullptr && given->size() == N;
    for (std::size_t i = 0; good && i < N; ++i) {
      const toml::Array* row = (*given)[i]->array();
      good = row != nullptr && row->size() == 3;
      std::array<double, 3> x{};
      for (std::size_t j = 0; good && j < 3; ++j) {
        const double* number = (*row)[j]->number();
        good = number != nullptr;
        if (good && !finite(key, *(*row)[j], *number, false)) return std::nullopt;
        if (good) x[j] = *number;
      }
      m[i] = {x[0], x[1], x[2]};
    }
    if (good) return m;
    wrong(key, *node, need);
    return std::nullopt;
  }
  std::optional<SO3<>> matrix(std::string_view key) {
    const auto m = rows<3>(key, "it needs three rows of three numbers");
    return m ? std::optional(transpose(SO3<>{(*m)[0], (*m)[1], (*m)[2]})) : std::nullopt;
  }
  /// An array of two names.
  std::optional<std::array<std::string, 2>> pair_of_names(std::string_view key, std::string_view need) {
    const toml::Value* node = take(key);
    if (node == nullptr) return std::nullopt;
    const auto* array = node->array();
    std::array<std::string, 2> names;
    bool good = array != nullptr && array->size() == 2;
    for (std::size_t k = 0; good && k < 2; ++k) {
      const std::string* name = (*array)[k]->text();
      good = name != nullptr && printable(*name) && !name->empty();
      if (good) names[k] = *name;
    }
    if (good) return names;
    wrong(key, *node, need);
    return std::nullopt;
  }
  /// All keys of a table, with the number of each.
  std::vector<std::pair<std::string, double>> named_numbers(std::string_view key) {
    std::vector<std::pair<std::string, double>> all;
    auto inner = table(key);
    if (!inner) return all;
    inner->rename(std::string(key) + " of " + element_);
    for (const auto& [name, entry] : inner->entries_) {
      if (!printable(name))
        inner->error(Rule::wrong_value, in_quotes(name) + " must not hold control characters", entry.value);
      if (const auto x = inner->number(name)) all.emplace_back(name, *x);
    }
    return all;
  }
  /// A symmetric tensor, given by Ixx Iyy Izz, by Ixx Iyy Izz Ixy Ixz Iyz, or by the rows of a symmetric
  /// matrix.
  std::optional<Sym3<>> symmetric(std::string_view key) {
    const toml::Value* node = look(key);
    const auto* array = node == nullptr ? nullptr : node->array();
    if (array != nullptr && array->size() == 3 && array->front()->array() != nullptr) {
      const auto A = matrix(key);
      if (!A) return std::nullopt;
      const double largest = std::max({std::abs(A->x.x), std::abs(A->y.y), std::abs(A->z.z)});
      const double skew =
          std::max({std::abs(A->x.y - A->y.x), std::abs(A->x.z - A->z.x), std::abs(A->y.z - A->z.y)});
      if (skew <= 1e-9 * largest) return Sym3<>{A->x.x, A->y.y, A->z.z, A->y.x, A->z.x, A->z.y};
      wrong(key, *node, "its rows must be those of a symmetric matrix");
      return std::nullopt;
    }
    if (array != nullptr && array->size() == 3) {
      const auto d = vector(key);
      return d ? std::optional(Sym3<>{d->x, d->y, d->z, 0, 0, 0}) : std::nullopt;
    }
    if (node != nullptr && (array == nullptr || array->size() != 6)) {
      take(key);
      wrong(key, *node,
            "it needs [Ixx, Iyy, Izz], [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] or three rows of three numbers");
      return std::nullopt;
    }
    const auto t = numbers<6>(key);
    return t ? std::optional(Sym3<>{(*t)[0], (*t)[1], (*t)[2], (*t)[3], (*t)[4], (*t)[5]}) : std::nullopt;
  }

  /// The rotation that `rotation` (rows), `quaternion` (x y z w) or `rpy` gives; the identity if there is
  /// none of them.
  SO3<> rotation() {
    constexpr std::array<std::string_view, 3> ways{"rotation", "quaternion", "rpy"};
    if (std::count_if(ways.begin(), ways.end(), [&](std::string_view way) { return has(way); }) > 1)
      error(Rule::wrong_value, "gives more than one of rotation, quaternion and rpy; one is enough");
    std::optional<SO3<>> R;
    if (const auto rows = matrix("rotation")) {
      R = rows;
      if (!is_rotation(*rows)) {
        error(Rule::not_a_rotation,
              "rotation is not one: RᵀR must be the identity to 1e-6 and the determinant +1",
              look("rotation"));
        R.reset();
      }
    }
    if (const auto x = numbers<4>("quaternion")) {
      R = from_quaternion({(*x)[0], (*x)[1], (*x)[2], (*x)[3]});
      if (!R)
        error(Rule::not_a_rotation, "quaternion is off norm 1 by more than 1e-6; its order is x, y, z, w",
              look("quaternion"));
    }
    if (const auto angles = vector("rpy")) R = from_roll_pitch_yaw(*angles);
    return R.value_or(SO3<>{});
  }
  SE3<> pose() {
    const Vec3<> r = vector("position").value_or(Vec3<>{});
    return {rotation(), r};
  }

  /// A table inside this one.
  std::optional<Table> table(std::string_view key) {
    const toml::Value* node = take(key);
    if (node == nullptr) return std::nullopt;
    if (node->table() != nullptr) return Table(notes_, *node, element_);
    wrong(key, *node, "it needs a table, { key = value, ... }");
    return std::nullopt;
  }
  std::optional<SE3<>> pose(std::string_view key) {
    auto inner = table(key);
    if (!inner) return std::nullopt;
    const SE3<> C = inner->pose();
    inner->finish();
    return C;
  }
  std::optional<std::array<SE3<>, 2>> pair_of_poses(std::string_view key, std::string_view need) {
    const toml::Value* node = take(key);
    if (node == nullptr) return std::nullopt;
    const auto* array = node->array();
    const auto is_table = [](const toml::Value* entry) { return entry->table() != nullptr; };
    if (array == nullptr || array->size() != 2 || !std::ranges::all_of(*array, is_table)) {
      wrong(key, *node, need);
      return std::nullopt;
    }
    std::array<SE3<>, 2> poses;
    for (std::size_t k = 0; k < 2; ++k) {
      Table inner(notes_, *(*array)[k], element_);
      poses[k] = inner.pose();
      inner.finish();
    }
    return poses;
  }
  /// The tables of an array of tables.
  std::vector<Table> tables(std::string_view key, const std::string& need) {
    const toml::Value* node = take(key);
    if (node == nullptr) return {};
    std::vector<Table> all;
    const auto* array = node->array();
    if (array == nullptr) {
      wrong(key, *node, need);
    } else {
      for (const toml::Value* entry : *array) {
        if (entry->table() != nullptr) {
          all.emplace_back(notes_, *entry, element_);
        } else {
          error(Rule::wrong_value, std::string(key) + " holds " + shown(*entry) + "; " + need, entry);
        }
      }
    }
    return all;
  }

 private:
  bool finite(std::string_view key, const toml::Value& at, double x, bool may_be_infinite) const {
    if (std::isfinite(x) || (may_be_infinite && std::isinf(x))) return true;
    error(Rule::non_finite_number, std::string(key) + " holds " + to_text(x) + ", which is not finite", &at);
    return false;
  }

  Notes notes_;
  const toml::Table& entries_;
  int line_;
  std::string element_;
  std::vector<std::string_view> known_;
};

constexpr auto kind_names = [] {
  std::array<std::string_view, joint_kinds.size()> names;
  std::ranges::transform(joint_kinds, names.begin(), &JointTraits::name);
  return names;
}();

/// The ways in which the geometry of a body is given: by A, by B, or by S_prev and S_self.
enum class Way { construction, body, joint };

/// Reads the geometry of a body: A, or B, or S_prev and S_self.
Way read_geometry(Table& table, BodyDescription& body) {
  const bool has_A = table.has("A"), has_B = table.has("B"),
             has_S = table.has("S_prev") || table.has("S_self"), has_frame = table.has("frame");
  if (has_A + has_B + has_S + has_frame > 1)
    table.error(Rule::wrong_value,
                "mixes frame, A, B and S_prev, S_self; a body is placed in one of these ways");
  const SE3<> A = table.pose("A").value_or(SE3<>{}), B = table.pose("B").value_or(SE3<>{});
  const SE3<> S_prev = table.pose("S_prev").value_or(SE3<>{}),
              S_self = table.pose("S_self").value_or(SE3<>{});
  if (has_S) {
    body.geometry = InJointFrames{S_prev, S_self};
    return Way::joint;
  }
  if (has_B) {
    body.geometry = InBodyFrame{B};
    return Way::body;
  }
  body.geometry = InConstructionFrame{A};
  return Way::construction;
}

constexpr std::array<std::string_view, 8> dof_keys{"limits",   "velocity", "effort", "damping",
                                                   "friction", "armature", "spring", "stop"};

/// Reads the table of a spring or of stops, which has the key `stiffness` and one other key.
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

Dof read_dof(Table& table) {
  Dof dof;
  if (const auto limits = table.numbers<2>("limits", true))
    dof.lower = (*limits)[0], dof.upper = (*limits)[1];
  dof.velocity = table.number("velocity", true).value_or(dof.velocity);
  dof.effort = table.number("effort", true).value_or(dof.effort);
  dof.damping = table.number("damping").value_or(0);
  dof.friction = table.number("friction").value_or(0);
  dof.armature = table.number("armature").value_or(0);
  read_elastic(table, "spring", dof.stiffness, "rest", dof.rest);
  read_elastic(table, "stop", dof.stop_stiffness, "damping", dof.stop_damping);
  return dof;
}

/// Reads the limits and losses of a joint. They are next to its axis if it has one degree of freedom, else in
/// `dof`.
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

/// Reads axis, point and pitch of a joint, and reports those that its kind needs or must not have.
void read_screw(Table& table, Way way, JointDescription& joint) {
  const JointKind kind = joint.kind;
  const std::string a_kind = "a " + std::string(to_string(kind)) + " joint";
  const auto axis = [&](std::string_view key, bool needed, Vec3<>& into) {
    if (needed && !table.has(key) && way != Way::joint)
      table.missing(key, a_kind + " needs one, such as [0, 0, 1] or \"z\"");
    into = table.direction(key).value_or(into);
  };
  const bool has_axis = traits(kind).axis, has_point = traits(kind).point;
  if (has_axis) {
    axis("axis", true, joint.axis);
  } else {
    table.refuse("axis", a_kind + " has no axis");
  }
  if (kind == JointKind::universal) {
    axis("second_axis", true, joint.second_axis);
  } else {
    table.refuse("second_axis", a_kind + " has no second axis");
  }
  if (!has_axis && !has_point) {
    table.refuse("point", a_kind + " has no point");
  } else {
    if (has_point && way == Way::construction && !table.has("point"))
      table.missing("point", a_kind + " needs one: [x, y, z] of a point on its axis, or of its centre");
    joint.point = table.vector("point").value_or(Vec3<>{});
  }
  if (kind == JointKind::helical && table.has("pitch") == table.has("lead"))
    table.error(Rule::missing_element, "needs either pitch, m/rad, or lead, m for each turn");
  joint.pitch = table.number("pitch").value_or(0);
  if (kind != JointKind::helical) {
    table.refuse("lead", a_kind + " has no lead");
  } else if (const auto lead = table.number("lead")) {
    joint.pitch = *lead / (2 * std::numbers::pi);
  }
}

/// Reads the keys of a joint whose kind is not known, so that faults in its numbers are reported as well.
void read_of_unknown_kind(Table& table) {
  for (const char* const key : {"axis", "second_axis"}) table.direction(key);
  table.vector("point");
  for (const char* const key : {"pitch", "lead"}) table.number(key);
  read_dof(table);
  table.flag("passive");
  for (const char* const key : {"dof", "follows"}) table.take(key);
}

void read_joint(Table& body_table, Way way, BodyDescription& body) {
  const toml::Value* node = body_table.take("joint");
  if (node == nullptr) {
    body_table.missing("joint",
                       "say how it moves, such as joint = { kind = \"revolute\", ... }, or \"fixed\"");
    return;
  }
  body.joint.source = {body.source.file, node->line};
  if (node->text() != nullptr) {  // a kind without further keys
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
  read_screw(*table, way, body.joint);
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

constexpr std::array<std::string_view, 2> frame_names{"construction", "body"};

std::optional<MassProperties> read_inertia(Table& table, Way way) {
  MassProperties given;
  const bool has_mass = table.has("mass");
  given.in = way == Way::construction ? GivenIn::construction_frame : GivenIn::body_frame;
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
  given.mass = *mass, given.com = *com, given.Theta = *Theta;
  return given;
}

/// Places the frame of a drawn body by the key `frame`, if there is one: at the point of its joint or at its
/// centre of mass, parallel to the construction frame.
void move_frame(Table& table, BodyDescription& body) {
  constexpr std::array<std::string_view, 2> places{"joint", "com"};
  const toml::Value* at = table.look("frame");
  const auto place = table.choice("frame", places);
  auto* drawn = std::get_if<InConstructionFrame>(&body.geometry);
  if (!place || drawn == nullptr) return;
  if (*place == 0) {
    const toml::Value* joint = table.look("joint");
    const bool has_point = joint != nullptr && joint->table() != nullptr && joint->table()->contains("point");
    if (!has_point && !traits(body.joint.kind).point)  // a kind that needs one has its fault already
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

constexpr auto shape_names = [] {
  std::array<std::string_view, shape_kinds.size()> names;
  std::ranges::transform(shape_kinds, names.begin(), &ShapeTraits::name);
  return names;
}();
constexpr std::array<std::string_view, 6> shape_sizes{"size",   "semi_axes", "radius",
                                                      "length", "file",      "scale"};

bool has_key(const ShapeTraits& kind, std::string_view key) {
  if (key == "radius") return kind.radius;
  if (key == "length") return kind.length;
  return key == kind.size || (kind.kind == ShapeKind::mesh && (key == "file" || key == "scale"));
}

/// Reads a shape, or a mesh if `told` gives the kind. The result is empty if the table has faults.
std::optional<ShapeDescription> read_shape(Table& table, const std::string& owner,
                                           std::optional<ShapeKind> told = {}) {
  ShapeDescription shape;
  const std::size_t faults = table.faults();
  table.rename((told ? "mesh of " : "shape of ") + owner);
  shape.name = table.text("name").value_or("");
  constexpr std::array<std::string_view, 2> roles{"visual", "collision"};
  if (table.choice("role", roles) == 1U) shape.role = ShapeDescription::Role::collision;
  if (!told) {
    if (!table.has("kind")) table.missing("kind", "give one, such as \"box\" or \"mesh\"");
    if (const auto kind = table.choice("kind", shape_names)) told = shape_kinds[*kind].kind;
  }
  shape.pose = table.pose();
  shape.color = table.color("color");
  if (told) {
    const ShapeTraits& kind = traits(shape.kind = *told);
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
  } else {  // without a kind, the keys of its size are not known
    for (const std::string_view key : shape_sizes) table.take(key);
  }
  const bool complete = table.faults() == faults;
  table.finish();
  return complete ? std::optional(std::move(shape)) : std::nullopt;
}

void read_shapes(Table& owner, const std::string& element, const std::string& key,
                 std::vector<ShapeDescription>& shapes) {
  for (Table& shape : owner.tables("shape", "write [[" + key + "]] before its keys"))
    if (auto told = read_shape(shape, element)) shapes.push_back(std::move(*told));
}

BodyDescription read_body(Table& table, std::size_t number, const std::string& file) {
  BodyDescription body;
  table.rename("body " + std::to_string(number));
  body.source = {file, table.line()};
  body.name = table.name("name", "every body needs one");
  if (!body.name.empty()) table.rename("body \"" + body.name + '"');
  body.predecessor = table.text("on").value_or("ground");
  const Way way = read_geometry(table, body);
  read_joint(table, way, body);
  body.inertia = read_inertia(table, way);
  move_frame(table, body);
  read_shapes(table, table.element(), "body.shape", body.shapes);
  for (Table& mesh : table.tables("mesh", "write [[body.mesh]] before its keys"))
    if (auto told = read_shape(mesh, table.element(), ShapeKind::mesh))
      body.shapes.push_back(std::move(*told));
  table.finish();
  return body;
}

FrameDescription read_frame(Table& table, std::size_t number, const std::string& file) {
  FrameDescription frame;
  table.rename("frame " + std::to_string(number));
  frame.source = {file, table.line()};
  frame.name = table.name("name", "every frame needs one");
  if (!frame.name.empty()) table.rename("frame \"" + frame.name + '"');
  frame.body = table.name("on", "name the body that carries it, or \"ground\"");
  if (frame.body.empty()) frame.body = "ground";
  frame.in = table.choice("in", frame_names) == 1U ? GivenIn::body_frame : GivenIn::construction_frame;
  frame.pose = table.pose();
  table.finish();
  return frame;
}

SpringDescription read_spring(Table& table, std::size_t number, const std::string& file) {
  SpringDescription spring;
  table.rename("spring " + std::to_string(number));
  spring.source = {file, table.line()};
  const std::string_view need = "it needs the names of two bodies or frames, or \"ground\"";
  if (!table.has("between")) table.missing("between", need);
  spring.between =
      table.pair_of_names("between", need).value_or(std::array<std::string, 2>{"ground", "ground"});
  const bool in_body = table.choice("in", frame_names) == 1U;
  if (const auto points = table.rows<2>("points", "it needs two points, [[x, y, z], [x, y, z]]")) {
    spring.points = *points;
    if (!in_body) spring.in = GivenIn::construction_frame;
  }
  if (!table.has("stiffness") && !table.has("damping"))
    table.missing("stiffness", "a spring needs it, N/m, and a damper needs damping, N s/m");
  spring.stiffness = table.number("stiffness").value_or(0);
  spring.rest = table.number("rest").value_or(0);
  spring.damping = table.number("damping").value_or(0);
  table.finish();
  return spring;
}

constexpr auto loop_names = [] {
  std::array<std::string_view, loop_kinds.size()> names;
  std::ranges::transform(loop_kinds, names.begin(), &LoopTraits::name);
  return names;
}();

/// The keys that say where a loop is drawn. A loop with frames has none of them.
constexpr std::array<std::string_view, 5> drawn_keys{"axis", "second_axis", "point", "points", "center"};
constexpr std::array<std::string_view, 6> size_keys{"pitch",      "lead",   "length",
                                                    "wheel_axis", "radius", "angle"};

/// Whether a key means something for a kind of loop. A lead is another way to write a pitch.
bool has_key(LoopKind kind, std::string_view key) { return traits(kind).has(key == "lead" ? "pitch" : key); }

/// Reads the two bodies or frames that a loop connects. Their names are in `between` or, if they are frames
/// which also say where the loop is, in `frames`.
void read_ends(Table& table, LoopDescription& loop) {
  const toml::Value* frames = table.look("frames");
  const toml::Array* both = frames == nullptr ? nullptr : frames->array();
  const bool named = both != nullptr && !both->empty() && both->front()->text() != nullptr;
  const std::string_view key = named ? "frames" : "between",
                         need = "it needs the names of two bodies or frames, or \"ground\"";
  if (!table.has(key)) table.missing(key, need);
  loop.between = table.pair_of_names(key, need).value_or(loop.between);
  if (named) {
    table.refuse("between", "frames has the names already");
    loop.frames.emplace();
  } else {
    loop.frames = table.pair_of_poses("frames",
                                      "it needs the names of two frames, or, with between, two poses, "
                                      "[{ position = ... }, { position = ... }]");
  }
}

/// Reads where a loop is, and the numbers that belong to its kind.
void read_place(Table& table, LoopDescription& loop) {
  const bool drawn = !table.has("frames");
  const std::string a_kind = "a " + std::string(to_string(loop.kind)) + " loop";
  const auto reads = [&](std::string_view key) {
    const bool by_frames = !drawn && std::ranges::find(drawn_keys, key) != drawn_keys.end();
    return has_key(loop.kind, key) && !by_frames;
  };
  const auto need = [&](std::string_view key, std::string_view what) {
    if (reads(key) && !table.has(key)) table.missing(key, a_kind + " needs " + std::string(what));
  };
  need("axis", "one, such as [0, 0, 1] or \"z\"");
  need("second_axis", "one, such as [0, 0, 1] or \"z\"");
  if (traits(loop.kind).located)
    need("point", "one: [x, y, z] of a point on its axis or plane, or of its centre");
  need("points", "its ends, [[x, y, z], [x, y, z]]");
  need("center", "that of what rolls, [x, y, z]");
  if (reads("pitch") && table.has("pitch") == table.has("lead"))
    table.error(Rule::missing_element, "needs either pitch, m/rad, or lead, m for each turn");

  if (reads("axis")) loop.axis = table.direction("axis").value_or(loop.axis);
  if (reads("second_axis")) loop.second_axis = table.direction("second_axis").value_or(loop.second_axis);
  if (reads("point")) loop.point = table.vector("point").value_or(loop.point);
  if (reads("points"))
    loop.points =
        table.rows<2>("points", "it needs two points, [[x, y, z], [x, y, z]]").value_or(loop.points);
  if (reads("center")) loop.center = table.vector("center").value_or(loop.center);
  if (reads("pitch")) loop.pitch = table.number("pitch").value_or(0);
  if (reads("lead"))
    if (const auto lead = table.number("lead")) loop.pitch = *lead / (2 * std::numbers::pi);
  if (reads("length")) loop.length = table.number("length");
  if (reads("radius")) loop.radius = table.number("radius");
  if (reads("angle")) loop.angle = table.number("angle");
  if (reads("wheel_axis")) loop.wheel_axis = table.direction("wheel_axis");
  if (!drawn && loop.wheel_axis && norm(*loop.wheel_axis - Vec3<>{0, 0, 1}) > 0)
    table.wrong("wheel_axis", *table.look("wheel_axis"),
                "between frames it is \"z\", that of the second frame");
}

void refuse_keys(Table& table, LoopKind kind) {
  const std::string reason = "a " + std::string(to_string(kind)) + " loop has no ";
  for (const std::string_view key : drawn_keys)
    if (!has_key(kind, key)) {
      table.refuse(key, reason + std::string(key));
    } else if (table.has("frames")) {
      table.refuse(key, "frames say where the loop is");
    }
  for (const std::string_view key : size_keys)
    if (!has_key(kind, key)) table.refuse(key, reason + std::string(key));
}

/// Reads a loop. The result is empty if something is missing or wrong, so that no further faults follow from
/// that.
std::optional<LoopDescription> read_loop(Table& table, std::size_t number, const std::string& file) {
  LoopDescription loop;
  loop.name = table.text("name").value_or("");
  loop.source = {file, table.line()};
  table.rename("loop " + in_quotes(loop_name(loop, number)));
  const std::size_t faults = table.faults();
  read_ends(table, loop);
  if (!table.has("kind")) table.missing("kind", "give one, such as \"revolute\" or \"rod\"");
  const auto kind = table.choice("kind", loop_names);
  if (!kind) {  // without a kind, its keys are not known
    for (const std::string_view key : drawn_keys) table.take(key);
    for (const std::string_view key : size_keys) table.take(key);
    table.finish();
    return std::nullopt;
  }
  loop.kind = loop_kinds[*kind].kind;
  read_place(table, loop);
  const bool complete = table.faults() == faults;
  refuse_keys(table, loop.kind);
  table.finish();
  return complete ? std::optional(std::move(loop)) : std::nullopt;
}

/// Reads a coupling. The result is empty if the table has faults.
std::optional<CouplingDescription> read_coupling(Table& table, std::size_t number, const std::string& file) {
  CouplingDescription coupling;
  coupling.name = table.text("name").value_or("");
  coupling.source = {file, table.line()};
  table.rename("coupling " + in_quotes(coupling_name(coupling, number)));
  const std::size_t faults = table.faults();
  if (!table.has("terms"))
    table.missing("terms", "name joints and their factors, such as { left = 1, right = -1 }");
  coupling.terms = table.named_numbers("terms");
  coupling.offset = table.number("offset").value_or(0);
  const bool complete = table.faults() == faults;
  table.finish();
  return complete ? std::optional(std::move(coupling)) : std::nullopt;
}

void read_top(Table& top, Reading& result, const std::string& file) {
  Description& description = result.description;
  constexpr std::array<std::string_view, 1> formats{"axode drawing 1"};
  if (!top.has("format")) top.missing("format", "a drawing begins with format = \"axode drawing 1\"");
  top.choice("format", formats);
  description.name = top.text("name").value_or(description.name);
  description.gravity = top.vector("gravity").value_or(description.gravity);
  std::size_t number = 0;
  for (Table& body : top.tables("body", "write [[body]] before the keys of each body"))
    description.bodies.push_back(read_body(body, ++number, file));
  number = 0;
  for (Table& frame : top.tables("frame", "write [[frame]] before the keys of each frame"))
    description.frames.push_back(read_frame(frame, ++number, file));
  read_shapes(top, "the ground", "shape", description.shapes);
  number = 0;
  for (Table& spring : top.tables("spring", "write [[spring]] before the keys of each spring"))
    description.springs.push_back(read_spring(spring, ++number, file));
  number = 0;
  for (Table& loop : top.tables("loop", "write [[loop]] before the keys of each loop"))
    if (auto told = read_loop(loop, number++, file)) description.loops.push_back(std::move(*told));
  number = 0;
  for (Table& coupling : top.tables("coupling", "write [[coupling]] before the keys of each coupling"))
    if (auto told = read_coupling(coupling, number++, file))
      description.couplings.push_back(std::move(*told));
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
  Notes{result.faults, file}.error(Rule::syntax, "", document.failure->message, document.failure->line);
  return result;
}

Reading read_drawing(const toml::Value& drawing, const std::string& file, Strictness strictness) {
  Reading result;
  result.description.source = {file, 0};
  const Notes notes{result.faults, file};
  Table top(notes, drawing, "drawing");
  read_top(top, result, file);
  if (strictness == Strictness::lenient) forgive(result);
  return result;
}

}  // namespace axode::io

namespace axode {

Description read_drawing_text(std::string_view text, const std::string& file_name, Strictness strictness) {
  return io::accept(io::read_drawing(text, file_name, strictness));
}

}  // namespace axode
