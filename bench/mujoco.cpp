// Measures the functions of MuJoCo that correspond to those of axode, on the same mechanisms and states, through its C interface.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "bench/subjects.hpp"

namespace {

using namespace axode;
using namespace axode::bench;
static_assert(mjVERSION_HEADER >= 3010000, "the benchmarks need MuJoCo 3.10 or later");

/// The reason why a mechanism is not measured with MuJoCo.
struct LeftOut : std::runtime_error {
  using std::runtime_error::runtime_error;
};

const char* kind_in_mjcf(const Tree<double>& tree, int i) {
  if (tree->coupled[i]) throw LeftOut("a coupled joint would be a constraint");
  switch (tree->kind[i]) {
    case Subgroup::revolute: return "hinge";
    case Subgroup::prismatic: return "slide";
    case Subgroup::spherical: return "ball";
    case Subgroup::free:
      if (tree->parent[i] == 0) return "free";
      throw LeftOut("a free joint hangs on a moving body");
    default: throw LeftOut("it has no such joint");
  }
}

/// The mechanism in MuJoCo's format, with body frames in the joint frames. No forces act but those of drives,
/// gravity and inertia.
std::string mjcf(const Model& model) {
  const Tree<double>& tree = model.tree<double>();
  std::ostringstream out;
  out.precision(17);
  const auto numbers = [&out](const char* name, const auto&... x) {
    out << ' ' << name << "='", ((out << x << ' '), ...), out << '\'';
  };
  out << "<mujoco><compiler angle='radian' inertiafromgeom='false' balanceinertia='false' "
         "boundmass='0'/><option";
  numbers("gravity", tree.g.x, tree.g.y, tree.g.z);
  out << "><flag constraint='disable'/></option><worldbody>";
  std::vector<int> open{0};  // the elements that are open: the path from the ground to the previous body
  for (int i = 1; i <= tree->n; ++i) {
    for (; open.back() != tree->parent[i]; open.pop_back()) out << "</body>";
    open.push_back(i);
    const Vec3<>& r = tree.B[i].r;
    const Quaternion<> p = quaternion(tree.B[i].R);
    out << "<body";
    numbers("pos", r.x, r.y, r.z), numbers("quat", p.w, p.x, p.y, p.z);
    out << "><joint axis='0 0 1' type='" << kind_in_mjcf(tree, i) << '\'';
    numbers("armature", tree.armature[tree->iv[i]]);
    out << "/>";
    if (const Inertia<>& M = tree.M[i]; M.m > 0) {
      const Vec3<> c = center_of_mass(M);
      const Sym3<> Theta = inertia_about_com(M);
      out << "<inertial";
      numbers("mass", M.m), numbers("pos", c.x, c.y, c.z);
      numbers("fullinertia", Theta.xx, Theta.yy, Theta.zz, Theta.xy, Theta.xz, Theta.yz);
      out << "/>";
    }
  }
  for (; open.size() > 1; open.pop_back()) out << "</body>";
  out << "</worldbody></mujoco>";
  return out.str();
}

std::shared_ptr<const mjModel> compile(const std::string& text) {
  char error[1000] = "";
  const std::unique_ptr<mjSpec, void (*)(mjSpec*)> spec(
      mj_parseXMLString(text.c_str(), nullptr, error, sizeof error), mj_deleteSpec);
  if (!spec) throw LeftOut(error);
  mjModel* m = mj_compile(spec.get(), nullptr);
  if (!m) throw LeftOut(mjs_getError(spec.get()));
  return {m, mj_deleteModel};
}

using PeerData = std::unique_ptr<mjData, void (*)(mjData*)>;

/// A state in MuJoCo's coordinates. Positions stand before quaternions w x y z. The twist of a free base is
/// mixed, with its linear part before the angular one.
struct PeerState {
  std::vector<double> q, v, a, tau;

  PeerState(const Model& model, std::vector<double> q_, std::vector<double> v_, std::vector<double> a_,
            std::vector<double> tau_)
      : q(std::move(q_)), v(std::move(v_)), a(std::move(a_)), tau(std::move(tau_)) {
    const Tree<double>& tree = model.tree<double>();
    for (int i = 1; i <= tree->n; ++i) {
      double* const at = &q[tree->iq[i]];
      if (tree->kind[i] == Subgroup::spherical) std::rotate(at, at + 3, at + 4);
      if (tree->kind[i] == Subgroup::free) place(tree.B[i], at, tree->iv[i]);
    }
  }

 private:
  void place(const SE3<>& B, double* at, int iv) {
    const SE3<> C = subgroup::Free<double>::pose(B, at);
    const Quaternion<> p = quaternion(B.R) * subgroup::Free<double>::quaternion_of(at);
    const double numbers[]{C.r.x, C.r.y, C.r.z, p.w, p.x, p.y, p.z};
    std::copy(std::begin(numbers), std::end(numbers), at);
    const auto halves = [iv](const std::vector<double>& x) {
      return std::pair{Vec3<>{x[iv], x[iv + 1], x[iv + 2]}, Vec3<>{x[iv + 3], x[iv + 4], x[iv + 5]}};
    };
    const auto write = [iv](std::vector<double>& x, const Vec3<>& linear, const Vec3<>& angular) {
      const double both[]{linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
      std::copy(std::begin(both), std::end(both), &x[iv]);
    };
    const auto [w, vel] = halves(v);
    const auto [dw, dvel] = halves(a);
    const auto [moment, force] = halves(tau);
    const Twist<BodyFixed> V{w, vel};
    const Twist<Mixed> V_m = change<Mixed>(C, V);
    const TwistRate<Mixed> dV_m = change<Mixed>(C, V, TwistRate<BodyFixed>{dw, dvel});
    const Wrench<Mixed> W_m = change<Mixed>(C, Wrench<BodyFixed>{moment, force});
    write(v, V_m.v, V_m.w), write(a, dV_m.v, dV_m.w), write(tau, W_m.f, W_m.m);
  }
};

void set(const std::vector<double>& x, mjtNum* out) { std::copy(x.begin(), x.end(), out); }

void poses_of(const mjModel* m, mjData* d, const PeerState& x) {
  set(x.q, d->qpos);
  mj_kinematics(m, d);
}
/// The motion axes of all joints, about the centre of mass of their tree.
void axes_of(const mjModel* m, mjData* d, const PeerState& x) {
  poses_of(m, d, x);
  mj_comPos(m, d);
}
void sparse_mass_matrix_of(const mjModel* m, mjData* d, const PeerState& x) {
  axes_of(m, d, x);
  mj_makeM(m, d);
}
void mass_matrix_of(const mjModel* m, mjData* d, const PeerState& x, mjtNum* M) {
  sparse_mass_matrix_of(m, d, x);
  mj_fullM(m, d, M);
}
void inverse_dynamics_of(const mjModel* m, mjData* d, const PeerState& x, mjtNum* tau) {
  axes_of(m, d, x);
  set(x.v, d->qvel), set(x.a, d->qacc);
  mj_comVel(m, d);
  mj_rne(m, d, 1, tau);
  for (int k = 0; k < m->nv; ++k)
    tau[k] += m->dof_armature[k] * d->qacc[k];  // mj_inverse adds these forces
                                                // too
}
/// Computes the accelerations into qacc_smooth.
void forward_dynamics_of(const mjModel* m, mjData* d, const PeerState& x) {
  sparse_mass_matrix_of(m, d, x);
  mj_factorM(m, d);
  set(x.v, d->qvel), set(x.tau, d->qfrc_applied);
  mj_comVel(m, d);
  mj_rne(m, d, 0, d->qfrc_bias);
  mj_fwdAcceleration(m, d);
}

/// Throws an exception if two numbers differ by more than 1e-9 of the largest one.
void expect_equal(const char* what, std::span<const double> theirs, std::span<const double> ours) {
  double largest = 0;
  for (const double x : ours) largest = std::max(largest, std::abs(x));
  for (std::size_t k = 0; k < ours.size(); ++k) {
    const double difference = std::abs(theirs[k] - ours[k]);
    if (difference <= 1e-9 * largest) continue;
    std::ostringstream message;
    message << "its " << what << " differs from ours by " << difference / largest << " of the largest number";
    throw LeftOut(message.str());
  }
}

/// Throws an exception if MuJoCo computes other results than axode: inverse dynamics, the mass matrix column
/// by column, and the forces that belong to the accelerations of forward dynamics.
void expect_same_mechanism(const Model& model, const mjModel* m) {
  const PeerData d(mj_makeData(m), mj_deleteData);
  Workspace<> workspace(model);
  States states(model);
  const std::size_t s = states.next(), nv = static_cast<std::size_t>(model.nv());
  const std::vector<double>&q = states.q[s], &v = states.v[s], &a = states.a[s];
  std::vector<double> tau(nv), M(nv * nv), theirs(nv), M_theirs(nv * nv);

  inverse_dynamics(model, workspace, q, v, a, tau);
  PeerState x(model, q, v, a, tau);
  inverse_dynamics_of(m, d.get(), x, theirs.data());
  expect_equal("inverse dynamics", theirs, x.tau);

  forward_dynamics_of(m, d.get(), x);
  x.a.assign(d->qacc_smooth, d->qacc_smooth + nv);
  inverse_dynamics_of(m, d.get(), x, theirs.data());
  expect_equal("forward dynamics", theirs, x.tau);

  mass_matrix(model, workspace, q, M);
  mass_matrix_of(m, d.get(), x, M_theirs.data());
  for (std::size_t c = 0; c < nv; ++c) {
    std::vector<double> unit(nv);
    unit[c] = 1;
    const auto column = M.begin() + static_cast<std::ptrdiff_t>(c * nv);
    const PeerState y(model, q, unit, a, {column, column + static_cast<std::ptrdiff_t>(nv)});
    mju_mulMatVec(theirs.data(), M_theirs.data(), y.v.data(), model.nv(), model.nv());
    expect_equal("mass matrix", theirs, y.tau);
  }
}

/// The mechanisms that MuJoCo accepts and for which it computes the same. Prints which mechanisms are left
/// out.
const std::vector<std::pair<Model, std::shared_ptr<const mjModel>>>& peers() {
  static const auto all = [] {
    std::vector<std::pair<Model, std::shared_ptr<const mjModel>>> out;
    for (const Model& model : models()) try {
        std::shared_ptr<const mjModel> m = compile(mjcf(model));
        expect_same_mechanism(model, m.get());
        out.emplace_back(model, std::move(m));
      } catch (const LeftOut& reason) {
        const std::string why = reason.what();
        std::fprintf(stderr, "%s is not measured with MuJoCo: %s\n", model.name().c_str(),
                     why.substr(0, why.find('\n')).c_str());
      }
    return out;
  }();
  return all;
}

/// Measures f(model, data, state, out) of MuJoCo for every model; `out` has room for two square matrices.
template <class F> void measure_peer(const std::string& function, const F& f) {
  for (const auto& [subject, compiled] : peers())
    measure(function, "mujoco",
            [f, m = compiled](benchmark::State& state, const Model& model) {
              const PeerData d(mj_makeData(m.get()), mj_deleteData);
              States states(model);
              std::vector<PeerState> x;
              for (std::size_t s = 0; s < States::count; ++s)
                x.emplace_back(model, states.q[s], states.v[s], states.a[s], states.a[s]);
              std::vector<mjtNum> out(static_cast<std::size_t>(2 * m->nv * std::max(model.nv(), 3)));
              repeat(state, out.data(), [&] { f(m.get(), d.get(), x[states.next()], out.data()); });
            },
            {subject});
}

const bool registered = [] {
  using M = mjModel;
  using D = mjData;
  using X = PeerState;
  measure_peer("inverse_dynamics", inverse_dynamics_of);
  measure_peer("forward_dynamics",
               [](const M* m, D* d, const X& x, mjtNum*) { forward_dynamics_of(m, d, x); });
  measure_peer("mass_matrix", mass_matrix_of);
  measure_peer("inverse_mass_matrix", [](const M* m, D* d, const X& x, mjtNum* out) {
    sparse_mass_matrix_of(m, d, x);
    mj_factorM(m, d);
    const int nv = static_cast<int>(m->nv);
    mjtNum* const unit = out + nv * nv;
    mju_eye(unit, nv);
    mj_solveM(m, d, out, unit, nv);
  });
  measure_peer("joint_jacobians", [](const M* m, D* d, const X& x, mjtNum*) { axes_of(m, d, x); });
  measure_peer("body_jacobians", [](const M* m, D* d, const X& x, mjtNum* out) {
    axes_of(m, d, x);
    for (int i = 1; i < m->nbody; ++i) {
      mj_jacBody(m, d, out, out + 3 * m->nv, i);
      benchmark::ClobberMemory();
    }
  });
  measure_peer("poses", [](const M* m, D* d, const X& x, mjtNum*) { poses_of(m, d, x); });
  return true;
}();

}  // namespace
