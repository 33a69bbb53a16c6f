// The solver of contact problems, steps with contact, and their derivatives. A cold solver begins without
// impulses; a warm one has the solution for momenta that differ by a thousandth. Both know the order of
// elimination.
#include <algorithm>
#include <cmath>

#include "axode/contact/law/velocity_solver.hpp"
#include "axode/integration/momenta/contact_step.hpp"
#include "axode/integration/momenta/contact_step_derivative.hpp"
#include "bench/contact_subjects.hpp"
#include "tests/contact/rigid_problems.hpp"

namespace {

using namespace axode;
using namespace axode::bench;

/// The velocity problem of a robot that begins to fall on its feet.
VelocityProblem problem_of(const Standing& robot) {
  ContactFinder finder{ContactShapes(robot.model)};
  ContactSystem system(robot.model);
  std::vector<SE3<>> C(static_cast<std::size_t>(robot.model.n_bodies()) + 1);
  system.poses(robot.q.data(), C.data());
  if (!finder.find(C, 1e-3)) std::abort();
  std::vector<Contact> contacts;
  for (const ContactPoint& p : finder.points())
    contacts.push_back({.a = finder.shapes()[p.a].body,
                        .b = finder.shapes()[p.b].body,
                        .point = p.point,
                        .normal = p.normal,
                        .gap = p.gap,
                        .surface = finder.shapes().surface(p.a, p.b),
                        .key = p.key});
  if (!system.set(robot.q.data(), contacts, Standing::h).ok()) std::abort();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(robot.model.nv());
  Eigen::VectorXd p = rest;
  system.bias_forces(robot.q.data(), rest.data(), {}, p.data());
  p *= -Standing::h;
  system.pull(p.data(), system.problem().w.data());
  system.problem().finish();
  return system.problem();
}

void register_problem(const std::string& name, VelocityProblem problem) {
  const std::size_t rows = static_cast<std::size_t>(problem.rows());
  benchmark::RegisterBenchmark(("contact_cold/" + name + "/axode").c_str(), [=](benchmark::State& state) {
    VelocitySolver solver;
    solver.reserve(problem.nv(), problem.rows());
    std::vector<double> lambda(rows);
    repeat(state, lambda.data(), [&] {
      std::ranges::fill(lambda, 0.0);
      benchmark::DoNotOptimize(solver.solve(problem, lambda.data()));
    });
  });
  benchmark::RegisterBenchmark(("contact_warm/" + name + "/axode").c_str(), [=](benchmark::State& state) {
    VelocitySolver solver;
    solver.reserve(problem.nv(), problem.rows());
    std::vector<double> start(rows, 0.0), lambda;
    static_cast<void>(solver.solve(problem, start.data()));
    VelocityProblem near = problem;
    for (int c = 0; c < near.nv(); ++c) near.w[c] *= 1 + 1e-3 * std::sin(c);
    repeat(state, start.data(), [&] {
      lambda = start;
      benchmark::DoNotOptimize(solver.solve(near, lambda.data()));
    });
  });
}

/// Steps of a robot that stands under springs and dampers in its joints, or the derivatives of its last step
/// by q, v and drive forces.
void stand(benchmark::State& state, const Standing& robot, bool derivatives) {
  const std::size_t nv = static_cast<std::size_t>(robot.model.nv());
  SimulationOptions options;
  options.drive = [&](double, std::span<const double> q, std::span<const double> v, std::span<double> tau) {
    std::ranges::fill(tau, 0.0);
    for (std::size_t c = 6; c < nv; ++c)
      tau[c] = Standing::stiffness * (robot.q[c + 1] - q[c + 1]) - Standing::damping * v[c];
  };
  const std::vector<double> rest(nv, 0.0);
  ContactSimulationRun run(robot.model, robot.q, rest, 0, options, false);
  ContactStep step(run, robot.model, ContactShapes(robot.model), false);
  Eigen::VectorXd q = run.q, v = run.v;
  double t = 0;
  const auto advance = [&] {
    if (step.run(t, Standing::h, q, v)) std::abort();
    q = step.q;
    v = step.v;
    t += Standing::h;
  };
  for (int k = 0; k < 500; ++k) advance();
  if (!derivatives) return repeat(state, q.data(), advance);
  step.keep_parts = true;
  advance();
  ContactStepDerivative derivative(robot.model, ContactShapes(robot.model), false, false);
  const Eigen::Index n = robot.model.nv();
  const Eigen::MatrixXd directions = Eigen::MatrixXd::Identity(3 * n, 3 * n);
  const ContactDirections along{.tau = directions.bottomRows(n)};
  Changes dq, dv;
  repeat(state, q.data(), [&] {
    dq = directions.topRows(n);
    dv = directions.middleRows(n, n);
    for (const ContactPart& part : step.kept)
      if (!derivative.run(part, dq, dv, along)) std::abort();
  });
}

const bool registered = [] {
  register_problem("stack_of_10", test::stack(std::vector<double>(10, 1.0)).build());
  register_problem("wall_of_100", test::wall(10, 10, 15).build());
  register_problem("arch_of_32", test::arch(32, 0.108, 1).build());
  for (const Standing& robot : standing_robots()) {
    register_problem("solo12", problem_of(robot));
    benchmark::RegisterBenchmark("contact_step/solo12/axode",
                                 [robot](benchmark::State& state) { stand(state, robot, false); });
    benchmark::RegisterBenchmark("contact_step_derivatives/solo12/axode",
                                 [robot](benchmark::State& state) { stand(state, robot, true); });
  }
  return true;
}();

}  // namespace
