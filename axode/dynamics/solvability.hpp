#pragma once
#include <string>

#include "axode/model/model.hpp"

namespace axode {

/// Whether accelerations (or velocities) could be found from forces (or momenta): the mass matrix must be
/// positive definite. It is not where a joint moves no mass, or where it moves mass only as other joints do
/// as well.
struct [[nodiscard]] Solvability {
  int singular_body = 0;  ///< the body on whose joint the elimination stopped; 0 where all went well
  bool ok() const { return singular_body == 0; }
};
/// One sentence for the user.
std::string to_string(const Model& model, const Solvability& solvability);

}  // namespace axode
