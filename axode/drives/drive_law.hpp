#pragma once
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "axode/model/drive_states.hpp"
#include "axode/scalar/dual.hpp"

/// The interface of drives with states. A drive acts at a port with the coordinate l and the rate w = l': an
/// angle (rad) or a length (m). With the state x and the input u,
///     x' = f(x, u, l, w, t),   force on the port g(x, u, l, w, t),   e' = P_in - P_loss - g w        (D17.1)
/// where e is the stored energy. See the page D17 of docs/derivations.
namespace axode {

/// The arguments of the functions of a drive.
template <class T> struct DrivePoint {
  double t;  ///< s
  T u;       ///< input
  T l, w;    ///< coordinate of the port (rad, m) and its rate
  std::span<const T> x;
};

/// The values of the functions of a drive.
template <class T> struct DriveResponse {
  std::span<T> dx;       ///< x'
  T force{};             ///< force on the port, N m or N; the output of a drive that feeds another one
  T stored{};            ///< energy e, J
  T supplied{}, lost{};  ///< powers P_in and P_loss, W
};

/// The law of a drive. Its functions are smooth while its statuses are constant; a status is a small integer,
/// such as the sign of a velocity or whether a limit is reached. All functions may be called by several
/// threads.
class DriveLaw {
 public:
  using Dual = axode::Dual<double, 1>;
  using Statuses = std::span<int>;

  virtual ~DriveLaw() = default;

  virtual std::vector<DriveState> states() const = 0;
  /// Writes the values of the states at the start of a motion; `at` has no x.
  virtual void start(const DrivePoint<double>& at, std::span<double> x) const = 0;
  /// Evaluates the functions, in double and with a derivative.
  virtual void evaluate(const DrivePoint<double>& at, std::span<const int> statuses,
                        DriveResponse<double>& out) const noexcept = 0;
  virtual void evaluate(const DrivePoint<Dual>& at, std::span<const int> statuses,
                        DriveResponse<Dual>& out) const noexcept = 0;

  /// The number of statuses.
  virtual std::size_t n_statuses() const { return 0; }
  /// Sets all statuses at the start of a motion.
  virtual void choose(const DrivePoint<double>&, Statuses) const {}
  /// A smooth function that is not negative while status k may remain as it is.
  virtual double margin(std::size_t, const DrivePoint<double>&, std::span<const int>) const noexcept {
    return 1;
  }
  /// Changes status k, whose margin has become negative. x may jump.
  virtual void change(std::size_t, const DrivePoint<double>&, Statuses, std::span<double>) const noexcept {}
};

/// A law whose functions are written once for all scalars T, by a struct with the member function
/// `evaluate(const DrivePoint<T>&, std::span<const int>, DriveResponse<T>&) const`, which is a template, and
/// the members states() and start(). If it has statuses, it has n_statuses() and the functions of them.
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

/// Relative distance by which a quantity passes a limit before its status changes, so that rounding errors do
/// not change it back.
inline constexpr double past_limit = 1e-12;

/// The status of a quantity that is limited to ±limit: 0 inside, and otherwise the sign of the limit at which
/// it is held.
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
