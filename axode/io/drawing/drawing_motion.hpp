#pragma once
#include <cstddef>
#include <optional>

#include "axode/io/drawing/drawing_table.hpp"
#include "axode/model/description.hpp"

/// Prescribed motions and the initial state of a drawing.
namespace axode::io {

/// Reads a motion and returns whether it is complete; faults name it by its number, from 0.
bool read_motion(Table& table, std::size_t number, MotionDescription& motion);

/// Reads the table `state` of the top, if there is one.
void read_state(Table& top, std::optional<InitialStateDescription>& state);

}  // namespace axode::io
