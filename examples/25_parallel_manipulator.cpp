// A parallel manipulator in its task space: a Gough platform whose six drives are elastic follows a motion of
// its plate in open loop. Such a machine is flat: the motion of the plate, up to the fourth derivative of its
// pose, determines the motors' positions and forces. Without the second derivative of the drive forces it
// would be off.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "axode/axode.hpp"
#include "axode/constraints.hpp"
#include "axode/drives.hpp"
#include "axode/io.hpp"

using namespace axode;
using Vector = std::vector<double>;

constexpr double stiffness = 5e5, inertia = 20;  // of each drive and its motor, N/m and kg, along the leg
constexpr double pi = 3.14159265358979323846;

/// The twist of the plate, which moves without turning, and its first three time derivatives.
Vector twist_and_rates(double t) {
  const double amplitude[]{0.05, -0.03, 0.08}, rhythm[]{7, 9, 11};
  Vector rows(4 * 6);
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t i = 0; i < 3; ++i)
      rows[6 * k + 3 + i] = amplitude[i] * std::pow(rhythm[i], static_cast<double>(k) + 1) *
                            std::sin(rhythm[i] * t + static_cast<double>(k) * pi / 2);
  return rows;
}
/// The pose that belongs to this twist.
SE3<> pose_at(double t) {
  return {{}, {0.05 * (1 - std::cos(7 * t)), -0.03 * (1 - std::cos(9 * t)), 0.08 * (1 - std::cos(11 * t))}};
}

struct Machine {
  Model model = load(AXODE_ROBOTS_DIR "/gough.toml");
  TaskSpace space{model, neutral(model)};
  ElasticFeedForward elastic = with_stiffness(stiffness),
                     rigid = with_stiffness(std::numeric_limits<double>::infinity());
  std::vector<std::size_t> drives;  ///< velocities of the drives
  std::vector<std::size_t> legs;    ///< coordinates of the drives

  Machine() {
    for (const Joint& joint : model.joints()) {
      if (joint.passive || joint.kind != Subgroup::prismatic) continue;
      drives.push_back(static_cast<std::size_t>(joint.iv));
      legs.push_back(static_cast<std::size_t>(joint.iq));
    }
  }
  ElasticFeedForward with_stiffness(double k) const {
    return {model, std::vector<ElasticDrive>(static_cast<std::size_t>(model.nv()), {k, inertia})};
  }
};

/// The state of platform and motors, or its rate: coordinates, twist, motors, rates of the motors.
struct State {
  Vector q, V, theta, omega;
  State plus(double h, const State& rate) const {
    State out = *this;
    const auto add = [h](Vector& to, const Vector& from) {
      for (std::size_t k = 0; k < to.size(); ++k) to[k] += h * from[k];
    };
    add(out.q, rate.q), add(out.V, rate.V), add(out.theta, rate.theta), add(out.omega, rate.omega);
    return out;
  }
};

/// The positions, velocities and forces of the motors for the motion of the plate at a time. The forces are
/// computed with u'' or without it, as if the drives were rigid.
struct FeedForward {
  Vector q, theta, omega, force;
  FeedForward(Machine& machine, double t, bool with_springs, Vector near) : q(std::move(near)) {
    ElasticFeedForward& drives = with_springs ? machine.elastic : machine.rigid;
    MotorMotion motors;
    const bool found = place_platform(machine.space, pose_at(t), q).reached &&
                       drives.evaluate(machine.space, q, twist_and_rates(t), motors).ok();
    if (!found) std::puts("the motion cannot be made");
    for (const std::size_t c : machine.drives) {
      theta.push_back(motors.position[c]);
      omega.push_back(motors.velocity[c]);
      force.push_back(motors.force[c]);
    }
  }
};

State rate_of(Machine& machine, const State& x, const Vector& force) {
  Vector v(static_cast<std::size_t>(machine.model.nv())), tau(v.size());
  State rate{{}, Vector(6), x.omega, Vector(6)};
  for (std::size_t k = 0; k < 6; ++k) {
    const double spring = stiffness * (x.theta[k] - x.q[machine.legs[k]]);
    tau[machine.drives[k]] = spring;
    rate.omega[k] = (force[k] - spring) / inertia;
  }
  const bool moves =
      machine.space.velocities(x.q, x.V, v).ok() && machine.space.forward_dynamics(x.q, v, tau, rate.V).ok();
  if (!moves) std::puts("the platform is singular");
  rate.q = coordinate_rates(machine.model, x.q, v);
  return rate;
}

/// The largest error of the plate's position in m, in open loop, by the method of Runge and Kutta.
double largest_error(Machine& machine, bool with_springs) {
  constexpr double step = 5e-4;
  const FeedForward start(machine, 0, true, neutral(machine.model));
  State x{start.q, Vector(6), start.theta, start.omega};
  double worst = 0;
  for (int n = 0; n < 600; ++n) {
    const double t = step * n;
    const auto force = [&](double at) { return FeedForward(machine, at, with_springs, x.q).force; };
    const Vector now = force(t), middle = force(t + step / 2), end = force(t + step);
    const State k1 = rate_of(machine, x, now), k2 = rate_of(machine, x.plus(step / 2, k1), middle),
                k3 = rate_of(machine, x.plus(step / 2, k2), middle),
                k4 = rate_of(machine, x.plus(step, k3), end);
    x = x.plus(step / 6, k1).plus(step / 3, k2).plus(step / 3, k3).plus(step / 6, k4);
    const SE3<> wanted = pose_at(t + step);
    Workspace<> workspace(machine.model);
    std::vector<SE3<>> C(static_cast<std::size_t>(machine.model.n_frames()));
    Vector q = neutral(machine.model);
    std::copy_n(x.q.begin(), 7, q.begin());  // the coordinates of the plate
    poses<double>(machine.model, workspace, normalize(machine.model, q), C);
    const SE3<> reached = C[static_cast<std::size_t>(machine.space.platform())];
    worst = std::max(worst, norm(reached.r - wanted.r));
    if (!place_platform(machine.space, reached, x.q).reached) std::puts("a leg does not reach the plate");
  }
  return worst;
}

int main() {
  Machine machine;
  std::printf("task velocities:");
  for (const std::string& name : machine.space.names()) std::printf(" %s", name.c_str());
  std::printf("\nlimbs: %d\n", machine.space.limbs());

  const double without = largest_error(machine, false), with = largest_error(machine, true);
  std::printf("largest error of the plate in 0.3 s of open loop: %.1e m without u'', %.1e m with it\n",
              without, with);

  Vector q = neutral(machine.model);
  for (const double angle : {0.5, 1.0, pi / 2})
    if (!place_platform(machine.space, exp(Screw<>{{0, 0, angle}, {}}), q).reached) return 1;
  for (const TaskSingularity& found : singularities(machine.space, q))
    std::printf("turned by 90 degrees: %s\n", found.sentence.c_str());
  return with < 1e-6 && without > 10 * with ? 0 : 1;
}
