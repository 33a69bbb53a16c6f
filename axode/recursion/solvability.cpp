#include "axode/recursion/solvability.hpp"

#include "axode/scalar/text.hpp"

namespace axode {
namespace {

/// The end of an error message about a joint that moves no mass, `named`: it names the other joints that move
/// no mass in any configuration, as in `; joint "b" moves none either`. Empty if there are none.
std::string others_without_mass(const Model& model, const std::string& named) {
  std::string names;
  int n = 0;
  for (const Fault& fault : model.warnings())
    if (fault.rule == Rule::moves_no_mass && fault.element != named)
      names += (n++ == 0 ? "; " : ", ") + fault.element;
  return names + (n == 0 ? "" : n == 1 ? " moves none either" : " move none either");
}

}  // namespace

std::string to_string(const Model& model, const Solvability& solvability) {
  if (solvability.ok()) return "the mass matrix is positive definite";
  if (solvability.not_finite)
    return "a number is not finite: an argument is NaN or infinite, or so large that the results overflow";
  if (solvability.directions < 6)
    return "the frame can move in " + std::to_string(solvability.directions) +
           " of six directions, so its operational-space inertia does not exist; compute its "
           "inverse_operational_space_inertia instead";
  if (const int i = solvability.locked_body; i > 0) {
    const Dof& dof = model.joint(i).dof[0];
    return "the gear of joint \"" + model.joint(i).name +
           "\" locks itself so strongly that a state has no or "
           "several accelerations: gear_loss_back is " +
           to_text(dof.gear_loss_back.value_or(dof.gear_loss)) +
           ", and it must be less than 1 + armature / (inertia that the gear moves); raise the armature, " +
           to_text(dof.armature) + ", or lower gear_loss_back";
  }
  const int i = solvability.singular_body;
  const std::string joint = "joint \"" + model.joint(i).name + '"';
  return "the mass matrix is singular: with the other joints free, " + joint + " of body \"" +
         model.body(i).name + "\" moves no mass" + others_without_mass(model, joint) +
         "; give it mass, give the joint armature, or lock the joint, see reduced";
}

}  // namespace axode
