#include <algorithm>
#include <cmath>

#include "axode/contact/law/velocity_solver.hpp"

/// Solves contact problems in which Newton's method fails. Instead of the law between impulses λ and
/// velocities u it is easier to solve the law between λ and u + R λ, with a large R, which makes the contacts
/// compliant. The solutions for all R are a path, which is followed as R falls to small values. See
/// "Following the path" of docs/derivations/contact.md.
namespace axode {
namespace {

constexpr double residual_part = 1e-8;  ///< largest residual of a point of the path, as a fraction of |w|
constexpr double least_length = 1e-9, most_length = 2;
constexpr double sharp =
    0.05;  ///< length of a step times 1 - cos of its turn: beyond, it may change the branch
constexpr int most_steps = 1000;

}  // namespace

/// Evaluates the residual f(x, σ) of the path (D11.10a) at x_ and σ, and returns |f|.
double VelocitySolver::path_residual(double sigma) noexcept {
  const Eigen::Map<const Eigen::VectorXd> d2(problem_->squared_scales().data(), rows_);
  R_ = std::exp(sigma) * d2;
  return velocity_residual(x_, f_);
}

/// For the path of solutions f(x, σ) = 0 of contact problems whose compliance falls with σ (D11.10a), with
/// the square matrix f' = ∂f/∂x: writes the Newton step -f'⁻¹ f at constant σ to dx_, and the unit tangent
/// of the path (D11.10b) to next_.
void VelocitySolver::linearize_path() noexcept {
  factorize_velocities(0);
  u_ = (z_ - lambda_0_).cwiseProduct(R_);
  multiply_blocks(u_);
  Vector& t = next_.x;
  t.setZero();
  problem_->add_product(-1 / size_, u_.data(), t.data());
  sparse_.solve(t.data());
  dx_ = -f_;
  sparse_.solve(dx_.data());
  next_.sigma = (sparse_.is_negative() ? 1 : -1) / std::sqrt(1 + t.squaredNorm());
  t *= next_.sigma;
}

/// Makes a step along the path of solutions of contact problems whose compliance falls (D11.10a): moves from
/// path_point_ by `length` along `direction`, and returns to the path by Newton steps perpendicular to it. If
/// this leads to a point ahead, without a sharp turn of the path, the function moves path_point_ there,
/// writes its tangent to next_ and returns true. `direction` is the tangent at path_point_ or, if
/// `beyond_kink` is set, the tangent after a kink of the path just after path_point_. A point is ahead if the
/// step to it goes forward along `direction` or, if `beyond_kink` is set, along the tangent at the new point.
bool VelocitySolver::step_on_path(const PathVector& direction, double length, bool beyond_kink) noexcept {
  constexpr int most = 8, patience = 3;
  x_ = path_point_.x + length * size_ * direction.x;
  double sigma = path_point_.sigma + length * direction.sigma, before = 0;
  for (int k = 0;; ++k) {
    const double norm = path_residual(sigma);
    if (!std::isfinite(norm) || k == most || (k > patience && norm > 0.9 * before)) return false;
    linearize_path();
    if (k == 0 && !beyond_kink) {
      after_kink_.x = next_.x;
      after_kink_.sigma = next_.sigma;
    }
    path_iterations_ = k;
    if (norm <= residual_part * size_) break;
    before = norm;
    const double along = next_.x.dot(dx_) / size_;
    x_ += dx_ - along * size_ * next_.x;
    sigma -= along * next_.sigma;
  }
  // The step from the last point of the path, in the units of tangents.
  dx_ = (x_ - path_point_.x) / size_;
  const double change = sigma - path_point_.sigma, way = std::hypot(dx_.norm(), change);
  const PathVector& ahead = beyond_kink ? next_ : direction;
  const double forward = ahead.x.dot(dx_) + ahead.sigma * change;
  const double turn = 1 - direction.x.dot(next_.x) - direction.sigma * next_.sigma;
  if (!(way < 2 * length && way > 0.1 * length && forward > 0 && turn * length < sharp)) return false;
  path_point_.x = x_;
  path_point_.sigma = sigma;
  return true;
}

void VelocitySolver::follow_path(double tolerance) {
  constexpr double begin = 100, first_try = 1e-4, last_try = 1e-10, smooth = 0.9;
  if (!(size_ > 0)) return;
  const Vector& center = y_;
  lambda_0_ = center;
  path_point_.sigma = std::log(begin);
  x_ = problem_->w;
  problem_->add_product(1, center.data(), x_.data());
  for (int k = 0; k < 20 && path_residual(path_point_.sigma) > residual_part * size_; ++k) {
    linearize_path();
    x_ += dx_;
  }
  path_point_.x = x_;
  linearize_path();
  tangent_.x = next_.x;
  tangent_.sigma = next_.sigma;
  double length = 0.5, next_try = std::log(first_try);
  for (int k = 0; k < most_steps && length > least_length && searches(); ++k) {
    bool found = step_on_path(tangent_, length, false);
    const double straight = tangent_.x.dot(after_kink_.x) + tangent_.sigma * after_kink_.sigma;
    if (!found && length < 0.3 && straight < smooth) found = step_on_path(after_kink_, length, true);
    if (!found) {
      length *= 0.4;
      continue;
    }
    tangent_.x = next_.x;
    tangent_.sigma = next_.sigma;
    if (path_iterations_ <= 4) length = std::min(most_length, 2 * length);
    if (path_point_.sigma > next_try) continue;
    start_ = resolved_;
    improve(tolerance, {.failures = 0, .mu = std::exp(path_point_.sigma), .patience = 5});
    if (path_point_.sigma < std::log(last_try)) return;
    next_try = std::min(next_try, path_point_.sigma) - std::log(10.0);
    lambda_0_ = center;
  }
}

}  // namespace axode
