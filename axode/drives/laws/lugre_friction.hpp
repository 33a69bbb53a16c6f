#pragma once
#include <cmath>

#include "axode/drives/drive_law.hpp"
#include "axode/scalar/exponential.hpp"

namespace axode {

/// LuGre friction of Canudas de Wit et al. (D17.14). The state is the deflection of the bristles (rad).
struct LuGreFriction {
  /// Stiffness of the bristles (N m/rad), damping of the bristles and viscous friction (N m s/rad).
  double sigma_0, sigma_1 = 0, sigma_2 = 0;
  double F_c, F_s;  ///< friction in sliding and largest friction in sticking, N m
  double v_s;       ///< Stribeck's velocity, rad/s
  double v_d;       ///< velocity above which the damping of the bristles vanishes, rad/s; may be infinite

  std::vector<DriveState> states() const {
    std::vector<DriveState> all = states_of(DriveKind::lugre);
    all[0].nominal = F_c / sigma_0;
    return all;
  }
  void start(const DrivePoint<double>&, std::span<double> x) const { x[0] = 0; }

  template <class T>
  void evaluate(const DrivePoint<T>& at, std::span<const int> statuses, DriveResponse<T>& out) const {
    using std::exp;
    const T &z = at.x[0], &w = at.w, speed = T(statuses[0]) * w;
    const auto bell = [&](double width) { return exp(-(w * w) * T(1 / (width * width))); };
    const T G = T(F_c) + T(F_s - F_c) * bell(v_s);
    const T slip = T(sigma_0) * speed * z / G, dz = w - slip;
    const T damping = std::isfinite(v_d) ? T(sigma_1) * bell(v_d) : T(sigma_1);
    out.dx[0] = dz;
    out.force = -(T(sigma_0) * z + damping * dz + T(sigma_2) * w);
    out.stored = T(0.5 * sigma_0) * z * z;
    out.supplied = T(0);
    out.lost = T(sigma_0) * z * slip + damping * dz * w + T(sigma_2) * w * w;
  }

  // The only status is the sign of the rate w of the port.
  std::size_t n_statuses() const { return 1; }
  void choose(const DrivePoint<double>& at, DriveLaw::Statuses statuses) const {
    statuses[0] = at.w < 0 ? -1 : 1;
  }
  template <class T> T margin(std::size_t, const DrivePoint<T>& at, std::span<const int> statuses) const {
    return T(statuses[0]) * at.w + T(past_limit * v_s);
  }
  void change(std::size_t, const DrivePoint<double>&, DriveLaw::Statuses statuses, std::span<double>) const {
    statuses[0] = -statuses[0];
  }
};

}  // namespace axode
