#pragma once
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "axode/fmi/check_supported.hpp"
#include "axode/fmi/motion_equations.hpp"
#include "axode/fmi/stepped_motion.hpp"
#include "axode/fmi/variables.hpp"

namespace axode::fmi {

/// An instance of an FMU (Functional Mock-up Unit), independent of the version of FMI. All functions throw
/// std::runtime_error or std::invalid_argument with a sentence for the log. A copy of an Instance is a saved
/// state.
class Instance {
 public:
  using References = std::span<const unsigned>;
  using Span = std::span<const double>;

  /// The modes of FMI 3.0. `step` is the mode of a co-simulation between two communication steps.
  enum class Mode { instantiated, initialization, event, continuous_time, step, terminated };

  /// Reads the texts of the resource files, drawing of the mechanism and settings, and resets the instance.
  Instance(Kind kind, std::string_view drawing, std::string_view settings);
  Instance(const Instance&) = default;
  Instance& operator=(const Instance&) = delete;
  ~Instance() = default;

  void reset();
  /// Sets the start time (s) and the relative tolerance of the importing program, which may be empty.
  void set_up(double start, std::optional<double> tolerance);
  void enter_initialization(double start, std::optional<double> tolerance) {
    set_up(start, tolerance);
    enter(Mode::initialization);
  }
  void exit_initialization();
  void enter(Mode mode) { mode_ = mode; }

  void get(References references, std::span<double> values);
  void set(References references, Span values);

  std::size_t n_states() const { return at_.q.size() + at_.v.size() + at_.x.size(); }
  std::size_t n_indicators() const { return table_.count(Role::indicator); }
  void set_time(double t) {
    at_.t = t;
    state_changed();
  }
  void set_states(Span states);
  void get_states(std::span<double> states) const;
  void get_rates(std::span<double> rates);
  void get_indicators(std::span<double> indicators);
  void get_nominals(std::span<double> nominals) const;
  /// Whether the FMU must go to event mode after the completed step. This is so if a drive must change to
  /// another branch of its law (for example because a current reaches its limit), if a joint with dry
  /// friction or gear losses must begin to stick or to slide, if a play (backlash of a coupling) or a hard
  /// stop must open or close, or if closing the loops and normalising the quaternions would change a
  /// coordinate or a velocity by more than a tolerance.
  bool needs_event();
  struct Event {
    bool states_changed = false;
    std::optional<double> next = {};  ///< time of the next event, s; empty if none is known
  };
  Event update_discrete_states();

  /// Integrates from the communication point at time t to t + h (s).
  void step(double t, double h);

  /// directional_derivative() returns the product of the Jacobian, which has the derivatives of the unknowns
  /// by the knowns, with a vector `seed` of one number for each known. adjoint_derivative() returns the
  /// product of the transposed Jacobian with one number for each unknown.
  void directional_derivative(References unknowns, References knowns, Span seed, std::span<double> result);
  void adjoint_derivative(References unknowns, References knowns, Span seed, std::span<double> result);

 private:
  const Variable& variable(unsigned reference) const;
  [[noreturn]] void refuse(const Variable& variable, const char* why) const;
  bool is_before_start() const { return mode_ == Mode::instantiated || mode_ == Mode::initialization; }
  void set_one(const Variable& variable, double value);
  double get_one(const Variable& variable);
  /// During initialisation, rebuilds the model if parameters or initial states of drives have changed, closes
  /// loops and normalises quaternions. Later it does nothing.
  void prepare();
  void start_stepping();
  const Rates& rates();
  const std::vector<double>& poses();
  double indicator(std::size_t k);
  double gap(const Stop& stop) const;
  std::vector<double> reserves();
  /// Returns the least margin of the drives. It becomes negative when a drive must change to another branch
  /// of its law, for example because a current reaches its limit. It is 1 if the FMU has no event indicator
  /// for the drives. Updates margin_scale_, the largest magnitude of the margin so far.
  double observe_margin();
  /// The Jacobian of the unknowns (rows) by the knowns (columns).
  Eigen::MatrixXd jacobian(References unknowns, References knowns);
  Eigen::RowVectorXd row(const Variable& unknown, const Eigen::MatrixXd& all) const;
  std::optional<Eigen::Index> column(const Variable& known) const;
  bool has_jumps() const;
  double drift(const Point& closed) const;
  void state_changed() {
    rates_.reset();
    poses_.reset();
    jacobian_.reset();
  }

  Kind kind_;
  Settings settings_;
  Model model_;
  VariableTable table_;
  std::vector<double> parameters_;
  MotionEquations equations_;
  std::optional<SteppedMotion> motion_;  ///< motion of a co-simulation; empty until accelerations or a step
                                         ///< are needed
  Point at_;
  Mode mode_ = Mode::instantiated;
  bool model_is_old_ = false, state_is_raw_ = true;
  double margin_scale_ = 0;  ///< largest absolute margin of the drives at the ends of steps so far
  std::optional<double> tolerance_;
  std::optional<Rates> rates_;
  std::optional<std::vector<double>> poses_;
  std::optional<Eigen::MatrixXd> jacobian_;
};

}  // namespace axode::fmi
