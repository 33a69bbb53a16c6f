#pragma once
#include <string>
#include <vector>

#include "axode/model/kinds/drive_kinds.hpp"

namespace axode {

/// A state of a drive.
struct DriveState {
  std::string name, unit;
  double nominal = 1;  ///< magnitude of usual values; errors of the state are relative to it
};

/// The states of a kind of drives, with their units for a drive on an angle and their typical sizes. A
/// dc_motor without a heat capacity has no state `temperature`. The typical size of the state `bristle` of a
/// lugre drive (LuGre friction) follows from its parameters.
inline std::vector<DriveState> states_of(DriveKind kind) {
  switch (kind) {
    case DriveKind::dc_motor: return {{"current", "A", 1}, {"temperature", "degC", 10}};
    case DriveKind::pid: return {{"integral", "", 1}, {"filter", "", 1}};
    case DriveKind::series_elastic:
      return {{"current", "A", 1}, {"rotor_angle", "rad", 1}, {"rotor_speed", "rad/s", 1}};
    case DriveKind::lugre: return {{"bristle", "rad", 1}};
    case DriveKind::hydraulic_cylinder: break;
  }
  return {{"pressure_a", "Pa", 1e6}, {"pressure_b", "Pa", 1e6}, {"spool", "", 1}};
}

}  // namespace axode
