#pragma once
#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/framed_tree.hpp"
#include "axode/scalar/counted.hpp"
#include "state.hpp"

/// The comparison of algorithms, representations and choices of body frames: what each costs.
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

/// The frames of the library's own trees, beside those of FramedTree.
struct JointFrames {};

/// A model, a state, a representation and a choice of body frames, ready for every algorithm. Those that take
/// drive forces find them in the place of the accelerations, momenta in that of the velocities.
class Subject {
 public:
  virtual ~Subject() = default;
  virtual bool can(Algorithm algorithm) const = 0;
  virtual void run(Algorithm algorithm, int calls) = 0;
  /// What one call of it makes; of the momentum form the velocities, then the rates of the momenta; not of
  /// accelerations.
  virtual std::vector<double> results_of(Algorithm algorithm) = 0;
};
/// Rep: BodyFixed, Spatial, Hybrid, Mixed, or Fast with JointFrames only and nothing applied.
template <class Rep, class Frames>
std::unique_ptr<Subject> make_subject(const Model& model, const State& state);
/// What one call of an algorithm that the subject can do executes.
template <class Rep, class Frames>
Operations operations(Algorithm algorithm, const Model& model, const State& state);

/// What one algorithm costs in one way.
struct Effort {
  Algorithm algorithm;
  std::string_view frames, representation;
  Operations operations;
  double seconds;
};
struct Study {
  std::string model;
  int bodies, velocities;
  std::vector<Effort> efforts;  ///< by algorithm, then frames, then representation
  std::string left_out;         ///< a sentence, where some algorithms cannot run
};

}  // namespace axode::command
