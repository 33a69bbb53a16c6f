#include "axode/integration/prescribed/kinematic_motion.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <stdexcept>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/prescribed/singularity.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"

namespace axode {
namespace {

using Eigen::VectorXd;
using Rows = LoopSystem<double>::RowByRow;

/// Newton's method has converged if a step is at most this, rad or m.
constexpr double converged = 1e-13;
constexpr int most_iterations = 12;
/// The longest displacement of a joint in one step, rad or m.
constexpr double longest = 0.5;
/// The largest correction by Newton's method relative to the predicted displacement, to keep to a branch.
constexpr double most_corrected = 0.2;
/// The shortest step in time, relative to the whole time.
constexpr double shortest = 1e-11;

/// The state of the mechanism at one time, with accelerations and jerks.
struct Instant {
  double t = 0;
  VectorXd q, v, a, jerk;
};

class KinematicSolver {
 public:
  KinematicSolver(const Model& model, std::span<const PrescribedMotion> motions)
      : motions_(model, motions),
        model_(motions_.model()),
        system_(model_),
        group_(model_.tree<double>()),
        r_(model_.loops().residuals),
        rows_(model_.loops().rows),
        forces_(model_.nv()) {}

  /// Moves q by Newton's method to a configuration that closes the loops and follows the prescribed motions
  /// at time t. Returns false if the method does not converge or q moves too far: the largest entries of the
  /// displacements of all iterations may add up to at most `reach` (rad or m).
  bool close(double t, double reach, VectorXd& q) {
    motions_.impose(t, system_);
    const VectorXd before = q;
    Rows R(r_.size(), model_.nv());
    double moved = 0;
    for (int n = 0; n < most_iterations; ++n) {
      system_.update_kinematics(q.data());
      system_.residual(q.data(), r_.data());
      system_.make_rows(ConstraintLevel::position);
      system_.write(R.data());
      const VectorXd step = -R.completeOrthogonalDecomposition().solve(r_);
      if (!step.allFinite()) return false;
      group_.move(q, step, q);
      moved += step.lpNorm<Eigen::Infinity>();
      if (moved > reach) return false;
      if (step.lpNorm<Eigen::Infinity>() <= converged) return r_.norm() <= closed_enough;
    }
    return false;
  }

  /// Computes velocities, accelerations and jerks at a closed q that follows the prescribed motions (D12.5).
  void differentiate(Instant& at) {
    const Eigen::Index nv = model_.nv();
    VectorXd s_1 = VectorXd::Zero(rows_.size()), s_3 = s_1;
    motions_.impose(at.t, system_);
    for (const MotionRows::Row& row : motions_.rows()) {
      const MotionValue value = row.function(at.t);
      s_1[row.place.row] = value.ds;
      s_3[row.place.row] = value.ddds;
    }
    at.v.setZero(nv);
    at.a.setZero(nv);
    Rows A(rows_.size(), nv);
    system_.force(at.q.data(), at.v.data(), at.a.data(), {}, forces_.data());
    system_.make_rows(ConstraintLevel::velocity);
    system_.write(A.data());
    const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factor(A);
    at.v = factor.solve(s_1);
    system_.move(at.q.data(), at.v.data(), {}, forces_.data());
    system_.bias(rows_.data());
    at.a = -factor.solve(rows_);
    system_.force(at.q.data(), at.v.data(), at.a.data(), {}, forces_.data());
    system_.make_rows(ConstraintLevel::velocity);
    Rows by_q = Rows::Zero(rows_.size(), nv), by_v = by_q, unused = Rows::Zero(nv, nv);
    const VectorXd lambda = VectorXd::Zero(rows_.size());
    system_.differentiate(lambda.data(), by_q.data(), by_v.data(), unused.data());
    at.jerk = factor.solve(s_3 - by_q * at.v - by_v * at.a);
    freedom_ = nv - factor.rank();
  }
  /// The number of independent velocities that the loops and the prescribed motions leave undetermined, at
  /// the last configuration for which differentiate() computed velocities and accelerations.
  Eigen::Index freedom() const { return freedom_; }

  /// Advances the state `at` to a later time t, in as many steps as needed. `whole` (s) is the duration of
  /// the whole motion; a step that fails is halved, but not to less than a small part of this duration.
  /// `monitor`, a function of the caller, is called before every step. Returns false if the monitor does so
  /// or if t cannot be reached; `at` is then the last state that was reached.
  bool go(double t, double whole, const std::function<bool()>& monitor, Instant& at) {
    double h = t - at.t;
    while (at.t < t) {
      if (monitor && !monitor()) return false;
      h = std::min(h, t - at.t);
      const bool last = h >= t - at.t;
      Instant next{last ? t : at.t + h, at.q, {}, {}, {}};
      const double tau = next.t - at.t;
      const VectorXd x = tau * (at.v + tau / 2 * (at.a + tau / 3 * at.jerk));
      const double length = x.lpNorm<Eigen::Infinity>();
      bool good = length <= longest;
      if (good) {
        group_.move(at.q, x, next.q);
        good = close(next.t, most_corrected * length + 1e-6, next.q);
      }
      if (good) {
        differentiate(next);
        at = std::move(next);
        h *= 2;
      } else {
        h /= 2;
        if (h < shortest * whole || at.t + h <= at.t) return false;
      }
    }
    return true;
  }

  std::string singularity(const Instant& at) {
    return nearby_singularity(motions_, system_, as_span(at.q), at.t);
  }
  const MotionRows& motions() const { return motions_; }

 private:
  MotionRows motions_;
  const Model& model_;
  LoopSystem<double> system_;
  ConfigurationGroup<double> group_;
  VectorXd r_, rows_, forces_;
  Eigen::Index freedom_ = 0;
};

void append(const Instant& at, KinematicMotion& motion) {
  motion.t.push_back(at.t);
  for (const auto& [all, x] :
       {std::pair{&motion.q, &at.q}, {&motion.v, &at.v}, {&motion.a, &at.a}, {&motion.jerk, &at.jerk}})
    all->insert(all->end(), x->begin(), x->end());
}

}  // namespace

KinematicMotion kinematic_motion(const Model& model, std::span<const double> q, std::span<const double> times,
                                 std::span<const PrescribedMotion> motions,
                                 const std::function<bool()>& monitor) {
  check_configuration(model, q);
  if (const std::string bad = first_not_finite(model, q, {}); !bad.empty())
    throw std::invalid_argument("kinematic motion: " + bad + "; it must be finite");
  if (!finite(times)) throw std::invalid_argument("kinematic motion: a time is not finite");
  if (times.empty() || std::ranges::adjacent_find(times, std::ranges::greater_equal()) != times.end())
    throw std::invalid_argument("kinematic motion: times are empty or do not increase");
  KinematicSolver solver(model, motions);
  solver.motions().check_times(times.front(), times.back());
  Instant at{times.front(), as_eigen(q), {}, {}, {}};
  if (!solver.close(at.t, longest, at.q))
    throw std::invalid_argument(
        "kinematic motion: q is not near a configuration that closes the loops and follows the motions "
        "at t = " +
        to_text(at.t) + " s; assemble() finds one, in a shell --assemble");
  solver.differentiate(at);
  if (solver.freedom() > 0)
    throw std::invalid_argument("kinematic motion: the motions leave the mechanism " +
                                std::to_string(solver.freedom()) +
                                (solver.freedom() == 1 ? " velocity" : " velocities") +
                                "; prescribe as many motions as it has, or simulate it with its dynamics");
  KinematicMotion motion;
  append(at, motion);
  for (const double t : times.subspan(1)) {
    bool interrupted = false;
    const std::function<bool()> should_continue = [&] {
      interrupted = monitor && !monitor();
      return !interrupted;
    };
    if (!solver.go(t, times.back() - times.front(), should_continue, at)) {
      motion.complete = false;
      if (interrupted) {
        motion.stop_reason = "it was interrupted";
        break;
      }
      const std::string where = solver.singularity(at);
      motion.stop_reason = "the motions cannot be followed after t = " + to_text(at.t) + " s" +
                           (where.empty() ? "" : ": the mechanism is " + where);
      if (at.t > motion.t.back()) append(at, motion);
      break;
    }
    append(at, motion);
  }
  motion.reached = at.t;
  return motion;
}

}  // namespace axode
