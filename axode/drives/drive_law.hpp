#pragma once
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "axode/model/drive_states.hpp"
#include "axode/scalar/dual.hpp"

/// The interface of drives with states. A drive acts at a port with the coordinate l, an angle (rad) or a
/// length (m), and the rate w = l'. With the state x and the input u,
///     x' = f(x, u, l, w, t),   force on the port g(x, u, l, w, t),   e' = P_in - P_loss - g w        (D17.1)
/// where e is the stored energy, P_in the supplied power and P_loss the power that becomes heat. See the page
/// D17 of docs/derivations.
namespace axode {

/// The arguments of the functions of a drive law: time, input, coordinate and rate of the port, and states.
template <class T> struct DrivePoint {
  double t;  ///< s
  T u;       ///< input u
  T l, w;    ///< coordinate of the port (rad, m) and its rate
  std::span<const T> x;
};

/// The values of the functions of a drive law at a DrivePoint.
template <class T> struct DriveResponse {
  std::span<T> dx;       ///< rates x' of the states
  T force{};             ///< force on the port, N m or N; or the output, if it is the input of another drive
  T stored{};            ///< energy e, J
  T supplied{}, lost{};  ///< powers P_in and P_loss, W
};

/// The law of a drive: its states, and their rates, the force, the energy and the powers as functions of a
/// DrivePoint (x, u, l, w and t of (D17.1)). These functions are smooth while the statuses of the law are
/// constant. A status is a small integer that selects a branch of the law, such as the sign of a velocity or
/// whether a limit is reached. Several threads may call all member functions at once.
class DriveLaw {
 public:
  using Dual = axode::Dual<double, 1>;
  using Statuses = std::span<int>;

  virtual ~DriveLaw() = default;

  virtual std::vector<DriveState> states() const = 0;
  /// Writes the values x of the states at the start of a motion. `at` has the time, the input, and the
  /// coordinate and rate of the port there; its x is not set yet.
  virtual void start(const DrivePoint<double>& at, std::span<double> x) const = 0;
  /// Evaluates the rates, the force, the energy and the powers at a point and for given statuses, in double
  /// or in dual numbers with the derivative along one direction.
  virtual void evaluate(const DrivePoint<double>& at, std::span<const int> statuses,
                        DriveResponse<double>& out) const noexcept = 0;
  virtual void evaluate(const DrivePoint<Dual>& at, std::span<const int> statuses,
                        DriveResponse<Dual>& out) const noexcept = 0;

  /// The number of statuses of the law, 0 if its functions are smooth everywhere.
  virtual std::size_t n_statuses() const { return 0; }
  /// Chooses all statuses that belong to a point, at the start of a motion or for a given state.
  virtual void choose(const DrivePoint<double>&, Statuses) const {}
  /// The margin of status k at a point for given statuses: how far the status is from having to change, a
  /// smooth function that becomes negative when it must.
  virtual double margin(std::size_t, const DrivePoint<double>&, std::span<const int>) const noexcept {
    return 1;
  }
  /// Changes status k after its margin has become negative. The states x may jump at this change.
  virtual void change(std::size_t, const DrivePoint<double>&, Statuses, std::span<double>) const noexcept {}
};

/// A DriveLaw made from a struct Law, whose functions are written once for all scalars T. The struct has the
/// member template `evaluate(const DrivePoint<T>&, std::span<const int>, DriveResponse<T>&) const`, and the
/// members states() and start() of DriveLaw. If the law has statuses, the struct also has the members
/// n_statuses(), choose(), margin() and change() of DriveLaw.
template <class Law> class DriveLawOf final : public DriveLaw {
 public:
  explicit DriveLawOf(Law law) : law_(std::move(law)) {}

  std::vector<DriveState> states() const override { return law_.states(); }
  void start(const DrivePoint<double>& at, std::span<double> x) const override { law_.start(at, x); }
  void evaluate(const DrivePoint<double>& at, std::span<const int> statuses,
                DriveResponse<double>& out) const noexcept override {
    law_.evaluate(at, statuses, out);
  }
  void evaluate(const DrivePoint<Dual>& at, std::span<const int> statuses,
                DriveResponse<Dual>& out) const noexcept override {
    law_.evaluate(at, statuses, out);
  }
  std::size_t n_statuses() const override {
    if constexpr (switches) return law_.n_statuses();
    return 0;
  }
  void choose(const DrivePoint<double>& at, Statuses statuses) const override {
    if constexpr (switches) law_.choose(at, statuses);
  }
  double margin(std::size_t k, const DrivePoint<double>& at,
                std::span<const int> statuses) const noexcept override {
    if constexpr (switches) return law_.margin(k, at, statuses);
    return 1;
  }
  void change(std::size_t k, const DrivePoint<double>& at, Statuses statuses,
              std::span<double> x) const noexcept override {
    if constexpr (switches) law_.change(k, at, statuses, x);
  }

 private:
  static constexpr bool switches = requires(const Law& law) { law.n_statuses(); };

  Law law_;
};

/// A quantity must pass a limit by this part of the limit before its status changes, so that rounding errors
/// do not change the status back.
inline constexpr double past_limit = 1e-12;

/// The status of a quantity that is limited to ±limit: 0 while the quantity is inside, and otherwise the sign
/// of the limit at which it is held.
struct Saturation {
  double limit;

  int choose(double value) const { return value > limit ? 1 : value < -limit ? -1 : 0; }
  double margin(double value, int status) const {
    if (status == 0) return limit * (1 + past_limit) - (value < 0 ? -value : value);
    return status * value - limit;
  }
  int next(double value, int status) const { return status == 0 ? (value > 0 ? 1 : -1) : 0; }
  template <class T> T of(const T& value, int status) const {
    return status == 0 ? value : T(status * limit);
  }
};

}  // namespace axode
