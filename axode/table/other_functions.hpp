#pragma once
#include "axode/table/functions.hpp"

namespace axode::catalog {

/// Functions of a mechanism that are no rows of the table: they take motions of any order, or targets, or
/// return more than numbers. Only the properties that they count are listed here.
struct Other {
  std::string_view name;
  Counts counts;
};
inline constexpr auto other_functions = std::to_array<Other>({
    {"inverse_dynamics_rates", table::of_forces},
    {"inverse_kinematics_rates",
     {.loops = counted,
      .passive_joints = of_the_tree(),
      .springs = of_the_tree(),
      .joint_losses = of_the_tree(),
      .motions = of_the_tree(),
      .contacts = of_the_tree()}},
    {"forward_dynamics_rates", table::of_derivatives_of_accelerations},
    {"linearize",
     {.loops = refused("independent_linearization counts them"),
      .passive_joints = of_the_tree(),
      .springs = counted,
      .joint_losses = optional,
      .motions = refused("reduced locks the joints that they move"),
      .contacts = of_the_tree()}},
    {"inverse_kinematics",
     {.loops = refused("assemble closes them, with joints held where they are to stay"),
      .passive_joints = of_the_tree(),
      .springs = of_the_tree(),
      .joint_losses = of_the_tree(),
      .motions = of_the_tree(),
      .contacts = of_the_tree()}},
    {"rollout",
     {.loops = counted,
      .passive_joints = of_the_tree(),
      .springs = counted,
      .joint_losses = optional,
      .motions = refused("simulate counts them"),
      .contacts = table::without_contacts}},
    {"rollout sensitivities",
     {.loops = refused("forward_dynamics, inverse_dynamics and simulate count them"),
      .passive_joints = of_the_tree(),
      .springs = counted,
      .joint_losses = counted,
      .motions = refused("simulate counts them"),
      .contacts = table::without_contacts}},
});

/// The number of such a function, which the compiler finds by its name.
struct OtherId {
  std::size_t index = 0;
  consteval OtherId(const char* name) {  // NOLINT(google-explicit-constructor): a name converts to an OtherId
    while (index < other_functions.size() && other_functions[index].name != name) ++index;
    if (index == other_functions.size()) throw "no other function has this name";
  }
};

}  // namespace axode::catalog
