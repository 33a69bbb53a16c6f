#pragma once
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "axode/constraints/loops.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/trajectory.hpp"
#include "axode/model/workspace.hpp"

/// Drives for SimulationOptions::drive and batch::rollout: what they make of (t, q, v) is written into tau (nv).
namespace axode {

using Drive = std::function<void(double t, std::span<const double> q, std::span<const double> v,
                                 std::span<double> tau)>;

/// Forces that are given at times: in between on straight lines, or held until the next time; the first ones hold before and
/// the last ones after. tau has a row of nv numbers for each time. Throws std::invalid_argument for no times, times that
/// do not increase, a wrong size, and numbers that are not finite.
class SampledDrive {
 public:
  SampledDrive(const Model& model, std::span<const double> times, std::span<const double> tau,
               bool hold = false);
  void operator()(double t, std::span<const double> q, std::span<const double> v,
                  std::span<double> tau) const;

 private:
  std::vector<double> times_, tau_;
  bool hold_;
};

/// Where a controller is to lead: q_d, v_d and a_d at a time.
class Reference {
 public:
  /// Always the same; v and a are 0 where they are empty. Throws std::invalid_argument for wrong sizes, a quaternion off 1
  /// and numbers that are not finite.
  Reference(const Model& model, std::span<const double> q, std::span<const double> v = {},
            std::span<const double> a = {});
  /// Those of a motion, which rests where it begins before that, and where it ends after that. Throws
  /// std::invalid_argument for one without a state or with other numbers of coordinates than the model.
  Reference(const Model& model, Trajectory motion);

  /// Finds them for a time.
  void find(double t);
  const std::vector<double>& q() const { return q_; }
  const std::vector<double>& v() const { return v_; }
  const std::vector<double>& a() const { return a_; }

 private:
  std::optional<Trajectory> motion_;
  std::vector<double> q_, v_, a_;
};

/// Gains of each velocity, or one number for all. Gains of 0 leave a joint, or a free base, to itself; those of passive
/// joints are taken as 0.
struct Gains {
  std::span<const double> kp, kd;
};

/// What controllers share: gains, and how far the state is from where it is to be.
class Tracking {
 public:
  const std::vector<double>& kp() const { return kp_; }
  const std::vector<double>& kd() const { return kd_; }
  const Reference& reference() const { return reference_; }

 protected:
  Tracking(const Model& model, const Gains& gains, Reference reference);
  /// Finds the reference for a time, and the x with q ⊕ x = q_d.
  void find(double t, std::span<const double> q);

  Model model_;
  std::vector<double> kp_, kd_, x_;
  Reference reference_;

 private:
  ConfigurationGroup<double> group_;
};

/// τ = kp x + kd (v_d - v) + feedforward, with q ⊕ x = q_d on the group of configurations, by the shorter way round on
/// rotations: kp in N m/rad or N/m, kd in N m s/rad or N s/m. `clip` keeps it within the joints' limits of effort. Throws
/// std::invalid_argument for gains that are negative, not finite or not one or nv numbers.
class ProportionalDerivative : public Tracking {
 public:
  ProportionalDerivative(const Model& model, const Gains& gains, Reference reference, Drive feedforward = {},
                         bool clip = false);
  void operator()(double t, std::span<const double> q, std::span<const double> v, std::span<double> tau);
  const Drive& feedforward() const { return feedforward_; }
  /// Of effort, of each velocity; empty where nothing is clipped.
  const std::vector<double>& limit() const { return limit_; }

 private:
  std::vector<double> limit_;
  Drive feedforward_;
};

/// τ = ID(q, v, a_d + kd (v_d - v) + kp x) less what the springs of the model do, so that x'' + kd x' + kp x = 0 for small
/// x: kp in 1/s², kd in 1/s. Loads and joint losses are not known to it. Throws as ProportionalDerivative.
///
/// In a mechanism with loops or passive joints, passive joints get no force, and x holds accelerations of the
/// drives alone. These accelerations are the wanted ones as far as the mechanism lets the drives make them,
/// otherwise those nearest, each acceleration measured by the one that a unit force of its drive makes; τ is
/// what inverse_dynamics() with loops gives for them. NaN where the mechanism has no accelerations. Allocates
/// there; O(nv³ + nv d²) for d drives.
class ComputedTorque : public Tracking {
 public:
  ComputedTorque(const Model& model, const Gains& gains, Reference reference);
  void operator()(double t, std::span<const double> q, std::span<const double> v, std::span<double> tau);
  /// Whether it is the inverse dynamics of a tree that has a drive for every velocity.
  bool drives_all() const { return !loops_; }

 private:
  /// Replaces the wanted accelerations in x_ by those that the drives make; false where there are none.
  bool make_possible(std::span<const double> q, std::span<const double> v);

  Workspace<> workspace_;
  std::optional<LoopWorkspace<>> loops_;  ///< of a mechanism with loops or passive joints
  std::vector<double> springs_;
};

}  // namespace axode
