// Measures the functions of Pinocchio that correspond to those of axode, on the same mechanisms and states.
#include <pinocchio/multibody.hpp>

#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/constrained-dynamics.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/loop-constrained-aba.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea-second-order-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include "axode/constraints.hpp"
#include "axode/eigen.hpp"
#include "bench/subjects.hpp"

namespace {

using namespace axode;
using namespace axode::bench;
using pinocchio::Data;

/// The mechanism in Pinocchio, with every axis along z, because its joints about z are the fastest ones.
pinocchio::Model peer(const Model& model) {
  const Tree<double>& tree = model.tree<double>();
  pinocchio::Model out;
  for (int i = 1; i <= tree->n; ++i) {
    const SE3<>& B = tree.B[i];
    const pinocchio::SE3 placement(to_eigen(B.R), to_eigen(B.r));
    const std::string& name = model.joint(i).name;
    switch (tree->kind[i]) {
      case Subgroup::revolute:
        out.addJoint(tree->parent[i], pinocchio::JointModelRZ(), placement, name);
        break;
      case Subgroup::prismatic:
        out.addJoint(tree->parent[i], pinocchio::JointModelPZ(), placement, name);
        break;
      case Subgroup::free:
        out.addJoint(tree->parent[i], pinocchio::JointModelFreeFlyer(), placement, name);
        break;
      default: throw std::logic_error("no such joint in the benchmarks");
    }
    const Inertia<>& M = tree.M[i];
    if (M.m > 0) out.appendBodyToJoint(i, {M.m, to_eigen(center_of_mass(M)), to_eigen(inertia_about_com(M))});
  }
  return out;
}

/// States in Pinocchio's order: positions before quaternions, linear parts before angular ones.
struct PeerStates {
  using Sequence = std::vector<std::vector<double>>;
  std::vector<Eigen::VectorXd> q, v, a;

  PeerStates(const Model& model, const States& states) : PeerStates(model, states.q, states.v, states.a) {}
  PeerStates(const Model& model, const Sequence& q_, const Sequence& v_, const Sequence& a_) {
    for (std::size_t s = 0; s < States::count; ++s) {
      q.push_back(Eigen::VectorXd::Map(q_[s].data(), model.nq()));
      v.push_back(Eigen::VectorXd::Map(v_[s].data(), model.nv()));
      a.push_back(Eigen::VectorXd::Map(a_[s].data(), model.nv()));
      if (model.joint(1).kind != Subgroup::free) continue;
      const Eigen::Matrix<double, 7, 1> base = q.back().head<7>();
      q.back().head<7>() << base.tail<3>(), base.head<4>();
      for (Eigen::VectorXd* x : {&v.back(), &a.back()}) x->head<3>().swap(x->segment<3>(3));
    }
  }
};

/// Measures f(model, data, q, v, a) of Pinocchio for every model.
template <class F>
void measure_peer(const std::string& function, const F& f, const std::vector<Model>& subjects = models()) {
  measure(
      function, "pinocchio",
      [f](benchmark::State& state, const Model& model) {
        const pinocchio::Model other = peer(model);
        Data data(other);
        States states(model);
        const PeerStates x(model, states);
        repeat(state, &data, [&] {
          const std::size_t s = states.next();
          f(other, data, x.q[s], x.v[s], x.a[s]);
        });
      },
      subjects);
}

/// The loops of a mechanism in Pinocchio, all of them spherical, and the settings with which it solves for
/// their forces.
struct PeerLoops {
  std::vector<pinocchio::RigidConstraintModel> models;
  std::vector<pinocchio::RigidConstraintData> data;
  pinocchio::ProximalSettings settings;

  PeerLoops(const Model& model, const pinocchio::Model& other, const pinocchio::ProximalSettings& how)
      : settings(how) {
    const auto placement = [](const Loop::End& end) {
      return pinocchio::SE3(to_eigen(end.F.R), to_eigen(end.F.r));
    };
    for (const Loop& loop : model.loops().joints) {
      if (loop.kind != LoopKind::spherical) throw std::logic_error("no such loop in the benchmarks");
      const auto& [i, j] = loop.ends;
      models.emplace_back(pinocchio::CONTACT_3D, other, i.body, placement(i), j.body, placement(j));
    }
    for (const auto& loop : models) data.emplace_back(loop);
  }
};

/// The largest difference between Pinocchio's accelerations and ours, relative to the largest acceleration.
double difference(const ClosedMechanism& mechanism, const ClosedStates& states, std::size_t s,
                  Eigen::VectorXd theirs) {
  const Model& model = mechanism.model;
  LoopWorkspace<> workspace(model);
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv());
  const std::span q(states.q[s]), v(states.v[s]), tau(states.tau[s]);
  Eigen::VectorXd a(model.nv());
  benchmark::DoNotOptimize(forward_dynamics<double>(model, workspace, q.first(nq), v.first(nv), tau.first(nv),
                                                    std::span(a.data(), nv)));
  theirs.head<3>().swap(theirs.segment<3>(3));  // for the free body
  return (theirs.head(model.nv()) - a).cwiseAbs().maxCoeff() / a.cwiseAbs().maxCoeff();
}

/// Measures init(model, data, loops) and solve(model, data, q, v, tau, loops) of Pinocchio for the mechanisms
/// for which it finds the same accelerations as axode.
template <class Init, class Solve>
void measure_constrained_peer(const std::string& variant, const pinocchio::ProximalSettings& settings,
                              const Init& init, const Solve& solve) {
  for (const ClosedMechanism& mechanism : closed_mechanisms())
    measure("constrained_forward_dynamics", variant,
            [&mechanism, settings, init, solve](benchmark::State& state, const Model&) {
              const Model& model = mechanism.of_balls;
              const pinocchio::Model other = peer(model);
              Data data(other);
              PeerLoops loops(model, other, settings);
              ClosedStates states(mechanism);
              const PeerStates x(model, states.q, states.v, states.tau);
              init(other, data, loops);
              for (std::size_t s = 0; s < States::count; ++s) {
                solve(other, data, x.q[s], x.v[s], x.a[s], loops);
                if (!(difference(mechanism, states, s, data.ddq) < 1e-6))
                  return state.SkipWithError("its accelerations are others");
              }
              repeat(state, &data, [&] {
                const std::size_t s = states.next();
                solve(other, data, x.q[s], x.v[s], x.a[s], loops);
              });
            },
            {mechanism.model});
}

const bool registered = [] {
  using namespace pinocchio;
  using M = pinocchio::Model;
  using V = Eigen::VectorXd;
  measure_peer("inverse_dynamics",
               [](const M& m, Data& d, const V& q, const V& v, const V& a) { rnea(m, d, q, v, a); });
  measure_peer("forward_dynamics",
               [](const M& m, Data& d, const V& q, const V& v, const V& tau) { aba(m, d, q, v, tau); });
  measure_peer("mass_matrix", [](const M& m, Data& d, const V& q, const V&, const V&) { crba(m, d, q); });
  measure_peer("inverse_mass_matrix",
               [](const M& m, Data& d, const V& q, const V&, const V&) { computeMinverse(m, d, q); });
  measure_peer("joint_jacobians",
               [](const M& m, Data& d, const V& q, const V&, const V&) { computeJointJacobians(m, d, q); });
  measure_peer("poses",
               [](const M& m, Data& d, const V& q, const V&, const V&) { forwardKinematics(m, d, q); });
  measure_peer("body_jacobians",
               [J = std::make_shared<Data::Matrix6x>()](const M& m, Data& d, const V& q, const V&, const V&) {
                 computeJointJacobians(m, d, q);
                 for (std::size_t i = 1; i < m.joints.size(); ++i) {
                   J->setZero(6, m.nv);
                   getJointJacobian(m, d, i, LOCAL_WORLD_ALIGNED, *J);
                   benchmark::ClobberMemory();
                 }
               });
  measure_peer("twists",
               [](const M& m, Data& d, const V& q, const V& v, const V&) { forwardKinematics(m, d, q, v); });
  measure_peer("accelerations", [](const M& m, Data& d, const V& q, const V& v, const V& a) {
    forwardKinematics(m, d, q, v, a);
  });
  measure_peer("inverse_dynamics_derivatives", [](const M& m, Data& d, const V& q, const V& v, const V& a) {
    computeRNEADerivatives(m, d, q, v, a);
  });
  measure_peer("forward_dynamics_derivatives", [](const M& m, Data& d, const V& q, const V& v, const V& tau) {
    computeABADerivatives(m, d, q, v, tau);
  });
  measure_peer(
      "inverse_dynamics_second_derivatives",
      [](const M& m, Data& d, const V& q, const V& v, const V& a) {
        ComputeRNEASecondOrderDerivatives(m, d, q, v, a);
      },
      small_models());
  using L = PeerLoops;
  measure_constrained_peer(  // the rows are independent, so that nothing is added to the diagonal and one
                             // step is enough
      "pinocchio", {1e-12, 0, 1},
      [](const M& m, Data& d, const L& l) { initConstraintDynamics(m, d, l.models, l.data); },
      [](const M& m, Data& d, const V& q, const V& v, const V& tau, L& l) {
        constraintDynamics(m, d, q, v, tau, l.models, l.data, l.settings);
      });
  measure_constrained_peer(  // with less than 1e-8 on the diagonal it loses digits, with more it needs more
                             // steps
      "lcaba", {1e-12, 1e-8, 10},
      [](const M& m, Data& d, const L& l) { computeJointMinimalOrdering(m, d, l.models); },
      [](const M& m, Data& d, const V& q, const V& v, const V& tau, L& l) {
        lcaba(m, d, q, v, tau, l.models, l.data, l.settings);
      });
  return true;
}();

}  // namespace
