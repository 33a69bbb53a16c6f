// Inverse kinematics of the arm for 10,000 poses that it can reach, from its neutral configuration. The
// result is the median time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

namespace {

using namespace axode;

void inverse_kinematics_of_the_arm(benchmark::State& state) {
  constexpr int n_targets = 10'000;
  const Model arm = load(AXODE_ROBOTS_DIR "/arm7.toml");
  const int tool = arm.frame_index("flange");
  Workspace<> workspace(arm);
  std::vector<SE3<>> C(static_cast<std::size_t>(arm.n_frames()));
  std::vector<PoseTarget> targets;
  for (int k = 0; k < n_targets; ++k) {
    poses(arm, workspace, random_configuration(arm, 1 + static_cast<std::uint64_t>(k)), C);
    targets.push_back({.place = tool, .pose = C[static_cast<std::size_t>(tool)]});
  }
  const std::vector<double> start = neutral(arm);
  for (auto _ : state) {
    std::vector<double> microseconds;
    int solved = 0;
    for (const PoseTarget& target : targets) {
      const auto begin = std::chrono::steady_clock::now();
      const InverseKinematicsResult result = inverse_kinematics(arm, {{target}}, start);
      const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - begin;
      microseconds.push_back(time.count());
      solved += result.status == InverseKinematicsStatus::solved;
    }
    std::sort(microseconds.begin(), microseconds.end());
    state.counters["solved_percent"] = 100.0 * solved / n_targets;
    state.counters["median_us"] = microseconds[n_targets / 2];
    state.counters["p99_us"] = microseconds[n_targets * 99 / 100];
  }
}
BENCHMARK(inverse_kinematics_of_the_arm)->Unit(benchmark::kMillisecond);

}  // namespace
