// A program that computes drive forces, as a user would write it. `make bench` measures how long it takes to
// compile.
#include <vector>

#include "axode/axode.hpp"

std::vector<double> drive_forces(const axode::Model& model, const std::vector<double>& q,
                                 const std::vector<double>& v, const std::vector<double>& a) {
  axode::Workspace<> workspace(model);
  std::vector<double> tau(v.size());
  axode::inverse_dynamics<axode::Hybrid>(model, workspace, q, v, a, tau);
  return tau;
}
