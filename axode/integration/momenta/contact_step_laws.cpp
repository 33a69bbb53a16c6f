#include "axode/integration/momenta/contact_step.hpp"
#include "axode/scalar/index.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace axode {
namespace {

/// The relative rounding error of places.
constexpr double resolution = 4 * std::numeric_limits<double>::epsilon();

}  // namespace

/// Linearises the mean forces of compliant contacts over the step in their gaps at its end (D11.26).
void ContactStep::set_compliances(double h) {
  // A softer contact converges as quickly with a compliance of this many times that of the masses.
  constexpr double softest = 1e3;
  VelocityProblem& problem = start_.system.problem();
  for (std::size_t k = 0; k < start_.contacts.size(); ++k) {
    const Contact& contact = start_.contacts[k];
    if (!contact.surface.compliance) continue;
    const VelocityProblem::Block& b = problem.blocks()[k];
    const Contact* same = with_key(found_, contact.key, k);
    const double gap = same ? same->gap : contact.gap + h * slip_[index(b.first)];
    const double slope = h * h / 2 * mean_force(contact.surface.compliance, contact.gap, gap, h).slope;
    const double of_masses = problem.columns(b).col(0).head(b.width - 1).squaredNorm();
    const double most = softest * of_masses;
    problem.set_compliance(b, slope * most > 1 ? 1 / slope : most);
  }
}

bool ContactStep::set_r_of_start(double h, bool choose) {
  ContactSystem& system = start_.system;
  VelocityProblem& problem = system.problem();
  // Velocities of the scaled rows as the linear problem has them.
  start_.x = problem.w;
  problem.add_product(1, start_.lambda.data(), start_.x.data());
  std::vector<double>& u = start_.u_after;
  std::ranges::fill(u, 0.0);
  problem.add_transposed(start_.x.data(), u.data());
  bool changed = false;
  // Slower velocities are rounding errors of those that the impulses stop, or of places.
  constexpr double rounding = 1e-10;
  const double at_rest = rounding * (start_.x - problem.w).norm();
  const auto set = [&](std::size_t row, double velocity, bool less_u = true) {
    problem.r[row] = problem.c[row] * velocity - (less_u ? u[row] : 0);
  };
  const std::size_t n = start_.contacts.size();
  for (std::size_t k = 0; k < n; ++k) {
    const Contact& contact = start_.contacts[k];
    const VelocityProblem::Block& b = problem.blocks()[k];
    const std::size_t row = index(b.first);
    const Contact* same = with_key(found_, contact.key, k);
    const double gap = same ? same->gap : contact.gap + h * slip_[row];
    if (contact.surface.compliance) {
      const double force = mean_force(contact.surface.compliance, contact.gap, gap, h).force;
      const double open = force > 0 ? 0 : std::max(gap, 0.0);
      const double C = problem.compliance(b);  // C λ is part of u
      set(row, open / h + C * (start_.lambda[row] - h / 2 * force));
    } else {
      set(row, (gap - std::min(contact.gap, 0.0)) / h);
    }
    double before = 0, change = 0;
    for (std::size_t i = row + 1; i < row + index(b.rows); ++i) {
      before += std::pow(problem.c[i] * start_.u[i], 2);
      change += std::pow(problem.c[i] * (slip_[i] - start_.u[i]), 2);
    }
    if (choose) {
      const double rest = at_rest * std::sqrt(problem.squared_scales()[row]) +
                          contact.surface.friction * resolution * (norm(contact.point) + size_) / h;
      const char slides = start_.lambda[row] > 0 && before > rest * rest && change < before / 4;
      changed = changed || slides != slides_[k];
      slides_[k] = slides;
    }
    for (std::size_t i = row + 1; i < row + index(b.rows); ++i)
      set(i, slip_[i] + (slides_[k] ? start_.u[i] : 0));
  }
  const auto blocks = problem.blocks();
  for (std::size_t k = 0; k < system.active_stops().size(); ++k) {
    const JointStop& stop = system.stops()[index(system.active_stops()[k])];
    const std::size_t row = index(blocks[n + k].first);
    const double room = stop.side * (run_->q_end[stop.coordinate] - stop.limit);
    set(row, (room - std::min(system.room()[n + k], 0.0)) / h);
  }
  const std::size_t first = index(system.first_loop_row());
  for (std::size_t k = first - system.dry_joints().size(); k < first; ++k)
    set(k, run_->v_middle[system.dry_joints()[k + system.dry_joints().size() - first].velocity]);
  end_.system.loop_openings(run_->q_end.data(), openings_.data());
  for (std::size_t k = first; k < problem.r.size(); ++k)
    if (problem.moves(k)) set(k, openings_[k - first] / h, system.has_residual(k));
  return changed;
}

double ContactStep::law_error() {
  const VelocityProblem& problem = start_.system.problem();
  scratch_.resize(2 * index(problem.rows()) + index(problem.nv()));
  return axode::certificate(problem, start_.lambda.data(), scratch_.data());
}

/// The part of law_error(), the relative error of the laws of contact for the impulses at the start of the
/// step, that rounding errors of positions may cause. The velocities in these laws are differences of gaps
/// divided by the length h of the step, so that rounding errors of positions enter them divided by h.
double ContactStep::rounding_error(double h) const {
  const double size = start_.system.problem().w.norm() + start_.x.norm();
  if (!(size > 0)) return 0;
  double place = 0, weights = 0;
  for (const Contact& contact : start_.contacts) place = std::max(place, norm(contact.point));
  for (const double weight : weights_) weights += weight * weight;
  return resolution * (place + size_) / h * std::sqrt(weights) / size;
}

/// Estimates the error of the end of the step, a displacement (m), that arises if a contact began to stick in
/// the step, because the time at which it did is unknown. Returns the largest estimate of all contacts.
double ContactStep::unresolved_slip(double h) const {
  double most = 0;
  const VelocityProblem& problem = start_.system.problem();
  for (std::size_t k = 0; k < start_.contacts.size(); ++k) {
    const LawBlock& b = problem.blocks()[k];
    const std::size_t row = index(b.first);
    if (slides_[k] || !(start_.lambda[row] > 0)) continue;
    double squares = 0;
    for (std::size_t i = row + 1; i < row + std::min<std::size_t>(index(b.rows), 3); ++i)
      squares += std::pow(slip_[i] - start_.u[i], 2);
    most = std::max(most, h / 4 * std::sqrt(squares));
  }
  return most;
}

void ContactStep::set_r_of_end(double bounciness) {
  VelocityProblem& problem = end_.system.problem();
  std::ranges::fill(problem.r, 0.0);
  const auto set = [&](std::size_t row, double r) { problem.r[row] = problem.c[row] * r; };
  for (std::size_t k = 0; k < end_.contacts.size(); ++k) {
    const Contact& contact = end_.contacts[k];
    const LawBlock& b = problem.blocks()[k];
    const std::size_t row = index(b.first);
    const Contact* same = with_key(start_.contacts, contact.key, k);
    if (!same) continue;
    const std::size_t at = static_cast<std::size_t>(same - start_.contacts.data());
    const std::size_t row_0 = at * index(b.rows);
    if (bounces_[at]) set(row, bounciness * contact.surface.restitution * start_.u[row_0]);
    if (!slides_[at]) continue;
    const Contact* in_middle = with_key(middle_, contact.key, k);
    const ContactFrame from =
        turned(contact_frame(same->normal), in_middle ? in_middle->normal : same->normal);
    const ContactFrame to = contact_frame(contact.normal);
    const auto turn = [&](std::size_t first) {
      const Vec3<> slip = slip_[row_0 + first] * from.t1 + slip_[row_0 + first + 1] * from.t2;
      set(row + first, dot(slip, to.t1));
      set(row + first + 1, dot(slip, to.t2));
    };
    turn(1);
    if (b.rows > 3) set(row + 3, slip_[row_0 + 3]);
    if (b.rows > 4) turn(4);
  }
  const std::size_t n = end_.contacts.size(), n_0 = start_.contacts.size();
  for (std::size_t k = 0; k < end_.system.active_stops().size(); ++k) {
    const std::size_t stop = index(end_.system.active_stops()[k]);
    const double e = end_.system.stops()[stop].restitution;
    if (bounces_[n_0 + stop])
      set(index(problem.blocks()[n + k].first),
          bounciness * e * start_.u[index(start_.system.problem().blocks()[n_0 + stop].first)]);
  }
  for (const PrescribedRow<double>& it : end_.system.prescribed())
    set(index(end_.system.first_loop_row() + it.row), -it.ds);
}

}  // namespace axode
