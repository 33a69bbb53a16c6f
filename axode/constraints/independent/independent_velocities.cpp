#include "axode/constraints/independent/independent_velocities.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <stdexcept>
#include <string>

#include "axode/model/configuration.hpp"
#include "axode/recursion/decompositions.hpp"
#include "axode/recursion/least_squares.hpp"

namespace axode {
namespace {

using Matrix = Eigen::MatrixXd;

std::string names_of(const Model& model, std::span<const int> velocities) {
  const std::vector<std::string> names = velocity_names(model);
  std::string all;
  for (const int c : velocities)
    all += (all.empty() ? "\"" : ", \"") + names[static_cast<std::size_t>(c)] + '"';
  return all;
}

/// Chooses the velocities that determine all others best, and returns their indices in ascending order.
/// `kernel` has a basis of the velocities that the loops allow; a QR decomposition with pivoting chooses
/// well-conditioned rows of it.
std::vector<int> best_of(const Matrix& kernel) {
  if (kernel.cols() == 0) return {};  // the decomposition needs at least one column
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
      throw std::invalid_argument("velocities: there is no velocity " + std::to_string(c) + "; model \"" +
                                  model.name() + "\" has velocities 0 to " + std::to_string(model.nv() - 1));
  if (static_cast<Eigen::Index>(velocities.size()) != freedom)
    throw std::invalid_argument("velocities holds " + std::to_string(velocities.size()) +
                                "; the loops leave " + std::to_string(freedom) + " independent here");
}

}  // namespace

IndependentVelocities independent_velocities(const Model& model, const IndependentRows<double>& rows,
                                             std::span<const int> wanted) {
  const Matrix kernel = rows.kernel();
  IndependentVelocities out;
  out.velocities = wanted.empty() ? best_of(kernel) : std::vector<int>(wanted.begin(), wanted.end());
  check(model, out.velocities, kernel.cols());
  out.N = kernel;
  if (kernel.cols() == 0) return out;
  const LuFactor chosen(kernel(out.velocities, Eigen::indexing::all));
  if (!(chosen.rcond() > 1e-8))
    throw std::invalid_argument("velocities: the velocities of " + names_of(model, out.velocities) +
                                " do not determine the others at this q");
  out.N = kernel * chosen.solve(Matrix::Identity(kernel.cols(), kernel.cols()));
  for (std::size_t k = 0; k < out.velocities.size(); ++k)
    out.N.row(out.velocities[k]).setZero()[static_cast<Eigen::Index>(k)] = 1;
  return out;
}

Matrix dependent_part(const IndependentVelocities& independent, const IndependentRows<double>& rows,
                      const Matrix& A, const Matrix& b) {
  if (rows.independent.empty()) return Matrix::Zero(A.cols(), b.cols());
  Matrix x =
      least_squares(A(rows.independent, Eigen::indexing::all), b(rows.independent, Eigen::indexing::all), 0);
  x -= independent.N * Matrix(x(independent.velocities, Eigen::indexing::all));
  for (const int k : independent.velocities) x.row(k).setZero();
  return x;
}

}  // namespace axode
