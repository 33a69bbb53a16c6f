#pragma once
#include <Eigen/Core>
#include <complex>
#include <vector>

namespace axode::command {

/// One way in which a linear system moves by itself, exp(λt) times a shape. Of two conjugates the one with
/// the positive imaginary part; 0 of a rigid mode, a displacement that no force opposes.
struct Mode {
  std::complex<double> eigenvalue;  ///< λ, 1/s; parts that rounding may have made are 0
  Eigen::VectorXcd shape;           ///< of the displacements, nv or k numbers of which the largest is 1

  bool rigid() const { return eigenvalue == 0.0; }
  bool oscillates() const { return eigenvalue.imag() > 0; }
  double natural_frequency() const { return std::abs(eigenvalue); }  ///< rad/s
  double damping_ratio() const { return -eigenvalue.real() / std::abs(eigenvalue); }
  double time_constant() const {
    return 1 / std::abs(eigenvalue.real());
  }  ///< s, in which it dies out or grows by e
};

struct Modes {
  std::vector<Mode> all;  ///< rigid ones first, then by the size of λ
  int zeros = 0;          ///< how often 0 is an eigenvalue
};

/// The modes of x' = A x, where the first half of x are displacements and the second half velocities.
Modes modes(const Eigen::MatrixXd& A);

}  // namespace axode::command
