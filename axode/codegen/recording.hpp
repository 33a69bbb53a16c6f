#pragma once
#include <array>
#include <string>
#include <vector>

#include "axode/codegen/c_source.hpp"
#include "axode/scalar/trace.hpp"

namespace axode::codegen {

/// A function as the operations that lead from its arguments to its results.
struct Recording {
  std::vector<std::string> arguments;  ///< by the number of the array
  std::vector<int> lengths;            ///< how many numbers each of them has
  std::string result;                  ///< the name of the array of results
  std::vector<Tape::Node> nodes;
  std::vector<Trace> results;
  bool returns_singularity = false;
  Trace::Condition maybe_singular{};  ///< whether the mass matrix may be singular, where this is returned
};

/// The kernels of the library on a Trace, in the representation in which they leave the fewest operations.
Recording record(const Model& model, const Function& function, bool single_precision);

/// x = M⁻¹ tau from q and tau, the accelerations that forces make by themselves, in each way in which the library finds
/// them: by articulated bodies, and where no path is long by the factors of the mass matrix.
std::vector<Recording> record_solutions(const Model& model);

/// How many operations the results need.
Operations operations(const Recording& recording);

/// For each node whether the results, or maybe_singular, depend on it.
std::vector<char> needed(const Recording& recording);

/// The nodes that a node is computed from; those that it does not use are node 0, the number 1.
std::array<int, 3> operands(const Tape::Node& node);

}  // namespace axode::codegen
