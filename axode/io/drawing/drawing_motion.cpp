#include "axode/io/drawing/drawing_motion.hpp"

#include "axode/model/building/placement.hpp"

namespace axode::io {
namespace {

using Kind = MotionDescription::Kind;

}  // namespace

void read_function(Table& table, MotionDescription& motion) {
  switch (motion.kind) {
    case Kind::harmonic:
      motion.offset = table.number("offset").value_or(0);
      motion.amplitude = table.needed_number("amplitude", "rad or m");
      motion.frequency = table.needed_number("frequency", "Hz");
      motion.phase = table.number("phase").value_or(0);
      break;
    case Kind::ramp:
      motion.from = table.number("from").value_or(0);
      motion.to = table.needed_number("to", "rad or m");
      motion.start = table.number("start").value_or(0);
      motion.end = table.needed_number("end", "s");
      break;
    case Kind::polynomial:
      motion.coefficients = table.needed_list("coefficients", "it needs those of 1, t, t^2, ... in brackets");
      break;
    case Kind::samples:
      motion.times = table.needed_list("times", "it needs the times of the samples in brackets, s");
      motion.values = table.needed_list("values", "it needs the values of the samples in brackets, rad or m");
      break;
  }
}

bool read_motion(Table& table, std::size_t number, MotionDescription& motion) {
  table.rename("motion " + std::to_string(number + 1));
  const std::size_t faults = table.faults();
  motion.name = table.text("name").value_or("");
  motion.of = table.name("of", "name the joint or the rod that follows it");
  if (!motion.of.empty()) table.rename(in_quotes(motion_name(motion)));
  if (!table.has("kind")) table.missing("kind", "give one, such as \"harmonic\" or \"ramp\"");
  const auto kind = table.choice("kind", function_kinds);
  if (!kind) return false;  // without a kind, its keys are not known
  motion.kind = static_cast<Kind>(*kind);
  read_function(table, motion);
  const bool complete = table.faults() == faults;
  table.finish();
  return complete;
}

void read_state(Table& top, std::optional<InitialStateDescription>& state) {
  auto table = top.table("state");
  if (!table) return;
  table->rename("state");
  state.emplace();
  state->q = table->named_lists("q");
  state->v = table->named_lists("v");
  state->source = {table->file(), table->line()};
  table->finish();
}

}  // namespace axode::io
