#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "axode/io/drawing/drawing_table.hpp"
#include "axode/model/description.hpp"

/// The readers of prescribed motions, functions of time and the initial state of a drawing.
namespace axode::io {

/// Reads a table [[motion]] of a drawing (a TOML file), a prescribed motion. Returns false if it has faults.
/// `number` is its index in the file, from 0.
bool read_motion(Table& table, std::size_t number, MotionDescription& motion);

/// The names of the kinds of functions of time, in the order of MotionDescription::Kind.
inline constexpr std::array<std::string_view, 4> function_kinds{"harmonic", "ramp", "polynomial", "samples"};
/// Reads the parameters of a function of time from a table. motion.kind must be set before.
void read_function(Table& table, MotionDescription& motion);

/// Reads the table `state` of a drawing, if there is one. `top` is the table of the whole file.
void read_state(Table& top, std::optional<InitialStateDescription>& state);

}  // namespace axode::io
