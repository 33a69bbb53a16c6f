#pragma once
#include <array>
#include <string>
#include <vector>

#include "axode/codegen/c/c_source.hpp"
#include "axode/scalar/trace.hpp"

namespace axode::codegen {

/// A recorded function: a list of operations that compute its results from its arguments.
struct Recording {
  std::vector<std::string> arguments;  ///< names of the arrays; Tape::Node::a of an input node is an index
                                       ///< into them
  std::vector<int> lengths;            ///< length of each of these arrays
  std::string result;                  ///< the name of the array of results
  std::vector<Tape::Node> nodes;
  std::vector<Trace> results;
  bool returns_singularity = false;
  Trace::Condition
      maybe_singular{};  ///< whether the mass matrix may be singular; used if returns_singularity
};

/// Records the operations of a function of the model. If the function solves with the mass matrix, it is
/// recorded with articulated bodies and, unless a path of the tree is long, with the factors of the mass
/// matrix; the recording with fewer operations is returned. `single_precision` changes only the test for
/// singular mass matrices.
Recording record(const Model& model, const Function& function, bool single_precision);

/// Records x = M⁻¹ tau as a function of q and tau in one or two ways: by articulated bodies and, unless a
/// path of the tree is long, by the factors of the mass matrix.
std::vector<Recording> record_solutions(const Model& model);

/// The number of operations that the results and the condition `maybe_singular` need.
Operations operations(const Recording& recording);

/// Determines for each node whether the results, or the condition `maybe_singular`, depend on it.
std::vector<char> needed(const Recording& recording);

/// The indices of the operations whose results a recorded operation uses; unused entries are 0.
std::array<int, 3> operands(const Tape::Node& node);

}  // namespace axode::codegen
