#include "axode/io/drawing/drawing_springs.hpp"

#include <algorithm>
#include <array>

#include "axode/model/building/placement.hpp"

namespace axode::io {
namespace {

constexpr auto spring_names = names_of(spring_kinds);
constexpr std::array<std::string_view, 2> sides{"tension", "compression"};
constexpr std::array<std::string_view, 3> law_names{"polynomial", "table", "gas"};

/// Keys of a table [[spring]]: place_keys say where the spring acts, law_keys describe its force law.
constexpr std::array<std::string_view, 9> place_keys{"between", "points", "path", "axis",     "frames",
                                                     "in",      "terms",  "pose", "rest_pose"};
constexpr std::array<std::string_view, 4> law_keys{"law", "rest", "preload", "one_sided"};

void read_between(Table& table, SpringDescription& spring) {
  const std::string_view need = "it needs the names of two bodies or frames, or \"ground\"";
  if (!table.has("between")) table.missing("between", need);
  spring.between =
      table.pair_of_names("between", need).value_or(std::array<std::string, 2>{"ground", "ground"});
}

void read_points(Table& table, SpringDescription& spring) {
  read_between(table, spring);
  const bool in_body = table.choice("in", frame_names) == 1U;
  if (const auto points = table.rows<2>("points", "it needs two points, [[x, y, z], [x, y, z]]")) {
    spring.points = *points;
    if (!in_body) spring.in = GivenIn::construction_frame;
  }
}

void read_path(Table& table, SpringDescription& spring) {
  const std::string need = "it needs points, [{ on = \"ground\", point = [x, y, z] }, ...]";
  if (!table.has("path")) table.missing("path", need);
  const bool in_body = table.choice("in", frame_names) == 1U;
  spring.in = in_body ? GivenIn::body_frame : GivenIn::construction_frame;
  std::size_t number = 0;
  for (Table& inner : table.tables("path", need)) {
    inner.rename("point " + std::to_string(++number) + " of " + table.element());
    SpringDescription::Point it{.on = inner.name("on", "name the body that carries it, or \"ground\"")};
    if (it.on.empty()) it.on = "ground";
    if (!inner.has("point")) inner.missing("point", "give [x, y, z] in m");
    it.point = inner.vector("point").value_or(Vec3<>{});
    inner.finish();
    spring.path.push_back(std::move(it));
  }
}

/// Reads the two frames of a torsion spring or bushing. If the frames coincide at q = 0, they are given in
/// the inertial frame by one key, whose name is in `drawn_by`: `axis` for a torsion spring, `pose` for a
/// bushing. Otherwise the key `frames` gives one frame on each body.
void read_frames(Table& table, SpringDescription& spring, std::string_view drawn_by) {
  read_between(table, spring);
  const bool given = table.has("frames");
  if (given == table.has(drawn_by))
    table.error(
        given ? Rule::wrong_value : Rule::missing_element,
        "needs either " + std::string(drawn_by) +
            ", where it is drawn, or frames, [{ position = ... }, { position = ... }], on its bodies");
  const auto in = table.choice("in", frame_names);
  spring.in = given && in != 0U ? GivenIn::body_frame : GivenIn::construction_frame;
  if (given) {
    spring.frames =
        table.pair_of_poses("frames", "it needs two poses, [{ position = ... }, { position = ... }]")
            .value_or(spring.frames);
  } else if (in == 1U) {
    table.error(Rule::wrong_value,
                "in is \"body\"; " + std::string(drawn_by) + " is drawn in the construction frame",
                table.look("in"));
  }
  if (drawn_by == "axis") {
    const auto axis = table.direction("axis");
    if (!given && axis && norm(*axis) > 0)
      spring.frames.fill(orthonormal(SE3<>{rotation_to(direction(*axis)), {}}));
    else if (!given && axis)
      table.error(Rule::zero_axis, "an axis is (0, 0, 0); an axis needs a direction", table.look("axis"));
  } else if (const auto pose = table.pose("pose"); pose && !given) {
    spring.frames.fill(*pose);
  }
}

void read_terms(Table& table, SpringDescription& spring) {
  if (!table.has("terms")) table.missing("terms", "name joints and their factors, such as { knee = 1 }");
  spring.terms = table.named_numbers("terms");
}

/// Reads a 6×6 matrix: the six numbers of its diagonal or six rows of six numbers.
void read_matrix(Table& table, std::string_view key, SixBySix& A) {
  const toml::Value* node = table.take(key);
  if (node == nullptr) return;
  const auto all_numbers = [](const toml::Array& array) {
    return array.size() == 6 &&
           std::ranges::all_of(array, [](const toml::Value* x) { return x->number() != nullptr; });
  };
  const auto is_row = [&](const toml::Value* x) { return x->array() != nullptr && all_numbers(*x->array()); };
  const toml::Array* given = node->array();
  if (given != nullptr && all_numbers(*given)) {
    for (std::size_t k = 0; k < 6; ++k) A[k][k] = *(*given)[k]->number();
  } else if (given != nullptr && given->size() == 6 && std::ranges::all_of(*given, is_row)) {
    for (std::size_t k = 0; k < 6; ++k)
      for (std::size_t l = 0; l < 6; ++l) A[k][l] = *(*(*given)[k]->array())[l]->number();
  } else {
    table.wrong(key, *node,
                "it needs six numbers, of turns about x, y, z and shifts along them, or six rows of six");
  }
}

std::optional<ForceCurve> read_law(Table& table) {
  if (!table.has("kind")) table.missing("kind", "give one, such as \"table\" or \"gas\"");
  const auto kind = table.choice("kind", law_names);
  if (!kind) return std::nullopt;  // without a kind, its keys are not known
  std::optional<ForceCurve> curve;
  if (*kind == 0) {
    curve = PolynomialCurve{
        table.needed_list("coefficients", "it needs those of 1, x, x^2, ... of the deflection in brackets")};
  } else if (*kind == 1) {
    TableCurve points;
    points.deflections = table.needed_list("deflections", "it needs deflections in brackets, m or rad");
    points.forces = table.needed_list("forces", "it needs a force for each deflection, N or N m");
    curve = std::move(points);
  } else {
    GasCurve gas;
    gas.area = table.needed_number("area", "m^2");
    gas.pressure = table.needed_number("pressure", "Pa");
    gas.volume = table.needed_number("volume", "m^3");
    gas.exponent =
        table.needed_number("exponent", "numbers: 1 at constant temperature, 1.4 without exchange of heat");
    gas.ambient = table.number("ambient").value_or(gas.ambient);
    curve = gas;
  }
  table.finish();
  return curve;
}

void read_force(Table& table, SpringDescription& spring) {
  const SpringTraits& kind = traits(spring.kind);
  spring.damping = table.number("damping").value_or(0);
  spring.rest = table.number("rest").value_or(0);
  if (table.has("preload")) spring.preload = table.number("preload");
  if (const auto side = table.choice("one_sided", sides))
    spring.acts = *side == 0 ? Acts::in_tension : Acts::in_compression;
  const bool has_law = table.has("law");
  if (auto law = table.table("law")) {
    law->rename("law of " + table.element());
    spring.curve = read_law(*law);
    const bool gas = spring.curve && std::holds_alternative<GasCurve>(*spring.curve);
    if (gas && !table.has("rest") && !spring.preload)
      table.missing("rest", "a gas needs it: the length or angle at which it has its pressure and volume");
  }
  if (has_law)
    return table.refuse("stiffness", "the spring has a law, which gives its force; remove stiffness or law");
  if (!table.has("stiffness") && !table.has("damping"))
    table.missing("stiffness", "a spring needs it, " + std::string(kind.stiffness) +
                                   ", and a damper needs damping, " + std::string(kind.damping));
  spring.stiffness = table.number("stiffness").value_or(0);
}

void read_place(Table& table, SpringDescription& spring) {
  switch (spring.kind) {
    case SpringKind::line: return read_points(table, spring);
    case SpringKind::tendon: return read_path(table, spring);
    case SpringKind::torsion: return read_frames(table, spring, "axis");
    case SpringKind::joints: return read_terms(table, spring);
    case SpringKind::bushing: return read_frames(table, spring, "pose");
  }
}

}  // namespace

bool read_spring(Table& table, std::size_t number, SpringDescription& spring) {
  spring.name = table.text("name").value_or("");
  table.rename(spring_element(spring, number));
  const std::size_t faults = table.faults();
  const bool given = table.has("kind");
  const auto kind = table.choice("kind", spring_names);
  if (given && !kind) {  // if the kind is not known, the keys of the spring are not known either
    for (const std::string_view key : place_keys) table.take(key);
    for (const std::string_view key : law_keys) table.take(key);
    for (const std::string_view key : {"stiffness", "damping"}) table.take(key);
    table.finish();
    return false;
  }
  if (kind) spring.kind = spring_kinds[*kind].kind;
  const auto refuse = [&](std::string_view key) {
    table.refuse(
        key, "a spring of kind \"" + std::string(to_string(spring.kind)) + "\" has no " + std::string(key));
  };
  for (const std::string_view key : place_keys)
    if (!traits(spring.kind).has(key)) refuse(key);
  read_place(table, spring);
  if (spring.kind == SpringKind::bushing) {
    for (const std::string_view key : law_keys) refuse(key);
    if (!table.has("stiffness") && !table.has("damping"))
      table.missing("stiffness", "give six numbers or six rows of six, N m/rad before N/m");
    spring.rest_pose = table.pose("rest_pose").value_or(SE3<>{});
    read_matrix(table, "stiffness", spring.K);
    read_matrix(table, "damping", spring.C);
  } else {
    read_force(table, spring);
  }
  const bool complete = table.faults() == faults;
  table.finish();
  return complete || spring.kind == SpringKind::line;
}

}  // namespace axode::io
