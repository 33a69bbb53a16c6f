#pragma once
#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "axode/drives/added_drive.hpp"
#include "axode/drives/drive_input.hpp"
#include "axode/drives/drive_law.hpp"
#include "axode/drives/drive_port.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// Sums over the drives of a mechanism: stored energy, supplied power and power that becomes heat.
struct DriveEnergy {
  double stored = 0;              ///< J
  double supplied = 0, lost = 0;  ///< W
};

/// Derivatives of the drive forces τ (nv numbers) and of the rates f = x' of the nx states x of the drives:
/// by q along the left-trivialised directions (nv columns), by v, by x (nx columns), and by those inputs u
/// that are functions of time (a column for each of these inputs).
struct DriveDerivatives {
  Eigen::MatrixXd tau_q, tau_v, tau_x, tau_u;
  Eigen::MatrixXd f_q, f_v, f_x, f_u;
};

/// Derivatives of the least margin of the statuses of the drives: by q along the left-trivialised directions,
/// by v, by the states x of the drives, and by the inputs that are functions of time. A status is an integer
/// that says which form of a drive's law holds, such as whether a limit is reached. Its margin is a smooth
/// function of time, state and inputs that becomes negative when the status must change.
struct MarginDerivatives {
  Eigen::RowVectorXd q, v, x, u;
};

/// All drives of a mechanism with their laws, inputs and statuses, the integers that say which form of each
/// law holds, such as whether a limit is reached. The input of a drive may be the output of another one. The
/// states x of all drives are one vector of nx() numbers. An object serves one thread.
class DriveSystem {
 public:
  using Span = std::span<const double>;

  /// Takes the drives of the description of the model, followed by those in `more`. A drive in `more` acts
  /// along a sum of joint coordinates, each multiplied by a factor. Throws std::invalid_argument for a drive
  /// in `more` without a law or without joints, for a joint that does not exist or does not have one
  /// velocity, and for a factor that is 0 or not finite.
  explicit DriveSystem(const Model& model, std::span<const AddedDrive> more = {});

  bool empty() const { return drives_.empty(); }
  std::size_t size() const { return drives_.size(); }
  std::size_t nx() const { return states_.size(); }
  const std::string& name(std::size_t drive) const { return drives_[drive].name; }
  /// The states of all drives in the order of x, with their units and with names `<drive>.<state>`.
  std::span<const DriveState> states() const { return states_; }
  /// Indices of the drives whose input is a function of time instead of the output of another drive.
  std::span<const std::size_t> inputs() const { return inputs_; }
  /// The rates of these inputs at time t, as difference quotients over 2 µs; those of steps are 0.
  Eigen::VectorXd input_rates(double t) const;

  /// Starts the drives at time t and state (q, v): sets the inputs to their values just after t, writes the
  /// initial states x (nx() numbers), and chooses the statuses, the integers that say which form of each
  /// drive's law holds.
  void start(double t, Span q, Span v, std::span<double> x);
  /// Sets the inputs to their values just after time t. Chooses the statuses, the integers that say which
  /// form of each drive's law holds, for the state (q, v, x).
  void set_state(double t, Span q, Span v, Span x);

  /// Evaluates all laws at time t and state (q, v, x): adds the drive forces to tau (nv numbers), and writes
  /// the rates x' to dx (nx() numbers).
  void evaluate(double t, Span q, Span v, Span x, std::span<double> tau, std::span<double> dx);
  /// Adds to tau the last forces of drives along lines between two points, which evaluate() also adds.
  void add_line_forces(std::span<double> tau) const;
  DriveEnergy energy(double t, Span q, Span v, Span x);
  /// Computes the derivatives of the drive forces and of the rates x' of the drive states by q, v, x and
  /// those inputs that are functions of time. The statuses, the integers that say which form of each drive's
  /// law holds, are taken as constant. Allocates memory only in the first call and for an `out` that has not
  /// been used before.
  void derivatives(double t, Span q, Span v, Span x, DriveDerivatives& out);
  DriveDerivatives derivatives(double t, Span q, Span v, Span x) {
    DriveDerivatives out;
    derivatives(t, q, v, x, out);
    return out;
  }
  /// Writes the rates x' of the drive states to dx, and ∂x'/∂x (nx() × nx()) to f_x.
  void rates_by_states(double t, Span q, Span v, Span x, std::span<double> dx, Eigen::MatrixXd& f_x);

  /// The first time after t at which an input or one of its derivatives jumps; infinite if there is none.
  double next_jump(double t) const;
  /// The least margin of the statuses of all drives; infinite if there are none. A status is an integer that
  /// says which form of a drive's law holds. Its margin is a smooth function of time, state and inputs that
  /// becomes negative when the status must change, for example the distance of a quantity from its limit, in
  /// the unit of this quantity.
  double least_margin(double t, Span q, Span v, Span x);
  /// Computes the derivatives of the least margin of the statuses of all drives by q along the
  /// left-trivialised directions, by v, by the states x of the drives and by the inputs that are functions of
  /// time. A status is an integer that says which form of a drive's law holds, and its margin is a function
  /// that becomes negative when the status must change. At least one drive must have a status. Allocates.
  MarginDerivatives margin_derivatives(double t, Span q, Span v, Span x);
  /// Applies the discontinuous changes of the drives at time t and state (q, v, x). Inputs that jump at t
  /// take their values after the jump. A status, the integer that says which form of a drive's law holds,
  /// changes if its margin is negative; states in x may jump then. The margin is a smooth function of time,
  /// state and inputs that the law defines. Returns whether an input or a status has changed.
  bool switch_at(double t, Span q, Span v, std::span<double> x);
  /// The discrete state of the drives, which switch_at() changes. For each drive it has the index of the time
  /// interval in which its input is constant at present (0 unless the input is piecewise constant), and the
  /// statuses, the integers that say which form of the drive's law holds. discrete() writes it to `out`, and
  /// set_discrete() restores it.
  void discrete(std::vector<std::size_t>& out) const;
  void set_discrete(std::span<const std::size_t> from);

 private:
  struct Drive {
    std::string name;
    std::shared_ptr<const DriveLaw> law;
    DrivePort port;
    DriveSignal signal;
    std::string from;  ///< name of the drive whose output is the input; empty: none
    std::vector<std::pair<std::string, double>> initial;
    int fed_by = -1;     ///< index of the drive whose output is the input, or -1
    bool feeds = false;  ///< whether the output is the input of another drive
    std::size_t first_x = 0, n_x = 0;
    std::vector<int> statuses = {};
  };
  /// The arguments and results of the laws: x and dx have nx() entries, the others one for each drive.
  template <class T> struct Values { std::vector<T> x, l, w, u, outputs, dx; };

  void order_by_inputs();
  /// Copies the arguments and results of the last evaluation to duals_, with derivatives of 0.
  void set_duals();
  void update_ports(double t, Span q, Span v);
  /// Evaluates the law of drive d. If another drive feeds it, that one must have been evaluated before.
  template <class T> DriveResponse<T> respond(std::size_t d, double t, Values<T>& values) const;
  template <class T> DrivePoint<T> point(std::size_t d, double t, const Values<T>& values) const;
  void evaluate_laws(double t, Span q, Span v, Span x);
  void choose_statuses(double t, std::size_t d);
  /// The status with the least margin at the last evaluation of the laws: the value of the margin, the index
  /// of the drive, and the index of the status in this drive. A status is an integer that says which form of
  /// the drive's law holds; it changes when its margin becomes negative.
  struct LeastMargin {
    double value;
    std::size_t drive = 0, status = 0;
  };
  LeastMargin least_margin_now(double t) const;
  struct ByArguments {
    Eigen::MatrixXd q, v, x, u;
  };
  template <class F> void by_arguments(double t, Span q, Span v, Eigen::Index n, const F& f);

  Model model_;
  std::vector<Drive> drives_;
  std::vector<std::size_t> order_, inputs_;
  std::vector<DriveState> states_;
  Values<double> now_;
  // Memory of derivatives() and rates_by_states().
  Values<DriveLaw::Dual> duals_;
  ByArguments by_;
  Eigen::VectorXd along_;
  std::vector<double> of_row_;
};

}  // namespace axode
