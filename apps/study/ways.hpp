#pragma once
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "apps/files/state.hpp"
#include "axode/scalar/counted.hpp"

namespace axode::command {

/// One of several ways to compute the same in one representation, in joint frames.
struct Way {
  std::string_view algorithm, name;
  Representation representation;
};
/// The ways that the study compares, sorted by algorithm.
const std::vector<Way>& ways();

/// Runs one of the compared algorithms on a model in one state. Jerks and higher rates that the algorithm
/// needs are given the numbers of the state's accelerations.
class WaySubject {
 public:
  virtual ~WaySubject() = default;
  virtual void run(int calls) = 0;
  /// The result of a call: forces, or six numbers for each body.
  virtual std::vector<double> results() = 0;
};
std::unique_ptr<WaySubject> make_subject(const Way& way, const Model& model, const State& state);
/// The operations of one call.
Operations operations(const Way& way, const Model& model, const State& state);

/// The cost of a way.
struct WayEffort {
  Way way;
  Operations operations;
  std::optional<double> seconds;  ///< of one call, if it was measured
};

}  // namespace axode::command
