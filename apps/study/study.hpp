#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/files/state.hpp"
#include "apps/study/contraction/contraction_counts.hpp"
#include "apps/study/drift.hpp"
#include "apps/study/framed_tree.hpp"
#include "apps/study/rounding.hpp"
#include "apps/study/ways.hpp"
#include "axode/scalar/counted.hpp"

/// Compares the cost of algorithms, representations and choices of body frames.
namespace axode::command {

enum class Algorithm {
  inverse_dynamics,
  forward_dynamics,
  mass_matrix,
  inverse_mass_matrix,
  accelerations,
  momentum_form
};
inline constexpr std::array<std::pair<std::string_view, Algorithm>, 6> algorithms{
    {{"inverse_dynamics", Algorithm::inverse_dynamics},
     {"forward_dynamics", Algorithm::forward_dynamics},
     {"mass_matrix", Algorithm::mass_matrix},
     {"inverse_mass_matrix", Algorithm::inverse_mass_matrix},
     {"accelerations", Algorithm::accelerations},
     {"momentum_form", Algorithm::momentum_form}}};

/// The choice of body frames of the library's own trees. FramedTree has other choices.
struct JointFrames {};

/// Runs algorithms on a model in one state, to measure their costs, in one representation of twists and one
/// choice of body frames. The accelerations of the state are also used as drive forces, and its velocities as
/// momenta.
class Subject {
 public:
  virtual ~Subject() = default;
  virtual bool can(Algorithm algorithm) const = 0;
  virtual void run(Algorithm algorithm, int calls) = 0;
  /// Runs an algorithm once and returns its result: forces, accelerations or the entries of a matrix. For
  /// `momentum_form`, which computes velocities and the rates of the momenta from given momenta, the
  /// velocities come first, then the rates. `algorithm` must not be `accelerations`: its result, the twists
  /// of all bodies and their rates, is not kept.
  virtual std::vector<double> results_of(Algorithm algorithm) = 0;
};
/// Makes an object that runs algorithms on a model in one state, to measure their costs, with a
/// representation Rep of twists and the body frames Frames. Rep is BodyFixed, Spatial, Hybrid or Mixed, or
/// Fast for the library's fastest algorithms; Fast requires Frames = JointFrames and a state without loads.
template <class Rep, class Frames>
std::unique_ptr<Subject> make_subject(const Model& model, const State& state);
/// The number of operations of one call of an algorithm, which the subject must be able to run.
template <class Rep, class Frames>
Operations operations(Algorithm algorithm, const Model& model, const State& state);

/// The cost of an algorithm in one representation and one choice of frames.
struct Effort {
  Algorithm algorithm;
  std::string_view frames, representation;
  Operations operations;
  std::optional<double> seconds;  ///< of one call, if it was measured
};
struct Study {
  std::string model;
  int bodies, velocities;
  std::vector<Effort> efforts;  ///< sorted by algorithm, then by frames, then by representation
  std::vector<WayEffort> ways;
  std::vector<ContractionCount> contraction;
  std::vector<RoundingErrors> rounding;  ///< if asked for
  std::vector<Drift> drift;              ///< if asked for
  std::string left_out;                  ///< if some algorithms cannot run, a sentence that says why

  bool timed() const { return !efforts.empty() && efforts.front().seconds.has_value(); }
};

}  // namespace axode::command
