#include "axode/constraints/higher_order/inverse_kinematics_rates.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/higher_order/loop_series.hpp"
#include "axode/constraints/stable_norm.hpp"
#include "axode/eigen.hpp"
#include "axode/kinematics/higher_order/higher_order.hpp"
#include "axode/model/finite.hpp"
#include "axode/recursion/least_squares.hpp"

namespace axode {
namespace {

constexpr double rounding = 1e-13;  ///< pivots of J that are smaller than this fraction of the largest
                                    ///< pivot count as 0
constexpr double reachable = 1e-9;  ///< largest RatesReached::missing of a derivative that counts as reached

/// Writes to `out` those of the parts w and v of a six-vector that the target specifies.
template <class Target>
void write_parts(const Target& target, const Vec3<>& w, const Vec3<>& v, Eigen::Ref<Eigen::VectorXd> out) {
  Eigen::Index row = 0;
  if (target.angular) {
    out.segment<3>(row) = to_eigen(w);
    row += 3;
  }
  if (target.linear) out.segment<3>(row) = to_eigen(v);
}
template <class Target> Eigen::Index rows_of(const Target& target) {
  return 3 * (Eigen::Index(target.angular) + Eigen::Index(target.linear));
}

template <class Rep> void check(std::span<const TwistTarget<Rep>> targets, std::size_t orders) {
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const std::string name = "targets[" + std::to_string(t) + "].V";
    check_size(name.c_str(), targets[t].V.size(), orders, "one for each row of rates");
    for (const TwistRate<Rep>& V : targets[t].V)
      if (const auto& [w, v] = V; !finite(w) || !finite(v))
        throw std::invalid_argument(name + " has a number that is not finite");
  }
}

/// The linear systems whose solutions are the joint velocities and their time derivatives. All have the same
/// matrix: the Jacobians of the frames on bodies that have wanted motions, and below them the Jacobian of the
/// loop equations. The right side of each is `wanted - known`, where `known` has the terms with lower
/// derivatives.
template <class Rep> class RateSystem {
 public:
  RateSystem(const Model& model, Numbers<double> q, std::span<const TwistTarget<Rep>> targets, int orders)
      : model_(model), q_(q), targets_(targets.begin(), targets.end()), motion_(model, orders - 1) {
    Eigen::Index rows = model.loops().rows;
    for (TwistTarget<Rep>& target : targets_) {
      target.place = found(model, target.place);
      rows += rows_of(target);
    }
    if (!model.loops().empty()) loops_.emplace(model, orders - 1);
    matrix.resize(rows, model.nv());
    wanted.resize(rows);
    known.resize(rows);
  }

  /// Sets up the linear system whose solution is the k-th time derivative v^(k) of the joint velocities. Its
  /// right side is `wanted - known`: the wanted k-th derivatives of the twists (0 for loops), minus their
  /// terms with lower derivatives of v. If k is 0, also sets up the matrix, which is the same for all
  /// derivatives. `rates` has the rows v, v', v'', ...; row v^(k) and the rows after it must be 0.
  void run(std::span<const double> rates, int k) {
    motion_.evaluate(q_, rates);
    Eigen::Index row = 0;
    for (const TwistTarget<Rep>& target : targets_) {
      const Eigen::Index n = rows_of(target);
      const auto& [w, v] = target.V[static_cast<std::size_t>(k)];
      write_parts(target, w, v, wanted.segment(row, n));
      const auto& [known_w, known_v] = motion_.template twist_derivative<Rep>(target.place, k);
      write_parts(target, known_w, known_v, known.segment(row, n));
      if (k == 0) write_jacobian(target, matrix.middleRows(row, n));
      row += n;
    }
    if (!loops_) return;
    loops_->run(q_.data(), rates.data());
    wanted.tail(model_.loops().rows).setZero();
    known.tail(model_.loops().rows) = loops_->known_terms(rates.data(), k);
    if (k == 0) matrix.bottomRows(model_.loops().rows) = loops_->derivative(0);
  }

  Eigen::MatrixXd matrix;
  Eigen::VectorXd wanted, known;

 private:
  void write_jacobian(const TwistTarget<Rep>& target, Eigen::Ref<Eigen::MatrixXd> out) const {
    std::vector<TwistRate<Rep>> J(static_cast<std::size_t>(model_.nv()));
    motion_.template jacobian_derivative<Rep>(target.place, 0, J);
    for (Eigen::Index c = 0; c < out.cols(); ++c) {
      const auto& [w, v] = J[static_cast<std::size_t>(c)];
      write_parts(target, w, v, out.col(c));
    }
  }

  const Model& model_;
  Numbers<double> q_;
  std::vector<TwistTarget<Rep>> targets_;
  HigherOrderMotion<> motion_;
  std::optional<LoopSeries> loops_;
};

}  // namespace

template <RecursionRepresentation Rep>
RatesReached inverse_kinematics_rates(const Model& model, Numbers<double> q,
                                      std::type_identity_t<std::span<const TwistTarget<Rep>>> targets,
                                      std::span<double> rates) {
  check_configuration(model, q);
  if (!finite(q)) throw std::invalid_argument("q is not finite");
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  const std::size_t none = targets.empty() ? 0 : targets.front().V.size();
  const std::size_t orders = nv == 0 ? none : rates.size() / nv;
  if (orders * nv != rates.size() || (nv > 0 && orders == 0))
    throw std::invalid_argument("rates has " + std::to_string(rates.size()) +
                                " numbers; they come in one or more rows of nv = " + std::to_string(nv));
  check(targets, orders);
  std::ranges::fill(rates, 0.0);
  if (!model.loops().empty()) {
    constexpr std::size_t most = LoopSeries::largest_order + 1;
    if (orders > most)
      throw std::invalid_argument("rates has " + std::to_string(orders) + " rows; with loops " +
                                  std::to_string(most) + " are the most");
    LoopWorkspace<> workspace(model);
    check_closed(workspace.system(model), q, rates.first(nv));
  }
  if (orders == 0) return {};
  RateSystem<Rep> system(model, q, targets, static_cast<int>(orders));
  for (std::size_t k = 0; k < orders; ++k) {
    system.run(rates, static_cast<int>(k));
    const Eigen::VectorXd b = system.wanted - system.known;
    Eigen::VectorXd x(model.nv());
    if (x.size() > 0) x = least_squares(system.matrix, b, rounding);
    const Eigen::VectorXd rest = b - system.matrix * x;
    const double size = stable_norm(as_span(system.wanted)) + stable_norm(as_span(system.known)) +
                        system.matrix.norm() * stable_norm(as_span(x));
    const double left = stable_norm(as_span(rest));
    if (!is_within(left, reachable * size)) {
      std::ranges::fill(rates.subspan(k * nv), std::numeric_limits<double>::quiet_NaN());
      return {static_cast<int>(k), left / size};
    }
    std::ranges::copy(x, rates.begin() + static_cast<std::ptrdiff_t>(k * nv));
  }
  return {static_cast<int>(orders), 0};
}

#define AXODE_RATES(Rep)                                                             \
  template RatesReached inverse_kinematics_rates<Rep>(const Model&, Numbers<double>, \
                                                      std::span<const TwistTarget<Rep>>, std::span<double>)
AXODE_RATES(BodyFixed);
AXODE_RATES(Spatial);
AXODE_RATES(Hybrid);
AXODE_RATES(Mixed);
#undef AXODE_RATES

}  // namespace axode
