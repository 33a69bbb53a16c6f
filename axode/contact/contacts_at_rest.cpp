#include "axode/contact/contacts_at_rest.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "axode/constraints/check_loops.hpp"
#include "axode/contact/contact_finder.hpp"
#include "axode/contact/law/contact_system.hpp"
#include "axode/contact/law/velocity_solver.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/scalar/index.hpp"
#include "axode/scalar/text.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

void check_distance(const char* name, double x) {
  if (!(x >= 0 && std::isfinite(x)))
    throw std::invalid_argument("contacts_at_rest: " + std::string(name) + " is " + to_text(x) +
                                " m; it must be finite and not negative");
}

/// Returns the drive forces tau (0 if empty) plus the spring forces at q and at rest, nv numbers.
std::vector<double> joint_forces(const Model& model, Numbers<double> q, Numbers<double> tau) {
  const std::vector<double> at_rest(index(model.nv()));
  std::vector<double> forces = at_rest;
  if (!tau.empty()) {
    check_size("tau", tau.size(), forces.size(), "nv");
    std::ranges::copy(tau, forces.begin());
  }
  if (!std::ranges::all_of(forces, [](double x) { return std::isfinite(x); }))
    throw std::invalid_argument("contacts_at_rest: tau has a number that is not finite");
  Workspace<> workspace(model, cut_tree);
  add_spring_forces<double>(model, workspace, q, at_rest, forces);
  return forces;
}

/// Throws std::invalid_argument, with the name of the loop, if a loop is open at q.
void check_loops_at_rest(const Model& model, Numbers<double> q) {
  if (model.loops().empty()) return;
  LoopWorkspace<double> workspace(model);
  check_closed(workspace.system(model), q, std::vector<double>(index(model.nv())));
}

}  // namespace

ContactsAtRest contacts_at_rest(const Model& model, const ContactShapes& shapes, Numbers<double> q,
                                Numbers<double> tau, const AtRestOptions& options, const Loads<>& loads) {
  check_shapes(model, shapes);
  check_configuration(model, q);
  check_loads(model, loads);
  catalog::check_counts<"contacts_at_rest">(model);
  if (options.joint_losses) refuse_gears(model);
  const double margin = options.margin.value_or(shapes.margin());
  check_distance("margin", margin);
  check_distance("touching", options.touching);
  const std::vector<double> forces = joint_forces(model, q, tau);
  check_loops_at_rest(model, q);

  // In a step of 1 s from rest, impulses are equal to forces and velocities to accelerations, because all
  // laws are homogeneous if no gap is left to close.
  constexpr double second = 1;
  ContactSystem system(model, shapes.contact_rows(), 16, options.joint_losses);
  ContactFinder finder(shapes);
  std::vector<SE3<>> C(index(model.n_bodies()) + 1);
  system.poses(q.data(), C.data());
  if (!finder.find(C, std::max(margin, options.touching)))
    throw std::invalid_argument("contacts_at_rest: there are more than " +
                                std::to_string(finder.points().size()) + " points of contact");
  ContactsAtRest found;
  std::vector<Contact> touching;
  for (const ContactPoint& point : finder.points()) {
    const ContactShape &a = shapes[point.a], &b = shapes[point.b];
    const SurfacePair surface = shapes.surface(point.a, point.b);
    found.contacts.push_back({.a = point.a,
                              .b = point.b,
                              .body_a = a.body,
                              .body_b = b.body,
                              .point = point.point,
                              .normal = point.normal,
                              .gap = point.gap,
                              .friction = surface.friction,
                              .key = point.key});
    if (point.gap <= options.touching)
      touching.push_back({a.body, b.body, point.point, point.normal, 0, surface, point.key,
                          surface.compliance
                              ? std::optional(second * surface.compliance.force_at_rest(point.gap))
                              : std::nullopt});
  }

  const Solvability verdict = system.set(q.data(), touching, second, options.touching);
  if (!verdict.ok()) throw std::invalid_argument("contacts_at_rest: " + to_string(model, verdict));
  VelocityProblem& problem = system.problem();
  const std::size_t nv = forces.size(), rows = index(problem.rows());
  const std::vector<double> at_rest(nv);
  std::vector<double> p(nv), u(rows), lambda(rows);
  system.bias_forces(q.data(), at_rest.data(), loads, p.data());
  for (std::size_t c = 0; c < nv; ++c) p[c] = forces[c] - p[c];
  system.pull(p.data(), problem.w.data());
  problem.finish();
  VelocitySolver solver;
  solver.reserve(problem.nv(), problem.rows());
  found.certificate = solver.solve(problem, lambda.data(), 1e-15).certificate;
  Eigen::VectorXd x = problem.w;
  problem.add_product(1, lambda.data(), x.data());
  found.a.resize(nv);
  system.push(x.data(), found.a.data());
  if (!std::isfinite(found.certificate) ||
      !std::ranges::all_of(found.a, [](double a) { return std::isfinite(a); }))
    throw std::invalid_argument("contacts_at_rest: " + to_string(model, Solvability{.not_finite = true}));
  system.times(found.a.data(), u.data());
  problem.complete(lambda.data());

  const double at_rest_below = 1e-9 * std::max(1e-3, x.norm());
  std::size_t k = 0;
  for (ContactForce& contact : found.contacts) {
    if (contact.gap > options.touching) continue;
    add_impulse(problem, k, lambda.data(), contact.normal, contact);
    contact.branch = branch_after(problem, k, lambda.data(), u.data(), at_rest_below);
    ++k;
  }
  return found;
}

}  // namespace axode
