#pragma once
#include "axode/drives/drive_law.hpp"

namespace axode {

/// A series-elastic drive: a DC motor, a gear, and a spring with a damper between gear and joint (D17.13).
/// The states are the current (A), and the angle (rad) and the speed (rad/s) of the rotor.
struct SeriesElastic {
  double R, L, k;  ///< resistance, inductance, torque constant; ohm, H, N m/A = V s/rad
  double b = 0;    ///< viscous friction at the motor, N m s/rad
  double N = 1;    ///< gear ratio: angle of the motor over that of the gear's output
  double J;        ///< inertia of the rotor, kg m²
  double k_s;      ///< stiffness of the spring at the joint, N m/rad
  double d_s = 0;  ///< damping of the spring at the joint, N m s/rad

  std::vector<DriveState> states() const { return states_of(DriveKind::series_elastic); }
  /// Writes the states at the start of a motion: no current, and a relaxed spring that turns with the joint.
  void start(const DrivePoint<double>& at, std::span<double> x) const {
    x[0] = 0;
    x[1] = N * at.l;
    x[2] = N * at.w;
  }

  template <class T>
  void evaluate(const DrivePoint<T>& at, std::span<const int>, DriveResponse<T>& out) const {
    const T &i = at.x[0], &theta = at.x[1], &omega = at.x[2];
    const T twist = T(1 / N) * theta - at.l, rate = T(1 / N) * omega - at.w;
    const T tau_s = T(k_s) * twist + T(d_s) * rate;
    out.dx[0] = (at.u - T(R) * i - T(k) * omega) / T(L);
    out.dx[1] = omega;
    out.dx[2] = (T(k) * i - T(b) * omega - T(1 / N) * tau_s) / T(J);
    out.force = tau_s;
    out.stored = T(0.5) * (T(L) * i * i + T(J) * omega * omega + T(k_s) * twist * twist);
    out.supplied = at.u * i;
    out.lost = T(R) * i * i + T(b) * omega * omega + T(d_s) * rate * rate;
  }
};

}  // namespace axode
