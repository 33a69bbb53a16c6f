#pragma once
#include "axode/io/drawing/drawing_table.hpp"
#include "axode/model/description.hpp"

namespace axode::io {

/// Reads a table [[spring]] of a drawing (a TOML file) into `spring`. `number` is its index in the file, from
/// 0. Returns whether `spring` is complete enough to be checked further. It is not if its kind is unknown, or
/// if it has faults and its kind is not `line`.
bool read_spring(Table& table, std::size_t number, SpringDescription& spring);

}  // namespace axode::io
