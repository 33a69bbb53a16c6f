#include "axode/dynamics/closed_form/closed_form.hpp"

#include <stdexcept>

#include "axode/eigen.hpp"
#include "axode/kinematics.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/kinematics/system_matrices.hpp"
#include "axode/lie/newton_euler.hpp"

namespace axode::closed_form {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

std::vector<SE3<>> frame_poses(const Model& model, std::span<const double> q) {
  Workspace<> workspace(model);
  std::vector<SE3<>> C(static_cast<std::size_t>(model.n_frames()));
  poses(model, workspace, q, C);
  return C;
}

template <class Rep> MatrixXd jacobian(const Model& model, std::span<const double> q) {
  const SystemMatrices system = system_matrices<Rep>(model, q);
  return system.A * system.X;
}

/// The 6×6 inertia matrix in representation Rep of a body with pose C and inertia M in its own frame.
template <class Rep> Matrix6<double> inertia_matrix(const SE3<>& C, const Inertia<>& M) {
  if constexpr (std::same_as<Rep, Spatial>) return to_eigen(transform(C, M));
  if constexpr (std::same_as<Rep, Hybrid>) return to_eigen(transform(C.R, M));
  Matrix6<double> M_i = to_eigen(M);
  if constexpr (std::same_as<Rep, Mixed>) {
    M_i.topRightCorner<3, 3>() *= to_eigen(C.R).transpose();
    M_i.bottomLeftCorner<3, 3>().applyOnTheLeft(to_eigen(C.R));
  }
  return M_i;
}

/// The applied wrenches W_i^app of all bodies, gravity included, stacked in one vector.
template <class Rep>
VectorXd applied_wrenches(const Model& model, const std::vector<SE3<>>& C, const Vec3<>& g,
                          const Loads<double>& loads) {
  VectorXd W(6 * model.n_bodies());
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const TwistRate<BodyFixed> falling{{}, transpose(C[i].R) * g};
    W.segment<6>(6 * (i - 1)) = to_eigen(change<Rep>(C[i], model.body(i).M * falling));
  }
  for (const AppliedWrench<double>& load : loads.wrenches) {
    const int i = model.frame(load.frame).body;
    if (i == 0) continue;
    const Wrench<Spatial> W_s = with_representation(load.representation, [&](auto rep) {
      const SE3<>& C_f = C[load.frame];
      return change<Spatial>(C_f, change<BodyFixed>(C_f, Wrench<decltype(rep)>{load.m, load.f}));
    });
    W.segment<6>(6 * (i - 1)) += to_eigen(change<Rep>(C[i], change<BodyFixed>(C[i], W_s)));
  }
  return W;
}

/// The generalised forces τ (nv) that drives must supply to accelerate the armatures with the accelerations a
/// and, if loads.joint_losses is set, to overcome damping and dry friction at the velocities v.
VectorXd joint_forces(const Model& model, std::span<const double> v, std::span<const double> a,
                      const Loads<double>& loads) {
  const Tree<double>& tree = model.tree<double>();
  VectorXd tau(tree->nv);
  for (int c = 0; c < tree->nv; ++c) {
    tau[c] = tree.armature[c] * a[c];
    if (loads.joint_losses)
      tau[c] += tree.damping[c] * v[c] + tree.friction[c] * double((v[c] > 0) - (v[c] < 0));
  }
  return tau;
}

void check(const Model& model, std::span<const double> q, std::span<const double> v,
           std::span<const double> a, const Loads<double>& loads) {
  check_configuration(model, q);
  check_size("v", v.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_size("a", a.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_loads(model, loads);
}

/// Calls f(i, V, V') for every body i with its twist V and twist rate V' in representation Rep.
template <class Rep, class F>
void each_motion(const Model& model, std::span<const double> q, std::span<const double> v,
                 std::span<const double> a, F&& f) {
  const VectorXd V = system_twist<Rep>(model, q, v), dV = system_acceleration<Rep>(model, q, v, a);
  for (int i = 1; i <= model.n_bodies(); ++i)
    f(i, from_eigen<Twist<Rep>>(V.segment<6>(6 * (i - 1))),
      from_eigen<TwistRate<Rep>>(dV.segment<6>(6 * (i - 1))));
}

}  // namespace

template <RecursionRepresentation Rep>
MatrixXd inertia_matrix(const Model& model, std::span<const double> q) {
  const std::vector<SE3<>> C = frame_poses(model, q);
  MatrixXd M = MatrixXd::Zero(6 * model.n_bodies(), 6 * model.n_bodies());
  for (int i = 1; i <= model.n_bodies(); ++i)
    M.block<6, 6>(6 * (i - 1), 6 * (i - 1)) = inertia_matrix<Rep>(C[i], model.body(i).M);
  return M;
}

template <RecursionRepresentation Rep>
VectorXd projection_equations(const Model& model, std::span<const double> q, std::span<const double> v,
                              std::span<const double> a, const Loads<double>& loads) {
  check(model, q, v, a, loads);
  const std::vector<SE3<>> C = frame_poses(model, q);
  VectorXd W = -applied_wrenches<Rep>(model, C, model.gravity(), loads);
  each_motion<Rep>(model, q, v, a, [&](int i, const Twist<Rep>& V, const TwistRate<Rep>& dV) {
    W.segment<6>(6 * (i - 1)) += to_eigen(wrench(C[i], model.body(i).M, V, dV));
  });
  return jacobian<Rep>(model, q).transpose() * W + joint_forces(model, v, a, loads);
}

VectorXd momentum_balance(const Model& model, std::span<const double> q, std::span<const double> v,
                          std::span<const double> a, const Loads<double>& loads) {
  check(model, q, v, a, loads);
  const std::vector<SE3<>> C = frame_poses(model, q);
  VectorXd W = -applied_wrenches<Spatial>(model, C, model.gravity(), loads);
  each_motion<Spatial>(model, q, v, a, [&](int i, const Twist<Spatial>& V, const TwistRate<Spatial>& dV) {
    const Inertia<> M = transform(C[i], model.body(i).M), dM = inertia_rate(V, M);
    W.segment<6>(6 * (i - 1)) += to_eigen(M * dV) + to_eigen(dM * V);  // Π' = M V' + M' V
  });
  return jacobian<Spatial>(model, q).transpose() * W + joint_forces(model, v, a, loads);
}

template <RecursionRepresentation Rep> MatrixXd mass_matrix(const Model& model, std::span<const double> q) {
  const MatrixXd J = jacobian<Rep>(model, q);
  MatrixXd M = J.transpose() * inertia_matrix<Rep>(model, q) * J;
  M.diagonal() += as_eigen(std::span(model.tree<double>().armature));
  return M;
}

MatrixXd coriolis_matrix(const Model& model, std::span<const double> q, std::span<const double> v,
                         CoriolisForm form) {
  check_configuration(model, q);
  check_size("v", v.size(), static_cast<std::size_t>(model.nv()), "nv");
  if (form == CoriolisForm::christoffel) {
    const Eigen::Index nv = model.nv();
    Workspace<> workspace(model);
    std::vector<double> Gamma(static_cast<std::size_t>(nv * nv * nv));
    axode::christoffel(model, workspace, q, Gamma);
    MatrixXd C(nv, nv);
    for (Eigen::Index i = 0; i < nv; ++i)
      C.row(i) = Eigen::Map<const MatrixXd>(Gamma.data() + i * nv * nv, nv, nv).transpose() * as_eigen(v);
    return C;
  }
  if (form == CoriolisForm::spatial) {
    const auto [A, D, X] = system_matrices<Spatial>(model, q);
    const MatrixXd M = inertia_matrix<Spatial>(model, q);
    const SystemMatrix b = b_matrix(model, system_twist<Spatial>(model, q, v));
    const MatrixXd J = A * X, dJ = A * b * X;
    MatrixXd C = M * dJ;
    C -= b.transpose() * M * J;
    return J.transpose() * C;
  }
  const auto [A, D, X] = system_matrices<BodyFixed>(model, q);
  const MatrixXd M = inertia_matrix<BodyFixed>(model, q), J = A * X;
  const SystemMatrix b = b_matrix(model, system_twist<BodyFixed>(model, q, v));
  const SystemMatrix a = a_matrix(model, v) * D;  // = a if all joints have one degree of freedom: a X = 0
  MatrixXd C = M * A * a;
  C += b.transpose() * M;
  if (form != CoriolisForm::paper) C -= M * b;
  return -(J.transpose() * C * J);
}

VectorXd lagrange_equations(const Model& model, std::span<const double> q, std::span<const double> v,
                            std::span<const double> a, const Loads<double>& loads) {
  check(model, q, v, a, loads);
  const MatrixXd M = mass_matrix<BodyFixed>(model, q), C = coriolis_matrix(model, q, v, CoriolisForm::paper);
  const VectorXd Q = jacobian<BodyFixed>(model, q).transpose() *
                     applied_wrenches<BodyFixed>(model, frame_poses(model, q), model.gravity(), loads);
  const std::vector<double> at_rest(a.size());
  return M * as_eigen(a) + C * as_eigen(v) - Q + joint_forces(model, v, at_rest, loads);
}

std::vector<double> christoffel(const Model& model, std::span<const double> q) {
  for (const Joint& joint : model.joints())
    if (joint.dof.size() != 1)
      throw std::invalid_argument("joint \"" + joint.name + "\" has " + std::to_string(joint.dof.size()) +
                                  " degrees of freedom; Binet's form of the Christoffel symbols needs 1");
  check_configuration(model, q);
  const int n = model.n_bodies();
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  std::vector<double> Gamma(nv * nv * nv);
  const std::vector<SE3<>> C = frame_poses(model, q);
  for (int l = 1; l <= n; ++l) {
    const Inertia<>& M = model.body(l).M;
    const Vec3<>& h = M.h;
    Eigen::Matrix4d P;
    P << to_eigen(binet_tensor(M.Theta)), to_eigen(h), to_eigen(h).transpose(), M.m;
    const auto J_hat = [&](int j) {  // Ĵ_lj for a unit of the velocity that moves joint j
      const double ratio = model.joint(j).leader ? model.joint(j).leader->ratio : 1.0;
      return hat(ratio * Ad(inverse(C[l]) * C[j], model.body(j).X[0]));
    };
    for (int k = l; k > 0; k = model.body(k).predecessor)
      for (int j = k; j > 0; j = model.body(j).predecessor) {
        const Eigen::Matrix4d right = P * (J_hat(j) * J_hat(k)).transpose();
        for (int i = l; i > 0; i = model.body(i).predecessor) {
          const double symbol = (J_hat(i) * right).trace();
          const auto c = [&](int body) { return static_cast<std::size_t>(model.joint(body).iv); };
          Gamma[(c(i) * nv + c(j)) * nv + c(k)] += symbol;
          if (j != k) Gamma[(c(i) * nv + c(k)) * nv + c(j)] += symbol;
        }
      }
  }
  return Gamma;
}

template MatrixXd inertia_matrix<BodyFixed>(const Model&, std::span<const double>);
template MatrixXd inertia_matrix<Spatial>(const Model&, std::span<const double>);
template MatrixXd inertia_matrix<Hybrid>(const Model&, std::span<const double>);
template MatrixXd inertia_matrix<Mixed>(const Model&, std::span<const double>);
template decltype(mass_matrix<BodyFixed>) mass_matrix<BodyFixed>;
template decltype(mass_matrix<Spatial>) mass_matrix<Spatial>;
template decltype(mass_matrix<Hybrid>) mass_matrix<Hybrid>;
template decltype(mass_matrix<Mixed>) mass_matrix<Mixed>;
template decltype(projection_equations<BodyFixed>) projection_equations<BodyFixed>;
template decltype(projection_equations<Spatial>) projection_equations<Spatial>;
template decltype(projection_equations<Hybrid>) projection_equations<Hybrid>;
template decltype(projection_equations<Mixed>) projection_equations<Mixed>;

}  // namespace axode::closed_form
