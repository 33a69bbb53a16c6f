#include "axode/integration/drives.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/dynamics/inverse_dynamics.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/references/number_checks.hpp"
#include "axode/model/configuration.hpp"
#include "axode/recursion/least_squares.hpp"
#include "axode/scalar/text.hpp"

namespace axode {
namespace {

using Span = std::span<const double>;

std::size_t nv_of(const Model& model) { return static_cast<std::size_t>(model.nv()); }

/// Returns one gain for each velocity, from nv gains or one for all. Throws std::invalid_argument for another
/// size, and for a gain that is negative or not finite.
std::vector<double> gains(const Model& model, const char* name, Span given) {
  std::vector<double> all = for_each_velocity(model, name, given);
  for (std::size_t k = 0; k < given.size(); ++k)
    if (!(given[k] >= 0) || !std::isfinite(given[k]))
      throw std::invalid_argument(std::string(name) + "[" + std::to_string(k) + "] is " + to_text(given[k]) +
                                  "; a gain must be finite and not negative");
  return all;
}

}  // namespace

SampledDrive::SampledDrive(const Model& model, Span times, Span tau, bool hold)
    : times_(times.begin(), times.end()), tau_(tau.begin(), tau.end()), hold_(hold) {
  if (times.empty()) throw std::invalid_argument("t is empty; a sampled drive needs at least one time");
  check_size("tau", tau.size(), times.size() * nv_of(model), "nv for each time");
  check_times(times);
  check_finite("tau", tau);
}

void SampledDrive::operator()(double t, Span, Span, std::span<double> tau) const {
  const auto after = std::ranges::upper_bound(times_, t);
  const std::size_t nv = tau.size(), next = static_cast<std::size_t>(after - times_.begin()),
                    last = next == 0 ? 0 : next - 1;
  const Span from = Span(tau_).subspan(last * nv, nv);
  if (next == 0 || next == times_.size() || hold_) {
    std::ranges::copy(from, tau.begin());
    return;
  }
  const double s = (t - times_[last]) / (times_[next] - times_[last]);
  for (std::size_t c = 0; c < nv; ++c) tau[c] = (1 - s) * from[c] + s * tau_[next * nv + c];
}

Reference::Reference(const Model& model, Span q, Span v, Span a)
    : q_(q.begin(), q.end()), v_(v.begin(), v.end()), a_(a.begin(), a.end()) {
  check_configuration(model, q_);
  for (const auto& [name, x] : {std::pair{"v", &v_}, {"a", &a_}}) {
    if (x->empty()) x->resize(nv_of(model));
    check_size(name, x->size(), nv_of(model), "nv");
    check_finite(name, *x);
  }
  check_finite("q", q_);
}

Reference::Reference(const Model& model, Trajectory motion)
    : motion_(std::move(motion)),
      q_(static_cast<std::size_t>(model.nq())),
      v_(nv_of(model)),
      a_(nv_of(model)) {
  const Model& its = motion_->model();
  if (its.nq() != model.nq() || its.nv() != model.nv())
    throw std::invalid_argument("the trajectory has nq = " + std::to_string(its.nq()) + " and nv = " +
                                std::to_string(its.nv()) + "; model \"" + model.name() + "\" has " +
                                std::to_string(model.nq()) + " and " + std::to_string(model.nv()));
  if (motion_->size() == 0)
    throw std::invalid_argument("motion is empty; a reference needs at least one state");
}

void Reference::find(double t) {
  if (!motion_) return;
  const double begin = motion_->t().front(), end = motion_->t().back();
  const double rounding =
      1e-12 * std::max(std::abs(begin), std::abs(end));  // allows for rounding in the times of stages
  motion_->at(std::clamp(t, begin, end), q_, v_, a_);
  if (t < begin - rounding || t > end + rounding) {
    std::ranges::fill(v_, 0.0);
    std::ranges::fill(a_, 0.0);
  }
}

Tracking::Tracking(const Model& model, const Gains& given, Reference reference)
    : model_(model),
      kp_(gains(model, "kp", given.kp)),
      kd_(gains(model, "kd", given.kd)),
      x_(nv_of(model)),
      reference_(std::move(reference)),
      group_(model_.tree<double>()) {
  for (std::size_t c = 0; c < x_.size(); ++c)
    if (!model.loops().driven[c]) kp_[c] = kd_[c] = 0;
}

void Tracking::find(double t, Span q) {
  reference_.find(t);
  group_.difference(q.data(), reference_.q().data(), x_.data());
}

ProportionalDerivative::ProportionalDerivative(const Model& model, const Gains& given, Reference reference,
                                               Drive feedforward, bool clip)
    : Tracking(model, given, std::move(reference)), feedforward_(std::move(feedforward)) {
  if (clip) limit_ = effort_limits(model);
}

void ProportionalDerivative::operator()(double t, Span q, Span v, std::span<double> tau) {
  find(t, q);
  std::ranges::fill(tau, 0.0);
  if (feedforward_) feedforward_(t, q, v, tau);
  for (std::size_t c = 0; c < tau.size(); ++c) tau[c] += kp_[c] * x_[c] + kd_[c] * (reference_.v()[c] - v[c]);
  for (std::size_t c = 0; c < limit_.size(); ++c) tau[c] = std::clamp(tau[c], -limit_[c], limit_[c]);
}

ComputedTorque::ComputedTorque(const Model& model, const Gains& given, Reference reference)
    : Tracking(model, given, std::move(reference)), workspace_(model, cut_tree), springs_(nv_of(model)) {
  if (!model.loops().empty() || std::ranges::count(model.loops().driven, 0) > 0) loops_.emplace(model);
}

void ComputedTorque::operator()(double t, Span q, Span v, std::span<double> tau) {
  find(t, q);
  for (std::size_t c = 0; c < x_.size(); ++c)
    x_[c] = reference_.a()[c] + kd_[c] * (reference_.v()[c] - v[c]) + kp_[c] * x_[c];
  if (!model_.springs().empty()) spring_forces(model_, workspace_, q, v, springs_);
  if (loops_) {
    if (make_possible(q, v))
      static_cast<void>(inverse_dynamics(model_, *loops_, q, v, Span(x_), tau, {}, {}, {}, springs_));
    else
      std::ranges::fill(tau, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  inverse_dynamics(model_, workspace_, q, v, x_, tau);
  if (model_.springs().empty()) return;
  for (std::size_t c = 0; c < tau.size(); ++c) tau[c] -= springs_[c];
}

/// Finds the drive forces u that give the driven velocities the accelerations w of the control law. The
/// accelerations of all joints are a₀ + R u: a₀ without drive forces, and column k of R for a unit force of
/// drive k. With the matrix B that selects the driven velocities, u is the least-squares solution of B R u =
/// B (w - a₀). B R is symmetric and scaled by its diagonal, so that the result depends neither on units nor
/// on the sizes of masses.
bool ComputedTorque::make_possible(Span q, Span v) {
  std::vector<int> drives;
  for (int c = 0; c < model_.nv(); ++c)
    if (model_.loops().driven[static_cast<std::size_t>(c)]) drives.push_back(c);
  Eigen::VectorXd a(model_.nv()), unit = Eigen::VectorXd::Zero(model_.nv());
  if (!forward_dynamics(model_, *loops_, q, v, Span(springs_), as_span(a)).ok()) return false;
  LoopSystem<double>& system = loops_->system(model_);
  static_cast<void>(system.factorize(q.data()));
  const auto d = static_cast<Eigen::Index>(drives.size());
  Eigen::MatrixXd R(model_.nv(), d);
  for (Eigen::Index k = 0; k < d; ++k) {
    const int c = drives[static_cast<std::size_t>(k)];
    unit[c] = 1;
    system.force_response(unit.data(), R.col(k).data());
    unit[c] = 0;
  }
  Eigen::MatrixXd BR = R(drives, Eigen::indexing::all);
  const Eigen::VectorXd scale =
      (BR.diagonal().array() > 0).select(BR.diagonal().array().rsqrt(), Eigen::ArrayXd::Zero(d));
  BR = scale.asDiagonal() * BR * scale.asDiagonal();
  const Eigen::VectorXd w = as_eigen(Span(x_)), missing = scale.cwiseProduct((w - a)(drives));
  if (d > 0) a += R * scale.cwiseProduct(least_squares(BR, missing, 1e-9).col(0));
  std::ranges::copy(a, x_.begin());
  return a.allFinite();
}

}  // namespace axode
