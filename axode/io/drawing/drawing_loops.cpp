#include "axode/io/drawing/drawing_loops.hpp"

#include <numbers>

#include "axode/model/building/placement.hpp"
#include "axode/model/loops.hpp"

namespace axode::io {
namespace {

constexpr auto loop_names = names_of(loop_kinds);

/// The keys that say where a loop is drawn. A loop that is given by `frames` must have none of them.
constexpr std::array<std::string_view, 5> drawn_keys{"axis", "second_axis", "point", "points", "center"};
constexpr std::array<std::string_view, 7> size_keys{"pitch",      "lead",   "length", "radii",
                                                    "wheel_axis", "radius", "angle"};

/// Whether a kind of loop has a key. `lead` is another way to give a pitch.
bool has_key(LoopKind kind, std::string_view key) { return traits(kind).has(key == "lead" ? "pitch" : key); }

/// Reads which two bodies or named frames a loop joint connects, from its table in a TOML file. The key
/// `between` has their names. If the joint frames of the loop joint are two named frames, the key `frames`
/// has their names instead. In addition to `between`, the key `frames` can have the poses of the joint frames
/// in the two frames that `between` names.
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

/// Reads the position of a loop joint, and numbers such as its pitch, length or radii; reports missing ones.
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
  need("points", traits(loop.kind).has("radii") ? "the centres of its pulleys, [[x, y, z], [x, y, z]]"
                                                : "its ends, [[x, y, z], [x, y, z]]");
  need("radii", "the radii of its pulleys, m, negative where a pulley turns the other way about the axis");
  need("center", "the centre of the rolling body, [x, y, z]");
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
  if (reads("radii")) loop.radii = table.numbers<2>("radii").value_or(loop.radii);
  if (reads("angle")) loop.angle = table.number("angle");
  if (reads("wheel_axis")) loop.wheel_axis = table.direction("wheel_axis");
  if (!drawn && loop.wheel_axis && norm(*loop.wheel_axis - Vec3<>{0, 0, 1}) > 0)
    table.wrong("wheel_axis", *table.look("wheel_axis"),
                "between frames it is \"z\", the z-axis of the second frame");
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

}  // namespace

bool read_loop(Table& table, std::size_t number, LoopDescription& loop) {
  loop.name = table.text("name").value_or("");
  table.rename("loop " + in_quotes(loop_name(loop, number)));
  const std::size_t faults = table.faults();
  read_ends(table, loop);
  if (!table.has("kind")) table.missing("kind", "give one, such as \"revolute\" or \"rod\"");
  const auto kind = table.choice("kind", loop_names);
  if (!kind) {  // if the kind is not known, the keys of the loop are not known either
    for (const std::string_view key : drawn_keys) table.take(key);
    for (const std::string_view key : size_keys) table.take(key);
    table.finish();
    return false;
  }
  loop.kind = loop_kinds[*kind].kind;
  read_place(table, loop);
  const bool complete = table.faults() == faults;
  refuse_keys(table, loop.kind);
  table.finish();
  return complete;
}

bool read_coupling(Table& table, std::size_t number, CouplingDescription& coupling) {
  coupling.name = table.text("name").value_or("");
  table.rename("coupling " + in_quotes(coupling_name(coupling, number)));
  const std::size_t faults = table.faults();
  if (!table.has("terms"))
    table.missing("terms", "name joints and their factors, such as { left = 1, right = -1 }");
  coupling.terms = table.named_numbers("terms");
  coupling.offset = table.number("offset").value_or(0);
  coupling.play = table.number("play").value_or(0);
  coupling.restitution = table.number("restitution").value_or(0);
  const bool complete = table.faults() == faults;
  table.finish();
  return complete;
}

}  // namespace axode::io
