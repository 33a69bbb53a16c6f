#pragma once
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/support/dense.hpp"
#include "tests/support/random_loops.hpp"
#include "tests/support/subject.hpp"

namespace axode::test {

/// A random mechanism and a state of it, with the quantities that laws compare, computed in the way of one
/// case.
class Trial {
 public:
  using Numbers = std::vector<double>;

  Trial(const Case& c, Model built, const State<double>& at);
  Trial(const Case& c, const Model& built, Random<double>& random);
  Trial(const Case& c, const MechanismAtAState& drawn) : Trial(c, drawn.model, drawn.state) {}
  Trial(const Case& c, std::uint64_t seed, const TreeRecipe& recipe = {});
  ~Trial();

  const Case how;
  const Model model;
  State<double> state;  ///< rounded to the scalar type of the case

  /// The same mechanism and state for another case.
  Trial by(const Case& other) const;
  Trial by(Representation representation) const;

  /// The arguments of a call at this state: its q, v, a and wrenches. A law may change them before it calls.
  Ask ask() const;
  Answer answer(std::string_view function, const Ask& with);
  Numbers call(std::string_view function, const Ask& with);
  Numbers call(std::string_view function);

  std::vector<SE3<>> poses();
  std::vector<Six> twists(const Numbers& v);
  std::vector<Six> twists();
  std::vector<Six> accelerations();
  std::vector<Six> joint_wrenches();
  Numbers inverse_dynamics(const Numbers& v, const Numbers& a, const Loads<>& loads);
  Numbers inverse_dynamics();
  Eigen::MatrixXd mass_matrix();

  Numbers zero() const;
  std::size_t n_frames() const { return static_cast<std::size_t>(model.n_frames()); }
  std::size_t n_bodies() const { return static_cast<std::size_t>(model.n_bodies()); }

 private:
  Trial(const Case& c, const std::pair<Model, State<double>>& drawn);

  std::unique_ptr<Subject> subject_;
};

}  // namespace axode::test
