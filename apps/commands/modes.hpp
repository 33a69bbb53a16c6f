#pragma once
#include <Eigen/Core>
#include <complex>
#include <vector>

namespace axode::command {

/// A mode of a linear system: a motion exp(λt) times a shape, with the eigenvalue λ. Of two conjugate
/// eigenvalues it has the one of positive imaginary part. A rigid mode, a displacement that no force opposes,
/// has λ = 0.
struct Mode {
  std::complex<double> eigenvalue;  ///< λ, 1/s; real and imaginary parts that are rounding errors are 0
  Eigen::VectorXcd shape;           ///< displacements, half as many as x has entries; the largest is 1

  bool rigid() const { return eigenvalue == 0.0; }
  bool oscillates() const { return eigenvalue.imag() > 0; }
  double natural_frequency() const { return std::abs(eigenvalue); }  ///< rad/s
  double damping_ratio() const { return -eigenvalue.real() / std::abs(eigenvalue); }
  double time_constant() const {
    return 1 / std::abs(eigenvalue.real());
  }  ///< time in which the mode decays or grows by the factor e, s
};

struct Modes {
  std::vector<Mode> all;  ///< rigid modes, then the others by the magnitude of λ
  int zeros = 0;          ///< multiplicity of the eigenvalue 0
};

/// The modes of the linear system x' = A x, where x consists of displacements, then their velocities.
Modes modes(const Eigen::MatrixXd& A);

}  // namespace axode::command
