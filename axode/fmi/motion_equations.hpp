#pragma once
#include <Eigen/Core>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "axode/drives/drive_system.hpp"
#include "axode/fmi/variables.hpp"
#include "axode/integration/closed_motion.hpp"
#include "axode/model/workspace.hpp"

namespace axode::fmi {

/// Thrown if the rates (q', v', x') cannot be computed at a state, for example because the mass matrix is
/// singular, numbers are not finite, or the time is beyond the samples of a prescribed motion. The master,
/// which is the importing program, may try another state.
class NoRates : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The arguments of the equations of motion: a time t (s), a state (q, v, x) of a mechanism with the states x
/// of its drives, drive forces tau (nv), and wrenches on frames. A wrench has six numbers: moment and force
/// about the origin of the frame, in inertial axes.
struct Point {
  double t = 0;
  std::vector<double> q, v, x, tau, wrenches = {};
};
/// Converts wrenches, six numbers for each frame, to loads on the frames with the given indices.
std::vector<AppliedWrench<>> applied(std::span<const double> wrenches, std::span<const int> frames);
/// The time derivatives of a state: q', the accelerations a = v', and the rates x' of the states of the
/// drives.
struct Rates {
  std::vector<double> dq, a, dx;
};

/// The equations of motion of a mechanism as a system of ordinary differential equations in (q, v, x), where
/// x are the states of the drives, with loops, prescribed motions, springs and drives. q need not have
/// quaternions of unit norm: every function of q normalises the quaternions first, so that their norm is
/// constant along solutions. The states of a mechanism with loops are those of its spanning tree. The
/// accelerations keep A v constant, with the Jacobian A of the loops, and close() removes the residuals that
/// an integration has accumulated.
class MotionEquations {
 public:
  using Span = std::span<const double>;

  /// `loads` are the indices of the frames on which the wrenches of a Point act.
  MotionEquations(const Model& model, const Settings& settings, std::span<const int> loads);

  const DriveSystem& drives() const { return drives_; }
  /// Replaces the drives by other drives of the same mechanism, with their discrete statuses and inputs.
  void act_by(const DriveSystem& drives) { drives_ = drives; }

  /// Corrects q and v: quaternions get unit norm, loops are closed, and prescribed motions are followed at
  /// the time in `at`. Then chooses the discrete statuses of the drives. Throws std::runtime_error if the
  /// loops cannot be closed.
  void start(Point& at);
  Rates rates(const Point& at);
  /// Projects q and v onto closed loops and followed motions, with quaternions of unit norm. Returns whether
  /// the loops could be closed.
  [[nodiscard]] bool close(Point& at);

  /// If an input of a drive jumps at the time in `at`, the input gets its value after the jump. Discrete
  /// statuses of drives that must change do so, which may change x, the states of the drives.
  void switch_drives(Point& at);
  double next_jump(double t) const;
  /// The least margin of the drives, which becomes negative when a discrete status must change; 1 if they
  /// have no statuses.
  double least_margin(const Point& at);
  /// The poses of the frames with the given indices. Each has 12 numbers: the columns of the rotation matrix
  /// R and the position r.
  std::vector<double> poses(const Point& at, std::span<const int> frames);

  /// The exact derivatives of (q', v', x', poses), one below the other, by (q, v, x, tau, wrenches).
  Eigen::MatrixXd jacobian(const Point& at, std::span<const int> frames);
  /// The derivatives of the accelerations (nv) by a parameter, a number of the description, for which
  /// Parameter::has_derivative must be true.
  Eigen::VectorXd acceleration_by(const Point& at, const Parameter& parameter);

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// The derivatives of the accelerations under springs and drives by q (along left-trivialised directions),
  /// v, tau and the states x of the drives, and the derivatives of drive forces and x'.
  struct Derivatives {
    RowMajor a_q, a_v, a_tau;
    Eigen::MatrixXd a_x;
    DriveDerivatives drives;
  };
  std::vector<double> normalized(Span q) const;
  void set_time(double t);
  bool is_closed(const Point& at);
  /// The loads of a point. They are valid until the next call.
  Loads<double> loads(const Point& at);
  /// The sum of tau and of the forces of drives and springs (nv). Writes the rates of x to dx unless dx is
  /// null.
  std::vector<double> force_sum(const Point& at, Span q, std::vector<double>* dx);
  Derivatives derivatives(const Point& at, Span q);
  /// Computes derivatives by the entries of `raw`, the coordinates before normalisation: those of the
  /// normalised coordinates q (`normalization`, nq × nq), and the displacement of q along the group
  /// (`displacement`, nv × nq).
  void seeds(Span raw, Span q, Eigen::MatrixXd& displacement, Eigen::MatrixXd& normalization) const;
  Eigen::MatrixXd rates_by_coordinates(Span q, Span v) const;

  Model model_;
  Settings settings_;
  std::vector<int> load_frames_;
  std::vector<AppliedWrench<>> wrenches_;
  Workspace<> workspace_;
  std::optional<ClosedMotion> loops_;
  DriveSystem drives_;
};

}  // namespace axode::fmi
