#include "axode/fmi/check_supported.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "axode/fmi/stepped_motion.hpp"
#include "axode/table/check_counts.hpp"

namespace axode::fmi {
namespace {

/// How FMUs treat properties of mechanisms: whether they take a property into account or refuse it. Contact,
/// hard stops and losses of joints have checks of their own.
constexpr catalog::Counts without_contact{.loops = catalog::counted,
                                          .passive_joints = catalog::counted,
                                          .springs = catalog::counted,
                                          .joint_losses = catalog::optional,
                                          .motions = catalog::counted,
                                          .drives = catalog::counted,
                                          .plays = catalog::counted,
                                          .contacts = catalog::of_the_tree()};
/// The properties that FMUs for co-simulation count if the mechanism moves with contact.
constexpr catalog::Counts with_contact = [] {
  catalog::Counts counts = without_contact;
  counts.plays = catalog::refused("remove [contact] and the hard stops of joints");
  counts.contacts = catalog::counted;
  return counts;
}();

/// Throws std::invalid_argument for a collision shape that is a mesh, whose file an FMU does not contain.
void refuse_meshes(const std::string& fmu, const Model& model) {
  const auto refuse_in = [&](const std::vector<ShapeDescription>& shapes, const std::string& where) {
    for (const ShapeDescription& shape : shapes)
      if (shape.role == ShapeDescription::Role::collision && shape.kind == ShapeKind::mesh)
        throw std::invalid_argument(fmu + " does not count contact of meshes, and " + where + " of model \"" +
                                    model.name() + "\" has the collision shape \"" + shape.file +
                                    "\"; give it boxes, spheres, cylinders, capsules or ellipsoids");
  };
  refuse_in(model.description().shapes, "the ground");
  for (const BodyDescription& body : model.description().bodies)
    refuse_in(body.shapes, "body \"" + body.name + '"');
}

}  // namespace

void check_supported(const Model& model, const Settings& settings, Kind kind) {
  const bool exchange = kind == Kind::model_exchange, touches = !exchange && moves_with_contact(model);
  const std::string fmu = exchange  ? "an FMU for model exchange"
                          : touches ? "an FMU for co-simulation with contact"
                                    : "an FMU for co-simulation";
  catalog::check_counts(fmu, touches ? with_contact : without_contact, model, catalog::Caller::whole);
  const auto refuse = [&](const std::string& property, const std::string& where, const char* instead) {
    throw std::invalid_argument(fmu + " does not count " + property + ", and " + where + " of model \"" +
                                model.name() + "\" has it; " + instead);
  };
  if (exchange && has_shapes_that_touch(model))
    throw std::invalid_argument(fmu + " does not count contact, and model \"" + model.name() +
                                "\" has shapes that touch; export it for co-simulation, or remove [contact]");
  if (has_shapes_that_touch(model)) refuse_meshes(fmu, model);
  for (const Joint& joint : model.joints())
    for (const Dof& dof : joint.dof) {
      const std::string where = "joint \"" + joint.name + '"';
      const bool rubs = settings.joint_losses && dof.friction != 0,
                 gear_loses = settings.joint_losses && has_gear_losses(dof);
      const bool follows =
          std::ranges::find(model.motions(), joint.name, &MotionDescription::of) != model.motions().end();
      if (follows && dof.hard_stops)
        refuse("a hard stop of a joint that follows a motion", where, "remove its stop");
      if (touches && gear_loses) refuse("a loss of a gear", where, "export it without joint losses");
      if (!rubs && !gear_loses) continue;
      const std::string losses = "dry friction or losses of gears ";
      if (follows)
        refuse(losses + "of a joint that follows a motion", where, "export it without joint losses");
      if (!model.loops().backlashes.empty())
        refuse(losses + "together with play", where, "export it without joint losses");
      if (exchange && has_hard_stops(model))
        refuse(losses + "together with hard stops", where,
               "export it for co-simulation, or without joint losses");
    }
}

}  // namespace axode::fmi
