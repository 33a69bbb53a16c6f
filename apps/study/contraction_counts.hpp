#pragma once
#include <vector>

#include "apps/files/state.hpp"
#include "axode/scalar/counted.hpp"

namespace axode::command {

/// The operations of forward dynamics by contraction of the tree (see TreeContraction), if chains of bodies
/// are compressed in a given number of rounds.
struct ContractionCount {
  int rounds, compressions;
  Operations operations;
  long longest_path;  ///< operations on the longest path, with a processor for each body
};
/// Counts the operations with compressions in no round, which is the articulated-body algorithm, in the first
/// round, in the first two rounds, and so on until more rounds change nothing. The result is empty if the
/// mass matrix may be singular.
std::vector<ContractionCount> contraction_counts(const Model& model, const State& state);

}  // namespace axode::command
