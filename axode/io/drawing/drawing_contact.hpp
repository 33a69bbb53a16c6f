#pragma once
#include "axode/io/drawing/drawing_table.hpp"

namespace axode::io {

/// Reads the keys of a shape that say how it behaves in contact. A visual shape must have none of them.
void read_surface(Table& table, ShapeDescription& shape);
/// Reads the table `contact` of a drawing, which may be absent.
void read_contact(Table& top, Description& description);

}  // namespace axode::io
