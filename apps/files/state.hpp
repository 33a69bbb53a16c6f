#pragma once
#include <string>
#include <vector>

#include "axode/kinematics.hpp"
#include "axode/model/model.hpp"
#include "axode/recursion/loads.hpp"

namespace axode::command {

/// A state (q, v) of a model, and other arguments of functions of a state. The numbers of q are in the order
/// of the model's coordinates, those of all other vectors of numbers in the order of its velocities. Loads
/// are wrenches on frames, and targets are poses of frames.
struct State {
  std::vector<double> q, v, a;
  std::vector<double> jerk, snap;        ///< the derivatives of a
  std::vector<double> tau;               ///< drive forces
  std::vector<double> p;                 ///< generalised momenta; empty if the state has none
  std::vector<double> dq, dv, da, dtau;  ///< direction of directional derivatives
  std::vector<double> w;                 ///< weights of the forces or accelerations, for gradients
  std::vector<AppliedWrench<>> loads;
  std::vector<PoseTarget> targets;
};

/// The velocities v and their derivatives a, jerk and snap of a state, one vector after the other.
std::vector<double> rates_of(const State& state);

/// The state with every joint at zero and at rest, without forces.
State neutral_state(const Model& model);

/// A random state in motion without forces. It is the same in every call.
State random_state(const Model& model);
/// One of several such states.
State random_state(const Model& model, unsigned seed);

/// Reads a state from a JSON file, or from standard input if `file` is "-":
///
///     {"q": [0.1, 0.2], "v": {"elbow": 1}, "a": {}, "loads": [{"frame": "tool", "wrench": [0, 0, 0, 0, 0, 5]}]}
///
/// The keys for numbers are q, v, the time derivatives a, jerk and snap of v, the drive forces tau, the
/// momenta p, the direction dq, dv, da, dtau of a directional derivative, and the weights w of the components
/// of τ or a in a weighted sum, of which a gradient is computed. The value of each is an array in the order
/// of the model or an object keyed by joint name. Missing numbers are those of the neutral configuration (0,
/// or the quaternion of no rotation) for q, 1 for w and 0 for all others; without the key p the state has no
/// momenta. "targets" are poses for inverse kinematics: a list of objects {"frame", "pose"}, where the pose
/// is four rows of four numbers. "loads" are wrenches on frames, in the representation that the key
/// "representation" names, or "body" without this key. Throws InputError with all faults of the file.
State read_state(const Model& model, const std::string& file);

/// A sequence of states, for which `axode eval` computes quantities.
struct Sweep {
  std::vector<State> states;
  std::vector<double> t;  ///< times of the states, or their indices from 0
  bool timed = false;     ///< whether the file has times
};
/// Reads a sequence of states from a CSV file with a row for each state. The column `t` has the times. Every
/// other column has one number of each state and a name such as `q elbow` or `tau hip[0]`. The first word is
/// q (coordinate), v (velocity), a, jerk, snap (the first three time derivatives of v) or tau (drive force).
/// The rest is the name of a coordinate or velocity, which is the name of its joint, with an index if the
/// joint has several. Any column may be missing, and a column `energy` is ignored. Throws InputError if the
/// file does not fit the model.
Sweep read_sweep(const Model& model, const std::string& file);

}  // namespace axode::command
