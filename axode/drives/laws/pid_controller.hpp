#pragma once
#include <cmath>

#include "axode/drives/drive_law.hpp"

namespace axode {

/// A PID controller for the position of a joint, or for the length of a line between two points of bodies
/// (D17.10). Its input is the reference of this position or length. Its output is a force on the joint or
/// along the line, or the input of another drive. The states are the integral part of the output and the
/// filtered error.
struct PidController {
  double K_p, K_i = 0, K_d = 0;
  double T_f = 0.01;         ///< time constant of the filter of the derivative, s
  double T_t;                ///< time constant with which the integrator follows the limit, s
  double limit;              ///< largest magnitude of the output; may be infinite
  bool conditional = false;  ///< whether the integrator stops, instead of following the limit

  std::vector<DriveState> states() const { return states_of(DriveKind::pid); }
  void start(const DrivePoint<double>& at, std::span<double> x) const {
    x[0] = 0;
    x[1] = at.u - at.l;
  }

  template <class T> T wanted(const DrivePoint<T>& at) const {
    const T e = at.u - at.l;
    return T(K_p) * e + at.x[0] + T(K_d / T_f) * (e - at.x[1]);
  }

  template <class T>
  void evaluate(const DrivePoint<T>& at, std::span<const int> statuses, DriveResponse<T>& out) const {
    const T e = at.u - at.l, y_c = wanted(at), y = Saturation{limit}.of(y_c, statuses[0]);
    const bool stops = conditional && statuses[0] != 0 && statuses[1] == statuses[0];
    out.dx[0] = stops ? T(0) : T(K_i) * e;
    if (!conditional) out.dx[0] += T(1 / T_t) * (y - y_c);
    out.dx[1] = (e - at.x[1]) / T(T_f);
    out.force = y;
    out.stored = out.lost = T(0);
    out.supplied = y * at.w;
  }

  // Status 0 is the sign of the limit that the output has reached, or 0. Status 1, which only conditional
  // integration has, is the sign of the error.
  std::size_t n_statuses() const { return conditional ? 2 : 1; }
  void choose(const DrivePoint<double>& at, DriveLaw::Statuses statuses) const {
    statuses[0] = Saturation{limit}.choose(wanted(at));
    if (conditional) statuses[1] = at.u < at.l ? -1 : 1;
  }
  template <class T> T margin(std::size_t k, const DrivePoint<T>& at, std::span<const int> statuses) const {
    if (k == 0) return Saturation{limit}.margin(wanted(at), statuses[0]);
    const auto size = [](const T& x) { return x < T(0) ? -x : x; };
    return T(statuses[1]) * (at.u - at.l) + T(past_limit) * (size(at.u) + size(at.l));
  }
  void change(std::size_t k, const DrivePoint<double>& at, DriveLaw::Statuses statuses,
              std::span<double>) const {
    statuses[k] = k == 0 ? Saturation{limit}.next(wanted(at), statuses[0]) : -statuses[1];
  }
};

}  // namespace axode
