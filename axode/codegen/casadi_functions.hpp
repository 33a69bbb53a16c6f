#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "axode/codegen/casadi_inverse.hpp"
#include "axode/codegen/recording.hpp"

/// What CasADi's functions compute, and how their matrices are filled.
namespace axode::codegen {

/// Where a matrix may have entries that are not 0: row + rows column, ascending.
struct Pattern {
  int rows = 0, columns = 0;
  std::vector<int> entries;
  bool is_dense() const { return static_cast<long>(entries.size()) == static_cast<long>(rows) * columns; }
};
struct CasadiInput {
  std::string name;
  Pattern pattern;
};
/// Its entries are numbers that one of the recordings results in.
struct CasadiOutput {
  std::string name;
  Pattern pattern;
  std::size_t recording = 0;
  std::vector<int> results{};  ///< for each entry
};
/// A function that CasADi calls; arguments of recordings are inputs of that name.
struct CasadiFunction {
  std::string name;
  std::vector<CasadiInput> inputs;
  std::vector<CasadiOutput> outputs;
  bool is_jacobian = false;  ///< whose matrices, for several states, are block by block on the diagonal
};
/// A function of the state and its derivatives by all coordinates, velocities and so on, as CasADi looks for
/// them: NAME, fwd1_NAME, adj1_NAME, jac_NAME and jac_adj1_NAME, each with a recording of its own. The
/// inverse mass matrix has no jac_adj1_NAME, and the recordings of its derivatives are signatures of loops.
struct CasadiFamily {
  std::vector<Recording> recordings;
  std::vector<CasadiFunction> functions;
  std::optional<CasadiInverse> inverse;
};

/// The function is of the coordinates as CasADi has them, n_q independent numbers: quaternions count divided
/// by their length. Derivatives of forward dynamics are found from those of inverse dynamics, T(q, v, a) =
/// tau, those of the inverse mass matrix from those of M, and all others by differentiating what is recorded.
/// `frames` are their names as identifiers.
CasadiFamily casadi_family(const Model& model, const Function& function, const std::string& name,
                           std::span<const std::string> frames);

}  // namespace axode::codegen
