#include "axode/constraints/embedding/task_space.hpp"

#include <algorithm>
#include <limits>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/embedding/task_kernel.hpp"
#include "axode/eigen.hpp"
#include "axode/model/finite.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

void check_state(TaskKernel& kernel, std::span<const double> q, std::span<const double> v) {
  check_configuration(kernel.model(), q);
  check_size("v", v.size(), static_cast<std::size_t>(kernel.model().nv()), "nv");
}
void check_task(const char* name, std::span<const double> X, const TaskKernel& kernel) {
  check_size(name, X.size(), static_cast<std::size_t>(kernel.freedom()), "freedom()");
}

}  // namespace

TaskVerdict judged(TaskVerdict verdict, std::initializer_list<std::span<double>> results) noexcept {
  for (const std::span<double> x : results)
    if (verdict.ok() && !finite(x)) verdict.kind = TaskVerdict::Kind::not_finite;
  if (!verdict.ok())
    for (const std::span<double> x : results) std::ranges::fill(x, std::numeric_limits<double>::quiet_NaN());
  return verdict;
}

TaskSpace::TaskSpace(const Model& model, std::span<const double> q, std::string_view platform) {
  catalog::check_counts<"TaskSpace">(model);
  if (model.loops().empty())
    throw std::invalid_argument("model: \"" + model.name() +
                                "\" has no loops; a task space is that of a parallel manipulator");
  LoopWorkspace<double> workspace(model);
  LoopSystem<double>& system = checked<double>(model, workspace, q);
  check_closed(system, q, std::vector<double>(static_cast<std::size_t>(model.nv())));
  kernel_ = std::make_unique<TaskKernel>(model, q, platform.empty() ? -1 : model.body_index(platform));
}
TaskSpace::~TaskSpace() = default;
TaskSpace::TaskSpace(TaskSpace&&) noexcept = default;
TaskSpace& TaskSpace::operator=(TaskSpace&&) noexcept = default;

const Model& TaskSpace::model() const { return kernel_->model(); }
int TaskSpace::platform() const { return kernel_->platform; }
int TaskSpace::freedom() const { return kernel_->freedom(); }
const std::vector<std::string>& TaskSpace::names() const { return kernel_->names; }
int TaskSpace::limbs() const { return static_cast<int>(kernel_->parts().size()); }
const std::vector<int>& TaskSpace::limb(int l) const {
  return kernel_->parts().at(static_cast<std::size_t>(l)).velocities;
}

TaskVerdict TaskSpace::velocities(std::span<const double> q, std::span<const double> V, std::span<double> v) {
  TaskKernel& kernel = *kernel_;
  check_state(kernel, q, v);
  check_task("V", V, kernel);
  if (!finite(q) || !finite(V)) return judged({TaskVerdict::Kind::not_finite}, {v});
  kernel.system().update_kinematics(q.data());
  kernel.system().make_rows(ConstraintLevel::velocity);
  const TaskVerdict verdict = kernel.resolve();
  if (verdict.ok()) kernel.expand(V.data(), nullptr, v.data());
  return judged(verdict, {v});
}

TaskVerdict TaskSpace::accelerations(std::span<const double> q, std::span<const double> v,
                                     std::span<const double> dV, std::span<double> a) {
  TaskKernel& kernel = *kernel_;
  check_state(kernel, q, v);
  check_task("dV", dV, kernel);
  check_size("a", a.size(), v.size(), "nv");
  if (!finite(q) || !finite(v) || !finite(dV)) return judged({TaskVerdict::Kind::not_finite}, {a});
  static_cast<void>(kernel.system().force_fast(q.data(), v.data(), kernel.zero.data(), {}));
  const TaskVerdict verdict = kernel.resolve();
  if (verdict.ok())
    kernel.expand(dV.data(), kernel.system().acceleration_residual(kernel.zero.data()).data(), a.data());
  return judged(verdict, {a});
}

TaskVerdict TaskSpace::inverse_dynamics(std::span<const double> q, std::span<const double> v,
                                        std::span<const double> dV, std::span<double> tau,
                                        const Loads<double>& loads) {
  TaskKernel& kernel = *kernel_;
  check_loads(kernel.model(), loads);
  check_size("tau", tau.size(), v.size(), "nv");
  TaskVerdict verdict = accelerations(q, v, dV, as_span(kernel.acceleration));
  if (!verdict.ok()) return judged(verdict, {tau});
  const std::span<double> f = kernel.tree_forces(q, v, kernel.acceleration.data(), loads);
  if (!kernel.drive_forces(f.data(), tau.data())) verdict.kind = TaskVerdict::Kind::drives_singular;
  return judged(verdict, {tau});
}

TaskVerdict TaskSpace::forward_dynamics(std::span<const double> q, std::span<const double> v,
                                        std::span<const double> tau, std::span<double> dV,
                                        std::span<double> a, const Loads<double>& loads) {
  TaskKernel& kernel = *kernel_;
  check_state(kernel, q, v);
  check_task("dV", dV, kernel);
  check_size("tau", tau.size(), v.size(), "nv");
  if (!a.empty()) check_size("a", a.size(), v.size(), "nv");
  check_separate("a", a, "dV", dV);
  check_loads(kernel.model(), loads);
  if (!finite(q) || !finite(v) || !finite(tau)) return judged({TaskVerdict::Kind::not_finite}, {dV, a});
  const std::span<double> w = kernel.system().force_fast(q.data(), v.data(), kernel.zero.data(), loads);
  if (const TaskVerdict verdict = kernel.resolve(); !verdict.ok()) return judged(verdict, {dV, a});
  std::ranges::copy(kernel.system().acceleration_residual(kernel.zero.data()), kernel.bias.begin());
  kernel.expand(kernel.zero.data(), kernel.bias.data(), kernel.acceleration.data());
  kernel.make_F();
  kernel.make_M(q);
  for (std::size_t c = 0; c < w.size(); ++c) w[c] = tau[c] - w[c];
  kernel.subtract_inertia_forces(kernel.acceleration.data(), w.data());
  kernel.project(w.data(), dV.data());
  if (!kernel.solve(dV.data())) return judged({TaskVerdict::Kind::mass_singular}, {dV, a});
  if (!a.empty()) kernel.expand(dV.data(), kernel.bias.data(), a.data());
  return judged({}, {dV, a});
}

TaskEquations TaskSpace::equations(std::span<const double> q, std::span<const double> v,
                                   const Loads<double>& loads) {
  TaskKernel& kernel = *kernel_;
  check_state(kernel, q, v);
  check_loads(kernel.model(), loads);
  TaskEquations out;
  if (!finite(q) || !finite(v)) {
    out.verdict.kind = TaskVerdict::Kind::not_finite;
    return out;
  }
  const Eigen::Index nv = model().nv(), f = freedom();
  const std::span<double> w = kernel.system().force_fast(q.data(), v.data(), kernel.zero.data(), loads);
  out.verdict = kernel.resolve();
  if (!out.verdict.ok()) return out;
  std::ranges::copy(kernel.system().acceleration_residual(kernel.zero.data()), kernel.bias.begin());
  out.c.resize(nv);
  kernel.expand(kernel.zero.data(), kernel.bias.data(), out.c.data());
  kernel.make_F();
  kernel.make_M(q);
  out.M = kernel.M();
  out.h.resize(f);
  for (double& w_c : w) w_c = -w_c;
  kernel.subtract_inertia_forces(out.c.data(), w.data());
  kernel.project(w.data(), out.h.data());
  out.h = -out.h;
  kernel.write_F(out.F);
  out.drives = driven(model(), {});
  out.J = out.F(out.drives, Eigen::indexing::all);
  return out;
}

std::string to_string(const TaskSpace& space, const TaskVerdict& verdict) {
  const bool carried = space.platform() > 0;
  const std::string body = carried ? "the platform" : "the mechanism",
                    more = carried ? "; singularities() of this configuration has more" : "";
  switch (verdict.kind) {
    case TaskVerdict::Kind::solved: break;
    case TaskVerdict::Kind::limb_singular:
      return "type 1: joints of the limb " + space.kernel().name_of_limb(verdict.limb) + " can move while " +
             (carried ? "the platform is at rest" : "the task velocities are 0") + more;
    case TaskVerdict::Kind::drives_singular:
      return "type 2: " + body + " can move while all drives are locked" + more;
    case TaskVerdict::Kind::constraint_singular:
      return "constraint singularity: the limbs leave " + body + " another freedom" + more;
    case TaskVerdict::Kind::mass_singular:
      return "the mass matrix of the task space is singular, because a motion moves no mass";
    case TaskVerdict::Kind::not_finite: return "an argument or a result is not a finite number";
  }
  return "nothing is singular";
}

}  // namespace axode
