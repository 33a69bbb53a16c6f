#pragma once
#include "axode/io/drawing/drawing_table.hpp"
#include "axode/model/description.hpp"

namespace axode::io {

/// Reads a table [[spring]] of a drawing (a TOML file) into `spring`. `number` is the index of the table in
/// the file, from 0, from which the default name follows. Returns false if the kind is unknown, or if the
/// table has faults and the kind is not `line`.
bool read_spring(Table& table, std::size_t number, SpringDescription& spring);

}  // namespace axode::io
