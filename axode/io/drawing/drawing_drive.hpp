#pragma once
#include <cstddef>

#include "axode/io/drawing/drawing_table.hpp"
#include "axode/model/description.hpp"

/// Drives of a drawing.
namespace axode::io {

/// Reads a drive and returns whether it is complete; faults name it by its number, from 0.
bool read_drive(Table& table, std::size_t number, DriveDescription& drive);

}  // namespace axode::io
