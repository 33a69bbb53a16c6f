#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "apps/commands/chart.hpp"
#include "apps/files/json_text.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration.hpp"

/// The files and the chart of `axode simulate`.
namespace axode::command {

/// The numbers of a motion that are written, a row for each time.
struct WrittenMotion {
  Eigen::VectorXd t, energy, kinetic_energy;
  Eigen::MatrixXd q, v, a, tau;
  Eigen::MatrixXd motion_forces;  ///< force that each prescribed motion takes
  std::vector<std::string> drive_states;
  Eigen::MatrixXd x;  ///< states of the drives
};

/// Evaluates a motion under a drive and loads at the ends of its steps or, if `samples` is positive, at the
/// ends of so many equal intervals.
WrittenMotion written_motion(const Trajectory& motion, const Drive& drive, const Loads<>& loads, int samples);

/// All numbers side by side, with the names of the columns.
std::string csv_of(const Model& model, const WrittenMotion& rows);
/// All that is known of a motion, with the names of the method and of the coordinates of its computation.
Json json_of(const Trajectory& motion, const WrittenMotion& rows, const std::string& method,
             const std::string& coordinates);
/// The numbers as arrays of NumPy.
std::string npz_of(const WrittenMotion& rows);
/// The numbers over time, with the contacts of the motion.
Chart chart_of(const Trajectory& motion, const WrittenMotion& rows);

}  // namespace axode::command
