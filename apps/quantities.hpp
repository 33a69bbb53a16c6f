#pragma once
#include <functional>
#include <string>
#include <vector>

#include "axode/dynamics/coriolis.hpp"
#include "axode/dynamics/joint_wrenches.hpp"
#include "axode/model/model.hpp"
#include "axode/recursion/solvability.hpp"
#include "json_text.hpp"
#include "state.hpp"
#include "table.hpp"

namespace axode::command {

/// A question about a mechanism: the model, its state, and how to answer.
struct Question {
  Model model;
  State state;
  Representation representation = Representation::body;
  bool joint_losses = false;
  std::vector<int> frames = {};  ///< the frames it is about; none: all
  int relative_to = 0;           ///< the frame of the observer, for relative motion; 0 is the ground
  int order = 1;                 ///< of derivatives
  CoriolisForm coriolis = CoriolisForm::christoffel;
  WrenchPoint at = WrenchPoint::body;  ///< of joint_wrenches

  Loads<> loads() const { return {state.loads, joint_losses}; }
};

/// What a quantity is, its units and axes, and its value twice: for programs and for people.
struct Answer {
  std::string label;
  Json value;
  Table table;
};

/// What `axode eval` can compute.
struct Quantity {
  std::string_view name, purpose;
  std::function<Answer(const Question&)> answer;
};
/// All, in the order of the documentation: the functions of the catalogue, and those that are none of one
/// state.
const std::vector<Quantity>& quantities();
/// Those that are not in the catalogue: they take an order or targets, or make more than numbers.
std::vector<Quantity> other_quantities();
/// Those about closed loops.
std::vector<Quantity> loop_quantities();

/// The frames that the question is about: those it names, or all but the inertial one.
std::vector<int> frames_of(const Question& ask);

/// Where the six components of a twist live, by representation.
std::string twist_axes(Representation representation);
/// A label: what it is, in which representation and axes, and its units.
std::string headline(std::string_view what, Representation representation, const std::string& axes,
                     std::string_view units);

}  // namespace axode::command
