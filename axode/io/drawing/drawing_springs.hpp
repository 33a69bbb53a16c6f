#pragma once
#include "axode/io/drawing/drawing_table.hpp"
#include "axode/model/description.hpp"

namespace axode::io {

/// Reads a table [[spring]]. Returns whether it is complete.
bool read_spring(Table& table, std::size_t number, SpringDescription& spring);

}  // namespace axode::io
