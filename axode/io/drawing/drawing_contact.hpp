#pragma once
#include "axode/io/drawing/drawing_table.hpp"

namespace axode::io {

/// Reads the keys of a shape for its friction, restitution and other properties in contact. A visual shape
/// must have none of these keys.
void read_surface(Table& table, ShapeDescription& shape);
/// Reads the table [contact] of a drawing (a TOML file) into the description, if there is one. `top` is the
/// table of the whole file.
void read_contact(Table& top, Description& description);

}  // namespace axode::io
