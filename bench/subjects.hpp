#pragma once
#include <benchmark/benchmark.h>

#include <random>
#include <string>
#include <vector>

#include "axode/axode.hpp"
#include "axode/eigen.hpp"
#include "axode/io.hpp"

#ifdef AXODE_BENCH_PINOCCHIO
#include <pinocchio/multibody.hpp>
#endif

/// What the benchmarks are run on: mechanisms and their states, and the same in Pinocchio.
namespace axode::bench {

inline std::mt19937_64 engine(1);
inline double random_number(double low, double high) {
  return std::uniform_real_distribution(low, high)(engine);
}
inline Vec3<> random_vector() { return {random_number(-1, 1), random_number(-1, 1), random_number(-1, 1)}; }

/// Hinges with axes in general position, one behind the other.
inline Model chain(int n) {
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

/// Chains of hinges, and the robots that the project ships, with their bases fixed.
inline const std::vector<Model>& models() {
  static const std::vector<Model> all{chain(7), chain(36), chain(100), load(AXODE_ROBOTS_DIR "/arm7.toml"),
                                      load(AXODE_ROBOTS_DIR "/humanoid.urdf", Base::fixed)};
  return all;
}

#ifdef AXODE_BENCH_PINOCCHIO
/// The same mechanism with every axis along z, for which Pinocchio has its fastest joints.
inline pinocchio::Model peer(const Model& model) {
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
    const Inertia<>& M = tree.M[i];
    if (M.m > 0)
      out.appendBodyToJoint(
          i, pinocchio::Inertia(M.m, to_eigen(center_of_mass(M)), to_eigen(inertia_about_com(M))));
  }
  return out;
}
inline std::vector<Eigen::VectorXd> vectors(const std::vector<std::vector<double>>& x, Eigen::Index first,
                                            Eigen::Index size) {
  std::vector<Eigen::VectorXd> out;
  for (const auto& x_s : x) out.push_back(Eigen::VectorXd::Map(x_s.data() + first, size));
  return out;
}
#endif

}  // namespace axode::bench
