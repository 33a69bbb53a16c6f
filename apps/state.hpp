#pragma once
#include <string>
#include <vector>

#include "axode/kinematics.hpp"
#include "axode/model/model.hpp"
#include "axode/recursion/loads.hpp"

namespace axode::command {

/// The state of a model, in the model's order.
struct State {
  std::vector<double> q, v, a;
  std::vector<double> jerk, snap;        ///< the derivatives of a
  std::vector<double> tau;               ///< drive forces
  std::vector<double> p;                 ///< generalised momenta; empty where the state has none
  std::vector<double> dq, dv, da, dtau;  ///< a direction
  std::vector<double> w;                 ///< weights of forces or accelerations
  std::vector<AppliedWrench<>> loads;
  std::vector<PoseTarget> targets;
};

/// Every joint at zero and at rest, nothing applied.
State neutral_state(const Model& model);

/// Some state in motion, always the same one, nothing applied.
State random_state(const Model& model);

/// The state in a JSON file, "-" for standard input:
///
///     {"q": [0.1, 0.2], "v": {"elbow": 1}, "a": {}, "loads": [{"frame": "tool", "wrench": [0, 0, 0, 0, 0, -5]}]}
///
/// q, v, a, jerk, snap, tau, p, the direction dq, dv, da, dtau and the weights w are arrays in the model's
/// order or objects keyed by joint name; what is not given is neutral, or zero, and each weight 1. "targets"
/// are poses for inverse kinematics: a list of {"frame", "pose"}, four rows of four numbers. A load's
/// representation is "body" where it says nothing. Throws InputError with everything that is wrong.
State read_state(const Model& model, const std::string& file);

/// States one after the other.
struct Sweep {
  std::vector<State> states;
  std::vector<double> t;  ///< the times of the states, or their numbers from 0
  bool timed = false;     ///< whether they have times
};
/// The states in a CSV file, a row for each, as `axode simulate --output run.csv` writes them: the columns t,
/// q NAME, v NAME, a NAME and tau NAME, of which any may be left out and a column energy is passed over.
/// Throws InputError.
Sweep read_sweep(const Model& model, const std::string& file);

}  // namespace axode::command
