// The mass of a payload from measured torques: drive forces are linear in the inertial parameters.
#include <Eigen/QR>
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/eigen.hpp"
#include "axode/io.hpp"

using namespace axode;

int main() {
  const Model arm = load(AXODE_ROBOTS_DIR "/arm7.toml");
  const int last = arm.n_bodies();
  // The measured robot is the same arm with 1.5 kg at 12 cm in front of the flange.
  Description description = arm.description();
  const SE3<> flange = arm.frame(arm.frame_index("flange")).pose;
  description.bodies.push_back(
      {.name = "payload",
       .predecessor = arm.body(last).name,
       .geometry = InBodyFrame{flange},
       .inertia = MassProperties{
           .mass = 1.5, .com = {0, 0, 0.12}, .Theta = {1e-3, 1e-3, 1e-3}, .in = GivenIn::body_frame}});
  const Model loaded = ModelBuilder(description).build();

  const int samples = 30, width = 10 * last, nv = arm.nv();
  Workspace<> workspace(arm), loaded_workspace(loaded);
  Eigen::MatrixXd A(samples * nv, 10);  // the columns of the last body, with which the payload moves
  Eigen::VectorXd b(samples * nv);
  for (int s = 0; s < samples; ++s) {
    const std::vector<double> q = random_configuration(arm, 10 + s);
    std::vector<double> v(nv), a(nv), tau(nv), expected(nv), Y(nv * width);
    for (int c = 0; c < nv; ++c)
      v[c] = 0.5 - (s * 7 + c * 3) % 10 / 10.0, a[c] = 1 - (s * 3 + c * 7) % 20 / 10.0;
    inverse_dynamics(loaded, loaded_workspace, q, v, a, tau);  // the measurement
    inverse_dynamics(arm, workspace, q, v, a, expected);
    regressor(arm, workspace, q, v, a, Y);
    for (int c = 0; c < nv; ++c) {
      A.row(s * nv + c) = Eigen::Map<Eigen::RowVectorXd>(&Y[c * width + 10 * (last - 1)], 10);
      b[s * nv + c] = tau[c] - expected[c];
    }
  }
  const Eigen::VectorXd pi = A.colPivHouseholderQr().solve(b);
  const Vec3<> com = inverse(flange) * Vec3<>{pi[1] / pi[0], pi[2] / pi[0], pi[3] / pi[0]};
  std::printf("payload: %.4f kg, centre of mass at (%.4f, %.4f, %.4f) m in the frame of the flange\n", pi[0],
              com.x, com.y, com.z);
}
