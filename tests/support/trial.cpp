#include "tests/support/trial.hpp"

namespace axode::test {

Trial::Trial(const Case& c, Model built, const State<double>& at)
    : how(c), model(std::move(built)), state(rounded(c, at)), subject_(subject(c, model)) {}
Trial::Trial(const Case& c, const Model& built, Random<double>& random)
    : Trial(c, built, random_state(built, random)) {}
Trial::Trial(const Case& c, Random<double> random, const TreeRecipe& recipe)
    : Trial(c, mechanism_at_a_state(random, recipe)) {}
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
