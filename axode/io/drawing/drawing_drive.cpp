#include "axode/io/drawing/drawing_drive.hpp"

#include <array>
#include <cmath>

#include "axode/io/drawing/drawing_motion.hpp"
#include "axode/model/kinds/drive_kinds.hpp"

namespace axode::io {
namespace {

constexpr std::array<std::string_view, 2> anti_windups{"back_calculation", "conditional"};

void read_port(Table& table, DriveDescription& drive) {
  if (table.has("between")) {
    table.refuse("joint", "the drive acts along the line between two points");
    table.refuse("joints", "the drive acts along the line between two points");
    const std::string_view need = "it needs the names of two bodies or frames, or \"ground\"";
    drive.line = DriveDescription::Line{};
    drive.line->between =
        table.pair_of_names("between", need).value_or(std::array<std::string, 2>{"ground", "ground"});
    const bool in_body = table.choice("in", frame_names) == 1U;
    if (const auto points = table.rows<2>("points", "it needs two points, [[x, y, z], [x, y, z]]")) {
      drive.line->points = *points;
      if (!in_body) drive.line->in = GivenIn::construction_frame;
    }
    return;
  }
  if (table.has("joints")) {
    table.refuse("joint", "joints has the joints on which the drive acts");
    drive.joints = table.named_numbers("joints");
    return;
  }
  const std::string joint = table.name("joint", "name the joint on which it acts, or give joints or between");
  drive.joints = {{joint, 1.0}};
}

void read_steps(Table& table, DriveInput& input) {
  for (const auto& [key, numbers] : {std::pair{"times", &input.times}, {"values", &input.values}}) {
    const std::string_view need = "steps need times (s), and the values from these on, in brackets";
    if (!table.has(key)) table.missing(key, need);
    *numbers = table.list(key, need).value_or(std::vector<double>{});
  }
}

void read_input(Table& table, DriveInput& input) {
  const toml::Value* node = table.look("input");
  if (node == nullptr || node->number() != nullptr) {
    if (const auto x = table.number("input")) input.values = {*x};
  } else if (node->text() != nullptr) {
    input.from = table.name("input", "name the drive whose output it is");
  } else if (node->table() == nullptr) {
    table.take("input");
    table.wrong("input", *node, "it needs a number, a function of time in a table, or the name of a drive");
  } else if (auto function = table.table("input")) {
    std::array<std::string_view, function_kinds.size() + 1> kinds{};
    std::ranges::copy(function_kinds, kinds.begin());
    kinds.back() = "steps";
    if (!function->has("kind")) function->missing("kind", "give one, such as \"harmonic\" or \"steps\"");
    const auto kind = function->choice("kind", kinds);
    if (!kind) return;  // without a kind, its keys are not known
    if (*kind + 1 == kinds.size()) {
      read_steps(*function, input);
    } else {
      input.function.emplace().kind = static_cast<MotionDescription::Kind>(*kind);
      read_function(*function, *input.function);
    }
    function->finish();
  }
}

}  // namespace

bool read_drive(Table& table, std::size_t number, DriveDescription& drive) {
  table.rename("drive " + std::to_string(number + 1));
  const std::size_t faults = table.faults();
  drive.name = table.text("name").value_or("");
  if (!drive.name.empty()) table.rename("drive " + in_quotes(drive.name));
  if (!table.has("kind")) table.missing("kind", "give one, such as \"dc_motor\" or \"pid\"");
  const auto kind = table.choice("kind", names_of(drive_kinds));
  if (!kind) return false;  // without a kind, its keys are not known
  drive.kind = drive_kinds[*kind].kind;
  read_port(table, drive);
  for (const DriveParameter& parameter : traits(drive.kind).parameters)
    if (const auto x = table.number(parameter.name, std::isinf(parameter.standard)))
      drive.parameters.emplace_back(parameter.name, *x);
  if (drive.kind == DriveKind::pid) drive.conditional = table.choice("anti_windup", anti_windups) == 1U;
  read_input(table, drive.input);
  drive.initial = table.named_numbers("initial");
  const bool complete = table.faults() == faults;
  table.finish();
  return complete;
}

}  // namespace axode::io
