#pragma once
#include "axode/io/drawing/drawing_table.hpp"

namespace axode::io {

/// Reads the friction, restitution and other contact properties of a shape; a visual shape must have none.
void read_surface(Table& table, ShapeDescription& shape);
/// Reads the table [contact], if any, of a drawing (a TOML file) with the table `top` of the whole file.
void read_contact(Table& top, Description& description);

}  // namespace axode::io
