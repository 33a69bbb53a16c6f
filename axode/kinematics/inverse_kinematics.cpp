#include "axode/kinematics/inverse_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/kinematics/check_arguments.hpp"
#include "axode/kinematics/path.hpp"
#include "axode/recursion/decompositions.hpp"
#include "axode/recursion/least_squares.hpp"
#include "axode/table/check_counts.hpp"

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

Eigen::Matrix<double, 6, 1> vector(const Screw<>& X) { return {X.w.x, X.w.y, X.w.z, X.v.x, X.v.y, X.v.z}; }
Eigen::Matrix<double, 6, 1> weighted(const PoseTarget& target, const Screw<>& X) {
  return vector({target.angular_weight * X.w, target.linear_weight * X.v});
}

/// A configuration q, its errors with respect to the target poses, and the body-fixed Jacobians of the frames
/// on bodies that have these targets.
struct Iterate {
  std::vector<double> q;
  std::vector<Screw<>> X;  ///< log(C⁻¹ C_target) of each target
  Vector e;                ///< X scaled by the weights
  Matrix J;                ///< six rows for each target
  double residual = 0;     ///< ‖e‖

  Iterate(const Model& model, std::size_t targets)
      : q(model.nq()), X(targets), e(6 * targets), J(6 * targets, model.nv()) {}
};

/// Runs Levenberg-Marquardt iterations from one start after the other, in memory that it owns.
class Solver {
 public:
  Solver(const Model& model, std::span<const PoseTarget> targets, const InverseKinematicsOptions& options)
      : model_(model),
        tree_(model.tree<double>()),
        targets_(targets),
        options_(options),
        limit_(limits(model)),
        at_(model, targets.size()),
        next_(model, targets.size()),
        J_(6 * targets.size(), model.nv()),
        H_(model.nv(), model.nv()),
        damped_(model.nv(), model.nv()),
        g_(model.nv()),
        step_(model.nv()) {}

  /// Iterates from the start q. Ends if the error is within the tolerance (solved), if an iteration hardly
  /// reduces it (stalled), or at the largest number of iterations. Adds the number of iterations to
  /// `iterations`.
  InverseKinematicsStatus run(std::span<const double> q, int& iterations) {
    std::ranges::copy(q, at_.q.begin());
    evaluate(at_);
    double damping = 1e-3;
    for (int k = 0; k < options_.iterations && at_.residual > options_.tolerance; ++k) {
      ++iterations;
      linearise();
      g_.noalias() = J_.transpose() * at_.e;
      stop_at_limits(g_, g_);
      H_.noalias() = J_.transpose() * J_;
      const double before = at_.residual;
      for (int attempt = 0; attempt < 10 && !(at_.residual < before); ++attempt) {
        damped_ = H_;
        damped_.diagonal().array() += damping * (H_.trace() + 1e-300);
        solver_.compute(damped_);
        solver_.solve(g_, step_);
        move(at_.q, step_, next_.q);
        evaluate(next_);
        if (next_.residual < before) {
          damping = std::max(next_.residual < 0.25 * before ? 0.02 * damping : 0.5 * damping, 1e-14);
          std::swap(at_, next_);
        } else {
          damping = std::max(10 * damping, 1e-8);
        }
      }
      if (at_.residual > before * (1 - 1e-3) && at_.residual > options_.tolerance)
        return InverseKinematicsStatus::stalled;
    }
    return at_.residual <= options_.tolerance ? InverseKinematicsStatus::solved
                                              : InverseKinematicsStatus::iteration_limit;
  }
  /// The iterate at which the last run() ended.
  const Iterate& end() const { return at_; }

  /// Moves a solution q towards the configuration `posture` in the null space of the target Jacobian J, by (I
  /// - J⁺J)(posture ⊖ q), and corrects q to the targets, as long as this decreases the distance from
  /// `posture`.
  void approach_posture(std::vector<double>& q, double& residual, int& iterations) {
    std::vector<double> q_try(q.size());
    double gain = 1, distance = way_to_posture(q).norm();
    for (int k = 0; k < options_.iterations && gain > 1e-3; ++k) {
      std::ranges::copy(q, at_.q.begin());
      evaluate(at_);
      linearise();
      const double rounding =
          Eigen::NumTraits<double>::epsilon() * static_cast<double>(std::min(J_.rows(), J_.cols()));
      Vector way = gain * way_to_posture(q);
      do step_ = way - least_squares(J_, J_ * way, rounding);
      while (stop_at_limits(step_, way));
      move(q, step_, q_try);
      const bool solved = run(q_try, iterations) == InverseKinematicsStatus::solved;
      const double distance_try = solved ? way_to_posture(at_.q).norm() : distance;
      if (distance_try < distance * (1 - 1e-6)) {
        q = at_.q;
        residual = at_.residual;
        distance = distance_try;
      } else {
        gain *= 0.5;
      }
    }
  }

 private:
  /// Computes the pose errors and Jacobians of all targets at an iterate.
  void evaluate(Iterate& at) const {
    at.J.setZero();
    for (std::size_t t = 0; t < targets_.size(); ++t) {
      const PoseTarget& target = targets_[t];
      const auto row = 6 * static_cast<Eigen::Index>(t);
      const SE3<> C = each_body_fixed_column(
          tree_, at.q.data(), target.place,
          [&](int, int c, const Screw<>& column) { at.J.block<6, 1>(row, c) += vector(column); });
      // If the orientation is free, the error is the vector between the origins.
      const SE3<> goal = target.angular_weight > 0 ? target.pose : SE3<>{C.R, target.pose.r};
      at.X[t] = log(inverse(C) * goal);
      at.e.segment<6>(row) = weighted(target, at.X[t]);
    }
    at.residual = at.e.norm();
  }

  /// Computes J = -∂e/∂q, the negative derivative of the weighted errors e of all targets.
  void linearise() {
    for (std::size_t t = 0; t < targets_.size(); ++t) {
      const Screw<>& X = at_.X[t];
      const ScrewOperator<double> dexp_inv_X = dexp_inv_operator(dot(X.w, X.w));
      for (Eigen::Index c = 0; c < J_.cols(); ++c) {
        const auto column = at_.J.block<6, 1>(6 * static_cast<Eigen::Index>(t), c);
        const Screw<> Z{{column[0], column[1], column[2]}, {column[3], column[4], column[5]}};
        J_.block<6, 1>(6 * static_cast<Eigen::Index>(t), c) = weighted(targets_[t], apply(dexp_inv_X, X, Z));
      }
    }
  }
  /// Holds the joints that are at a position limit and that a displacement along `gradient` (nv numbers)
  /// would move beyond this limit. Their columns of the Jacobian become 0, and so do their entries of
  /// `gradient` and `direction`. Either both are the same vector, the negative gradient of half the squared
  /// error, or `direction` is a wanted displacement and `gradient` its projection onto the null space of the
  /// Jacobian. Returns whether it has held a joint.
  bool stop_at_limits(Vector& gradient, Vector& direction) {
    if (!options_.limits) return false;
    bool held = false;
    for (int i = 1; i <= tree_->n; ++i) {
      const Joint& joint = model_.joint(i);
      if (joint.nq != 1) continue;
      const double x = at_.q[joint.iq], speed = gradient[joint.iv];
      if ((x >= limit_.upper[joint.iq] && speed > 0) || (x <= limit_.lower[joint.iq] && speed < 0)) {
        J_.col(joint.iv).setZero();
        gradient[joint.iv] = direction[joint.iv] = 0;
        held = true;
      }
    }
    return held;
  }
  /// Writes q ⊕ dv to `out`. Coordinates beyond a position limit are set to this limit.
  void move(const std::vector<double>& q, const Vector& dv, std::vector<double>& out) const {
    for (int i = 1; i <= tree_->n; ++i)
      if (!tree_->coupled[i])
        with_joint(tree_, i, [&](const auto& joint) {
          joint.integrate(&q[tree_->iq[i]], &dv[tree_->iv[i]], &out[tree_->iq[i]]);
        });
    if (!options_.limits) return;
    for (std::size_t k = 0; k < out.size(); ++k)
      out[k] = std::clamp(out[k], limit_.lower[k], limit_.upper[k]);
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
  Iterate at_, next_;
  Matrix J_, H_, damped_;
  Vector g_, step_;
  LdltFactor solver_;
};

void check(const Model& model, std::span<const PoseTarget> targets, std::span<const double> q0,
           const InverseKinematicsOptions& options) {
  const auto need = [](bool good, const std::string& what) {
    if (!good) throw std::invalid_argument("inverse_kinematics: " + what);
  };
  const auto finite = [](double x) { return std::isfinite(x); };
  catalog::check_counts<"inverse_kinematics">(model);
  check_configuration(model, q0, "q0");
  need(std::ranges::all_of(q0, finite), "q0 is not finite");
  need(!targets.empty(), "targets is empty; name at least one pose to reach");
  for (const PoseTarget& target : targets) {
    static_cast<void>(found(model, target.place));
    for (const double weight : {target.angular_weight, target.linear_weight})
      need(std::isfinite(weight) && weight >= 0,
           "a weight is " + to_text(weight) + "; it must not be negative");
    const Vec3<>& r = target.pose.r;
    need(std::isfinite(r.x + r.y + r.z), "a target position is not finite");
    const SO3<> G = transpose(target.pose.R) * target.pose.R;
    const double off = std::abs(G.x.x - 1) + std::abs(G.y.y - 1) + std::abs(G.z.z - 1) + std::abs(G.x.y) +
                       std::abs(G.x.z) + std::abs(G.y.z);
    need(off <= 6e-6 && dot(cross(target.pose.R.x, target.pose.R.y), target.pose.R.z) > 0,
         "a target rotation is off a rotation by " + to_text(off) + "; RᵀR must be the identity to 1e-6");
  }
  need(options.tolerance > 0, "tolerance is " + to_text(options.tolerance) + "; it must be positive");
  need(options.iterations > 0,
       "iterations is " + std::to_string(options.iterations) + "; it must be positive");
  need(options.restarts >= 0,
       "restarts is " + std::to_string(options.restarts) + "; it must not be negative");
  if (!options.posture.empty()) check_configuration(model, options.posture, "posture");
  need(std::ranges::all_of(options.posture, finite), "posture is not finite");
}

}  // namespace

InverseKinematicsResult inverse_kinematics(const Model& model, std::span<const PoseTarget> targets,
                                           std::span<const double> q0,
                                           const InverseKinematicsOptions& options) {
  check(model, targets, q0, options);
  std::vector<PoseTarget> found_targets(targets.begin(), targets.end());
  for (PoseTarget& target : found_targets) target.place = found(model, target.place);
  Solver solver(model, found_targets, options);
  InverseKinematicsResult best{.status = InverseKinematicsStatus::stalled,
                               .q = {q0.begin(), q0.end()},
                               .residual = std::numeric_limits<double>::infinity()};
  for (int start = 0; start <= options.restarts; ++start) {
    if (options.monitor && !options.monitor()) {
      best.status = InverseKinematicsStatus::iteration_limit;
      break;
    }
    std::vector<double> q =
        start == 0 ? std::vector<double>(q0.begin(), q0.end())
                   : random_configuration(model, options.seed + static_cast<std::uint64_t>(start));
    if (start == 0 && options.limits) q = clamp(model, q);
    const InverseKinematicsStatus status = solver.run(q, best.iterations);
    const Iterate& end = solver.end();
    if (end.residual < best.residual) {
      best.q = end.q;
      best.residual = end.residual;
    }
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
