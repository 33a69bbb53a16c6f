#include "axode/kinematics/inverse_kinematics.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <array>
#include <cmath>
#include <limits>

#include "axode/kinematics/check_arguments.hpp"
#include "axode/kinematics/path.hpp"

namespace axode {

std::string_view to_string(InverseKinematicsStatus status) {
  switch (status) {
    case InverseKinematicsStatus::solved: return "solved";
    case InverseKinematicsStatus::stalled: return "stalled";
    case InverseKinematicsStatus::iteration_limit: return "iteration_limit";
  }
  return "unknown";
}

namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Levenberg-Marquardt iterations from one start after the other, on memory of their own.
class Solver {
 public:
  Solver(const Model& model, std::span<const PoseTarget> targets, const InverseKinematicsOptions& options)
      : model_(model), tree_(model.tree<double>()), targets_(targets), options_(options), limit_(limits(model)),
        e_(6 * targets.size()), e_try_(6 * targets.size()), J_(6 * targets.size(), model.nv()),
        H_(model.nv(), model.nv()), damped_(model.nv(), model.nv()), g_(model.nv()), dv_(model.nv()) {}

  /// Improves q until it is solved, stalls, or uses up its iterations.
  InverseKinematicsStatus run(std::vector<double>& q, double& residual, int& iterations) {
    double damping = 1e-3;
    residual = error(q, e_);
    for (int k = 0; k < options_.iterations; ++k) {
      if (residual <= options_.tolerance) return InverseKinematicsStatus::solved;
      ++iterations;
      linearise(q);
      const double before = residual;
      for (int attempt = 0; attempt < 10 && !(residual < before); ++attempt) {
        std::vector<double> q_try = moved(q, step(damping));
        const double next = error(q_try, e_try_);
        if (next < before) {
          damping = std::max(next < 0.25 * before ? 0.02 * damping : 0.5 * damping, 1e-14);
          q = std::move(q_try);
          e_.swap(e_try_);
          residual = next;
        } else {
          damping = std::max(10 * damping, 1e-8);
        }
      }
      if (residual > before * (1 - 1e-3) && residual > options_.tolerance) return InverseKinematicsStatus::stalled;
    }
    return residual <= options_.tolerance ? InverseKinematicsStatus::solved
                                          : InverseKinematicsStatus::iteration_limit;
  }

  /// From a solution, moves within the null space of the targets, (I - J⁺J)(posture ⊖ q), and back onto the targets, as
  /// long as that comes nearer to the posture.
  void approach_posture(std::vector<double>& q, double& residual, int& iterations) {
    double gain = 1, distance = way_to_posture(q).norm();
    for (int k = 0; k < options_.iterations && gain > 1e-3; ++k) {
      error(q, e_);
      linearise(q);
      const Vector way = gain * way_to_posture(q);
      const Eigen::CompleteOrthogonalDecomposition<Matrix> J(J_);
      std::vector<double> q_try = moved(q, way - J.solve(J_ * way));
      double residual_try = 0;
      const bool solved = run(q_try, residual_try, iterations) == InverseKinematicsStatus::solved;
      const double distance_try = solved ? way_to_posture(q_try).norm() : distance;
      if (distance_try < distance * (1 - 1e-6)) {
        q = std::move(q_try);
        residual = residual_try, distance = distance_try;
      } else {
        gain *= 0.5;
      }
    }
  }

 private:
  SE3<> pose(const std::vector<double>& q, const Place<>& place) const {
    return each_body_fixed_column(tree_, q.data(), place, [](int, int, const Screw<>&) {});
  }
  static void store(const PoseTarget& target, const Screw<>& X, double* out) {
    const double a = target.angular_weight, l = target.linear_weight;
    out[0] = a * X.w.x, out[1] = a * X.w.y, out[2] = a * X.w.z;
    out[3] = l * X.v.x, out[4] = l * X.v.y, out[5] = l * X.v.z;
  }
  double error(const std::vector<double>& q, Vector& e) const {
    for (std::size_t t = 0; t < targets_.size(); ++t)
      store(targets_[t], log(inverse(pose(q, targets_[t].place)) * targets_[t].pose), e.data() + 6 * t);
    return e.norm();
  }

  /// J = -∂e/∂q, g = Jᵀe and H = JᵀJ, without the joints that push against a limit.
  void linearise(const std::vector<double>& q) {
    J_.setZero();
    for (std::size_t t = 0; t < targets_.size(); ++t) {
      const PoseTarget& target = targets_[t];
      const Screw<> X = log(inverse(pose(q, target.place)) * target.pose);
      each_body_fixed_column(tree_, q.data(), target.place, [&](int, int c, const Screw<>& column) {
        std::array<double, 6> x;
        store(target, dexp_inv(X, column), x.data());
        J_.block<6, 1>(6 * static_cast<Eigen::Index>(t), c) += Eigen::Map<const Eigen::Matrix<double, 6, 1>>(x.data());
      });
    }
    g_.noalias() = J_.transpose() * e_;
    for (int i = 1; options_.limits && i <= tree_.n; ++i) {
      const Joint& joint = model_.joint(i);
      if (joint.nq != 1) continue;
      const double x = q[joint.iq], push = g_[joint.iv];
      if ((x >= limit_.upper[joint.iq] && push > 0) || (x <= limit_.lower[joint.iq] && push < 0)) {
        J_.col(joint.iv).setZero();
        g_[joint.iv] = 0;
      }
    }
    H_.noalias() = J_.transpose() * J_;
  }
  const Vector& step(double damping) {
    damped_ = H_;
    damped_.diagonal().array() += damping * (H_.diagonal().maxCoeff() + 1e-300);
    solver_.compute(damped_);
    return step_ = solver_.solve(g_);
  }
  std::vector<double> moved(const std::vector<double>& q, const Vector& step) {
    Vector::Map(dv_.data(), model_.nv()) = step;
    std::vector<double> next = integrate(model_, q, dv_);
    return options_.limits ? clamp(model_, next) : next;
  }
  Vector way_to_posture(const std::vector<double>& q) const {
    const std::vector<double> way = difference(model_, q, options_.posture);
    return Vector::Map(way.data(), model_.nv());
  }

  const Model& model_;
  const Tree<double>& tree_;
  std::span<const PoseTarget> targets_;
  const InverseKinematicsOptions& options_;
  CoordinateLimits limit_;
  Vector e_, e_try_;
  Matrix J_, H_, damped_;
  Vector g_, step_;
  std::vector<double> dv_;
  Eigen::LDLT<Matrix> solver_;
};

void check(const Model& model, std::span<const PoseTarget> targets, const InverseKinematicsOptions& options) {
  const auto need = [](bool good, const std::string& what) {
    if (!good) throw std::invalid_argument("inverse_kinematics: " + what);
  };
  need(!targets.empty(), "targets is empty; name at least one pose to reach");
  for (const PoseTarget& target : targets) {
    check_place(model, target.place.frame);
    need(target.angular_weight >= 0 && target.linear_weight >= 0, "a weight is negative");
    const Vec3<>& r = target.pose.r;
    need(std::isfinite(r.x + r.y + r.z), "a target position is not finite");
    const SO3<> G = transpose(target.pose.R) * target.pose.R;
    const double off = std::abs(G.x.x - 1) + std::abs(G.y.y - 1) + std::abs(G.z.z - 1) + std::abs(G.x.y) +
                       std::abs(G.x.z) + std::abs(G.y.z);
    need(off <= 6e-6 && dot(cross(target.pose.R.x, target.pose.R.y), target.pose.R.z) > 0,
         "a target rotation is off a rotation by " + to_text(off) + "; RᵀR must be the identity to 1e-6");
  }
  need(options.tolerance > 0, "tolerance is " + to_text(options.tolerance) + "; it must be positive");
  need(options.iterations > 0, "iterations is " + std::to_string(options.iterations) + "; it must be positive");
  need(options.restarts >= 0, "restarts is " + std::to_string(options.restarts) + "; it must not be negative");
  if (!options.posture.empty()) check_configuration(model, options.posture, "posture");
}

}  // namespace

InverseKinematicsResult inverse_kinematics(const Model& model, std::span<const PoseTarget> targets,
                                           std::span<const double> q0, const InverseKinematicsOptions& options) {
  check_configuration(model, q0, "q0");
  check(model, targets, options);
  Solver solver(model, targets, options);
  InverseKinematicsResult best{.status = InverseKinematicsStatus::stalled,
                               .q = {q0.begin(), q0.end()},
                               .residual = std::numeric_limits<double>::infinity()};
  for (int start = 0; start <= options.restarts; ++start) {
    std::vector<double> q = start == 0 ? std::vector<double>(q0.begin(), q0.end())
                                       : random_configuration(model, options.seed + static_cast<std::uint64_t>(start));
    if (start == 0 && options.limits) q = clamp(model, q);
    double residual = 0;
    const InverseKinematicsStatus status = solver.run(q, residual, best.iterations);
    if (residual < best.residual) best.q = std::move(q), best.residual = residual;
    best.restarts = start;
    if (status == InverseKinematicsStatus::iteration_limit || status == InverseKinematicsStatus::solved)
      best.status = status;
    if (status == InverseKinematicsStatus::solved) break;
  }
  if (best.status == InverseKinematicsStatus::solved && !options.posture.empty())
    solver.approach_posture(best.q, best.residual, best.iterations);
  return best;
}

}  // namespace axode
