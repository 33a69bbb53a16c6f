#pragma once
#include <vector>

#include "apps/files/state.hpp"
#include "axode/scalar/counted.hpp"

namespace axode::command {

/// What forward dynamics by contraction of the tree costs (see TreeContraction).
struct ContractionCount {
  int rounds, compressions;
  Operations operations;
  long longest_path;  ///< operations on the longest path, with a processor for each body
};
/// The counts with compressions in no round, which is the articulated-body algorithm, in the first round, in
/// the first two rounds, and so on until more rounds change nothing. Empty if the mass matrix may be
/// singular.
std::vector<ContractionCount> contraction_counts(const Model& model, const State& state);

}  // namespace axode::command
