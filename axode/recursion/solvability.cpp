#include "axode/recursion/solvability.hpp"

namespace axode {

std::string to_string(const Model& model, const Solvability& solvability) {
  if (solvability.ok()) return "the mass matrix is positive definite";
  if (solvability.not_finite)
    return "a number is not finite: an argument is NaN or infinite, or so large that the results overflow";
  if (solvability.directions < 6)
    return "the frame can move in " + std::to_string(solvability.directions) +
           " of six directions, so that it shows no inertia to a wrench; ask for its mobility";
  const int i = solvability.singular_body;
  return "the mass matrix is singular: with the other joints free, joint \"" + model.joint(i).name +
         "\" of body \"" + model.body(i).name + "\" moves no mass";
}

}  // namespace axode
