#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "apps/commands/chart.hpp"
#include "apps/files/json_text.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration.hpp"

/// Makes the files and the chart that `axode simulate` writes.
namespace axode::command {

/// The numbers of a motion that are written, with a row (or entry) for each time.
struct WrittenMotion {
  Eigen::VectorXd t, energy, kinetic_energy;
  Eigen::MatrixXd q, v, a, tau;
  /// The force that each prescribed motion needs, also against the forces of contacts. Has no columns if hard
  /// stops act, whose forces a motion does not record.
  Eigen::MatrixXd motion_forces;
  std::vector<std::string> drive_states;
  Eigen::MatrixXd x;  ///< states of the drives
  /// load_frames are the frames on which loads act. The matrix `loads` has six columns for each of them: the
  /// moment and the force in inertial axes, about the origin of the frame.
  std::vector<int> load_frames;
  Eigen::MatrixXd loads;
};

/// Computes all members of WrittenMotion at the start of a motion and at the ends of its steps or, if
/// `samples` is positive, of `samples` equal intervals. The drive forces and the loads are computed again
/// from `drive` and `loads`, which must be those under which the motion was computed.
WrittenMotion written_motion(const Trajectory& motion, const Drive& drive, const Loads<>& loads, int samples);

/// The numbers of a motion as CSV: a line with the names of the columns, then a row for each time.
std::string csv_of(const Model& model, const WrittenMotion& rows);
/// A motion as JSON. `method` names the integration method, and `coordinates` its kind of coordinates.
Json json_of(const Trajectory& motion, const WrittenMotion& rows, const std::string& method,
             const std::string& coordinates);
/// The numbers of a motion as the bytes of an .npz file of NumPy.
std::string npz_of(const WrittenMotion& rows);
/// A chart of the numbers of a motion over time, with the forces of its contacts.
Chart chart_of(const Trajectory& motion, const WrittenMotion& rows);

}  // namespace axode::command
