#pragma once
#include <functional>
#include <string>
#include <vector>

#include "apps/files/json_text.hpp"
#include "apps/files/state.hpp"
#include "apps/shell/table.hpp"
#include "axode/dynamics/closed_form/coriolis.hpp"
#include "axode/dynamics/joint_wrenches.hpp"
#include "axode/model/model.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode::command {

/// A question of `axode eval` about a mechanism: the model, its state, and options for the answer.
struct Question {
  Model model;
  State state;
  Representation representation = Representation::body;
  bool joint_losses = false;
  std::vector<int> frames = {};  ///< frames to which the answer is limited; all if empty
  int relative_to = 0;           ///< the frame of the observer, for relative motion; 0 is the ground
  int order = 1;                 ///< order of derivatives
  CoriolisForm coriolis = CoriolisForm::christoffel;
  WrenchPoint at = WrenchPoint::body;  ///< point about which the moments of joint_wrenches are taken
  /// Stiffness of the springs and inertia of the motors of drives, N m/rad or N/m and kg m² or kg: words
  /// NUMBER for all joints, or JOINT=NUMBER.
  std::vector<std::string> stiffness = {}, inertia = {};

  Loads<> loads() const { return {state.loads, joint_losses}; }
};

/// The answer to a question: the values as JSON and as a table, their units, and details such as axes.
struct Answer {
  Json value;
  Table table;
  std::string units = {}, details = {};
};

/// A quantity that `axode eval` can compute: its name, a sentence on its purpose, and how it is computed.
struct Quantity {
  std::string_view name, purpose;
  std::function<Answer(const Question&)> answer;
};
/// All quantities of `axode eval`, in the order of the documentation.
const std::vector<Quantity>& quantities();
/// The quantities that need an order of differentiation or targets, or whose results are not only numbers.
std::vector<Quantity> other_quantities();
/// The quantities about closed loops.
std::vector<Quantity> loop_quantities();
/// The quantities about collision shapes.
std::vector<Quantity> contact_quantities();
/// The quantities about motors.
std::vector<Quantity> drive_quantities();

/// The frames that the question names, or all frames but the inertial frame if it names none.
std::vector<int> frames_of(const Question& ask);

/// A description of the axes and the reference point of the six components of a twist in a representation.
std::string twist_axes(Representation representation);
/// A detail of an answer: the name of the representation of its components, and their axes.
std::string components_in(Representation representation, const std::string& axes);

}  // namespace axode::command
