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

/// Thrown if rates cannot be computed at a state: the mass matrix is singular, or numbers are not finite. The
/// master may try another state.
class NoRates : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A state of a mechanism at a time, under forces tau (nv) and wrenches on frames, six numbers for each:
/// moment and force about the origin of the frame, in inertial axes.
struct Point {
  double t = 0;
  std::vector<double> q, v, x, tau, wrenches = {};
};
/// The wrenches as loads on these frames.
std::vector<AppliedWrench<>> applied(std::span<const double> wrenches, std::span<const int> frames);
/// The rates of a state.
struct Rates {
  std::vector<double> dq, a, dx;
};

/// The equations of motion of a mechanism as a system of ordinary differential equations in (q, v, x), with
/// loops, prescribed motions, springs and drives. q need not have quaternions of unit norm: every function of
/// q takes q with its quaternions normalised, so that their norm is constant along solutions. The states of a
/// mechanism with loops are those of its tree; accelerations keep A v, and close() removes what an
/// integration has added to the residuals.
class MotionEquations {
 public:
  using Span = std::span<const double>;

  /// `loads` are the frames on which the wrenches of a point act.
  MotionEquations(const Model& model, const Settings& settings, std::span<const int> loads);

  const DriveSystem& drives() const { return drives_; }
  /// Continues with the statuses and inputs of other drives of the same mechanism.
  void act_by(const DriveSystem& drives) { drives_ = drives; }

  /// Makes (q, v) a state of the mechanism: quaternions of unit norm, loops that are closed, motions that are
  /// followed; and chooses the statuses of the drives. Throws std::runtime_error if the loops cannot be
  /// closed.
  void start(Point& at);
  Rates rates(const Point& at);
  /// Projects q and v, with quaternions of unit norm. Returns whether the loops could be closed.
  [[nodiscard]] bool close(Point& at);

  /// Continues with the statuses and inputs of the drives after a time, which may change x.
  void switch_drives(Point& at);
  double next_jump(double t) const;
  /// The least margin of the drives, or 1 if they have no statuses.
  double least_margin(const Point& at);
  /// The poses of frames: 12 numbers for each, the columns of R and r.
  std::vector<double> poses(const Point& at, std::span<const int> frames);

  /// The derivatives of (q', v', x', poses), one below the other, by (q, v, x, tau, wrenches). They are
  /// exact.
  Eigen::MatrixXd jacobian(const Point& at, std::span<const int> frames);
  /// The derivatives of the accelerations by a number of the description, which must have one, see Parameter.
  Eigen::VectorXd acceleration_by(const Point& at, const Parameter& parameter);

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// Accelerations by q along the group, v and tau, with springs and drives.
  struct Derivatives {
    RowMajor a_q, a_v, a_tau;
    Eigen::MatrixXd a_x;
    DriveDerivatives drives;
  };
  std::vector<double> normalized(Span q) const;
  void set_time(double t);
  bool is_closed(const Point& at);
  /// The loads at a point, valid until the next call.
  Loads<double> loads(const Point& at);
  /// The sum of the forces of drives and springs and of tau; writes the rates of x unless dx is null.
  std::vector<double> force_sum(const Point& at, Span q, std::vector<double>* dx);
  Derivatives derivatives(const Point& at, Span q);
  /// v along the group, and q with normalised quaternions, for each unit vector of q: nv × nq and nq × nq.
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
