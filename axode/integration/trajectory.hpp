#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>

#include "axode/integration/configuration_group.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// Why a motion cannot go on at a time. Nothing, and false, where it can.
struct [[nodiscard]] Failure {
  double t = 0;
  std::string why = {};

  explicit operator bool() const { return !why.empty(); }
};

/// A motion at times t_0 < t_1 < ..., the ends of steps, and in between.
class Trajectory {
 public:
  explicit Trajectory(const Model& model) : model_(model) {}

  const Model& model() const { return model_; }
  std::size_t size() const { return t_.size(); }
  std::span<const double> t() const { return t_; }
  /// Row by row: size() × nq, nv, nv, nv. τ is that of the drives, 0 without.
  std::span<const double> q() const { return q_; }
  std::span<const double> v() const { return v_; }
  std::span<const double> a() const { return a_; }
  std::span<const double> tau() const { return tau_; }
  std::span<const double> q(std::size_t k) const { return std::span(q_).subspan(k * nq(), nq()); }
  std::span<const double> v(std::size_t k) const { return std::span(v_).subspan(k * nv(), nv()); }
  std::span<const double> a(std::size_t k) const { return std::span(a_).subspan(k * nv(), nv()); }

  /// q, v and, unless it is empty, a at a time, on the group: q = (q_k ⊕ (t - t_k) z) ⊕ x(t) in the step from t_k. z is the mean
  /// velocity of the step for joints of several velocities, and 0 for the others. x(t) is the quintic with which q, v and a
  /// are those of the step at both ends. A body may turn by any angle in a step if z is right within half a turn. The errors
  /// are of order h⁶ in q, h⁵ in v and h⁴ in a. Throws std::invalid_argument for a time outside.
  void at(double time, std::span<double> q, std::span<double> v, std::span<double> a = {}) const;

  /// Another end of a step.
  void append(double t, std::span<const double> q, std::span<const double> v, std::span<const double> a,
              std::span<const double> tau);

  /// From the last one on v and a are these: a jumps there, and v changes by rounding. a(k) is what follows.
  void jump(std::span<const double> v, std::span<const double> a);

  /// Takes back the last one.
  void pop_back();

  std::size_t steps = 0, rejected = 0;  ///< that were taken, and tried in vain
  std::size_t evaluations = 0;          ///< of accelerations
  bool complete = true;                 ///< whether the end was reached, or a terminal event
  std::string stop_reason;              ///< what stopped it before, in a sentence
  struct EventOccurrence {
    std::size_t event;
    double t;
  };
  std::vector<EventOccurrence> events;  ///< that were met, in the order of time

  /// In absolute coordinates, at each end of a step: by how much joints and loops were open, and slipped, the largest number of
  /// any (rad, m; rad/s, m/s). Coordinates of the joints are what is left of the bodies' without that.
  std::vector<double> position_residuals, velocity_residuals;
  std::vector<double> body_energies;  ///< likewise, kinetic and of weight, of the bodies as they are, J

 private:
  std::size_t nq() const { return static_cast<std::size_t>(model_.nq()); }
  std::size_t nv() const { return static_cast<std::size_t>(model_.nv()); }

  /// a at the end of a step, before it jumps.
  std::span<const double> a_before(std::size_t k) const;

  Model model_;
  std::vector<double> t_, q_, v_, a_, tau_;
  std::map<std::size_t, std::vector<double>> before_jumps_;
};

}  // namespace axode
