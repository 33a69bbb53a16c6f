// Velocity, acceleration, jerk and snap of a tool and the rate of its Jacobian, from one evaluation.
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

using namespace axode;

int main(int argc, char** argv) {
  const Model arm = load(argc > 1 ? argv[1] : AXODE_ROBOTS_DIR "/arm7.toml");
  const int tool = arm.n_frames() - 1, order = 3;

  // Every joint moves with q(t) = 0.3 + 0.5 t - 0.2 t², so that v = 0.5, v' = -0.4 and all higher derivatives
  // are 0.
  std::vector<double> q = neutral(arm), rates((order + 1) * arm.nv());
  for (double& angle : q) angle = 0.3;
  for (int c = 0; c < arm.nv(); ++c) rates[c] = 0.5, rates[arm.nv() + c] = -0.4;

  HigherOrderMotion<> motion(arm, order);
  motion.evaluate(q, rates);
  std::printf("motion of %s\n", arm.frame(tool).name.c_str());
  const char* const names[] = {"velocity", "acceleration", "jerk", "snap"};
  const char* const units[] = {"m/s", "m/s²", "m/s³", "m/s⁴"};
  for (int k = 0; k <= order; ++k) {
    const TwistRate<Hybrid> V_k =
        motion.twist_derivative<Hybrid>(tool, k);  // linear part: that of the origin
    std::printf("  %-12s (%8.4f %8.4f %8.4f) %s\n", names[k], V_k.v.x, V_k.v.y, V_k.v.z, units[k]);
  }

  std::vector<TwistRate<BodyFixed>> dJ(arm.nv());
  motion.jacobian_derivative<BodyFixed>(tool, 1, dJ);
  std::printf(
      "the first column of its body-fixed Jacobian changes by (%.4f %.4f %.4f; %.4f %.4f %.4f) per second\n",
      dJ[0].w.x, dJ[0].w.y, dJ[0].w.z, dJ[0].v.x, dJ[0].v.y, dJ[0].v.z);
}
