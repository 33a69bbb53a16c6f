#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/drives/drive_law.hpp"
#include "axode/scalar/exponential.hpp"

namespace axode {

/// A hydraulic cylinder with two chambers and a 4/3 valve (D17.16). A positive force makes it longer. The
/// states are the pressures of the chambers (Pa) and the position y of the spool, which follows the input;
/// the valve is fully open at y = 1 and y = -1, and y is not limited to this range.
struct HydraulicCylinder {
  double closed_length;     ///< length of the port at which the stroke is 0, m
  double stroke;            ///< length of the stroke, m
  double A_a, A_b;          ///< areas of the piston, m²
  double V_a, V_b;          ///< dead volumes, m³
  double beta;              ///< bulk modulus of the oil, Pa
  double C_i = 0, C_e = 0;  ///< leakages across the piston and to the outside, m³/(s Pa)
  double K_v;               ///< flow of the open valve over the square root of the pressure, m³/(s √Pa)
  double p_smooth;          ///< pressure below which flows become proportional to pressures, Pa
  double p_supply, p_tank;  ///< pressures of supply and tank, Pa
  double T_v;               ///< time constant of the valve, s
  double b = 0;             ///< viscous friction, N s/m
  double k_c = 0, d_c = 0;  ///< stiffness (N/m) and damping (s/m) of the cushions at both ends

  std::vector<DriveState> states() const { return states_of(DriveKind::hydraulic_cylinder); }
  void start(const DrivePoint<double>& at, std::span<double> x) const {
    x[0] = x[1] = p_tank;
    x[2] = at.u;
  }

  /// The function φ(p) = p/(p² + p_smooth²)^(1/4), a smooth approximation of sign(p) √|p|. The flow through a
  /// valve is proportional to φ of the pressure difference p.
  template <class T> T root(const T& p) const {
    using std::sqrt;
    return p / sqrt(sqrt(p * p + T(p_smooth * p_smooth)));
  }
  /// The power Π(p) = β (exp(p/β) - 1) of a unit of oil flow at the pressure p, including the energy of
  /// compression, with the bulk modulus β (D17.17).
  template <class T> T power_per_flow(const T& p) const {
    using std::exp;
    return T(beta) * (exp(p * T(1 / beta)) - T(1));
  }

  /// The rate of pressure in a chamber per inflow, bulk modulus over volume (Pa/m³); NaN without volume.
  template <class T> T stiffness(const T& volume) const {
    return volume > T(0) ? T(beta) / volume : T(std::numeric_limits<double>::quiet_NaN());
  }

  template <class T>
  void evaluate(const DrivePoint<T>& at, std::span<const int> statuses, DriveResponse<T>& out) const {
    const T &p_a = at.x[0], &p_b = at.x[1], &y = at.x[2], &w = at.w, s = at.l - T(closed_length);
    const bool extends = statuses[0] > 0;
    const T open = T(K_v) * y, P = T(p_supply), O = T(p_tank);
    const T Q_a = open * (extends ? root(P - p_a) : root(p_a - O));
    const T Q_b = -open * (extends ? root(p_b - O) : root(P - p_b));
    const T across = T(C_i) * (p_a - p_b);
    const T into_a = Q_a - across - T(C_e) * p_a, into_b = Q_b + across - T(C_e) * p_b;
    const T volume_a = T(V_a) + T(A_a) * s, volume_b = T(V_b) + T(A_b) * (T(stroke) - s);
    out.dx[0] = stiffness(volume_a) * (into_a - T(A_a) * w);
    out.dx[1] = stiffness(volume_b) * (into_b + T(A_b) * w);
    out.dx[2] = (at.u - y) / T(T_v);

    // A cushion is compressed by `depth`; its force acts against the piston.
    const T way = T(statuses[1]);
    const T depth = statuses[1] == 0 ? T(0) : statuses[1] > 0 ? s - T(stroke) : -s, closing = way * w;
    const T grip = T(1) + T(d_c) * closing, cushion = grip < T(0) ? T(0) : T(k_c) * depth * grip;
    out.force = T(A_a) * p_a - T(A_b) * p_b - T(b) * w - way * cushion;

    const T per_a = power_per_flow(p_a), per_b = power_per_flow(p_b);
    out.stored = volume_a * (per_a - p_a) + volume_b * (per_b - p_b) + T(0.5 * k_c) * depth * depth;
    out.supplied = extends ? power_per_flow(P) * Q_a + power_per_flow(O) * Q_b
                           : power_per_flow(P) * Q_b + power_per_flow(O) * Q_a;
    out.lost =
        out.supplied - per_a * into_a - per_b * into_b + T(b) * w * w + (cushion - T(k_c) * depth) * closing;
  }

  // Status 0 is the sign of the spool position. Status 1 is the cushion that is compressed: 1 at the end of
  // the stroke, -1 at its start, 0 if none is.
  std::size_t n_statuses() const { return 2; }
  void choose(const DrivePoint<double>& at, DriveLaw::Statuses statuses) const {
    const double s = at.l - closed_length;
    statuses[0] = at.x[2] < 0 || (at.x[2] == 0 && at.u < 0) ? -1 : 1;
    statuses[1] = s < 0 ? -1 : s > stroke ? 1 : 0;
  }
  template <class T> T margin(std::size_t k, const DrivePoint<T>& at, std::span<const int> statuses) const {
    if (k == 0) return T(statuses[0]) * at.x[2] + T(past_limit);
    const T s = at.l - T(closed_length), past = T(past_limit * stroke);
    if (statuses[1] == 0) return std::min(s, T(stroke) - s) + past;
    return (statuses[1] > 0 ? s - T(stroke) : -s) + past;
  }
  void change(std::size_t k, const DrivePoint<double>& at, DriveLaw::Statuses statuses,
              std::span<double>) const {
    if (k == 0) {
      statuses[0] = -statuses[0];
    } else {
      statuses[1] = statuses[1] != 0 ? 0 : at.l - closed_length < 0.5 * stroke ? -1 : 1;
    }
  }
};

}  // namespace axode
