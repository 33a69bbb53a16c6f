#pragma once
#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/files/state.hpp"
#include "apps/study/framed_tree.hpp"
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

/// A model, a state, a representation and a choice of body frames, with which algorithms can be run to
/// measure their cost. As only the cost matters, the numbers of the accelerations are used for drive forces,
/// and those of the velocities for momenta.
class Subject {
 public:
  virtual ~Subject() = default;
  virtual bool can(Algorithm algorithm) const = 0;
  virtual void run(Algorithm algorithm, int calls) = 0;
  /// The result of one call of an algorithm, which must not be `accelerations`. The result of momentum_form
  /// is the velocities, then the rates of the momenta.
  virtual std::vector<double> results_of(Algorithm algorithm) = 0;
};
/// Makes a Subject. Rep is BodyFixed, Spatial, Hybrid, Mixed or Fast. If Rep is Fast, Frames must be
/// JointFrames, and the state must not have loads.
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
  double seconds;
};
struct Study {
  std::string model;
  int bodies, velocities;
  std::vector<Effort> efforts;  ///< sorted by algorithm, then by frames, then by representation
  std::string left_out;         ///< if some algorithms cannot run, a sentence that says why
};

}  // namespace axode::command
