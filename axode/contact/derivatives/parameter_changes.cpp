#include "axode/contact/derivatives/parameter_changes.hpp"

#include <array>

#include "axode/derivatives/displacement/geometric_parameters.hpp"
#include "axode/eigen.hpp"
#include "axode/model/inertial_parameters.hpp"

namespace axode {
namespace {

/// The matrix K with K ξ = ad_ξᵀ W for a momentum or wrench W.
Matrix6<double> coad_matrix(const Momentum<Spatial>& W) {
  Matrix6<double> K;
  K << skew(W.l), skew(W.p), skew(W.p), Eigen::Matrix3d::Zero();
  return K;
}

}  // namespace

Changes geometric_displacements(const Tree<double>& tree, const SpatialTree<double>& at, const double* q,
                                const Changes& geometry) {
  Changes xi = Changes::Zero(6 * (tree->n + 1), geometry.cols());
  for (int i = 1; i <= tree->n; ++i) {
    Matrix6<double> U;
    each_unit_screw(at.link[i].C * frame_at_zero(tree, i, q),
                    [&](int u, const Screw<>& X) { U.col(u) = to_eigen(X); });
    add_product(U, geometry.middleRows<6>(6 * (i - 1)), xi.middleRows<6>(6 * i));
  }
  return xi;
}

ParameterChanges::ParameterChanges(const Model& model)
    : tree_(&model.tree<double>()),
      spatial_(model.topology()),
      V_(static_cast<std::size_t>(model.n_bodies()) + 1),
      Pi_(V_.size()),
      Gamma_(V_.size()) {}

void ParameterChanges::run(const double* q, const double* v, const ParameterDirections& along) {
  const Tree<double>& tree = *tree_;
  const int n = tree->n;
  const Eigen::Index p = along.count();
  const bool moves = along.geometry.size() > 0, weighs = along.inertia.size() > 0;
  spatial_->run(tree, q);
  xi_ = moves ? geometric_displacements(tree, *spatial_, q, along.geometry) : Changes::Zero(6 * (n + 1), p);
  for (Changes* x : {&dV_, &dPi_, &dGamma_}) x->setZero(6 * (n + 1), p);
  dh_.setZero(3 * (n + 1), p);
  dm_.setZero(n + 1, p);
  V_[0] = {};
  const Twist<Spatial> g{{}, tree.g};
  for (int i = 1; i <= n; ++i) {
    const std::size_t k = static_cast<std::size_t>(i), parent = static_cast<std::size_t>(tree->parent[i]);
    const Inertia<>& M = spatial_->M_body[i];
    Twist<Spatial> Sv{};
    spatial_->each_screw(i, [&](int c, const Twist<Spatial>& S) { Sv += v[c] * S; });
    V_[k] = V_[parent] + Sv;
    Pi_[k] = M * V_[k];
    Gamma_[k] = M * g;
    auto dPi = dPi_.middleRows<6>(6 * i), dGamma = dGamma_.middleRows<6>(6 * i);
    auto dh = dh_.middleRows<3>(3 * i);
    if (moves) {
      auto xi = xi_.middleRows<6>(6 * i), dV = dV_.middleRows<6>(6 * i);
      xi += xi_.middleRows<6>(6 * tree->parent[i]);
      dV = dV_.middleRows<6>(6 * tree->parent[i]);
      subtract_product(ad_matrix(screw(Sv)), xi, dV);
      const Matrix6<double> inertia = to_eigen(M);
      add_product(inertia, dV, dPi);
      add_product(Matrix6<double>(inertia * ad_matrix(screw(V_[k])) - coad_matrix(Pi_[k])), xi, dPi);
      add_product(Matrix6<double>(inertia * ad_matrix(screw(g)) - coad_matrix(Gamma_[k])), xi, dGamma);
      dh = M.m * xi.bottomRows<3>();
      subtract_product(skew(M.h), xi.topRows<3>(), dh);
    }
    if (weighs) {
      const SE3<> C = spatial_->link[i].C * tree.frame_offset[k];
      Eigen::Matrix<double, 6, 10> by_Pi, by_Gamma;
      Eigen::Matrix<double, 3, 10> by_h;
      for (std::size_t c = 0; c < 10; ++c) {
        std::array<double, 10> unit{};
        unit[c] = 1;
        const Inertia<> one = transform(C, inertia_of(unit));
        const Eigen::Index column = static_cast<Eigen::Index>(c);
        by_Pi.col(column) = to_eigen(one * V_[k]);
        by_Gamma.col(column) = to_eigen(one * g);
        by_h.col(column) = to_eigen(one.h);
      }
      const auto change = along.inertia.middleRows<10>(10 * (i - 1));
      add_product(by_Pi, change, dPi);
      add_product(by_Gamma, change, dGamma);
      add_product(by_h, change, dh);
      dm_.row(i) = change.row(0);
    }
  }
  for (int i = n; i > 0; --i) {
    const int parent = tree->parent[i];
    if (parent == 0) continue;
    const std::size_t from = static_cast<std::size_t>(i), to = static_cast<std::size_t>(parent);
    Pi_[to] += Pi_[from];
    Gamma_[to] += Gamma_[from];
    dPi_.middleRows<6>(6 * parent) += dPi_.middleRows<6>(6 * i);
    dGamma_.middleRows<6>(6 * parent) += dGamma_.middleRows<6>(6 * i);
    dh_.middleRows<3>(3 * parent) += dh_.middleRows<3>(3 * i);
    dm_.row(parent) += dm_.row(i);
  }
  for (Changes* x : {&momenta, &forces, &gravity}) x->setZero(tree->nv, p);
  for (int i = 1; i <= n; ++i) {
    const std::size_t k = static_cast<std::size_t>(i);
    const auto dPi = dPi_.middleRows<6>(6 * i), dGamma = dGamma_.middleRows<6>(6 * i);
    const Vector6<double> Pi = to_eigen(Pi_[k]), Gamma = to_eigen(Gamma_[k]);
    const Matrix6<double> ad_V = ad_matrix(screw(V_[static_cast<std::size_t>(tree->parent[i])]));
    spatial_->each_screw(i, [&](int c, const Twist<Spatial>& screw_c) {
      const Vector6<double> S = to_eigen(screw_c), psi = ad_V * S;
      const auto row_of = [c](Changes& x) { return x.middleRows(c, 1); };
      add_product(S.transpose(), dPi, row_of(momenta));
      add_product(psi.transpose(), dPi, row_of(forces));
      add_product(S.transpose(), dGamma, row_of(gravity));
      if (!moves) return;
      const Matrix6<double> ad_S = ad_matrix(screw(screw_c));
      const auto xi = xi_.middleRows<6>(6 * i), dV_p = dV_.middleRows<6>(6 * tree->parent[i]);
      using Row = Eigen::Matrix<double, 1, 6>;
      const Row Pi_S = Pi.transpose() * ad_S;
      subtract_product(Pi_S, xi, row_of(momenta));
      subtract_product(Pi_S, dV_p, row_of(forces));
      subtract_product(Row(Pi.transpose() * ad_V * ad_S), xi, row_of(forces));
      subtract_product(Row(Gamma.transpose() * ad_S), xi, row_of(gravity));
    });
  }
}

Eigen::Matrix3Xd ParameterChanges::center(int body) {
  const Inertia<>& M = spatial_->M[body];
  return (dh_.middleRows<3>(3 * body) - to_eigen(center_of_mass(M)) * dm_.row(body)) / M.m;
}

}  // namespace axode
