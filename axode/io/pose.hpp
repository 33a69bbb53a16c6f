#pragma once
#include <cmath>
#include <optional>

#include "axode/lie/se3.hpp"

/// Conversions of rotations from and to the forms in which files give them.
namespace axode::io {

/// The rotation R_z(yaw) R_y(pitch) R_x(roll). `angles` has roll, pitch and yaw in rad.
inline SO3<> from_roll_pitch_yaw(const Vec3<>& angles) {
  const double sr = std::sin(angles.x), cr = std::cos(angles.x);
  const double sp = std::sin(angles.y), cp = std::cos(angles.y);
  const double sy = std::sin(angles.z), cy = std::cos(angles.z);
  return {{cy * cp, sy * cp, -sp},
          {cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr},
          {cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr}};
}

/// The roll, pitch and yaw (rad) of a rotation, with |pitch| <= π/2; the inverse of from_roll_pitch_yaw(). At
/// |pitch| = π/2 roll and yaw turn about the same line, so that they are not unique; one of the possible
/// pairs is returned.
inline Vec3<> to_roll_pitch_yaw(const SO3<>& R) {
  const double yaw = std::atan2(R.x.y, R.x.x), sy = std::sin(yaw), cy = std::cos(yaw);
  return {std::atan2(sy * R.z.x - cy * R.z.y, cy * R.y.y - sy * R.y.x),
          std::atan2(-R.x.z, std::hypot(R.x.x, R.x.y)), yaw};
}

/// The rotation of a quaternion, scaled to norm 1; empty if its norm differs from 1 by more than 1e-6.
inline std::optional<SO3<>> from_quaternion(const Quaternion<>& a) {
  const double size = norm(a);
  if (!(std::abs(size - 1) <= 1e-6)) return std::nullopt;
  return rotation(Quaternion<>{a.x / size, a.y / size, a.z / size, a.w / size});
}

/// Whether RᵀR is the identity to 1e-6 and R is not a reflection.
inline bool is_rotation(const SO3<>& R) {
  const SO3<> G = transpose(R) * R;
  const auto off = [](const Vec3<>& column, const Vec3<>& unit) { return norm(column - unit); };
  return off(G.x, {1, 0, 0}) <= 1e-6 && off(G.y, {0, 1, 0}) <= 1e-6 && off(G.z, {0, 0, 1}) <= 1e-6 &&
         dot(cross(R.x, R.y), R.z) > 0;
}

}  // namespace axode::io
