#pragma once
#include "tests/paper/columns.hpp"

/// Quantities of Lagrange's equations, computed without formulas: the kinetic energy of the point masses is
/// differentiated by series. All joints have one screw; indices are those of velocities.
namespace axode::test::paper {

/// ∂T/∂q.
Matrix energy_gradient(const Motion& m);
/// ∂T/∂v and its rate along the motion: the conjugate momenta and their rates.
struct Momenta {
  Matrix p, dp;
};
Momenta conjugate_momenta(const Motion& m);
/// M_ij = ∂²T/∂v_i∂v_j.
Matrix mass_matrix_of(const Motion& m);
/// Γ_ijk = (∂M_ik/∂q_j + ∂M_ij/∂q_k - ∂M_jk/∂q_i) / 2 at [(i n + j) n + k].
std::vector<double> christoffel_symbols_of(const Motion& m);

/// W_i^app of all bodies: gravity and loads, without the drives.
template <class Rep> Matrix system_W_app(const Motion& m) {
  return stacked(m, [&](int i) { return m.W_app<Rep>(i); });
}
/// The drive forces that the library computes for the motion.
Matrix drive_forces(const Motion& m);
/// Q: the generalised forces of drives, loads and gravity.
Matrix generalised_forces(const Motion& m);

}  // namespace axode::test::paper
