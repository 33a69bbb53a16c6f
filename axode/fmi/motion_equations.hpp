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

/// Thrown if the rates of a state cannot be computed, for example because the mass matrix is singular,
/// numbers are not finite, or the time is beyond the samples of a prescribed motion. A solver may try another
/// state.
class NoRates : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The arguments of the equations of motion: a time t (s), a state (q, v, x) with the states x of drives,
/// drive forces tau (nv), and wrenches on frames: moment and force about the origin of the frame, in inertial
/// axes.
struct Point {
  double t = 0;
  std::vector<double> q, v, x, tau, wrenches = {};
};
/// Converts wrenches, six numbers for each frame, to loads on the frames with the given indices.
std::vector<AppliedWrench<>> applied(std::span<const double> wrenches, std::span<const int> frames);
/// The time derivatives of a state: q', the accelerations a = v', and the rates x' of the drive states.
struct Rates {
  std::vector<double> dq, a, dx;
};

/// The equations of motion of a mechanism, with loops, prescribed motions, springs and drives, as ordinary
/// differential equations in (q, v, x) with the states x of drives. Quaternions in q are normalised first in
/// every function, so that their norm is constant along solutions. A mechanism with loops has the states of
/// its spanning tree; the accelerations keep A v constant, with the Jacobian A of the loops, and close()
/// removes accumulated residuals.
class MotionEquations {
 public:
  using Span = std::span<const double>;

  /// `loads` are the indices of the frames on which the wrenches of a Point act.
  MotionEquations(const Model& model, const Settings& settings, std::span<const int> loads);

  const DriveSystem& drives() const { return drives_; }
  /// Replaces the drives by other drives of the same mechanism, with their discrete statuses and inputs.
  void act_by(const DriveSystem& drives) { drives_ = drives; }

  /// Normalises quaternions, closes loops and follows prescribed motions by corrections of q and v at the
  /// time in `at`, and then chooses the statuses of the drives. Throws std::runtime_error if the loops cannot
  /// be closed.
  void start(Point& at);
  Rates rates(const Point& at);
  /// Projects q and v onto closed loops and motions, with unit quaternions. Returns whether this succeeded.
  [[nodiscard]] bool close(Point& at);

  /// Lets inputs of drives jump that do so at the time in `at`, and changes discrete statuses of drives where
  /// necessary, which may change x, the states of the drives.
  void switch_drives(Point& at);
  double next_jump(double t) const;
  /// The least margin of the drives, negative when a discrete status must change; 1 without statuses.
  double least_margin(const Point& at);
  /// The poses of frames, given by indices, with 12 numbers each: columns of the rotation, then position.
  std::vector<double> poses(const Point& at, std::span<const int> frames);

  /// The exact derivatives of (q', v', x', poses), one below the other, by (q, v, x, tau, wrenches).
  Eigen::MatrixXd jacobian(const Point& at, std::span<const int> frames);
  /// The derivatives of the accelerations (nv) by a parameter; its has_derivative must be true.
  Eigen::VectorXd acceleration_by(const Point& at, const Parameter& parameter);

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// The derivatives of the accelerations by q (along left-trivialised directions), v, tau and the states x
  /// of drives, and those of drive forces and x'.
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
  /// The sum of tau and the forces of drives and springs (nv). Writes the rates of x to dx unless it is null.
  std::vector<double> force_sum(const Point& at, Span q, std::vector<double>* dx);
  Derivatives derivatives(const Point& at, Span q);
  /// Computes the derivatives by the coordinates `raw` before normalisation: those of the normalised q
  /// (`normalization`, nq × nq), and its displacement along left-trivialised directions for each unit of
  /// `raw` (`displacement`, nv × nq).
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
