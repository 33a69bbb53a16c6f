#pragma once
#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <string_view>

namespace axode {

/// The kinds of drives with states, see DriveDescription.
enum class DriveKind {
  dc_motor,            ///< electric motor with a gear; the input is the voltage, V
  pid,                 ///< PID controller of a position; the input is the reference, rad or m
  series_elastic,      ///< DC motor, gear and a spring to the joint; the input is the voltage, V
  lugre,               ///< LuGre friction (Canudas de Wit and others); there is no input
  hydraulic_cylinder,  ///< cylinder with a 4/3 valve; the input is the spool command, -1 to 1
};

/// A parameter of a kind of drives, with the values that it may have.
struct DriveParameter {
  enum class Bound { any, not_zero, not_negative, positive };

  std::string_view name;  ///< key in a drawing
  std::string_view unit;  ///< unit if the drive acts on an angle; "" for a pure number
  Bound bound;
  double standard;  ///< value if a description gives none; NaN if it must give one
};

/// A kind of drives: its name, its parameters, and whether it has an input and an output.
struct DriveTraits {
  DriveKind kind;
  std::string_view name;
  bool has_input;
  bool may_feed;  ///< whether its output may be the input of another drive
  std::span<const DriveParameter> parameters;
};

namespace detail {

using Bound = DriveParameter::Bound;
inline constexpr double required = std::numeric_limits<double>::quiet_NaN();
inline constexpr double unlimited = std::numeric_limits<double>::infinity();

inline constexpr std::array dc_motor_parameters{
    DriveParameter{"resistance", "ohm", Bound::positive, required},
    DriveParameter{"inductance", "H", Bound::positive, required},
    DriveParameter{"torque_constant", "N m/A", Bound::positive, required},
    DriveParameter{"viscous", "N m s/rad", Bound::not_negative, 0},
    DriveParameter{"ratio", "", Bound::not_zero, 1},
    DriveParameter{"voltage_limit", "V", Bound::positive, unlimited},
    DriveParameter{"current_limit", "A", Bound::positive, unlimited},
    DriveParameter{"heat_capacity", "J/K", Bound::positive, unlimited},
    DriveParameter{"thermal_resistance", "K/W", Bound::positive, unlimited},
    DriveParameter{"temperature_coefficient", "1/K", Bound::any, 0},
    DriveParameter{"ambient_temperature", "degC", Bound::any, 25},
    DriveParameter{"reference_temperature", "degC", Bound::any, 25}};
inline constexpr std::array pid_parameters{DriveParameter{"kp", "N m/rad", Bound::not_negative, required},
                                           DriveParameter{"ki", "N m/(rad s)", Bound::not_negative, 0},
                                           DriveParameter{"kd", "N m s/rad", Bound::not_negative, 0},
                                           DriveParameter{"filter_time", "s", Bound::positive, 0.01},
                                           DriveParameter{"tracking_time", "s", Bound::positive, unlimited},
                                           DriveParameter{"limit", "N m", Bound::positive, unlimited}};
inline constexpr std::array series_elastic_parameters{
    DriveParameter{"resistance", "ohm", Bound::positive, required},
    DriveParameter{"inductance", "H", Bound::positive, required},
    DriveParameter{"torque_constant", "N m/A", Bound::positive, required},
    DriveParameter{"viscous", "N m s/rad", Bound::not_negative, 0},
    DriveParameter{"ratio", "", Bound::not_zero, 1},
    DriveParameter{"rotor_inertia", "kg m^2", Bound::positive, required},
    DriveParameter{"stiffness", "N m/rad", Bound::positive, required},
    DriveParameter{"damping", "N m s/rad", Bound::not_negative, 0}};
inline constexpr std::array lugre_parameters{
    DriveParameter{"bristle_stiffness", "N m/rad", Bound::positive, required},
    DriveParameter{"bristle_damping", "N m s/rad", Bound::not_negative, 0},
    DriveParameter{"viscous", "N m s/rad", Bound::not_negative, 0},
    DriveParameter{"coulomb", "N m", Bound::positive, required},
    DriveParameter{"stiction", "N m", Bound::positive, required},
    DriveParameter{"stribeck_velocity", "rad/s", Bound::positive, required},
    DriveParameter{"damping_velocity", "rad/s", Bound::positive, unlimited}};
inline constexpr std::array hydraulic_cylinder_parameters{
    DriveParameter{"closed_length", "m", Bound::any, 0},
    DriveParameter{"stroke", "m", Bound::positive, required},
    DriveParameter{"area_a", "m^2", Bound::positive, required},
    DriveParameter{"area_b", "m^2", Bound::positive, required},
    DriveParameter{"dead_volume_a", "m^3", Bound::positive, required},
    DriveParameter{"dead_volume_b", "m^3", Bound::positive, required},
    DriveParameter{"bulk_modulus", "Pa", Bound::positive, required},
    DriveParameter{"internal_leakage", "m^3/(s Pa)", Bound::not_negative, 0},
    DriveParameter{"external_leakage", "m^3/(s Pa)", Bound::not_negative, 0},
    DriveParameter{"valve", "m^3/(s Pa^0.5)", Bound::not_negative, required},
    DriveParameter{"smooth_pressure", "Pa", Bound::positive, 1e5},
    DriveParameter{"supply_pressure", "Pa", Bound::not_negative, required},
    DriveParameter{"tank_pressure", "Pa", Bound::not_negative, 0},
    DriveParameter{"valve_time", "s", Bound::positive, required},
    DriveParameter{"viscous", "N s/m", Bound::not_negative, 0},
    DriveParameter{"cushion_stiffness", "N/m", Bound::not_negative, 0},
    DriveParameter{"cushion_damping", "s/m", Bound::not_negative, 0}};

}  // namespace detail

inline constexpr std::array drive_kinds{
    DriveTraits{DriveKind::dc_motor, "dc_motor", true, false, detail::dc_motor_parameters},
    DriveTraits{DriveKind::pid, "pid", true, true, detail::pid_parameters},
    DriveTraits{DriveKind::series_elastic, "series_elastic", true, false, detail::series_elastic_parameters},
    DriveTraits{DriveKind::lugre, "lugre", false, false, detail::lugre_parameters},
    DriveTraits{DriveKind::hydraulic_cylinder, "hydraulic_cylinder", true, false,
                detail::hydraulic_cylinder_parameters}};
constexpr const DriveTraits& traits(DriveKind kind) { return drive_kinds[static_cast<std::size_t>(kind)]; }
constexpr std::string_view to_string(DriveKind kind) { return traits(kind).name; }

}  // namespace axode
