#pragma once
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "axode/constraints/loops.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/trajectory.hpp"
#include "axode/model/workspace.hpp"

/// Drives for SimulationOptions::drive and batch::rollout. A drive is called with (t, q, v) and writes the
/// drive forces tau (nv).
namespace axode {

using Drive = std::function<void(double t, std::span<const double> q, std::span<const double> v,
                                 std::span<double> tau)>;

/// Forces that are given at times. In between they are interpolated linearly, or held until the next time;
/// before the first and after the last time they are constant. tau has a row of nv numbers for each time.
/// Throws std::invalid_argument if there is no time, times do not increase, a size is wrong or a number is
/// not finite.
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

/// The reference q_d, v_d and a_d of a controller as a function of time.
class Reference {
 public:
  /// A constant reference; v and a are 0 if they are empty. Throws std::invalid_argument for wrong sizes,
  /// quaternions that are not of unit norm and numbers that are not finite.
  Reference(const Model& model, std::span<const double> q, std::span<const double> v = {},
            std::span<const double> a = {});
  /// A motion, at rest before its start and after its end. Throws std::invalid_argument if it has no state or
  /// another number of coordinates than the model.
  Reference(const Model& model, Trajectory motion);

  /// Evaluates the reference at a time.
  void find(double t);
  const std::vector<double>& q() const { return q_; }
  const std::vector<double>& v() const { return v_; }
  const std::vector<double>& a() const { return a_; }

 private:
  std::optional<Trajectory> motion_;
  std::vector<double> q_, v_, a_;
};

/// Gains for each velocity, or one number for all. With gains of 0 a joint or free base is not controlled;
/// gains of passive joints are taken as 0.
struct Gains {
  std::span<const double> kp, kd;
};

/// Common part of controllers: gains and the deviation from the reference.
class Tracking {
 public:
  const std::vector<double>& kp() const { return kp_; }
  const std::vector<double>& kd() const { return kd_; }
  const Reference& reference() const { return reference_; }

 protected:
  Tracking(const Model& model, const Gains& gains, Reference reference);
  /// Evaluates the reference at a time, and computes the deviation x with q ⊕ x = q_d.
  void find(double t, std::span<const double> q);

  Model model_;
  std::vector<double> kp_, kd_, x_;
  Reference reference_;

 private:
  ConfigurationGroup<double> group_;
};

/// A proportional-derivative controller: τ = kp x + kd (v_d - v) + feedforward, with the deviation x of q ⊕ x
/// = q_d on the group of configurations, where rotations take the shorter way round. kp is in N m/rad or N/m,
/// kd in N m s/rad or N s/m. `clip` limits τ to the effort limits of the joints. Throws std::invalid_argument
/// if gains are negative or not finite, or if their number is not 1 or nv.
class ProportionalDerivative : public Tracking {
 public:
  ProportionalDerivative(const Model& model, const Gains& gains, Reference reference, Drive feedforward = {},
                         bool clip = false);
  void operator()(double t, std::span<const double> q, std::span<const double> v, std::span<double> tau);
  const Drive& feedforward() const { return feedforward_; }
  /// The effort limit of each velocity; empty if forces are not clipped.
  const std::vector<double>& limit() const { return limit_; }

 private:
  std::vector<double> limit_;
  Drive feedforward_;
};

/// A computed-torque controller: τ = ID(q, v, a_d + kd (v_d - v) + kp x) minus the spring forces of the
/// model, where ID is inverse dynamics and q ⊕ x = q_d, so that x'' + kd x' + kp x = 0 for small x. kp is in
/// 1/s², kd in 1/s. Loads and joint losses are not compensated. It throws as ProportionalDerivative does.
///
/// In a mechanism with loops or passive joints, passive joints get no force, and the control law defines
/// wanted accelerations of the drives only. If the drives cannot produce them, the nearest accelerations that
/// they can produce are used instead; the difference of each is measured by the acceleration that a unit
/// force of its drive causes. τ is the inverse dynamics with loops at these accelerations, or NaN if the mass
/// matrix is singular. For such a mechanism each call allocates and takes O(nv³ + nv d²) for d drives.
class ComputedTorque : public Tracking {
 public:
  ComputedTorque(const Model& model, const Gains& gains, Reference reference);
  void operator()(double t, std::span<const double> q, std::span<const double> v, std::span<double> tau);
  /// Whether the mechanism is a tree with a drive for every velocity.
  bool drives_all() const { return !loops_; }

 private:
  /// Replaces the wanted accelerations in x_ by those that the drives produce; returns false if there are
  /// none.
  bool make_possible(std::span<const double> q, std::span<const double> v);

  Workspace<> workspace_;
  std::optional<LoopWorkspace<>> loops_;  ///< for mechanisms with loops or passive joints
  std::vector<double> springs_;
};

}  // namespace axode
