#pragma once
#include "axode/io/drawing/drawing_table.hpp"
#include "axode/model/description.hpp"

/// Loops and couplings of a drawing.
namespace axode::io {

/// Reads a table [[loop]], or below a table [[coupling]]; its number counts from 0. Returns false if the
/// table has faults, so that no further faults follow from an incomplete loop.
bool read_loop(Table& table, std::size_t number, LoopDescription& loop);
bool read_coupling(Table& table, std::size_t number, CouplingDescription& coupling);

}  // namespace axode::io
