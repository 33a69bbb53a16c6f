#include "axode/integration/schemes/anderson_iteration.hpp"

#include <cmath>

#include "axode/recursion/least_squares.hpp"

namespace axode {

bool AndersonIteration::read(double size, std::initializer_list<Part> parts) {
  constexpr double ill_conditioned = 1e-7;
  constexpr int patience = 4;
  Eigen::Index n = 0;
  for (const Part& part : parts) n += part.x.size();
  x_.resize(n);
  dx_.resize(n);
  Eigen::Index at = 0;
  for (const Part& part : parts) {
    x_.segment(at, part.x.size()) = part.x;
    dx_.segment(at, part.x.size()) = part.dx;
    at += part.x.size();
  }
  change_ = norm_->of_velocities(dx_.head(parts.begin()->x.size()));
  if (!std::isfinite(change_)) return false;
  if (change_ < best_) {
    best_ = change_;
    closest_ = x_ + dx_;
  }
  if (change_ < 0.5 * halved_) {
    halved_ = change_;
    since_ = 0;
  }
  return ++since_ > patience && best_ < ill_conditioned * size;
}

AndersonIteration::Status AndersonIteration::advance(double size, std::initializer_list<Part> parts,
                                                     bool is_rounding) {
  constexpr double rounding = 2e-14, noisy = 1e-10;
  constexpr int most = 60;
  if (!std::isfinite(change_)) return Status::diverged;
  const bool converged = change_ <= rounding * size || is_rounding;
  Vector next;
  if (converged)
    next = closest_;
  else if (change_ > noisy * size)
    next = mixed(parts.begin()->x.size());
  else
    next = x_ + dx_;
  Eigen::Index at = 0;
  for (const Part& part : parts) {
    Eigen::Ref<Vector>(part.x) = next.segment(at, part.x.size());
    at += part.x.size();
  }
  if (converged) return Status::converged;
  x_before_.swap(x_);
  dx_before_.swap(dx_);
  return ++steps_ == most ? Status::diverged : Status::iterating;
}

AndersonIteration::Vector AndersonIteration::mixed(Eigen::Index n) {
  Vector next = x_ + dx_;
  if (steps_ == 0) return next;
  constexpr Eigen::Index depth = 5;
  const Eigen::Index column = filled_ < depth ? filled_++ : oldest_++ % depth;
  changes_.conservativeResize(n, depth);
  moves_.conservativeResize(x_.size(), depth);
  const auto weighted = norm_->weights().asDiagonal();
  changes_.col(column) = weighted * (dx_ - dx_before_).head(n);
  moves_.col(column) = next - x_before_ - dx_before_;
  next -= moves_.leftCols(filled_) * least_squares(changes_.leftCols(filled_), weighted * dx_.head(n), 1e-8);
  return next;
}

}  // namespace axode
