#pragma once
#include "axode/batch.hpp"
#include "axode/batch/accelerations.hpp"
#include "axode/drives/drive_system.hpp"

namespace axode::batch {

/// N motions of K steps of length `step` (s), as in rollout(): under given forces tau or a drive.
struct MotionsUnderForces {
  std::span<const double> q, v, tau;
  const Drive& drive;
  std::size_t K;
  double step;
  std::span<double> q_out, v_out;
};

/// Checks the arguments of a rollout of N motions that belong to drives. Throws std::invalid_argument if the
/// initial states x of the drives have a wrong size or are not finite, if the memory x_out for the later
/// states has a wrong size or overlaps that of an argument or a result, and if the time of the start is not
/// finite or, with dry friction or losses of gears, is not 0.
void check_drives(const MotionsUnderForces& motions, const DriveMotions& drives, const DriveSystem& system,
                  std::size_t N, const Losses& losses);

/// Computes a rollout of a mechanism with drives that have states. The caller must have checked the sizes in
/// `motions`, and that all initial states (q, v) close the loops. Throws std::invalid_argument if the initial
/// states x of the drives have a wrong size or are not finite, if the memory x_out for the later states has a
/// wrong size or overlaps that of an argument or a result, and if the time of the start is not finite or,
/// with dry friction or losses of gears, is not 0.
Outcome run_with_drives(const Model& model, const CompiledDynamics<double>& compiled,
                        const MotionsUnderForces& motions, const DriveMotions& drives, const Tableau& method,
                        const Losses& losses, int threads, const Monitor& monitor);

}  // namespace axode::batch
