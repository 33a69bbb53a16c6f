// All joint Jacobians at once, accelerations, and jerk of all bodies, in one thread, on states drawn at
// random.
#include <benchmark/benchmark.h>

#include <array>
#include <random>
#include <string>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

#ifdef AXODE_BENCH_PINOCCHIO
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/multibody.hpp>
#endif

namespace {

using namespace axode;

std::mt19937_64 engine(1);
double random_number(double low, double high) { return std::uniform_real_distribution(low, high)(engine); }
Vec3<> random_vector() { return {random_number(-1, 1), random_number(-1, 1), random_number(-1, 1)}; }

/// Hinges with axes in general position, one behind the other.
Model chain(int n) {
  ModelBuilder builder("chain" + std::to_string(n));
  for (int i = 1; i <= n; ++i)
    builder.add(
        {.name = std::to_string(i),
         .predecessor = i == 1 ? "ground" : std::to_string(i - 1),
         .joint = {.kind = JointKind::revolute, .axis = random_vector(), .point = 0.1 * random_vector()},
         .geometry = InBodyFrame{exp(Screw<>{random_vector(), 0.3 * random_vector()})},
         .inertia = MassProperties{.mass = 1, .com = 0.1 * random_vector(), .Theta = {.1, .1, .1, 0, 0, 0}}});
  return builder.build();
}

/// More states than a cache line holds, so that no branch or value is predicted from the run before.
struct States {
  static constexpr std::size_t count = 64;
  std::vector<std::vector<double>> q, rates;
  std::size_t k = 0;

  States(const Model& model, int orders) {
    for (std::size_t s = 0; s < count; ++s) {
      q.push_back(random_configuration(model, s));
      rates.emplace_back(static_cast<std::size_t>(orders * model.nv()));
      for (double& x : rates.back()) x = random_number(-1, 1);
    }
  }
  std::size_t next() { return k = (k + 1) % count; }
};

void joint_screws_of_all(benchmark::State& state, const Model& model) {
  Workspace<> workspace(model);
  States states(model, 1);
  std::vector<Twist<Spatial>> J(static_cast<std::size_t>(model.n_screws()));
  for (auto _ : state) {
    joint_screws(model, workspace, states.q[states.next()], J);
    benchmark::DoNotOptimize(J.data());
    benchmark::ClobberMemory();
  }
}

template <class Rep> void accelerations_of_all(benchmark::State& state, const Model& model) {
  Workspace<> workspace(model);
  States states(model, 2);
  std::vector<TwistRate<Rep>> dV(static_cast<std::size_t>(model.n_frames()));
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  for (auto _ : state) {
    const std::size_t s = states.next();
    const std::span<const double> rates = states.rates[s];
    accelerations<Rep>(model, workspace, states.q[s], rates.first(nv), rates.last(nv), dV);
    benchmark::DoNotOptimize(dV.data());
    benchmark::ClobberMemory();
  }
}

template <class Rep> void jerk_of_all(benchmark::State& state, const Model& model) {
  HigherOrderMotion<> motion(model, 2);
  States states(model, 3);
  std::vector<TwistRate<Rep>> jerk(static_cast<std::size_t>(model.n_bodies() + 1));
  for (auto _ : state) {
    const std::size_t s = states.next();
    motion.evaluate(states.q[s], states.rates[s]);
    for (int i = 1; i <= model.n_bodies(); ++i) jerk[i] = motion.template twist_derivative<Rep>(i, 2);
    benchmark::DoNotOptimize(jerk.data());
    benchmark::ClobberMemory();
  }
}

#ifdef AXODE_BENCH_PINOCCHIO
/// The same mechanism with every axis along z, for which Pinocchio has its fastest joints.
pinocchio::Model peer(const Model& model) {
  const Tree<double>& tree = model.tree<double>();
  pinocchio::Model out;
  for (int i = 1; i <= tree.n; ++i) {
    const SE3<>& B = tree.B[i];
    Eigen::Matrix3d R;
    R << B.R.x.x, B.R.y.x, B.R.z.x, B.R.x.y, B.R.y.y, B.R.z.y, B.R.x.z, B.R.y.z, B.R.z.z;
    const pinocchio::SE3 placement(R, Eigen::Vector3d(B.r.x, B.r.y, B.r.z));
    if (tree.kind[i] == Subgroup::revolute)
      out.addJoint(tree.parent[i], pinocchio::JointModelRZ(), placement, model.joint(i).name);
    else
      out.addJoint(tree.parent[i], pinocchio::JointModelPZ(), placement, model.joint(i).name);
  }
  return out;
}
std::vector<Eigen::VectorXd> vectors(const std::vector<std::vector<double>>& x, Eigen::Index first,
                                     Eigen::Index size) {
  std::vector<Eigen::VectorXd> out;
  for (const auto& x_s : x) out.push_back(Eigen::VectorXd::Map(x_s.data() + first, size));
  return out;
}

void peer_joint_jacobians(benchmark::State& state, const Model& model) {
  const pinocchio::Model other = peer(model);
  pinocchio::Data data(other);
  States states(model, 1);
  const auto q = vectors(states.q, 0, model.nq());
  for (auto _ : state) {
    pinocchio::computeJointJacobians(other, data, q[states.next()]);
    benchmark::DoNotOptimize(data.J.data());
    benchmark::ClobberMemory();
  }
}
void peer_accelerations(benchmark::State& state, const Model& model) {
  const pinocchio::Model other = peer(model);
  pinocchio::Data data(other);
  States states(model, 2);
  const auto q = vectors(states.q, 0, model.nq()), v = vectors(states.rates, 0, model.nv()),
             a = vectors(states.rates, model.nv(), model.nv());
  for (auto _ : state) {
    const std::size_t s = states.next();
    pinocchio::forwardKinematics(other, data, q[s], v[s], a[s]);
    benchmark::DoNotOptimize(data.a.data());
    benchmark::ClobberMemory();
  }
}
#endif

const std::array models{chain(7), chain(36), chain(100), load(AXODE_ROBOTS_DIR "/arm7.toml"),
                        load(AXODE_ROBOTS_DIR "/humanoid.urdf")};

const bool registered = [] {
  for (const Model& model : models) {
    const auto add = [&](const std::string& name, void (*run)(benchmark::State&, const Model&)) {
      benchmark::RegisterBenchmark((name + "/" + model.name()).c_str(), run, model);
    };
    add("joint_screws/spatial", joint_screws_of_all);
    add("accelerations/body", accelerations_of_all<BodyFixed>);
    add("accelerations/hybrid", accelerations_of_all<Hybrid>);
    add("jerk/spatial", jerk_of_all<Spatial>);
    add("jerk/hybrid", jerk_of_all<Hybrid>);
#ifdef AXODE_BENCH_PINOCCHIO
    add("joint_screws/pinocchio", peer_joint_jacobians);
    add("accelerations/pinocchio", peer_accelerations);
#endif
  }
  return true;
}();

}  // namespace
