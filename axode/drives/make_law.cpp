#include "axode/drives/make_law.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "axode/drives/laws/dc_motor.hpp"
#include "axode/drives/laws/hydraulic_cylinder.hpp"
#include "axode/drives/laws/lugre_friction.hpp"
#include "axode/drives/laws/pid_controller.hpp"
#include "axode/drives/laws/series_elastic.hpp"

namespace axode {
namespace {

template <class Law> std::shared_ptr<const DriveLaw> shared(Law law) {
  return std::make_shared<DriveLawOf<Law>>(std::move(law));
}

/// The time constant (s) with which the integrator of a saturated PID controller is driven back to the limit.
/// It is the given one if this is finite; otherwise the ratio K_p/K_i of the proportional and the integral
/// gain, or 1 s if one of the gains is 0.
double tracking_time(double given, double K_p, double K_i) {
  if (std::isfinite(given)) return given;
  return K_i > 0 && K_p > 0 ? K_p / K_i : 1;
}

}  // namespace

double parameter_of(const DriveDescription& drive, std::string_view name) {
  const auto given =
      std::ranges::find(drive.parameters, name, [](const auto& p) -> std::string_view { return p.first; });
  if (given != drive.parameters.end()) return given->second;
  return std::ranges::find(traits(drive.kind).parameters, name, &DriveParameter::name)->standard;
}

std::shared_ptr<const DriveLaw> make_law(const DriveDescription& drive) {
  const auto of = [&](std::string_view name) { return parameter_of(drive, name); };
  switch (drive.kind) {
    case DriveKind::dc_motor:
      return shared(DcMotor{.R = of("resistance"),
                            .L = of("inductance"),
                            .k = of("torque_constant"),
                            .b = of("viscous"),
                            .N = of("ratio"),
                            .u_max = of("voltage_limit"),
                            .i_max = of("current_limit"),
                            .C = of("heat_capacity"),
                            .R_thermal = of("thermal_resistance"),
                            .alpha = of("temperature_coefficient"),
                            .T_a = of("ambient_temperature"),
                            .T_0 = of("reference_temperature")});
    case DriveKind::pid:
      return shared(PidController{.K_p = of("kp"),
                                  .K_i = of("ki"),
                                  .K_d = of("kd"),
                                  .T_f = of("filter_time"),
                                  .T_t = tracking_time(of("tracking_time"), of("kp"), of("ki")),
                                  .limit = of("limit"),
                                  .conditional = drive.conditional});
    case DriveKind::series_elastic:
      return shared(SeriesElastic{.R = of("resistance"),
                                  .L = of("inductance"),
                                  .k = of("torque_constant"),
                                  .b = of("viscous"),
                                  .N = of("ratio"),
                                  .J = of("rotor_inertia"),
                                  .k_s = of("stiffness"),
                                  .d_s = of("damping")});
    case DriveKind::lugre:
      return shared(LuGreFriction{.sigma_0 = of("bristle_stiffness"),
                                  .sigma_1 = of("bristle_damping"),
                                  .sigma_2 = of("viscous"),
                                  .F_c = of("coulomb"),
                                  .F_s = of("stiction"),
                                  .v_s = of("stribeck_velocity"),
                                  .v_d = of("damping_velocity")});
    case DriveKind::hydraulic_cylinder: break;
  }
  return shared(HydraulicCylinder{.closed_length = of("closed_length"),
                                  .stroke = of("stroke"),
                                  .A_a = of("area_a"),
                                  .A_b = of("area_b"),
                                  .V_a = of("dead_volume_a"),
                                  .V_b = of("dead_volume_b"),
                                  .beta = of("bulk_modulus"),
                                  .C_i = of("internal_leakage"),
                                  .C_e = of("external_leakage"),
                                  .K_v = of("valve"),
                                  .p_smooth = of("smooth_pressure"),
                                  .p_supply = of("supply_pressure"),
                                  .p_tank = of("tank_pressure"),
                                  .T_v = of("valve_time"),
                                  .b = of("viscous"),
                                  .k_c = of("cushion_stiffness"),
                                  .d_c = of("cushion_damping")});
}

}  // namespace axode
