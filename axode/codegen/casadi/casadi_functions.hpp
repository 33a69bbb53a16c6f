#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "axode/codegen/casadi/casadi_inverse.hpp"
#include "axode/codegen/tape/recording.hpp"

/// The functions that are generated for CasADi, and the sparsity patterns of their matrices.
namespace axode::codegen {

/// The sparsity pattern of a matrix.
struct Pattern {
  int rows = 0, columns = 0;
  std::vector<int> entries;  ///< row + rows column of each entry that may not be 0, ascending
  bool is_dense() const { return static_cast<long>(entries.size()) == static_cast<long>(rows) * columns; }
};
struct CasadiInput {
  std::string name;
  Pattern pattern;
};
/// A matrix whose entries are results of a recording; `recording` is its index in CasadiFamily.
struct CasadiOutput {
  std::string name;
  Pattern pattern;
  std::size_t recording = 0;
  std::vector<int> results{};  ///< for each entry of the pattern: the index of the result
};
/// A function that CasADi calls. Its inputs have the names of the arguments of the recordings that it needs.
struct CasadiFunction {
  std::string name;
  std::vector<CasadiInput> inputs;
  std::vector<CasadiOutput> outputs;
  bool is_jacobian = false;  ///< whether matrices of several states are blocks on a diagonal
};
/// A function of the state and its derivatives by all arguments, under the names that CasADi looks for: NAME,
/// fwd1_NAME, adj1_NAME, jac_NAME and jac_adj1_NAME. Each of them has a recording (a list of operations) of
/// its own, from which its C code is generated. The inverse mass matrix is an exception: it has no
/// jac_adj1_NAME, and the C code of its derivatives multiplies matrices in `for` loops (see the member
/// `inverse`). The recordings of these derivatives only describe arguments and results.
struct CasadiFamily {
  std::vector<Recording> recordings;
  std::vector<CasadiFunction> functions;
  std::optional<CasadiInverse> inverse;
};

/// Makes a function of the model and its derivatives for CasADi. In CasADi the nq coordinates are independent
/// numbers; hence quaternions are divided by their norm. Derivatives of forward dynamics are computed from
/// derivatives of the inverse dynamics T(q, v, a) = tau, derivatives of the inverse mass matrix from
/// derivatives of M, and all other derivatives by differentiation of recorded operations. `frames` are the
/// names of all frames as identifiers.
CasadiFamily casadi_family(const Model& model, const Function& function, const std::string& name,
                           std::span<const std::string> frames);

}  // namespace axode::codegen
