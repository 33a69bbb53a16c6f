#pragma once
#include <Eigen/Core>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "axode/drives/drive_system.hpp"
#include "axode/fmi/variables.hpp"
#include "axode/integration/prescribed/closed_motion.hpp"
#include "axode/integration/runs/friction_response.hpp"
#include "axode/integration/runs/plays.hpp"
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
/// `reserves` are numbers that become negative when a joint must begin to stick or to slide, or when a play
/// (backlash of a coupling) or a hard stop must open or close. There is one for each velocity with dry
/// friction or a gear with losses, then one for each play and hard stop.
struct Rates {
  std::vector<double> dq, a, dx, reserves = {};
};

/// The equations of motion of a mechanism, with loops, prescribed motions, springs, drives and losses of
/// joints, as ordinary differential equations in (q, v, x) with the states x of drives. Joints with dry
/// friction stick or slide in one direction until switch_friction() is called. Plays (backlash of couplings)
/// and hard stops are free or at an end until switch_plays() is called. All functions first normalise the
/// quaternions in q. A mechanism with loops has the states of its spanning tree. The accelerations satisfy
/// the second time derivative of the loop equations; deviations of q and v from closed loops, which
/// accumulate in an integration, are removed by close().
class MotionEquations {
 public:
  using Span = std::span<const double>;

  /// `loads` are the indices of the frames on which the wrenches of a Point act.
  MotionEquations(const Model& model, const Settings& settings, std::span<const int> loads);

  const DriveSystem& drives() const { return drives_; }
  /// Copies two parts of another motion of the same mechanism: its drives, with their inputs and statuses
  /// (integers that select the branches of their laws), and which of its joints stick or slide. The
  /// continuous states (q, v, x) are not copied.
  void act_by(const DriveSystem& drives, const DryFriction& friction) {
    drives_ = drives;
    friction_ = friction;
  }

  /// Corrects a state at which a motion starts: normalises the quaternions, and changes q and v such that
  /// loops are closed and prescribed motions are followed at the time in `at`. Then determines which branch
  /// of its law each drive is in, and which joints stick or slide. Throws std::runtime_error if the loops
  /// cannot be closed. Throws NoRates if q cannot be normalised, or if there are joints with dry friction or
  /// gear losses and the accelerations cannot be computed.
  void start(Point& at);
  /// Finds out which plays (backlash of couplings) and hard stops are at an end in the state `at` at which a
  /// motion starts. Those that move against their end have an impact, which changes v. Throws
  /// std::invalid_argument for a play or joint beyond an end. Without this call all plays and stops are free.
  void start_plays(Point& at);
  Rates rates(const Point& at);
  /// Whether there are loops, prescribed motions or plays at an end, which close() keeps closed.
  bool has_loops() const { return loops_.has_value(); }
  /// Changes q and v of the state `at` such that loops are closed and prescribed motions are followed at its
  /// time, and plays at an end remain there. Normalises quaternions. Returns whether this succeeded.
  [[nodiscard]] bool close(Point& at);

  /// Updates the drives at the time in `at`. Inputs that jump at this time take their new values. The
  /// statuses of drives, the integers that select a branch of a drive's law (for example that a current is at
  /// its limit), change if they must; then the states x of the drives may change, too.
  void switch_drives(Point& at);
  double next_jump(double t) const;
  /// Lets joints with dry friction or gear losses begin to stick or to slide, at the time and the state in
  /// `at`. The velocities of joints that have come to rest at this time, up to rounding, become 0 in `at`.
  /// Joints at rest begin to slide if friction cannot hold them.
  void switch_friction(Point& at);
  /// Lets plays (backlash of couplings) and hard stops meet and leave their ends in the state `at`, as
  /// simulate() does with plays. Impacts change v.
  void switch_plays(Point& at);
  /// Takes note that a step of the importing program has ended at `at`, without an event.
  void complete_step(const Point& at) { plays_.reduce_overshoot(at.q); }
  /// The least margin of the statuses of all drives; 1 if there are no statuses. A status is an integer that
  /// selects a branch of a drive's law. Its margin becomes negative when the status must change; it is for
  /// example the distance of a current from its limit, in A.
  double least_margin(const Point& at);
  /// The poses of frames, given by indices, with 12 numbers each: columns of the rotation, then position.
  std::vector<double> poses(const Point& at, std::span<const int> frames);

  /// The derivatives of the equations of motion at the time, the state (q, v, x), the drive forces and the
  /// wrenches of `at`; x are the states of drives. The rows are those of q', v', x' and the poses of `frames`
  /// (12 numbers each), one below the other. The columns are the derivatives by q (nq; for a quaternion, by
  /// its four components before it is normalised), by v, by x, by the drive forces (nv) and by the wrenches
  /// (6 numbers for each loaded frame). The losses of gears are not differentiated. All other derivatives are
  /// exact as long as no drive changes to another branch of its law, no joint begins to stick or slide and no
  /// play (backlash of a coupling) opens or closes.
  Eigen::MatrixXd jacobian(const Point& at, std::span<const int> frames);
  /// The derivatives of the accelerations (nv) by a parameter; its has_derivative must be true.
  Eigen::VectorXd acceleration_by(const Point& at, const Parameter& parameter);

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// The derivatives of the accelerations a and of the drives' forces and rates x', by q (along
  /// left-trivialised directions), by v and by the states x of drives; and those of a by tau.
  struct Derivatives {
    RowMajor a_q, a_v, a_tau;
    Eigen::MatrixXd a_x;
    DriveDerivatives drives;
  };
  std::vector<double> normalized(Span q) const;
  void set_time(double t);
  bool is_closed(const Point& at);
  Plays::Engage engagement(const Point& at);
  void settle_plays(const Point& at);
  /// The loads with the wrenches in `at`. They are valid until the next call.
  Loads<double> loads(const Point& at);
  /// The joint forces (nv) at the time and the state in `at`. They are the sum of the forces tau in `at`,
  /// which the importing program gives, of the forces of the drives and springs of the mechanism and, if
  /// there is dry friction, of the forces of damping and of friction in sliding joints. q is the
  /// configuration with normalised quaternions. Writes the rates of the states x of the drives to `dx` unless
  /// it is null.
  std::vector<double> force_sum(const Point& at, Span q, std::vector<double>* dx);
  Derivatives derivatives(const Point& at, Span q);
  /// Computes derivatives by the coordinates before quaternions are normalised, `raw` (nq numbers).
  /// `normalization` (nq × nq) has the derivatives of the normalised coordinates q by `raw`. Column k of
  /// `displacement` (nv × nq) is the displacement of the configuration, along left-trivialised directions,
  /// for a unit of raw[k].
  void seeds(Span raw, Span q, Eigen::MatrixXd& displacement, Eigen::MatrixXd& normalization) const;
  Eigen::MatrixXd rates_by_coordinates(Span q, Span v) const;

  Model model_;
  Settings settings_;
  std::vector<int> load_frames_;
  std::vector<AppliedWrench<>> wrenches_;
  Workspace<> workspace_;
  std::optional<ClosedMotion> loops_;
  DriveSystem drives_;
  Plays plays_;
  DryFriction friction_;
  EnergyNorm norm_;
  FrictionResponse response_;
  std::vector<double> through_gears_;  ///< the part of the drive forces that passes through gears
};

}  // namespace axode::fmi
