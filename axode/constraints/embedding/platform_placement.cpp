#include "axode/constraints/embedding/platform_placement.hpp"

#include <algorithm>
#include <cmath>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/embedding/task_kernel.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"

namespace axode {
namespace {

constexpr int most_iterations = 60;
constexpr double reached = 1e-10;    ///< largest residual of a limb that counts as reaching the platform, rad
                                     ///< and m
constexpr double most_change = 0.5;  ///< largest change of a joint in an iteration, rad or m

/// The residual of one limb, its Jacobian by the velocities of the limb, and Newton steps to close it.
class LimbClosure {
 public:
  LimbClosure(const LoopTable& table, const TaskKernel::Part& part) : table_(table), part_(part) {
    for (const int k : part.loops) rows_ += path(k).residuals.count;
    matrix_.reserve(static_cast<std::size_t>(rows_), part.velocities.size());
    residual_.resize(static_cast<std::size_t>(rows_));
    reduced_.resize(residual_.size());
    step_.resize(part.velocities.size());
  }

  double last_norm() const { return last_norm_; }

  /// Computes a Newton step that closes the loops of one limb (a chain that carries the platform), from their
  /// residuals r. Returns false, with a zero step, if the norm of the residual is not finite, or if it is at
  /// most `reached` and has not fallen since the last call.
  bool compute_step(const LoopSystem<double>& system, const Eigen::VectorXd& r) {
    const int n = static_cast<int>(part_.velocities.size());
    matrix_.reset(rows_, n);
    int row = 0;
    double square = 0;
    for (const int k : part_.loops) {
      const LoopPath& of = path(k);
      const double* entry = system.entries()[static_cast<std::size_t>(k)].data();
      for (const LoopColumn& column : of.columns) {
        const auto j = std::ranges::find(part_.velocities, column.velocity) - part_.velocities.begin();
        for (int i = 0; i < of.residuals.count; ++i, ++entry)
          if (j < n) matrix_.row(row + i)[j] += *entry;
      }
      for (int i = 0; i < of.residuals.count; ++i, ++row) {
        residual_[static_cast<std::size_t>(row)] = -r[of.residuals.first + i];
        square += r[of.residuals.first + i] * r[of.residuals.first + i];
      }
    }
    const double norm = std::sqrt(square);
    std::ranges::fill(step_, 0.0);
    const bool due = norm > 0 && std::isfinite(norm) && (norm > reached || norm < last_norm_);
    last_norm_ = norm;
    if (!due) return false;
    static_cast<void>(matrix_.run(system.considerable_entry()));
    matrix_.reduce(residual_.data(), reduced_.data());
    matrix_.solve(reduced_.data(), step_.data());
    double largest = 0;
    for (const double x : step_) largest = std::max(largest, std::abs(x));
    if (largest > most_change)
      for (double& x : step_) x *= most_change / largest;
    return true;
  }
  void write_step(std::span<double> dv) const {
    for (std::size_t j = 0; j < step_.size(); ++j)
      dv[static_cast<std::size_t>(part_.velocities[j])] = step_[j];
  }

 private:
  const LoopPath& path(int k) const { return table_.paths[static_cast<std::size_t>(k)]; }
  const LoopTable& table_;
  const TaskKernel::Part& part_;
  int rows_ = 0;
  RowElimination<double> matrix_;
  std::vector<double> residual_, reduced_, step_;
  double last_norm_ = std::numeric_limits<double>::infinity();
};

/// Sets the coordinates of the platform's joint such that its body frame has the pose C.
void set_platform(const Model& model, int platform, const SE3<>& C, std::span<double> q) {
  const Tree<double>& tree = model.tree<double>();
  const SE3<> D = inverse(tree.B[static_cast<std::size_t>(platform)]) *
                  (C * inverse(tree.frame_offset[static_cast<std::size_t>(platform)]));
  double* const own = q.data() + model.joint(platform).iq;
  const std::vector<double> near(own, own + model.joint(platform).nq);
  with_joint(tree, platform, [&](const auto& joint) { joint.coordinates(D, near.data(), own); });
}

/// The larger of the angle (rad) and the distance (m) between the platform's body frame and the pose C.
double distance_from(const TaskKernel& kernel, const SE3<>& C) {
  const SE3<> found = kernel.platform_pose() *
                      kernel.model().tree<double>().frame_offset[static_cast<std::size_t>(kernel.platform)];
  return std::max(norm(log_SO3(transpose(found.R) * C.R)), norm(found.r - C.r));
}

}  // namespace

PlatformPlacement place_platform(TaskSpace& space, const SE3<>& C, std::span<double> q) {
  TaskKernel& kernel = space.kernel();
  const Model& model = space.model();
  check_configuration(model, q);
  kernel.check_platform();
  if (!finite(q) || !finite(C))
    throw std::invalid_argument("q or the pose of \"" + model.body(kernel.platform).name +
                                "\" has a number that is not finite");
  set_platform(model, kernel.platform, C, q);
  LoopSystem<double>& system = kernel.system();
  std::vector<LimbClosure> limbs;
  for (const TaskKernel::Part& part : kernel.parts()) limbs.emplace_back(system.table(), part);
  Eigen::VectorXd r(model.loops().residuals);
  std::vector<double> dv(static_cast<std::size_t>(model.nv()));
  PlatformPlacement out;
  bool moves = true;
  for (; moves && out.iterations < most_iterations; ++out.iterations) {
    system.update_kinematics(q.data());
    system.residual(q.data(), r.data());
    system.make_rows(ConstraintLevel::position);
    moves = false;
    for (LimbClosure& limb : limbs) {
      moves = limb.compute_step(system, r) || moves;
      limb.write_step(dv);
    }
    if (moves) std::ranges::copy(integrate(model, q, dv), q.begin());
  }
  for (std::size_t l = 0; l < limbs.size(); ++l)
    if (out.limb < 0 || !(limbs[l].last_norm() <= out.residual)) {
      out.limb = static_cast<int>(l);
      out.residual = limbs[l].last_norm();
    }
  out.reached = out.residual <= reached;
  if (const double off = distance_from(kernel, C); !(off <= closed_enough))
    out = {.limb = -1, .residual = off, .iterations = out.iterations};
  return out;
}

std::string to_string(const TaskSpace& space, const PlatformPlacement& placement) {
  if (placement.reached) return "the platform has the pose";
  const std::string off = to_text(placement.residual) + " (rad and m)";
  if (placement.limb < 0)
    return "the joint of \"" + space.model().body(space.platform()).name +
           "\" does not have this pose; the nearest one is off by " + off;
  return "the limb " + space.kernel().name_of_limb(placement.limb) +
         " does not reach the pose: it stays open by " + off + "; q may be too far from the pose";
}

}  // namespace axode
