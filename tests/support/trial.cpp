#include "tests/support/trial.hpp"

#include <optional>
#include <utility>

namespace axode::test {
namespace {

/// A mechanism at a state that was drawn from a seed. Each thread remembers the last ones, because a law is
/// tested on the same mechanisms for every representation and scalar type, and building a model takes longer
/// than most laws.
struct Drawn {
  std::uint64_t seed = 0;
  TreeRecipe recipe;
  int most_bodies = 0;
  LastMechanism last;
  std::optional<std::pair<Model, State<double>>> model_and_state;
};

const std::pair<Model, State<double>>& drawn(std::uint64_t seed, const TreeRecipe& recipe) {
  thread_local std::vector<Drawn> remembered(1024);
  Drawn& place = remembered[seed % remembered.size()];
  const int most_bodies = AtMostBodies::limit();
  if (place.model_and_state && place.seed == seed && place.recipe == recipe &&
      place.most_bodies == most_bodies) {
    set_last_mechanism(place.last);
  } else {
    Random<double> random(seed);
    const MechanismAtAState mechanism = mechanism_at_a_state(random, recipe);
    place = {seed, recipe, most_bodies, last_mechanism(), std::pair{mechanism.model, mechanism.state}};
  }
  return *place.model_and_state;
}

}  // namespace

Trial::Trial(const Case& c, Model built, const State<double>& at)
    : how(c), model(std::move(built)), state(rounded(c, at)), subject_(subject(c, model)) {}
Trial::Trial(const Case& c, const Model& built, Random<double>& random)
    : Trial(c, built, random_state(built, random)) {}
Trial::Trial(const Case& c, std::uint64_t seed, const TreeRecipe& recipe) : Trial(c, drawn(seed, recipe)) {}
Trial::Trial(const Case& c, const std::pair<Model, State<double>>& drawn)
    : Trial(c, drawn.first, drawn.second) {}
Trial::~Trial() = default;

Trial Trial::by(const Case& other) const { return {other, model, state}; }
Trial Trial::by(Representation representation) const { return by(in(representation, how)); }

Ask Trial::ask() const { return {.q = state.q, .v = state.v, .a = state.a, .loads = state.loads()}; }
Answer Trial::answer(std::string_view function, const Ask& with) { return subject_->call(function, with); }
Trial::Numbers Trial::call(std::string_view function, const Ask& with) {
  return answer(function, with).numbers;
}
Trial::Numbers Trial::call(std::string_view function) { return call(function, ask()); }

std::vector<SE3<>> Trial::poses() { return poses_of(call("poses")); }
std::vector<Six> Trial::twists(const Numbers& v) { return sixes_of(call("twists", {.q = state.q, .v = v})); }
std::vector<Six> Trial::twists() { return twists(state.v); }
std::vector<Six> Trial::accelerations() { return sixes_of(call("accelerations")); }
std::vector<Six> Trial::joint_wrenches() { return sixes_of(call("joint_wrenches")); }
Trial::Numbers Trial::inverse_dynamics(const Numbers& v, const Numbers& a, const Loads<>& loads) {
  return call("inverse_dynamics", {.q = state.q, .v = v, .a = a, .loads = loads});
}
Trial::Numbers Trial::inverse_dynamics() { return inverse_dynamics(state.v, state.a, state.loads()); }
Eigen::MatrixXd Trial::mass_matrix() { return matrix(model.nv(), call("mass_matrix")); }

Trial::Numbers Trial::zero() const { return Numbers(static_cast<std::size_t>(model.nv())); }

}  // namespace axode::test
