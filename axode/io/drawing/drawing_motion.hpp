#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "axode/io/drawing/drawing_table.hpp"
#include "axode/model/description.hpp"

/// Prescribed motions and the initial state of a drawing.
namespace axode::io {

/// Reads a motion and returns whether it is complete; faults name it by its number, from 0.
bool read_motion(Table& table, std::size_t number, MotionDescription& motion);

/// Names of the kinds of functions of time, in the order of MotionDescription::Kind.
inline constexpr std::array<std::string_view, 4> function_kinds{"harmonic", "ramp", "polynomial", "samples"};
/// Reads the parameters of a function of time, whose kind is set.
void read_function(Table& table, MotionDescription& motion);

/// Reads the table `state` of the top, if there is one.
void read_state(Table& top, std::optional<InitialStateDescription>& state);

}  // namespace axode::io
