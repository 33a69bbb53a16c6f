#include "axode/integration/prescribed/closed_motion.hpp"

#include <algorithm>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/prescribed/singularity.hpp"
#include "axode/constraints/stable_norm.hpp"

namespace axode {
namespace {

constexpr double closed = 1e-13;

}  // namespace

ClosedMotion::ClosedMotion(const Model& model, std::span<const PrescribedMotion> more)
    : motions_(model, more),
      model_(motions_.model()),
      workspace_(model_),
      group_(model_.tree<double>()),
      lambda_(static_cast<std::size_t>(model_.loops().rows)),
      r_(lambda_.size()),
      x_(static_cast<std::size_t>(model.nv())),
      a_(x_) {
  set_time(0);
}

void ClosedMotion::set_time(double t) {
  time_ = t;
  if (!motions_.empty()) motions_.impose(t, workspace_.system(model_));
}

std::string ClosedMotion::unfollowed(Span q, Span v, Span a) {
  LoopSystem<double>& system = workspace_.system(model_);
  const auto is_redundant = [](char redundant) { return redundant != 0; };
  if (motions_.empty() || (system.weakest_row() >= 1 && std::ranges::none_of(rank_.redundant, is_redundant)))
    return {};
  system.force(q.data(), v.data(), a.data(), {}, x_.data());
  system.make_rows(ConstraintLevel::velocity);
  const std::span<const double> rates = system.acceleration_residual(a.data());
  constexpr double tolerance = 1e-6;
  const double speed = stable_norm(v);
  const std::string name =
      motions_.worst(rates, tolerance * (1 + stable_norm(a)) + (tolerance * speed) * speed);
  return name.empty() ? name
                      : "the loops and the other motions do not allow the prescribed motion of \"" + name +
                            "\" at this configuration";
}

void ClosedMotion::check(Span q, Span v) {
  LoopSystem<double>& system = workspace_.system(model_);
  check_closed(system, q, v);
  static_cast<void>(system.determine_rank(q.data(), rank_));
}

Solvability ClosedMotion::accelerate(Span q, Span v, Span tau, const Loads<double>& loads,
                                     std::span<double> a) {
  return workspace_.system(model_).accelerate(q.data(), v.data(), tau.data(), loads, a.data(), lambda_.data(),
                                              rank_);
}

std::string ClosedMotion::singularity(Span q, double t) {
  return nearby_singularity(motions_, workspace_.system(model_), q, t);
}

double ClosedMotion::weakest_row() { return workspace_.system(model_).weakest_row(); }

void ClosedMotion::factorize(Span q) {
  static_cast<void>(workspace_.system(model_).factorize(q.data(), rank_));
}

double ClosedMotion::unit_force_response(int c, std::span<double> a) {
  LoopSystem<double>& system = workspace_.system(model_);
  std::ranges::fill(a, 0.0);
  a[static_cast<std::size_t>(c)] = 1;
  system.solve(a.data());
  const double alone = a[static_cast<std::size_t>(c)];
  motions_.release(system);
  static_cast<void>(system.impact(a.data(), 0, a.data(), lambda_.data(), rank_));
  set_time(time_);
  return alone;
}

void ClosedMotion::differentiate(Span q, Span v, Span tau, const Loads<double>& loads,
                                 const ClosedDynamicsDerivatives<double>& d) {
  static_cast<void>(forward_dynamics_derivatives(model_, workspace_, q, v, tau, d, loads));
}

void ClosedMotion::determine_rank(Span q) {
  static_cast<void>(workspace_.system(model_).determine_rank(q.data(), rank_));
}

Solvability ClosedMotion::add_constraint_forces(Span q, Span v, Span tau, const Loads<double>& loads,
                                                std::span<double> f) {
  const Solvability found = accelerate(q, v, tau, loads, a_);
  if (!found.ok()) return found;
  LoopSystem<double>& system = workspace_.system(model_);
  system.update_kinematics(q.data());
  system.make_rows(ConstraintLevel::velocity);
  system.add_transposed_times(lambda_.data(), f.data());
  return found;
}

bool ClosedMotion::close_momenta(Span q, std::span<double> p) {
  LoopSystem<double>& system = workspace_.system(model_);
  if (!system.determine_rank(q.data(), rank_).ok()) return false;
  system.make_rows(ConstraintLevel::velocity);
  std::ranges::fill(x_, 0.0);
  system.velocity_residual(x_.data(), r_.data());  // -s'
  system.add_response(p.data(), r_.data());
  system.solve_rows(r_.data(), lambda_.data(), rank_);
  system.add_transposed_times(lambda_.data(), p.data());
  return true;
}

bool ClosedMotion::close(std::span<double> q, std::span<double> v) {
  if (!close_places(q)) return false;
  LoopSystem<double>& system = workspace_.system(model_);
  return system.determine_rank(q.data(), rank_).ok() &&
         system.impact(v.data(), 0, v.data(), lambda_.data(), rank_).ok();
}

double ClosedMotion::multiplier(std::string_view coupling) const {
  const std::vector<LoopCoupling>& all = model_.loops().couplings;
  const auto row = std::ranges::find(all, coupling, &LoopCoupling::name);
  return lambda_[static_cast<std::size_t>(row->first_row)];
}

bool ClosedMotion::bounce(Span q, double restitution, std::span<double> v) {
  LoopSystem<double>& system = workspace_.system(model_);
  return system.determine_rank(q.data(), rank_).ok() &&
         system.impact(v.data(), restitution, v.data(), lambda_.data(), rank_).ok();
}

double ClosedMotion::open(Span q) {
  LoopSystem<double>& system = workspace_.system(model_);
  system.update_kinematics(q.data());
  system.residual(q.data(), r_.data());
  return stable_norm(Span(r_).first(static_cast<std::size_t>(model_.loops().residuals)));
}

bool ClosedMotion::is_closed(Span q) { return open(q) <= closed_enough; }

bool ClosedMotion::close_places(std::span<double> q) {
  LoopSystem<double>& system = workspace_.system(model_);
  double before = open(q);
  for (int n = 0; n < 5 && before > closed; ++n) {
    if (!system.projection_step(q.data(), x_.data(), rank_).ok()) return false;
    group_.move(q.data(), x_.data(), q.data());
    const double now = open(q);
    const bool stalled = !(now < 0.5 * before);  // stopped by rounding, or because the loops cannot be closed
    before = now;
    if (stalled) break;
  }
  return before <= closed_enough;
}

}  // namespace axode
