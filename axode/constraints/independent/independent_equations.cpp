#include "axode/constraints/independent/independent_equations.hpp"

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/independent/independent_velocities.hpp"
#include "axode/dynamics/inverse_dynamics.hpp"
#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "axode/eigen.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {

IndependentEquations independent_equations(const Model& model, std::span<const double> q,
                                           std::span<const double> v, std::span<const int> velocities,
                                           const Loads<double>& loads) {
  catalog::check_counts<"independent_equations">(model);
  LoopWorkspace<double> loops(model);
  LoopSystem<double>& system = checked<double>(model, loops, q, v);
  check_loads(model, loads);
  const Eigen::Index nv = model.nv();
  system.update_kinematics(q.data());
  const IndependentRows<double> rows(system, ConstraintLevel::velocity);
  const IndependentVelocities independent = independent_velocities(model, rows, velocities);
  IndependentEquations out;
  out.velocities = independent.velocities;
  out.N = independent.N;

  Eigen::VectorXd gamma(model.loops().rows), forces(nv);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> A(gamma.size(), nv), M(nv, nv);
  system.write(A.data());
  system.move(q.data(), v.data(), loads, forces.data());
  system.bias(gamma.data());
  out.c = dependent_part(independent, rows, A, -gamma);

  Workspace<double> workspace(model);
  mass_matrix(model, workspace, q, as_span(M));
  out.M = out.N.transpose() * M * out.N;
  out.h = out.N.transpose() * (M * out.c + forces);
  return out;
}

}  // namespace axode
