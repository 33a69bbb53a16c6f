#include "axode/constraints/independent_equations.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <stdexcept>
#include <string>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/independent_rows.hpp"
#include "axode/dynamics/check_loads.hpp"
#include "axode/dynamics/inverse_dynamics.hpp"
#include "axode/dynamics/mass_matrix.hpp"
#include "axode/eigen.hpp"
#include "axode/model/configuration.hpp"

namespace axode {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

std::string names_of(const Model& model, std::span<const int> velocities) {
  const std::vector<std::string> names = velocity_names(model);
  std::string all;
  for (const int c : velocities)
    all += (all.empty() ? "\"" : ", \"") + names[static_cast<std::size_t>(c)] + '"';
  return all;
}

/// The rows of the kernel that are farthest from dependent.
std::vector<int> best_of(const Matrix& kernel) {
  const Eigen::ColPivHouseholderQR<Matrix> qr(kernel.transpose());
  std::vector<int> found;
  for (Eigen::Index k = 0; k < kernel.cols(); ++k)
    found.push_back(static_cast<int>(qr.colsPermutation().indices()[k]));
  std::ranges::sort(found);
  return found;
}

void check(const Model& model, std::span<const int> velocities, Eigen::Index freedom) {
  for (const int c : velocities)
    if (c < 0 || c >= model.nv())
      throw std::invalid_argument("velocities holds " + std::to_string(c) + "; expected numbers from 0 to " +
                                  std::to_string(model.nv() - 1));
  if (static_cast<Eigen::Index>(velocities.size()) != freedom)
    throw std::invalid_argument("velocities holds " + std::to_string(velocities.size()) +
                                "; the loops leave " + std::to_string(freedom) + " independent here");
}

}  // namespace

IndependentEquations independent_equations(const Model& model, std::span<const double> q,
                                           std::span<const double> v, std::span<const int> velocities,
                                           const Loads<double>& loads) {
  LoopWorkspace<double> loops(model);
  LoopSystem<double>& system = checked<double>(model, loops, q, v);
  check_loads(model, loads);
  const Eigen::Index nv = model.nv();
  system.place(q.data());
  const IndependentRows<double> rows(system, LoopSystem<double>::Rows::velocities);
  const Matrix kernel = rows.kernel();
  IndependentEquations out;
  out.velocities =
      velocities.empty() ? best_of(kernel) : std::vector<int>(velocities.begin(), velocities.end());
  check(model, out.velocities, kernel.cols());
  const Eigen::FullPivLU<Matrix> chosen(Matrix(kernel(out.velocities, Eigen::all)));
  if (kernel.cols() > 0 && !(chosen.rcond() > 1e-8))
    throw std::invalid_argument("velocities holds those of " + names_of(model, out.velocities) +
                                ", which do not determine the others at this q");
  out.N = kernel.cols() > 0 ? Matrix(kernel * chosen.inverse()) : kernel;
  for (std::size_t k = 0; k < out.velocities.size(); ++k)
    out.N.row(out.velocities[k]).setZero()[static_cast<Eigen::Index>(k)] = 1;

  Vector gamma(model.loops().rows), forces(nv);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> A(gamma.size(), nv), M(nv, nv);
  system.write(A.data());
  system.move(q.data(), v.data(), loads, forces.data());
  system.bias(gamma.data());
  out.c = rows.kept.empty() ? Vector(Vector::Zero(nv))
                            : Vector(Matrix(A(rows.kept, Eigen::all))
                                         .completeOrthogonalDecomposition()
                                         .solve(Vector(-gamma(rows.kept))));
  out.c -= out.N * Vector(out.c(out.velocities));
  for (const int k : out.velocities) out.c[k] = 0;

  Workspace<double> workspace(model);
  mass_matrix(model, workspace, q, as_span(M));
  out.M = out.N.transpose() * M * out.N;
  out.h = out.N.transpose() * (M * out.c + forces);
  return out;
}

}  // namespace axode
