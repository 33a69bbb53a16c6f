#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/contact/law/contact_system.hpp"

namespace axode {

/// A step of ContactStep, or a part of one that was repeated in parts: its states, its impulses and its
/// decisions. They determine its derivative.
struct ContactPart {
  using Vector = Eigen::VectorXd;
  /// The room up to which a stop counts as closed at the end, rad or m.
  static constexpr double near_stop = 1e-9;
  /// A floating base, and whether its centre of mass rests in its moving frame, see FloatingBases.
  struct Base {
    int body;
    bool constant;
  };

  double h = 0;                                  ///< s
  double margin = 0;                             ///< gap up to which contacts were found, m
  Vector q_0, v_0;                               ///< at the start, before impulses
  Vector q_middle, v_middle, q_1, v_before_end;  ///< of the free motion, see ContactSimulationRun::fly()
  std::vector<Contact> start = {}, end = {};     ///< with rows in the two problems
  std::vector<double> lambda_start = {}, lambda_end = {};  ///< multipliers in scaled rows
  std::vector<char> slides = {};    ///< of each contact at the start: friction against the mean velocity
  std::vector<char> bounces = {};   ///< of each contact and stop at the start
  std::vector<char> overlaps = {};  ///< of each contact at the start: by more than rounding
  double bounciness = 1;            ///< factor of restitutions
  std::vector<Contact> apart = {};  ///< contacts that were moved apart at the end (D11.15), or none
  std::vector<double> lambda_apart = {};
  double most_apart = 0;  ///< the largest overlap that was parted, m
  std::vector<Base> bases = {};
};

}  // namespace axode
