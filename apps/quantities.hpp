#pragma once
#include <string>
#include <vector>

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

/// A row for each velocity of the model, or coordinate, with the name of its joint: `name` or `name[2]`.
std::vector<std::string> velocity_names(const Model& model);
std::vector<std::string> coordinate_names(const Model& model);

}  // namespace axode::command
