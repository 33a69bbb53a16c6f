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

/// Energy and powers of all drives of a mechanism.
struct DriveEnergy {
  double stored = 0;              ///< J
  double supplied = 0, lost = 0;  ///< W
};

/// Derivatives of the drive forces τ (nv) and of the rates f of the states (nx), by q along the group, by v,
/// by x and by the inputs u that are functions of time.
struct DriveDerivatives {
  Eigen::MatrixXd tau_q, tau_v, tau_x, tau_u;
  Eigen::MatrixXd f_q, f_v, f_x, f_u;
};

/// All drives of a mechanism: their ports and laws, in an order in which a drive comes after the one that
/// feeds it. The states x of all drives are one vector, in the order of the drives. An object serves one
/// thread.
class DriveSystem {
 public:
  using Span = std::span<const double>;

  /// The drives of the description, followed by `more`. Throws std::invalid_argument for unknown joints, for
  /// joints that do not have one velocity, and for drives of `more` without a law, a joint or a finite
  /// factor.
  explicit DriveSystem(const Model& model, std::span<const AddedDrive> more = {});

  bool empty() const { return drives_.empty(); }
  std::size_t size() const { return drives_.size(); }
  std::size_t nx() const { return states_.size(); }
  const std::string& name(std::size_t drive) const { return drives_[drive].name; }
  /// The states with their units; their names are `<drive>.<state>`.
  std::span<const DriveState> states() const { return states_; }
  /// The drives whose input is a function of time, in the order of the columns of tau_u and f_u.
  std::span<const std::size_t> inputs() const { return inputs_; }

  /// Takes the inputs after a time, writes the states x with which a motion starts there, and chooses the
  /// statuses.
  void start(double t, Span q, Span v, std::span<double> x);
  /// Takes the inputs after a time, and chooses the statuses of a state.
  void set_state(double t, Span q, Span v, Span x);

  /// Adds the drive forces to tau (nv), and writes the rates of x.
  void evaluate(double t, Span q, Span v, Span x, std::span<double> tau, std::span<double> dx);
  /// Adds to tau the forces of drives that act along lines, at the last evaluation; evaluate() has added them
  /// as well.
  void add_line_forces(std::span<double> tau) const;
  DriveEnergy energy(double t, Span q, Span v, Span x);
  /// Allocates.
  DriveDerivatives derivatives(double t, Span q, Span v, Span x);
  /// Writes the rates of x, and returns their derivatives f_x alone. Allocates.
  Eigen::MatrixXd rates_by_states(double t, Span q, Span v, Span x, std::span<double> dx);

  /// The first time after t at which an input jumps; infinite if there is none.
  double next_jump(double t) const;
  /// The least margin of all statuses. A step must end where it becomes negative.
  double least_margin(double t, Span q, Span v, Span x);
  /// Continues a motion after a step: inputs that jump at this time take their new values, and statuses with
  /// negative margins change. Returns whether anything changed, which may include x.
  bool switch_at(double t, Span q, Span v, std::span<double> x);

 private:
  struct Drive {
    std::string name;
    std::shared_ptr<const DriveLaw> law;
    DrivePort port;
    DriveSignal signal;
    std::string from;  ///< drive whose output is the input, or empty
    std::vector<std::pair<std::string, double>> initial;
    int fed_by = -1;     ///< its index
    bool feeds = false;  ///< whether the output is the input of another drive
    std::size_t first_x = 0, n_x = 0;
    std::vector<int> statuses = {};
  };
  /// The arguments of all laws, and their results.
  template <class T> struct Values { std::vector<T> x, l, w, u, outputs, dx; };

  void order_by_inputs();
  /// The arguments and results of the last evaluation, with derivatives of 0.
  Values<DriveLaw::Dual> with_duals() const;
  void update_ports(double t, Span q, Span v);
  /// Evaluates drive d after the one that feeds it.
  template <class T> DriveResponse<T> respond(std::size_t d, double t, Values<T>& values) const;
  template <class T> DrivePoint<T> point(std::size_t d, double t, const Values<T>& values) const;
  void evaluate_laws(double t, Span q, Span v, Span x);
  void choose_statuses(double t, std::size_t d);

  Model model_;
  std::vector<Drive> drives_;
  std::vector<std::size_t> order_, inputs_;
  std::vector<DriveState> states_;
  Values<double> now_;
};

}  // namespace axode
