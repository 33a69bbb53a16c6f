#pragma once
#include <algorithm>
#include <cmath>

#include "axode/drives/drive_law.hpp"

namespace axode {

/// A DC motor with a gear (D17.8). The states are the current (A) and, if the motor has a finite heat
/// capacity, the temperature of its winding (degC). The inertia J of the rotor is not part of the drive: for
/// the gear ratio N, N² J must be the armature of the joint.
struct DcMotor {
  /// Resistance at the temperature T_0 (ohm), inductance (H) and torque constant (N m/A = V s/rad).
  double R, L, k;
  double b = 0;               ///< viscous friction at the motor, N m s/rad
  double N = 1;               ///< gear ratio: angle of the motor over that of the joint
  double u_max, i_max;        ///< limits of voltage and current, V and A; may be infinite
  double C, R_thermal;        ///< heat capacity, J/K, and thermal resistance, K/W; infinite C: no state
  double alpha = 0;           ///< temperature coefficient of the resistance, 1/K
  double T_a = 25, T_0 = 25;  ///< ambient temperature, and the one at which R is given, degC

  /// The current control of the motor: the current is free (0), or the amplifier holds its magnitude at the
  /// limit i_max (1), or the magnitude is above i_max because the voltage of the amplifier is too small to
  /// hold it there (2). This number times the sign of the current is a status of the drive, an integer that
  /// selects a branch of its law.
  enum Current { free = 0, held = 1, beyond = 2 };

  bool has_temperature() const { return std::isfinite(C); }
  std::vector<DriveState> states() const {
    std::vector<DriveState> all = states_of(DriveKind::dc_motor);
    if (!has_temperature()) all.pop_back();
    return all;
  }
  void start(const DrivePoint<double>&, std::span<double> x) const {
    x[0] = 0;
    if (has_temperature()) x[1] = T_a;
  }

  template <class T> T resistance(const DrivePoint<T>& at) const {
    return has_temperature() ? T(R) * (T(1) + T(alpha) * (at.x[1] - T(T_0))) : T(R);
  }
  /// The voltage (V) at which the current is constant: R i + k N w.
  template <class T> T holding_voltage(const DrivePoint<T>& at) const {
    return resistance(at) * at.x[0] + T(k * N) * at.w;
  }

  template <class T>
  void evaluate(const DrivePoint<T>& at, std::span<const int> statuses, DriveResponse<T>& out) const {
    const T &i = at.x[0], omega = T(N) * at.w, hold = holding_voltage(at);
    T u = voltage().of(at.u, statuses[0]);
    if (std::abs(statuses[1]) == held) u = hold;
    if (std::abs(statuses[1]) == beyond) u = T(statuses[1] > 0 ? -u_max : u_max);
    out.dx[0] = std::abs(statuses[1]) == held ? T(0) : (u - hold) / T(L);
    out.force = T(N) * (T(k) * i - T(b) * omega);
    const T heat = resistance(at) * i * i;
    if (has_temperature()) out.dx[1] = (heat - (at.x[1] - T(T_a)) / T(R_thermal)) / T(C);
    out.stored = T(0.5 * L) * i * i;
    out.supplied = u * i;
    out.lost = heat + T(b) * omega * omega;
  }

  std::size_t n_statuses() const { return 2; }
  void choose(const DrivePoint<double>& at, DriveLaw::Statuses statuses) const {
    statuses[0] = voltage().choose(at.u);
    statuses[1] = free;
    const double i = at.x[0];
    if (std::abs(i) < i_max * (1 - past_limit)) return;
    const int sign = i > 0 ? 1 : -1;
    if (std::abs(i) > i_max * (1 + past_limit))
      statuses[1] = sign * beyond;
    else if (drive_at_limit(at, statuses, sign) > 0)
      statuses[1] = sign * held;
  }
  template <class T>
  T margin(std::size_t k_status, const DrivePoint<T>& at, std::span<const int> statuses) const {
    if (k_status == 0) return voltage().margin(at.u, statuses[0]);
    const T& i = at.x[0];
    if (statuses[1] == free) return T(i_max * (1 + past_limit)) - (i < T(0) ? -i : i);
    const int sign = statuses[1] > 0 ? 1 : -1;
    if (std::abs(statuses[1]) == beyond) return T(sign) * i - T(i_max);
    return std::min(drive_at_limit(at, statuses, sign), T(sign) * holding_voltage(at) + T(u_max));
  }
  void change(std::size_t k_status, const DrivePoint<double>& at, DriveLaw::Statuses statuses,
              std::span<double> x) const {
    if (k_status == 0) {
      statuses[0] = voltage().next(at.u, statuses[0]);
      return;
    }
    const int sign = statuses[1] > 0 || (statuses[1] == free && at.x[0] > 0) ? 1 : -1;
    if (std::abs(statuses[1]) == held) {
      statuses[1] = drive_at_limit(at, statuses, sign) < 0 ? free : sign * beyond;
    } else {
      statuses[1] = sign * held;
      x[0] = sign * i_max;
    }
  }

 private:
  Saturation voltage() const { return {u_max}; }
  /// How far the input exceeds the voltage that would hold the current at its limit (V), counted in the
  /// direction `sign` of the current. If it is positive, the input drives the current beyond the limit.
  template <class T>
  T drive_at_limit(const DrivePoint<T>& at, std::span<const int> statuses, int sign) const {
    return T(sign) * (voltage().of(at.u, statuses[0]) - holding_voltage(at));
  }
};

}  // namespace axode
