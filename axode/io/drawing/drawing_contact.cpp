#include "axode/io/drawing/drawing_contact.hpp"

namespace axode::io {

void read_surface(Table& table, ShapeDescription& shape) {
  constexpr std::array<std::string_view, 7> keys{
      "friction", "spin_friction", "rolling_friction", "restitution", "stiffness", "exponent", "damping"};
  if (shape.role == ShapeDescription::Role::visual) {
    for (const std::string_view key : keys)
      table.refuse(key, "a visual shape touches nothing; give it role = \"collision\"");
    return;
  }
  ContactProperties& contact = shape.contact;
  contact.friction = table.number("friction");
  contact.spin_friction = table.number("spin_friction").value_or(0);
  contact.rolling_friction = table.number("rolling_friction").value_or(0);
  contact.restitution = table.number("restitution").value_or(0);
  contact.stiffness = table.number("stiffness");
  contact.exponent = table.number("exponent").value_or(contact.exponent);
  contact.damping = table.number("damping").value_or(0);
}

void read_contact(Table& top, Description& description) {
  auto table = top.table("contact");
  if (!table) return;
  table->rename("contact");
  ContactDescription contact;
  contact.source = {table->file(), table->line()};
  contact.friction = table->number("friction").value_or(contact.friction);
  contact.margin = table->number("margin").value_or(contact.margin);
  contact.threshold = table->number("threshold").value_or(contact.threshold);
  contact.ignored =
      table->pairs_of_names("ignored", "it needs pairs of bodies, such as [[\"hand\", \"ground\"]]");
  table->finish();
  description.contact = std::move(contact);
}

}  // namespace axode::io
