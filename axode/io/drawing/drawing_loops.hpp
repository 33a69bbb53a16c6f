#pragma once
#include "axode/io/drawing/drawing_table.hpp"
#include "axode/model/description.hpp"

/// The readers of the tables [[loop]] and [[coupling]] of a drawing.
namespace axode::io {

/// These functions read a table [[loop]] or [[coupling]] of a drawing (a TOML file), and return false if it
/// has faults. `number` is the index of the table in the file, from 0; the loop or coupling is named by it if
/// it has no name.
bool read_loop(Table& table, std::size_t number, LoopDescription& loop);
bool read_coupling(Table& table, std::size_t number, CouplingDescription& coupling);

}  // namespace axode::io
