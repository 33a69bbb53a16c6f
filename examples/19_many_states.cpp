// The drive forces along a motion of two seconds: 2,000 states in one call, in SIMD lanes and on every core.
#include <cmath>
#include <cstdio>
#include <thread>

#include "axode/axode.hpp"
#include "axode/batch.hpp"
#include "axode/eigen.hpp"
#include "axode/io.hpp"

using namespace axode;

int main() {
  const Model arm = load(AXODE_ROBOTS_DIR "/arm7.toml");
  constexpr int N = 2000;
  constexpr double step = 1e-3, w = 3;             // s, rad/s
  Eigen::MatrixXd q(arm.nq(), N), v(arm.nv(), N);  // a state in every column
  for (int k = 0; k < N; ++k) {
    q.col(k).setConstant(0.5 * std::sin(w * step * k));
    v.col(k).setConstant(0.5 * w * std::cos(w * step * k));
  }
  const Eigen::MatrixXd a = -w * w * q;

  Eigen::MatrixXd tau(arm.nv(), N);
  const int threads = static_cast<int>(std::thread::hardware_concurrency());
  const batch::Outcome outcome = batch::run(
      arm, "inverse_dynamics", {.q = as_span(q), .v = as_span(v), .a = as_span(a)}, as_span(tau), threads);

  std::printf("%s, %zu states at once with %s\n%-6s %18s %18s\n", arm.name().c_str(), outcome.done,
              instruction_set(), "joint", "largest force, N m", "largest power, W");
  for (const Joint& joint : arm.joints())
    std::printf("%-6s %18.3f %18.3f\n", joint.name.c_str(), tau.row(joint.iv).cwiseAbs().maxCoeff(),
                tau.row(joint.iv).cwiseProduct(v.row(joint.iv)).cwiseAbs().maxCoeff());
}
