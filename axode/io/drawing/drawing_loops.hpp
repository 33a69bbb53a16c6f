#pragma once
#include "axode/io/drawing/drawing_table.hpp"
#include "axode/model/description.hpp"

/// The readers of the tables [[loop]] and [[coupling]] of a drawing.
namespace axode::io {

/// read_loop() reads a table [[loop]] of a drawing (a TOML file) and read_coupling() a table [[coupling]].
/// `number` is the index of the table in the file, from 0, from which the default name follows. The functions
/// return false if the table has faults, so that an incomplete loop is left out of the description and causes
/// no further faults.
bool read_loop(Table& table, std::size_t number, LoopDescription& loop);
bool read_coupling(Table& table, std::size_t number, CouplingDescription& coupling);

}  // namespace axode::io
