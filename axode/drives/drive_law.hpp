#pragma once
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "axode/model/drive_states.hpp"
#include "axode/scalar/dual.hpp"

/// The interface of drives with states, such as motors and cylinders. A drive acts along a coordinate l, an
/// angle (rad) or a length (m), with the rate w = l'. With the states x of the drive and its input u,
///   x' = f(x, u, l, w, t),   force along l: g(x, u, l, w, t),   e' = P_in - P_loss - g w        (D17.1)
/// where e is the stored energy, P_in the supplied power and P_loss the power that becomes heat.
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

/// The law of a drive. It gives the rates of the states of the drive, its force, its energy and its powers as
/// functions of time, of the input and the states of the drive, of the coordinate along which the drive acts,
/// and of the rate of this coordinate. This coordinate is a sum of joint coordinates with factors, or the
/// length of a straight line between points of two bodies. A status is a small integer that selects a branch
/// of the law, such as the sign of a velocity or whether a limit is reached; the functions are smooth while
/// all statuses are constant. Several threads may call all member functions at once.
class DriveLaw {
 public:
  using Dual = axode::Dual<double, 1>;
  using Statuses = std::span<int>;

  virtual ~DriveLaw() = default;

  virtual std::vector<DriveState> states() const = 0;
  /// Writes the initial values x of the states for the time, input, coordinate and rate in `at`.
  virtual void start(const DrivePoint<double>& at, std::span<double> x) const = 0;
  /// Evaluates the law at a point for given statuses; with dual numbers, also a directional derivative.
  virtual void evaluate(const DrivePoint<double>& at, std::span<const int> statuses,
                        DriveResponse<double>& out) const noexcept = 0;
  virtual void evaluate(const DrivePoint<Dual>& at, std::span<const int> statuses,
                        DriveResponse<Dual>& out) const noexcept = 0;

  /// The number of statuses of the law, 0 if its functions are smooth everywhere.
  virtual std::size_t n_statuses() const { return 0; }
  /// Chooses all statuses that belong to a point, at the start of a motion or for a given state.
  virtual void choose(const DrivePoint<double>&, Statuses) const {}
  /// The margin of status k at a point: a smooth function that becomes negative when the status must change.
  virtual double margin(std::size_t, const DrivePoint<double>&, std::span<const int>) const noexcept {
    return 1;
  }
  /// The margin of a status, the integer that selects a branch of the law. The margin becomes negative when
  /// the status must change. It is computed with its derivative along the direction in `DrivePoint<Dual>`.
  /// Sensitivities of a motion need the derivative, because the time of the change depends on the state. A
  /// law that does not override it has the derivative 0; its changes then count as changes at fixed times.
  virtual Dual margin(std::size_t, const DrivePoint<Dual>&, std::span<const int>) const noexcept { return 1; }
  /// Changes status k after its margin has become negative. The states x may jump at this change.
  virtual void change(std::size_t, const DrivePoint<double>&, Statuses, std::span<double>) const noexcept {}
};

/// Makes a DriveLaw from a struct Law, whose functions are written once for all types T of numbers. The
/// struct has a member template `evaluate(const DrivePoint<T>&, std::span<const int>, DriveResponse<T>&)
/// const`, and the members states() and start() of DriveLaw. If the law has statuses, integers that select a
/// branch of the law (such as whether a limit is reached), the struct also has the members n_statuses(),
/// choose(), margin() and change() of DriveLaw; margin() may be a template.
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
  Dual margin(std::size_t k, const DrivePoint<Dual>& at,
              std::span<const int> statuses) const noexcept override {
    if constexpr (requires { law_.margin(k, at, statuses); }) return law_.margin(k, at, statuses);
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

/// Hysteresis of limits: a status changes when its quantity has passed the limit by this fraction of it.
inline constexpr double past_limit = 1e-12;

/// The status of a quantity limited to ±limit: 0 inside, or the sign of the limit at which it is held.
struct Saturation {
  double limit;

  int choose(double value) const { return value > limit ? 1 : value < -limit ? -1 : 0; }
  template <class T> T margin(const T& value, int status) const {
    if (status == 0) return T(limit * (1 + past_limit)) - (value < T(0) ? -value : value);
    return T(status) * value - T(limit);
  }
  int next(double value, int status) const { return status == 0 ? (value > 0 ? 1 : -1) : 0; }
  template <class T> T of(const T& value, int status) const {
    return status == 0 ? value : T(status * limit);
  }
};

}  // namespace axode
