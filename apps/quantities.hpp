#pragma once
#include <string>
#include <vector>

#include "axode/dynamics/coriolis.hpp"
#include "axode/model/model.hpp"
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
};

/// What a quantity is, its units and axes, and its value twice: for programs and for people.
struct Answer {
  std::string label;
  Json value;
  Table table;
};

/// What `axode eval` can compute.
struct Quantity {
  std::string_view name;
  std::string_view purpose;
  Answer (*answer)(const Question&);
};
const std::vector<Quantity>& quantities();
/// Those of them that are about Jacobians, their derivatives and motion of higher order.
std::vector<Quantity> kinematic_quantities();
/// Mass and Coriolis matrices, forward dynamics, momenta, energies, regressors, inertia at a frame.
std::vector<Quantity> dynamic_quantities();

/// Where the six components of a twist live, by representation.
std::string twist_axes(Representation representation);
std::string wrench_axes(Representation representation);
/// A label: what it is, in which representation and axes, and its units.
std::string headline(std::string_view what, Representation representation, const std::string& axes,
                     std::string_view units);

/// A row for each velocity of the model, or coordinate, with the name of its joint: `name` or `name[2]`.
std::vector<std::string> velocity_names(const Model& model);
std::vector<std::string> coordinate_names(const Model& model);

}  // namespace axode::command
