#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/contact/law/contact_system.hpp"

namespace axode {

/// The data from which a substep with contact is differentiated: its states, its impulses, and which contacts
/// slide and bounce. A substep is a whole step, or a part of a step that was repeated in parts.
struct ContactPart {
  using Vector = Eigen::VectorXd;
  /// The distance of a joint from a stop (rad or m) up to which the stop is closed at the end of a step.
  static constexpr double near_stop = 1e-9;
  /// A floating base, and whether its centre of mass rests in its moving frame, see FloatingBases.
  struct Base {
    int body;
    bool constant;
  };

  double h = 0;                                            ///< length of the part, s
  double margin = 0;                                       ///< gap up to which contacts were found, m
  Vector q_0, v_0;                                         ///< state at the start, before impulses
  Vector q_middle, v_middle, q_1, v_before_end;            ///< results of ContactSimulationRun::fly()
  Vector v_1;                                              ///< velocities after the impulses at the end
  std::vector<Contact> start = {}, end = {};               ///< contacts in the problems at start and end
  std::vector<double> lambda_start = {}, lambda_end = {};  ///< multipliers in scaled rows
  std::vector<char> slides = {};    ///< for each contact in `start`: its friction opposes the mean velocity
  std::vector<char> bounces = {};   ///< for each contact in `start`, then each stop: it bounces
  std::vector<char> overlaps = {};  ///< for each contact in `start`: its gap is negative beyond rounding
  double bounciness = 1;            ///< factor by which restitutions are reduced
  std::vector<Contact> apart = {};  ///< contacts that were moved apart at the end (D11.15), or none
  std::vector<double> lambda_apart = {};
  double most_apart = 0;  ///< largest overlap that is removed in one step, m
  std::vector<Base> bases = {};
};

}  // namespace axode
