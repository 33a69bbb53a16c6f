// A gradient through contact: a finger pushes a puck, which then slides on a floor until it rests. Which
// force brings it to a target? The derivatives of every step, of sticking and sliding contacts too, give
// Newton's method for the two components of the force. It ends within a millimetre: the motion as a function
// of the force has small jumps, where a foot lands in another step.
#include <Eigen/Dense>
#include <algorithm>
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/contact.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/contact_sensitivities.hpp"

using namespace axode;

ShapeDescription ball(double radius, const Vec3<>& center, double friction) {
  return {.role = ShapeDescription::Role::collision,
          .kind = ShapeKind::sphere,
          .pose = {{}, center},
          .radius = radius,
          .contact = {.friction = friction}};
}

/// A finger on two slides, and a puck on three feet beside it.
Model finger_and_puck() {
  Description d;
  ShapeDescription floor{.role = ShapeDescription::Role::collision, .kind = ShapeKind::plane};
  floor.contact.friction = 0.3;
  d.shapes.push_back(floor);
  BodyDescription slide{.name = "slide"}, finger{.name = "finger", .predecessor = "slide"},
      puck{.name = "puck"};
  slide.joint = {.kind = JointKind::prismatic, .axis = {1, 0, 0}, .dof = {Dof{.damping = 20}}};
  slide.inertia = MassProperties{.mass = 0.1, .Theta = {1e-3, 1e-3, 1e-3, 0, 0, 0}};
  finger.joint = {.kind = JointKind::prismatic, .axis = {0, 1, 0}, .dof = {Dof{.damping = 20}}};
  finger.inertia = MassProperties{.mass = 0.2, .Theta = {1e-3, 1e-3, 1e-3, 0, 0, 0}};
  finger.shapes.push_back(ball(0.05, {-0.151, 0.02, 0.07}, 0.5));
  puck.joint = {.kind = JointKind::free};
  puck.inertia = MassProperties{.mass = 0.5, .com = {0, 0, 0.05}, .Theta = {2e-3, 2e-3, 3e-3, 0, 0, 0}};
  puck.shapes.push_back(ball(0.1, {0, 0, 0.11}, 0.5));
  for (const Vec3<>& foot : {Vec3<>{0.1, 0, 0.01}, {-0.05, 0.087, 0.01}, {-0.05, -0.087, 0.01}})
    puck.shapes.push_back(ball(0.01, foot, 0.3));
  d.bodies = {slide, finger, puck};
  return ModelBuilder(std::move(d)).build();
}

int main() {
  const Model model = finger_and_puck();
  const ContactShapes shapes(model);
  constexpr double step = 5e-3;
  constexpr std::size_t pushed = 40, steps = 160;
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  const std::vector<double> q = neutral(model), v(nv);
  const Eigen::Vector2d target{0.25, -0.02};
  const auto place_x = static_cast<std::size_t>(model.nq()) - 3;

  // The finger pushes in the first steps with the force f.
  Eigen::Vector2d f{12, 0};
  for (int iteration = 0; iteration < 20; ++iteration) {
    std::vector<double> tau(steps * nv);
    for (std::size_t k = 0; k < pushed; ++k)
      std::copy_n(f.data(), 2, tau.begin() + static_cast<long>(k * nv));
    std::vector<double> q_k((steps + 1) * q.size()), v_k((steps + 1) * nv), A(4 * steps * nv * nv),
        B(2 * steps * nv * nv);
    const ContactSensitivity found =
        contact_rollout_derivatives(model, shapes, q, v, tau, step, {q_k, v_k, A, B});
    if (!found.ok()) return std::printf("%s\n", found.failure.why.c_str()), 1;

    // The deviation of the state along both components of the force.
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const auto n = static_cast<Eigen::Index>(nv);
    Eigen::MatrixXd x = Eigen::MatrixXd::Zero(2 * n, 2);
    for (std::size_t k = 0; k < steps; ++k) {
      const Eigen::Map<const Rows> A_k(&A[4 * k * nv * nv], 2 * n, 2 * n), B_k(&B[2 * k * nv * nv], 2 * n, n);
      x = (A_k * x).eval();
      if (k < pushed) x += B_k.leftCols(2);
    }
    // The puck's displacement is in its own axes; the rotation of its pose brings it to those of the floor.
    const double* end = &q_k[steps * q.size()];
    const SO3<> R = rotation(Quaternion<>{end[2], end[3], end[4], end[5]});
    const Eigen::Matrix2d by_force = (to_eigen(R) * x.middleRows<3>(n - 3)).topRows<2>();
    const Eigen::Vector2d missing = target - Eigen::Vector2d{end[place_x], end[place_x + 1]};
    std::printf(
        "f = (%7.4f, %7.4f) N: the puck rests %.2e m from the target, with %.1e m/s; certificate %.0e\n",
        f.x(), f.y(), missing.norm(), Eigen::Map<const Eigen::VectorXd>(&v_k[steps * nv], n).norm(),
        found.certificate);
    if (missing.norm() < 1e-3) return 0;
    const Eigen::Vector2d change = by_force.partialPivLu().solve(missing);
    f += std::min(1.0, 1.5 / change.norm()) * change;
  }
  return 1;
}
