#include "axode/dynamics/solvability.hpp"

namespace axode {

std::string to_string(const Model& model, const Solvability& solvability) {
  if (solvability.ok()) return "the mass matrix is positive definite";
  const int i = solvability.singular_body;
  return "the mass matrix is singular: with the other joints free, joint \"" + model.joint(i).name +
         "\" of body \"" + model.body(i).name + "\" moves no mass";
}

}  // namespace axode
