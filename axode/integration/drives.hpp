#pragma once
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "axode/constraints/loops.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/trajectory.hpp"
#include "axode/model/workspace.hpp"

/// Drives without states: functions that are called with a time t (s) and a state (q, v), and write the drive
/// forces tau (nv numbers; N m or N).
namespace axode {

using Drive = std::function<void(double t, std::span<const double> q, std::span<const double> v,
                                 std::span<double> tau)>;

/// A drive with given forces at times (s), one row of nv numbers in tau for each. In between, forces are
/// interpolated linearly or, if `hold` is true, keep the earlier value; before the first and after the last
/// time they are constant. Throws std::invalid_argument if there is no time, times do not increase, a size is
/// wrong or a number is not finite.
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

/// The reference of a controller: configuration, velocities and accelerations as functions of time.
class Reference {
 public:
  /// A reference that has the given q, v and a at all times, with v = 0 and a = 0 if these spans are empty.
  /// Throws std::invalid_argument for wrong sizes, quaternions that are not of unit norm and numbers that are
  /// not finite.
  Reference(const Model& model, std::span<const double> q, std::span<const double> v = {},
            std::span<const double> a = {});
  /// A reference that follows a motion, and rests at its ends before and after it. Throws
  /// std::invalid_argument if the motion has no state, or if its model has another nq or nv than `model`.
  Reference(const Model& model, Trajectory motion);

  /// Evaluates the reference at a time t (s); q(), v() and a() have the results.
  void find(double t);
  const std::vector<double>& q() const { return q_; }
  const std::vector<double>& v() const { return v_; }
  const std::vector<double>& a() const { return a_; }

 private:
  std::optional<Trajectory> motion_;
  std::vector<double> q_, v_, a_;
};

/// The gains of a controller: kp for deviations of the configuration, and kd for deviations of the
/// velocities. Each has nv numbers, or one number for all velocities. A joint or free base with gains 0 is
/// not controlled; gains of passive joints are taken as 0.
struct Gains {
  std::span<const double> kp, kd;
};

/// The common part of controllers: the gains, and the deviation of a configuration from the reference.
class Tracking {
 public:
  const std::vector<double>& kp() const { return kp_; }
  const std::vector<double>& kd() const { return kd_; }
  const Reference& reference() const { return reference_; }

 protected:
  Tracking(const Model& model, const Gains& gains, Reference reference);
  /// Stores in x_ the deviation x of q from the reference q_d at a time t (s), defined by q ⊕ x = q_d.
  void find(double t, std::span<const double> q);

  Model model_;
  std::vector<double> kp_, kd_, x_;
  Reference reference_;

 private:
  ConfigurationGroup<double> group_;
};

/// A proportional-derivative controller: τ = kp x + kd (v_d - v) + w. The deviation x from the reference q_d
/// is defined by q ⊕ x = q_d, where rotations take the shorter way round; v_d are the reference velocities,
/// and w are the forces that the function `feedforward` computes, or 0 if it is empty. kp is in N m/rad or
/// N/m, kd in N m s/rad or N s/m. `clip` limits τ to the effort limits of the joints. Throws
/// std::invalid_argument if gains are negative or not finite, or if their number is not 1 or nv.
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
/// model. ID are the forces of inverse dynamics, q_d, v_d and a_d are the reference, and the deviation x is
/// defined by q ⊕ x = q_d. Hence small deviations obey x'' + kd x' + kp x = 0. kp is in 1/s², kd in 1/s.
/// Loads and joint losses are not compensated. Throws std::invalid_argument if gains are negative or not
/// finite, or if their number is not 1 or nv.
///
/// In a mechanism with loops or passive joints, the control law defines the accelerations of the driven
/// joints only, and passive joints have no force. If the drives cannot produce these accelerations, the
/// controller uses the nearest ones that they can produce: it minimises the sum of the squared differences,
/// each divided by the acceleration that a unit force of its drive causes. In such a mechanism, τ is NaN if
/// the mass matrix is singular, and each call allocates and takes O(nv³ + nv d²) for d drives.
class ComputedTorque : public Tracking {
 public:
  ComputedTorque(const Model& model, const Gains& gains, Reference reference);
  void operator()(double t, std::span<const double> q, std::span<const double> v, std::span<double> tau);
  /// Whether the mechanism is a tree with a drive for every velocity.
  bool drives_all() const { return !loops_; }

 private:
  /// Replaces the accelerations x_ (nv) of the control law by accelerations of all joints that the drives can
  /// produce. These minimise the sum, over the driven joints, of the squared difference from the control law
  /// divided by the acceleration that a unit force of the joint's drive causes. Returns false if the mass
  /// matrix is singular or a result is not finite.
  bool make_possible(std::span<const double> q, std::span<const double> v);

  Workspace<> workspace_;
  std::optional<LoopWorkspace<>> loops_;  ///< for mechanisms with loops or passive joints
  std::vector<double> springs_;
};

}  // namespace axode
