// Joint angles that put a tool into a pose, within the limits of the joints and near a posture.
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

using namespace axode;

int main() {
  const Model arm = load(AXODE_ROBOTS_DIR "/arm7.toml");
  const int tool = arm.frame_index("flange");
  const SO3<> down = rotation(Quaternion<>{1, 0, 0, 0});  // half a turn about x
  const PoseTarget target{.place = tool, .pose = {down, {0.5, 0.1, 0.3}}};
  const std::vector<double> start = neutral(arm), posture{0, 0.5, 0.5, -1.2, 0, 1, 0};

  const auto show = [](const char* what, const InverseKinematicsResult& result) {
    std::printf("%s: %s after %d iterations and %d restarts, error %.1e\n  q = (", what,
                to_string(result.status).data(), result.iterations, result.restarts, result.residual);
    for (const double angle : result.q) std::printf(" %7.4f", angle);
    std::printf(" )\n");
    return result.status == InverseKinematicsStatus::solved;
  };
  const bool good = show("any configuration", inverse_kinematics(arm, {{target}}, start)) &&
                    show("near a posture", inverse_kinematics(arm, {{target}}, start, {.posture = posture}));

  const PoseTarget far{.place = tool, .pose = {down, {2, 0, 0.36}}, .angular_weight = 0};  // a position alone
  show("out of reach", inverse_kinematics(arm, {{far}}, start));
  return good ? 0 : 1;
}
