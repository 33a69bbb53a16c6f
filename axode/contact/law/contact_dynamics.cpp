#include "axode/contact/law/contact_dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "axode/kinematics/check_arguments.hpp"
#include "axode/scalar/index.hpp"
#include "axode/scalar/text.hpp"

namespace axode {
namespace {

void check_numbers(const char* name, std::span<const double> x, std::size_t size) {
  if (x.size() != size)
    throw std::invalid_argument("ContactDynamics: " + std::string(name) + " has " + std::to_string(x.size()) +
                                " numbers; it needs " + std::to_string(size));
  for (std::size_t k = 0; k < size; ++k)
    if (!std::isfinite(x[k]))
      throw std::invalid_argument("ContactDynamics: " + std::string(name) + "[" + std::to_string(k) +
                                  "] is " + to_text(x[k]) + "; all numbers must be finite");
}

}  // namespace

ContactDynamics::ContactDynamics(const Model& model, int contact_rows, std::size_t capacity)
    : system_(model, contact_rows, capacity) {
  if (contact_rows != 3 && contact_rows != 4 && contact_rows != 6)
    throw std::invalid_argument("ContactDynamics: a contact cannot have " + std::to_string(contact_rows) +
                                " rows; it has 3, 4 with drilling friction, or 6 with rolling friction");
  const std::size_t nv = index(model.nv());
  const std::size_t rows = capacity * index(contact_rows) + system_.stops().size() +
                           system_.dry_joints().size() + index(model.loops().rows);
  for (std::vector<double>* x : {&free_velocity_, &velocity_, &generalized_impulse_, &before_, &x_})
    x->resize(nv);
  for (std::vector<double>* x : {&impulses_, &contact_velocity_, &r_, &multipliers_}) x->reserve(rows);
  solver_.reserve(model.nv(), static_cast<int>(rows));
  branches_.reserve(capacity);
  bounces_.reserve(capacity + system_.stops().size());
}

void ContactDynamics::check(std::span<const double> q, std::span<const double> v, std::span<const double> tau,
                            std::span<const Contact> contacts, const Options& options,
                            std::span<const double> start, const Loads<>& loads) const {
  const Model& model = system_.model();
  check_numbers("q", q, index(model.nq()));
  check_numbers("v", v, index(model.nv()));
  check_numbers("tau", tau, index(model.nv()));
  check_numbers("start", start, start.size());
  check_configuration(model, q);
  check_loads(model, loads);
  if (!(options.h > 0 && std::isfinite(options.h)))
    throw std::invalid_argument("ContactDynamics: the step h is " + to_text(options.h) +
                                " s; it must be positive");
  if (!(options.threshold >= 0))
    throw std::invalid_argument("ContactDynamics: the threshold is " + to_text(options.threshold) +
                                " m/s; it must not be negative");
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const Contact& c = contacts[k];
    const auto refuse = [&](const std::string& what) {
      throw std::invalid_argument("ContactDynamics: contact " + std::to_string(k) + what);
    };
    for (const int body : {c.a, c.b})
      if (body < 0 || body > model.n_bodies())
        refuse(" is on body " + std::to_string(body) + "; the model has bodies 0 to " +
               std::to_string(model.n_bodies()));
    if (c.a == c.b) refuse(" is between a body and itself");
    const SurfacePair& s = c.surface;
    for (const double mu : {s.friction, s.spin_friction, s.rolling_friction})
      if (!(mu >= 0 && std::isfinite(mu)))
        refuse(" has a friction of " + to_text(mu) + "; it must be finite and not negative");
    if (s.compliance)
      refuse(" has a stiffness; ContactDynamics knows rigid contacts, and simulations compliant ones");
    if (!(s.restitution >= 0 && s.restitution <= 1))
      refuse(" has a restitution of " + to_text(s.restitution) + "; it must be between 0 and 1");
    if (!(std::abs(norm(c.normal) - 1) < 1e-9))
      refuse(" has a normal of length " + to_text(norm(c.normal)) + "; it must be a unit vector");
    if (!std::isfinite(c.gap + dot(c.point, c.point))) refuse(" has a gap or a point that is not finite");
  }
}

/// Sets r of all rows in physical units. contact_velocity_ has the velocities of the rows before the step.
void ContactDynamics::set_r(std::span<const Contact> contacts, const Options& options) noexcept {
  VelocityProblem& problem = system_.problem();
  bounces_.clear();
  const std::size_t unilateral = contacts.size() + system_.active_stops().size();
  for (std::size_t k = 0; k < unilateral; ++k) {
    const double e = k < contacts.size()
                         ? contacts[k].surface.restitution
                         : system_.stops()[index(system_.active_stops()[k - contacts.size()])].restitution;
    const std::size_t row = index(problem.blocks()[k].first);
    const double u = contact_velocity_[row], gap = system_.room()[k];
    const bool bounces = e > 0 && u < -options.threshold && gap + options.h * u <= 0;
    problem.r[row] = bounces ? e * u : std::max(gap / options.h, -5 * options.threshold);
    bounces_.push_back(bounces ? 1 : 0);
  }
  const std::size_t first = index(system_.first_loop_row());
  for (std::size_t k = unilateral; k < system_.room().size(); ++k)
    problem.r[first + k - unilateral] = system_.room()[k] / options.h;
}

ContactStatus ContactDynamics::solve(std::span<const double> q, std::span<const double> v,
                                     std::span<const double> tau, std::span<const Contact> contacts,
                                     const Options& options, std::span<const double> start,
                                     const Loads<>& loads) {
  check(q, v, tau, contacts, options, start, loads);
  ContactStatus status;
  h_ = options.h;
  status.mass_matrix = system_.set(q.data(), contacts, options.h);
  if (!status.mass_matrix.ok()) return status;
  VelocityProblem& problem = system_.problem();
  const std::size_t rows = index(problem.rows()), nv = v.size();
  if (!start.empty()) check_numbers("start", start, rows);
  for (std::vector<double>* x : {&impulses_, &contact_velocity_, &r_, &multipliers_}) x->assign(rows, 0);
  solver_.reserve(system_.model().nv(), problem.rows());

  system_.times(v.data(), contact_velocity_.data());
  set_r(contacts, options);
  std::ranges::copy(problem.r, r_.begin());
  std::vector<double>& p = before_;
  system_.momenta(v.data(), p.data());
  system_.bias_forces(q.data(), v.data(), loads, x_.data());
  for (std::size_t c = 0; c < nv; ++c) p[c] += h_ * (tau[c] - x_[c]);
  system_.pull(p.data(), problem.w.data());
  problem.finish();
  system_.push(problem.w.data(), free_velocity_.data());

  for (std::size_t k = 0; k < start.size(); ++k)
    multipliers_[k] = problem.c[k] > 0 ? start[k] / problem.c[k] : 0;
  status.solution = solver_.solve(problem, multipliers_.data(), options.tolerance);
  for (std::size_t k = 0; k < rows; ++k) impulses_[k] = problem.c[k] * multipliers_[k];
  std::ranges::copy(problem.w, x_.begin());
  problem.add_product(1, multipliers_.data(), x_.data());
  system_.push(x_.data(), velocity_.data());
  system_.times(velocity_.data(), contact_velocity_.data());
  std::ranges::fill(generalized_impulse_, 0.0);
  system_.add_transposed_times(impulses_.data(), generalized_impulse_.data());
  on_ground_ = system_.on_ground(contacts, impulses_.data());
  classify(contacts.size());
  return status;
}

void ContactDynamics::classify(std::size_t contacts) noexcept {
  const VelocityProblem& problem = system_.problem();
  const auto length = [](std::span<const double> x) {
    return Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size())).norm();
  };
  const double at_rest = 1e-9 * std::max(1e-3, length(velocity_) + length(free_velocity_));
  branches_.clear();
  for (const VelocityProblem::Block& b : problem.blocks().first(contacts)) {
    double s = 0;
    for (int row = b.first + 1; row < b.first + b.rows; ++row) {
      const double slip = problem.c[index(row)] * contact_velocity_[index(row)];
      s += slip * slip;
    }
    branches_.push_back(!(impulses_[index(b.first)] > 0) ? LawBranch::open
                        : std::sqrt(s) > at_rest         ? LawBranch::slide
                                                         : LawBranch::stick);
  }
}

Eigen::MatrixXd ContactDynamics::derivative(const Eigen::MatrixXd& dx, const Eigen::MatrixXd& du,
                                            ProblemDerivative* details) {
  ProblemDerivative found = differentiate(system_.problem(), multipliers_.data(), dx, du);
  Eigen::MatrixXd dv(dx.rows(), dx.cols());
  for (Eigen::Index k = 0; k < dx.cols(); ++k) system_.push(found.motion.col(k).data(), dv.col(k).data());
  if (details) *details = std::move(found);
  return dv;
}

Eigen::MatrixXd ContactDynamics::derivative_by_momenta(ProblemDerivative* details) {
  const Eigen::Index nv = system_.model().nv(), m = system_.problem().rows();
  Eigen::MatrixXd dw(nv, nv);
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(nv, nv);
  for (Eigen::Index k = 0; k < nv; ++k) system_.pull(one.col(k).data(), dw.col(k).data());
  return derivative(dw, Eigen::MatrixXd::Zero(m, nv), details);
}

Eigen::MatrixXd ContactDynamics::derivative_by_tau(ProblemDerivative* details) {
  return h_ * derivative_by_momenta(details);
}

Eigen::MatrixXd ContactDynamics::derivative_by_r(ProblemDerivative* details) {
  const VelocityProblem& problem = system_.problem();
  const Eigen::Map<const Eigen::VectorXd> c(problem.c.data(), problem.rows());
  return derivative(Eigen::MatrixXd::Zero(problem.nv(), problem.rows()), c.asDiagonal().toDenseMatrix(),
                    details);
}

/// A scaled row is c times the physical one. Hence its derivatives by c are dY = Y/c dc and dr = r/c dc.
Eigen::MatrixXd ContactDynamics::derivative_by_friction(ProblemDerivative* details) {
  const VelocityProblem& problem = system_.problem();
  const Eigen::Index nv = problem.nv(), m = problem.rows();
  Eigen::MatrixXd dx = Eigen::MatrixXd::Zero(nv, m), du = Eigen::MatrixXd::Zero(m, m);
  for (const VelocityProblem::Block& b : problem.blocks()) {
    if (b.law != ContactLaw::contact) continue;
    const auto Y = problem.columns(b);
    const auto at = problem.support(b);
    for (int k = 1; k < b.rows; ++k) {
      const Eigen::Index row = b.first + k;
      const double c = problem.c[static_cast<std::size_t>(row)];
      if (c == 0) continue;
      for (int i = 0; i < b.width; ++i)
        dx(at[index(i)], row) = Y(i, k) / c * multipliers_[static_cast<std::size_t>(row)];
      du(row, row) = contact_velocity_[static_cast<std::size_t>(row)] + r_[static_cast<std::size_t>(row)];
    }
  }
  return derivative(dx, du, details);
}

}  // namespace axode
