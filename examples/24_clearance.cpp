// Clearance: an arm moves its flange to a target and keeps its links 3 cm away from a ball that stands in the
// way. The rows of the distances' Jacobian are inequalities of each step of the inverse kinematics. Without
// them a link would enter the ball by 3 cm.
#include <Eigen/Dense>
#include <algorithm>
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/contact.hpp"
#include "axode/eigen.hpp"
#include "axode/io.hpp"

using namespace axode;

/// The arm with a ball about the centre of mass of each link, and a ball on the ground.
Model arm_and_ball(const Vec3<>& ball) {
  const Model arm = load(AXODE_ROBOTS_DIR "/arm7.toml");
  Description d = arm.description();
  const auto sphere = [](double radius, const Vec3<>& center) {
    return ShapeDescription{.role = ShapeDescription::Role::collision,
                            .kind = ShapeKind::sphere,
                            .pose = {{}, center},
                            .radius = radius};
  };
  for (BodyDescription& body : d.bodies)
    if (body.inertia && body.joint.kind != JointKind::fixed)
      body.shapes.push_back(sphere(0.08, body.inertia->com));  // body frames are the construction frame here
  d.shapes.push_back(sphere(0.1, ball));
  return ModelBuilder(std::move(d)).build();
}

int main() {
  constexpr double clearance = 0.03, near = 0.15, step = 0.02;
  const Vec3<> ball{0.55, 0, 0.7}, start{0.5, 0.4, 0.6}, target{0.5, -0.4, 0.6};
  const Model arm = arm_and_ball(ball);
  const int flange = arm.frame_index("flange"), nv = arm.nv();
  Workspace<> workspace(arm);

  // The pairs of the ball with all other shapes; the ball is shape 0, because shapes of the ground come
  // first.
  std::vector<std::array<int, 2>> pairs;
  for (const auto& pair : ContactShapes(arm).pairs())
    if (pair[0] == 0) pairs.push_back(pair);
  Distances distances(arm, ContactShapes(arm), pairs);

  std::vector<double> q(nv, 0.4), J_d;
  double least = 1, error = 1;
  int steps = 0;
  bool started = false;
  for (; steps < 1000 && (!started || error > 1e-4); ++steps) {
    std::vector<SE3<>> C(arm.n_frames());
    std::vector<Twist<Hybrid>> J(nv);
    poses<double>(arm, workspace, q, C);
    jacobian<Hybrid, double>(arm, workspace, q, flange, J);
    if (!started && norm(start - C[flange].r) < 1e-3) started = true;  // from here on the ball counts
    const Vec3<> to_go = (started ? target : start) - C[flange].r;
    error = norm(to_go);
    const double scale = std::min(1.0, step / error);
    Eigen::Matrix3Xd A(3, nv);
    for (int c = 0; c < nv; ++c) A.col(c) = to_eigen(J[c].v);
    const Eigen::Matrix3d damped = A * A.transpose() + 1e-6 * Eigen::Matrix3d::Identity();
    Eigen::VectorXd dq = A.transpose() * damped.ldlt().solve(scale * to_eigen(to_go));

    // Projects the step on d + J dq >= clearance, one distance after the other.
    const auto found = distances.evaluate(q, near);
    J_d.resize(found.size() * nv);
    distances.jacobian(J_d);
    const int sweeps = started ? 50 : 0;
    for (int sweep = 0; sweep < sweeps; ++sweep)
      for (std::size_t k = 0; k < found.size(); ++k) {
        const Eigen::Map<const Eigen::VectorXd> row(J_d.data() + k * nv, nv);
        const double missing = clearance - found[k].distance - row.dot(dq);
        if (missing > 0) dq += (missing / row.squaredNorm()) * row;
      }
    for (const ShapeDistance& d : found)
      if (started) least = std::min(least, d.distance);
    q = integrate(arm, q, as_span(dq));
  }
  std::printf("%d steps, the flange is %.1e m from its target, no link was nearer to the ball than %.4f m\n",
              steps, error, least);
  return error < 1e-3 && least > clearance - 2e-3 && least < near ? 0 : 1;
}
