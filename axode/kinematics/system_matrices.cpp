#include "axode/kinematics/system_matrices.hpp"

#include <Eigen/SparseCholesky>
#include <vector>

#include "axode/kinematics.hpp"
#include "axode/recursion/link.hpp"

namespace axode {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

void add_column(Triplets& triplets, int row, int column, const Screw<>& X) {
  const double x[6] = {X.w.x, X.w.y, X.w.z, X.v.x, X.v.y, X.v.z};
  for (int k = 0; k < 6; ++k)
    if (x[k] != 0) triplets.emplace_back(row + k, column, x[k]);
}
Screw<> unit_screw(int k) {
  return {{double(k == 0), double(k == 1), double(k == 2)}, {double(k == 3), double(k == 4), double(k == 5)}};
}
/// Adds the 6×6 matrix of a linear map on screws at block row i and block column j (bodies i and j).
template <class F> void add_block(Triplets& triplets, int i, int j, F&& map) {
  for (int k = 0; k < 6; ++k) add_column(triplets, 6 * (i - 1), 6 * (j - 1) + k, map(unit_screw(k)));
}
SystemMatrix matrix(int rows, int columns, const Triplets& triplets) {
  SystemMatrix M(rows, columns);
  M.setFromTriplets(triplets.begin(), triplets.end());
  return M;
}
template <class Rep> Twist<Rep> twist_of(const Eigen::VectorXd& V, int i) {
  if (i == 0) return {};
  const double* x = V.data() + 6 * (i - 1);
  return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
}
template <class Motion> void store(const Motion& V, int i, Eigen::VectorXd& out) {
  out.segment<6>(6 * (i - 1)) << V.w.x, V.w.y, V.w.z, V.v.x, V.v.y, V.v.z;
}

/// The poses of the ground and of the body frames that the user placed.
std::vector<SE3<>> user_poses(const Model& model, std::span<const double> q) {
  Workspace<> workspace(model);
  std::vector<SE3<>> C(model.n_frames());
  poses(model, workspace, q, C);
  C.resize(model.n_bodies() + 1);
  return C;
}
/// For each body, the transformation of twists from its predecessor to it, and of wrenches from it to its
/// predecessor, in the representation Rep. They are for the body frames that the user placed. Index 0 is the
/// ground.
template <class Rep>
std::vector<Link<Rep, double>> user_links(const Model& model, std::span<const double> q) {
  const std::vector<SE3<>> C = user_poses(model, q);
  std::vector<Link<Rep, double>> links{Link<Rep, double>::root()};
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const int p = model.body(i).predecessor;
    links.push_back(links[p].child(inverse(C[p]) * C[i]));
  }
  return links;
}
/// The index of the velocity that moves screw k of joint i, and the joint's rate for a unit of it: the ratio
/// of a coupled joint, otherwise 1.
std::pair<int, double> velocity_of(const Model& model, int i, int k) {
  const Joint& joint = model.joint(i);
  return {joint.iv + k, joint.leader ? joint.leader->ratio : 1.0};
}

template <class Rep>
SystemMatrices matrices(const Model& model, const std::vector<Link<Rep, double>>& links) {
  const int n = model.n_bodies();
  Triplets A, D, X;
  for (int i = 1; i <= n; ++i) {
    const int p = model.body(i).predecessor;
    const auto down = [&](const Screw<>& x, int at) {
      const Twist<Rep> V = links[at].down(Twist<Rep>{x.w, x.v});
      return Screw<>{V.w, V.v};
    };
    if (p > 0) add_block(D, i, p, [&](const Screw<>& x) { return down(x, i); });
    std::vector<int> path;  // from i up to, but without, body j
    for (int j = i; j > 0; j = model.body(j).predecessor) {
      add_block(A, i, j, [&](Screw<> x) {
        for (auto at = path.rbegin(); at != path.rend(); ++at) x = down(x, *at);
        return x;
      });
      path.push_back(j);
    }
    for (int k = 0; k < static_cast<int>(model.body(i).X.size()); ++k) {
      const Screw<>& X_k = model.body(i).X[k];
      const auto [c, ratio] = velocity_of(model, i, k);
      const Twist<Rep> J = push(links[i], Twist<BodyFixed>{X_k.w, X_k.v});
      add_column(X, 6 * (i - 1), c, ratio * Screw<>{J.w, J.v});
    }
  }
  return {matrix(6 * n, 6 * n, A), matrix(6 * n, 6 * n, D), matrix(6 * n, model.nv(), X)};
}

Eigen::VectorXd least_squares(const SystemMatrix& X, const Eigen::VectorXd& right) {
  const SystemMatrix XtX = X.transpose() * X;
  return Eigen::SimplicialLDLT<SystemMatrix>(XtX).solve(X.transpose() * right);
}
void check_stacked(const Model& model, const char* argument, const Eigen::VectorXd& V) {
  check_size(argument, static_cast<std::size_t>(V.size()), static_cast<std::size_t>(6 * model.n_bodies()),
             "6 n_bodies");
}

}  // namespace

template <RecursionRepresentation Rep>
SystemMatrices system_matrices(const Model& model, std::span<const double> q) {
  return matrices<Rep>(model, user_links<Rep>(model, q));
}

SpatialFactors spatial_factors(const Model& model, std::span<const double> q) {
  const std::vector<SE3<>> C = user_poses(model, q);
  const int n = model.n_bodies();
  Triplets A_s, Y_s, A_sb;
  for (int i = 1; i <= n; ++i) {
    const SE3<>& A = model.body(i).A;
    for (int j = i; j > 0; j = model.body(j).predecessor) {
      add_block(A_s, i, j, [&](const Screw<>& x) { return Ad(C[j] * inverse(model.body(j).A), x); });
      add_block(A_sb, i, j, [&](const Screw<>& x) { return Ad(C[j], x); });
    }
    for (int k = 0; k < static_cast<int>(model.body(i).X.size()); ++k) {
      const auto [c, ratio] = velocity_of(model, i, k);
      add_column(Y_s, 6 * (i - 1), c, ratio * Ad(A, model.body(i).X[k]));
    }
  }
  return {matrix(6 * n, 6 * n, A_s), matrix(6 * n, model.nv(), Y_s), matrix(6 * n, 6 * n, A_sb)};
}

SystemMatrix a_matrix(const Model& model, std::span<const double> v) {
  check_size("v", v.size(), static_cast<std::size_t>(model.nv()), "nv");
  Triplets a;
  for (int i = 1; i <= model.n_bodies(); ++i) {
    Screw<> X;
    for (int k = 0; k < static_cast<int>(model.body(i).X.size()); ++k) {
      const auto [c, ratio] = velocity_of(model, i, k);
      X = X + (ratio * v[c]) * model.body(i).X[k];
    }
    add_block(a, i, i, [&](const Screw<>& x) { return ad(X, x); });
  }
  return matrix(6 * model.n_bodies(), 6 * model.n_bodies(), a);
}

SystemMatrix b_matrix(const Model& model, const Eigen::VectorXd& V) {
  check_stacked(model, "V", V);
  Triplets b;
  for (int i = 1; i <= model.n_bodies(); ++i)
    add_block(b, i, i, [&](const Screw<>& x) { return ad(screw(twist_of<BodyFixed>(V, i)), x); });
  return matrix(6 * model.n_bodies(), 6 * model.n_bodies(), b);
}

template <RecursionRepresentation Rep>
Eigen::VectorXd system_twist(const Model& model, std::span<const double> q, std::span<const double> v) {
  Workspace<> workspace(model);
  std::vector<Twist<Rep>> V(model.n_frames());
  twists<Rep>(model, workspace, q, v, V);
  Eigen::VectorXd out(6 * model.n_bodies());
  for (int i = 1; i <= model.n_bodies(); ++i) store(V[i], i, out);
  return out;
}

template <RecursionRepresentation Rep>
Eigen::VectorXd system_acceleration(const Model& model, std::span<const double> q, std::span<const double> v,
                                    std::span<const double> a) {
  Workspace<> workspace(model);
  std::vector<TwistRate<Rep>> dV(model.n_frames());
  accelerations<Rep>(model, workspace, q, v, a, dV);
  Eigen::VectorXd out(6 * model.n_bodies());
  for (int i = 1; i <= model.n_bodies(); ++i) store(dV[i], i, out);
  return out;
}

template <RecursionRepresentation Rep>
Eigen::VectorXd joint_velocities(const Model& model, std::span<const double> q, const Eigen::VectorXd& V) {
  check_stacked(model, "V", V);
  const SystemMatrices system = system_matrices<Rep>(model, q);
  return least_squares(system.X, V - system.D * V);
}

template <RecursionRepresentation Rep>
Eigen::VectorXd joint_accelerations(const Model& model, std::span<const double> q, const Eigen::VectorXd& V,
                                    const Eigen::VectorXd& dV) {
  check_stacked(model, "V", V);
  check_stacked(model, "dV", dV);
  const std::vector<Link<Rep, double>> links = user_links<Rep>(model, q);
  const SystemMatrices system = matrices<Rep>(model, links);
  Eigen::VectorXd bias(V.size());
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Twist<Rep> V_p = twist_of<Rep>(V, model.body(i).predecessor), V_i = twist_of<Rep>(V, i);
    store(links[i].bias(V_p, V_i, V_i - links[i].down(V_p)), i, bias);
  }
  return least_squares(system.X, dV - system.D * dV - bias);
}

template decltype(system_matrices<BodyFixed>) system_matrices<BodyFixed>;
template decltype(system_twist<BodyFixed>) system_twist<BodyFixed>;
template decltype(system_acceleration<BodyFixed>) system_acceleration<BodyFixed>;
template decltype(joint_velocities<BodyFixed>) joint_velocities<BodyFixed>;
template decltype(joint_accelerations<BodyFixed>) joint_accelerations<BodyFixed>;
template decltype(system_matrices<Spatial>) system_matrices<Spatial>;
template decltype(system_twist<Spatial>) system_twist<Spatial>;
template decltype(system_acceleration<Spatial>) system_acceleration<Spatial>;
template decltype(joint_velocities<Spatial>) joint_velocities<Spatial>;
template decltype(joint_accelerations<Spatial>) joint_accelerations<Spatial>;
template decltype(system_matrices<Hybrid>) system_matrices<Hybrid>;
template decltype(system_twist<Hybrid>) system_twist<Hybrid>;
template decltype(system_acceleration<Hybrid>) system_acceleration<Hybrid>;
template decltype(joint_velocities<Hybrid>) joint_velocities<Hybrid>;
template decltype(joint_accelerations<Hybrid>) joint_accelerations<Hybrid>;
template decltype(system_matrices<Mixed>) system_matrices<Mixed>;
template decltype(system_twist<Mixed>) system_twist<Mixed>;
template decltype(system_acceleration<Mixed>) system_acceleration<Mixed>;
template decltype(joint_velocities<Mixed>) joint_velocities<Mixed>;
template decltype(joint_accelerations<Mixed>) joint_accelerations<Mixed>;

}  // namespace axode
