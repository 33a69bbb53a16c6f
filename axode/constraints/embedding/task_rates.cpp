#include "axode/constraints/embedding/task_rates.hpp"

#include <algorithm>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/embedding/task_kernel.hpp"
#include "axode/constraints/higher_order/loop_series.hpp"
#include "axode/derivatives/displacement/force_series.hpp"
#include "axode/model/finite.hpp"

namespace axode {

TaskVerdict inverse_dynamics_rates(TaskSpace& space, std::span<const double> q, std::span<const double> rates,
                                   std::span<double> tau, std::span<double> motion,
                                   const Loads<double>& loads) {
  using Vector = Eigen::VectorXd;
  TaskKernel& kernel = space.kernel();
  LoopSystem<double>& system = kernel.system();
  const Model& model = space.model();
  check_configuration(model, q);
  check_loads(model, loads);
  const auto nv = static_cast<std::size_t>(model.nv()), f = static_cast<std::size_t>(space.freedom());
  const std::size_t orders = nv == 0 ? 0 : tau.size() / nv;
  if (orders == 0 || orders * nv != tau.size() || orders > LoopSeries::largest_order)
    throw std::invalid_argument("tau has " + std::to_string(tau.size()) + " numbers; they come in 1 to " +
                                std::to_string(LoopSeries::largest_order) +
                                " rows of nv = " + std::to_string(nv));
  check_size("rates", rates.size(), (orders + 1) * f, "a row of freedom() more than rows of tau");
  if (!motion.empty()) check_size("motion", motion.size(), (orders + 1) * nv, "a row of nv more than tau");
  check_separate("motion", motion, "tau", tau);
  if (!finite(q) || !finite(rates)) return judged({TaskVerdict::Kind::not_finite}, {tau, motion});

  system.update_kinematics(q.data());
  system.make_rows(ConstraintLevel::velocity);
  if (const TaskVerdict verdict = kernel.resolve(); !verdict.ok()) return judged(verdict, {tau, motion});
  std::vector<double> v((orders + 1) * nv), forces(orders * nv);
  LoopSeries loops(model, static_cast<int>(orders));
  for (std::size_t k = 0; k <= orders; ++k) {
    if (k > 0) loops.run(q.data(), v.data());
    const Vector known = loops.known_terms(v.data(), static_cast<int>(k));
    kernel.expand(rates.data() + k * f, known.data(), v.data() + k * nv);
  }
  const int last = static_cast<int>(orders) - 1;
  ForceSeries<double>(model.tree<double>(), last)
      .run(model.tree<double>(), q.data(), v.data(), loads, forces.data());

  std::vector<Vector> lambda;
  for (std::size_t k = 0; k < orders; ++k) {
    Eigen::Map<Vector> Q(forces.data() + k * nv, static_cast<Eigen::Index>(nv));
    double binomial = 1;
    for (std::size_t l = 1; l <= k; ++l) {
      binomial = binomial * static_cast<double>(k - l + 1) / static_cast<double>(l);
      Q -= binomial * (loops.derivative(static_cast<int>(l)).transpose() * lambda[k - l]);
    }
    lambda.emplace_back(model.loops().rows);
    if (!system.drive_forces({}, Q.data(), tau.data() + k * nv, lambda.back().data()))
      return judged({TaskVerdict::Kind::drives_singular}, {tau, motion});
  }
  if (!motion.empty()) std::ranges::copy(v, motion.begin());
  return judged({}, {tau, motion});
}

}  // namespace axode
