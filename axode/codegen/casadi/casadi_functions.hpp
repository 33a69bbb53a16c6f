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
/// A function NAME of the state and its derivatives by all arguments for CasADi: fwd1_NAME along a direction,
/// adj1_NAME, the gradient of the weighted sum of the results, the Jacobian jac_NAME, and the Jacobian
/// jac_adj1_NAME of adj1_NAME. The C code of each of them is generated from its recording (a list of
/// operations). The inverse mass matrix is an exception: it has no jac_adj1_NAME, the member `inverse`
/// generates the code of its derivatives, and their recordings only describe arguments and results.
struct CasadiFamily {
  std::vector<Recording> recordings;
  std::vector<CasadiFunction> functions;
  std::optional<CasadiInverse> inverse;
};

/// Makes a function of the model and its derivatives for CasADi. In CasADi the nq coordinates are independent
/// numbers; hence quaternions are divided by their norm. Derivatives of the forward dynamics are computed
/// from those of the inverse dynamics, derivatives of the inverse mass matrix from those of the mass matrix,
/// and all other derivatives by differentiation of the recorded operations. `frames` are the names of all
/// frames, as C identifiers.
CasadiFamily casadi_family(const Model& model, const Function& function, const std::string& name,
                           std::span<const std::string> frames);

}  // namespace axode::codegen
