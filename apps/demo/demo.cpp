#include "apps/demo/demo.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/demo/tree_drawing.hpp"
#include "apps/files/state.hpp"
#include "apps/shell/table.hpp"
#include "apps/shell/terminal.hpp"
#include "apps/study/call_timer.hpp"
#include "axode/dynamics.hpp"
#include "axode/io.hpp"
#include "axode/kinematics/poses.hpp"

namespace axode::command {
namespace {

constexpr std::array<Representation, 4> all_representations{Representation::body, Representation::spatial,
                                                            Representation::hybrid, Representation::mixed};

/// The folder of the robots of the demonstration, which is beside an installed command or in the source tree.
std::filesystem::path robots_folder() {
  std::error_code unknown;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  const std::filesystem::path installed = program.parent_path() / AXODE_INSTALLED_ROBOTS;
  if (std::filesystem::is_directory(installed)) return installed.lexically_normal();
  if (std::filesystem::is_directory(AXODE_SOURCE_ROBOTS)) return AXODE_SOURCE_ROBOTS;
  throw std::runtime_error("the robots of the demo are neither in " + installed.lexically_normal().string() +
                           " nor in " + AXODE_SOURCE_ROBOTS);
}

std::string short_number(double x) { return x == 0 ? "0" : fmt::format("{:.1e}", x); }

double microseconds(double seconds) { return std::round(1e8 * seconds) / 100; }

/// Results and computation times of the inverse dynamics of a robot, in each representation of twists.
struct RepresentationTimes {
  std::array<std::vector<double>, 5> tau;
  std::array<double, 5> time{};

  RepresentationTimes(const Model& model, const State& state) {
    Workspace<> workspace(model);
    const auto run = [&](std::size_t r, auto rep) {
      tau[r].resize(model.nv());
      CallTimer timer([&](int calls) {
        for (int k = 0; k < calls; ++k)
          inverse_dynamics<decltype(rep)>(model, workspace, state.q, state.v, state.a, tau[r]);
      });
      timer.sample(2001);
      time[r] = timer.median();
    };
    for (std::size_t r = 0; r < 4; ++r)
      with_representation(all_representations[r], [&](auto rep) { run(r, rep); });
    run(4, Fast{});
  }
  /// The largest difference between two of the results in component k.
  double spread(std::size_t k) const {
    const auto [least, most] = std::minmax({tau[0][k], tau[1][k], tau[2][k], tau[3][k], tau[4][k]});
    return most - least;
  }
  double largest() const {
    double largest = 0;
    for (const double x : tau[0]) largest = std::max(largest, std::abs(x));
    return largest;
  }
  double largest_spread() const {
    double largest = 0;
    for (std::size_t k = 0; k < tau[0].size(); ++k) largest = std::max(largest, spread(k));
    return largest;
  }
};

void print_forces(const Model& model, const RepresentationTimes& times) {
  constexpr std::size_t most_rows = 10;
  const std::vector<std::string> names = velocity_names(model);
  std::vector<std::size_t> shown(names.size());
  for (std::size_t k = 0; k < shown.size(); ++k) shown[k] = k;
  const bool some = shown.size() > most_rows;
  if (some) {
    const auto larger = [&](std::size_t i, std::size_t j) {
      return std::abs(times.tau[0][i]) > std::abs(times.tau[0][j]);
    };
    std::ranges::sort(shown, larger);
    shown.resize(most_rows);
    std::ranges::sort(shown);
  }
  Table table({"joint", "body-fixed", "spatial", "hybrid", "mixed", "they differ by"});
  for (const std::size_t k : shown)
    table.row({names[k], times.tau[0][k], times.tau[1][k], times.tau[2][k], times.tau[3][k],
               short_number(times.spread(k))});
  fmt::print("\ndrive forces at a random state, one recursion in four representations{}; N m or N\n{}",
             some ? fmt::format(" (the {} largest of {})", most_rows, names.size()) : "", table.text());
}

/// Prints the position of the last frame of a model, which is the frame of its tool or of its last body.
void print_tip(const Model& model, const State& state) {
  Workspace<> workspace(model);
  std::vector<SE3<>> C(model.n_frames());
  poses(model, workspace, state.q, C);
  const auto& [R, r] = C.back();
  fmt::print("\npose of \"{}\" in the inertial frame; m\n", model.frames().back().name);
  Table pose({"R x", "R y", "R z", "r"});
  pose.row({R.x.x, R.y.x, R.z.x, r.x}).row({R.x.y, R.y.y, R.z.y, r.y}).row({R.x.z, R.y.z, R.z.z, r.z});
  fmt::print("{}", pose.text());
}

void print_reaction(const Model& model, const State& state) {
  Workspace<> workspace(model);
  std::vector<Wrench<BodyFixed>> W(model.n_bodies());
  joint_wrenches(model, workspace, state.q, state.v, state.a, W);
  fmt::print(
      "\nwrench that joint \"{}\" transmits to \"{}\", drive and reaction, in the body's own axes; N m, N\n",
      model.joint(1).name, model.body(1).name);
  Table wrench({"m x", "m y", "m z", "f x", "f y", "f z"});
  wrench.row({W[0].m.x, W[0].m.y, W[0].m.z, W[0].f.x, W[0].f.y, W[0].f.z});
  fmt::print("{}", wrench.text());
}

RepresentationTimes show(const Model& model) {
  fmt::print("\n{}: {} moving bodies, nq = {}, nv = {}, {} kg\n{}", in(Ink::heading, model.name()),
             model.n_bodies(), model.nq(), model.nv(), significant(model.total_mass()), draw_limbs(model));
  std::fflush(stdout);
  const State state = random_state(model);
  const RepresentationTimes times(model, state);
  print_forces(model, times);
  return times;
}

void print_summary(const Table& table) {
  fmt::print("\n{}\n{}",
             in(Ink::heading, "time of one call of inverse dynamics, one thread, median; microseconds"),
             table.text());
}

}  // namespace

void show_demo() {
  const std::filesystem::path folder = robots_folder();
  const auto start = std::chrono::steady_clock::now();
  const Model arm = load(folder / "arm7.toml"), humanoid = load(folder / "humanoid.urdf", Base::free);
  const std::chrono::duration<double, std::milli> loading = std::chrono::steady_clock::now() - start;
  fmt::print("{}: robots from {}, loaded in {:.1f} ms\n", in(Ink::heading, "axode " AXODE_VERSION),
             folder.string(), loading.count());
  Table summary(
      {"robot", "bodies", "body-fixed", "spatial", "hybrid", "mixed", "fast", "difference / largest force"});
  double worst = 0;
  for (const Model* model : {&arm, &humanoid}) {
    const RepresentationTimes times = show(*model);
    if (model == &arm) {
      const State state = random_state(arm);
      print_tip(arm, state);
      print_reaction(arm, state);
    }
    const double difference = times.largest_spread() / times.largest();
    worst = std::max(worst, difference);
    summary.row({model->name(), std::to_string(model->n_bodies()), microseconds(times.time[0]),
                 microseconds(times.time[1]), microseconds(times.time[2]), microseconds(times.time[3]),
                 microseconds(times.time[4]), short_number(difference)});
  }
  print_summary(summary);
  const bool agree = worst <= 1e-11;
  fmt::print("\n{}\n",
             agree ? in(Ink::good, "The four representations agree to rounding. So does the fast path.")
                   : in(Ink::bad, "The four representations and the fast path do not agree."));
  if (!agree)
    throw std::runtime_error("representations differ by " + significant(worst, 2) + " of the largest force");
  fmt::print("Next: axode info {0}\n      axode eval {0} --want poses,twists --representation hybrid\n",
             (folder / "arm7.toml").string());
}

}  // namespace axode::command
