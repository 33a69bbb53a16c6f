#pragma once
#include <vector>

#include "apps/files/state.hpp"
#include "axode/scalar/counted.hpp"

namespace axode::command {

/// Counts of the operations of forward dynamics by tree contraction, a parallel algorithm. It works in
/// rounds: in each round, every body or chain of bodies without children is joined to the body or chain above
/// it. In some rounds, neighbours in chains of bodies with one child each are also joined in pairs, which is
/// a compression. `rounds` and `compressions` are the numbers of all rounds and compressions.
struct ContractionCount {
  int rounds, compressions;
  Operations operations;
  long longest_path;  ///< operations on the longest path, with a processor for each body
};
/// Counts the operations of forward dynamics by tree contraction, a parallel algorithm that joins bodies in
/// rounds. Entry k of the result is for the algorithm that, in its first k rounds only, also joins pairs of
/// neighbours in chains of bodies with one child each (compressions). Entry 0 is the articulated-body
/// algorithm. The list ends before the first entry that would have no more compressions than the previous
/// one, or in which a pivot is so small that the mass matrix, or the inertia of a part of the tree, may be
/// singular.
std::vector<ContractionCount> contraction_counts(const Model& model, const State& state);

}  // namespace axode::command
