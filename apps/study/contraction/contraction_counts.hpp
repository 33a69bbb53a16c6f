#pragma once
#include <vector>

#include "apps/files/state.hpp"
#include "axode/scalar/counted.hpp"

namespace axode::command {

/// Counts of the operations of forward dynamics by tree contraction, a parallel algorithm that joins
/// neighbouring bodies in rounds. Chains of bodies are compressed only in the first `rounds` rounds.
struct ContractionCount {
  int rounds, compressions;
  Operations operations;
  long longest_path;  ///< operations on the longest path, with a processor for each body
};
/// Counts the operations of forward dynamics by tree contraction if chains of bodies are compressed in no
/// round (this is the articulated-body algorithm), in the first round, in the first two rounds, and so on
/// until more rounds change nothing. The result is empty if the mass matrix may be singular.
std::vector<ContractionCount> contraction_counts(const Model& model, const State& state);

}  // namespace axode::command
