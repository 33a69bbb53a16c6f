#pragma once
#include <string>
#include <vector>

#include "axode/kinematics.hpp"
#include "axode/model/model.hpp"
#include "axode/recursion/loads.hpp"

namespace axode::command {

/// A state of a model. The numbers are in the order of the model.
struct State {
  std::vector<double> q, v, a;
  std::vector<double> jerk, snap;        ///< the derivatives of a
  std::vector<double> tau;               ///< drive forces
  std::vector<double> p;                 ///< generalised momenta; empty if the state has none
  std::vector<double> dq, dv, da, dtau;  ///< a direction for derivatives
  std::vector<double> w;                 ///< weights of forces or accelerations
  std::vector<AppliedWrench<>> loads;
  std::vector<PoseTarget> targets;
};

/// The state with every joint at zero and at rest, without forces.
State neutral_state(const Model& model);

/// A state in motion that is the same in every call, without forces.
State random_state(const Model& model);

/// Reads the state in a JSON file, "-" for standard input:
///
///     {"q": [0.1, 0.2], "v": {"elbow": 1}, "a": {}, "loads": [{"frame": "tool", "wrench": [0, 0, 0, 0, 0, 5]}]}
///
/// q, v, a, jerk, snap, tau, p, the direction dq, dv, da, dtau and the weights w are arrays in the model's
/// order or objects keyed by joint name. Missing entries are neutral, or zero, and 1 for weights. "targets"
/// are poses for inverse kinematics: a list of {"frame", "pose"}, four rows of four numbers. The default
/// representation of a load is "body". Throws InputError with all faults.
State read_state(const Model& model, const std::string& file);

/// A sequence of states.
struct Sweep {
  std::vector<State> states;
  std::vector<double> t;  ///< times of the states, or their indices from 0
  bool timed = false;     ///< whether the file has times
};
/// Reads the states in a CSV file as `axode simulate --output run.csv` writes it, a row for each state. The
/// columns are t, q NAME, v NAME, a NAME and tau NAME. Any of them may be missing, and a column energy is
/// ignored. Throws InputError.
Sweep read_sweep(const Model& model, const std::string& file);

}  // namespace axode::command
