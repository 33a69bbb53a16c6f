#pragma once
#include <cstddef>

#include "axode/io/drawing/drawing_table.hpp"
#include "axode/model/description.hpp"

/// The reader of the tables [[drive]] of a drawing.
namespace axode::io {

/// Reads a table [[drive]] of a drawing (a TOML file) into `drive`. Returns false if it has faults. `number`
/// is its index in the file, from 0.
bool read_drive(Table& table, std::size_t number, DriveDescription& drive);

}  // namespace axode::io
