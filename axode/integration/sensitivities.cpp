#include "axode/integration/sensitivities.hpp"

#include <algorithm>
#include <deque>
#include <stdexcept>
#include <utility>
#include <vector>

#include "axode/derivatives/displacement/forward_first_order.hpp"
#include "axode/derivatives/displacement/scratch.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/runs/sized_arguments.hpp"
#include "axode/integration/schemes/group_derivatives.hpp"
#include "axode/integration/schemes/munthe_kaas.hpp"
#include "axode/integration/schemes/spring_terms.hpp"
#include "axode/integration/schemes/tangent_steps.hpp"
#include "axode/model/finite.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

using Span = std::span<const double>;
using Matrix = GroupDerivatives::Matrix;
using Rows = SpringTerms::Rows;
using Joints = GroupDerivatives::Joints;

void check_motion(const Model& model, double step, const Loads<double>& loads, const Tableau& method,
                  std::initializer_list<Sized<const double>> arguments,
                  std::initializer_list<Sized<double>> results) {
  check(method);
  check_step(step);
  check_loads(model, loads);
  catalog::check_counts<"rollout sensitivities">(model);
  check_sizes(arguments, results);
  check_configuration(model, arguments.begin()->x);
}

/// Sets the state from which steps are taken.
void begin(TangentSteps& steps, Span q, Span v) {
  std::ranges::copy(q, steps.q.begin());
  std::ranges::copy(v, steps.y.begin());
}

/// A Runge-Kutta-Munthe-Kaas step that stores its stages with their factorised mass matrices, and the
/// reverse-mode (adjoint) differentiation of this step.
class AdjointStep {
 public:
  AdjointStep(const Model& model, const Tableau& method, const Loads<double>& loads)
      : v(static_cast<std::size_t>(model.nv())),
        q(static_cast<std::size_t>(model.nq())),
        tree_(model.tree<double>()),
        method_(method),
        loads_(loads),
        scheme_(tree_, method),
        group_(tree_),
        end_(tree_),
        springs_(model),
        w_theta_(Matrix::Zero(model.nv(), 1)),
        w_eta_(w_theta_),
        w_V_(w_theta_),
        sum_(w_theta_) {
    for (std::size_t i = 0; i < method.b.size(); ++i) stages_.emplace_back(model, w_theta_);
    stages_.front().maps.at(v.data(), v.data());  // theta = 0
  }

  std::vector<double> v, q;  ///< state at the end of the step, after find()

  /// Computes the stages of a step of length h.
  Solvability find(double h, const double* q_0, const double* v_0, const double* tau) {
    Solvability verdict = take(stages_[0], Span(q_0, q.size()), Span(v_0, v.size()), tau);
    std::size_t i = 0;
    const auto accelerate = [&](double, Span q_i, Span v_i, std::span<double> a_i) {
      Stage& stage = stages_[++i];
      stage.maps.at(scheme_.theta.data(), v_i.data());
      verdict = take(stage, q_i, v_i, tau);
      std::copy_n(stage.dynamics->forward.a, a_i.size(), a_i.data());
      return verdict.ok();
    };
    if (!verdict.ok() || !scheme_.run(0, q_0, v_0, stages_[0].dynamics->forward.a, h, accelerate))
      return verdict;
    group_.move(q_0, scheme_.theta.data(), q.data());
    v = scheme_.y;
    end_.at(scheme_.theta.data(), v.data());
    return verdict;
  }

  /// Reverse-mode differentiation of the step. On entry, w_q and w_v are the gradients of the objective by q
  /// and v at the end of the step; on return, they are its gradients by q and v at the start. Adds the
  /// gradients by the drive forces to by_tau (nv numbers) and, unless by_geometry is null, the gradients by
  /// the geometric parameters to by_geometry (6 n_bodies numbers). The six geometric parameters of a body
  /// displace its joint and its subtree along unit screws.
  void back(double h, Matrix& w_q, Matrix& w_v, double* by_tau, double* by_geometry) {
    const Tableau& m = method_;
    const bool euler = m.b.size() == 1;
    w_theta_.setZero();
    end_.add_transposed(&Joints::velocity, w_q, w_theta_);
    if (euler) w_v += h * w_theta_;
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      stages_[i].w_K = (euler ? 0 : h * m.b[i]) * w_theta_;
      stages_[i].w_L = (h * m.b[i]) * w_v;
    }
    sum_.setZero();
    end_.add_transposed(&Joints::carry, w_q, sum_);
    w_q.swap(sum_);
    for (std::size_t i = stages_.size(); i-- > 0;) {
      Stage& stage = stages_[i];
      multiply(stage, by_tau, by_geometry);
      stage.maps.add_transposed(&Joints::carry, w_eta_, w_q);
      stage.maps.add_transposed(&Joints::rate, stage.w_K, w_V_);
      w_v += w_V_;
      w_theta_.setZero();
      stage.maps.add_transposed(&Joints::turn, stage.w_K, w_theta_);
      stage.maps.add_transposed(&Joints::velocity, w_eta_, w_theta_);
      for (std::size_t j = 0; j < i; ++j) {
        stages_[j].w_K += (h * m.a[i][j]) * w_theta_;
        stages_[j].w_L += (h * m.a[i][j]) * w_V_;
      }
    }
  }

 private:
  struct Stage {
    WithScratch<double, ForwardVjp<double>> dynamics;
    GroupDerivatives maps;
    std::vector<double> q, v;
    Matrix w_K, w_L;
    Stage(const Model& model, const Matrix& zero)
        : dynamics(model.topology()), maps(model.tree<double>()), w_K(zero), w_L(zero) {}
  };

  Solvability take(Stage& stage, Span q_i, Span v_i, const double* tau) {
    stage.q.assign(q_i.begin(), q_i.end());
    stage.v.assign(v_i.begin(), v_i.end());
    return stage.dynamics->forward.run(tree_, q_i.data(), v_i.data(), springs_.forces(q_i, v_i, tau), loads_);
  }
  /// Reverse-mode differentiation of the accelerations of one stage of the Runge-Kutta method. From the
  /// gradient w_L of the objective by these accelerations, computes its gradients w_eta_ and w_V_ by the
  /// configuration and the velocity of the stage. Adds its gradients by the drive forces to by_tau (nv
  /// numbers) and, unless by_geometry is null, its gradients by the geometric parameters of all bodies to
  /// by_geometry (6 n_bodies numbers). The six geometric parameters of a body displace its joint and its
  /// subtree along unit screws.
  void multiply(Stage& stage, double* by_tau, double* by_geometry) {
    ForwardVjp<double>& dynamics = *stage.dynamics;
    dynamics.compute_gradient(tree_, stage.q.data(), stage.v.data(), stage.w_L.data(), loads_);
    for (std::size_t c = 0; c < v.size(); ++c) {
      const Eigen::Index row = static_cast<Eigen::Index>(c);
      by_tau[c] += dynamics.mu[c];
      w_eta_(row) = dynamics.vjp.by_q[c];
      w_V_(row) = dynamics.vjp.by_v[c];
    }
    if (springs_.any()) {
      springs_.differentiate(stage.q, stage.v);
      const Eigen::Map<const Eigen::VectorXd> mu(dynamics.mu, w_eta_.rows());
      w_eta_.noalias() += springs_.by_q.transpose() * mu;
      w_V_.noalias() += springs_.by_v.transpose() * mu;
    }
    if (by_geometry)
      dynamics.vjp.each_parameter(tree_, stage.q.data(), stage.v.data(), dynamics.forward.a, dynamics.mu,
                                  [&](int i, int u, double x) { by_geometry[(i - 1) * 6 + u] -= x; });
  }

  const Tree<double>& tree_;
  const Tableau& method_;
  const Loads<double>& loads_;
  MuntheKaas<> scheme_;
  ConfigurationGroup<double> group_;
  GroupDerivatives end_;
  SpringTerms springs_;
  std::deque<Stage> stages_;
  Matrix w_theta_, w_eta_, w_V_, sum_;
};

}  // namespace

Solvability step_derivatives(const Model& model, Workspace<double>& workspace, Span q, Span v, Span tau,
                             double step, const StepDerivatives& end, const Loads<double>& loads,
                             const Tableau& method) {
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv());
  workspace.check(model);
  check_motion(model, step, loads, method, {{"q", q, nq, "nq"}, {"v", v, nv, "nv"}, {"tau", tau, nv, "nv"}},
               {{"end.q", end.q, nq, "nq"},
                {"end.v", end.v, nv, "nv"},
                {"end.A", end.A, 4 * nv * nv, "2nv * 2nv"},
                {"end.B", end.B, 2 * nv * nv, "2nv * nv"}});
  const Tree<double>& tree = model.tree<double>();
  const Eigen::Index n = model.nv();
  TangentSteps steps(model, method, 3 * n);  // one column for each direction of q, v and tau
  begin(steps, q, v);
  steps.dq.leftCols(n).setIdentity();
  steps.dy.middleCols(n, n).setIdentity();
  Rows by_q(n, n), by_v(n, n), by_tau(n, n);
  SpringTerms springs(model);
  Arena arena = workspace.arena(model.topology());
  ForwardFirstOrder<double> dynamics(arena);
  Solvability verdict;
  bool first = true;
  steps.run(0, step,
            [&](double, const TangentSteps::Row&, Span q_i, Span v_i, const Matrix& dq, const Matrix& dv,
                std::span<double> a, Matrix& da) {
              const double* const forces = springs.forces(q_i, v_i, tau.data());
              verdict = dynamics.run(tree, q_i.data(), v_i.data(), forces, loads, by_q.data(), by_v.data(),
                                     by_tau.data());
              std::copy_n(dynamics.forward.a, n, a.data());
              if (springs.any() && verdict.ok()) {
                springs.differentiate(q_i, v_i);
                by_q.noalias() += by_tau * springs.by_q;
                by_v.noalias() += by_tau * springs.by_v;
              }
              if (std::exchange(first, false)) {
                da << by_q, by_v, by_tau;
              } else {
                da.noalias() = by_q * dq;
                da.noalias() += by_v * dv;
                da.rightCols(n) += by_tau;
              }
              return verdict.ok();
            });
  std::ranges::copy(steps.q, end.q.begin());
  std::ranges::copy(steps.y, end.v.begin());
  Eigen::Map<Rows> A(end.A.data(), 2 * n, 2 * n), B(end.B.data(), 2 * n, n);
  A << steps.dq.leftCols(2 * n), steps.dy.leftCols(2 * n);
  B << steps.dq.rightCols(n), steps.dy.rightCols(n);
  return solved_or_nan(verdict, {end.q, end.v, end.A, end.B});
}

Solvability rollout_jvp(const Model& model, Span q, Span v, Span tau, double step, Span dq, Span dv,
                        Span dtau, std::span<double> dq_out, std::span<double> dv_out,
                        const Loads<double>& loads, const Tableau& method, const Monitor& monitor) {
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv()),
                    K = steps_of(model, tau);
  check_motion(
      model, step, loads, method,
      {{"q", q, nq, "nq"},
       {"v", v, nv, "nv"},
       {"tau", tau, K * nv, "K nv"},
       {"dq", dq, nv, "nv"},
       {"dv", dv, nv, "nv"},
       {"dtau", dtau, K * nv, "K nv"}},
      {{"dq_out", dq_out, (K + 1) * nv, "(K + 1) nv"}, {"dv_out", dv_out, (K + 1) * nv, "(K + 1) nv"}});
  const Tree<double>& tree = model.tree<double>();
  TangentSteps steps(model, method, 1);
  begin(steps, q, v);
  std::ranges::copy(dq, steps.dq.data());
  std::ranges::copy(dv, steps.dy.data());
  WithScratch<double, ForwardJvp<double>> dynamics(model.topology());
  SpringTerms springs(model);
  std::vector<double> dforces(nv);
  Solvability verdict;
  const auto write = [&](std::size_t k) {
    std::copy_n(steps.dq.data(), nv, dq_out.data() + k * nv);
    std::copy_n(steps.dy.data(), nv, dv_out.data() + k * nv);
  };
  write(0);
  for (std::size_t k = 0; k < K && verdict.ok(); ++k) {
    if (monitor && !monitor()) verdict.not_finite = true;
    const double *const tau_k = tau.data() + k * nv, *const dtau_k = dtau.data() + k * nv;
    steps.run(0, step,
              [&](double, const TangentSteps::Row&, Span q_i, Span v_i, const Matrix& eta, const Matrix& dV,
                  std::span<double> a, Matrix& da) {
                const double* along = dtau_k;
                if (springs.any() && finite(q_i)) {
                  springs.differentiate(q_i, v_i);
                  Eigen::Map<Eigen::VectorXd> sum(dforces.data(), model.nv());
                  sum = Eigen::Map<const Eigen::VectorXd>(dtau_k, model.nv());
                  sum.noalias() += springs.by_q * eta;
                  sum.noalias() += springs.by_v * dV;
                  along = dforces.data();
                }
                if (verdict.ok())
                  verdict = dynamics->run(tree, q_i.data(), v_i.data(), springs.forces(q_i, v_i, tau_k),
                                          eta.data(), dV.data(), along, loads);
                std::copy_n(dynamics->forward.a, nv, a.data());
                std::copy_n(dynamics->x, nv, da.data());
                return verdict.ok();
              });
    write(k + 1);
  }
  return solved_or_nan(verdict, {dq_out, dv_out});
}

Solvability rollout_vjp(const Model& model, Span q, Span v, Span tau, double step, Span w_q, Span w_v,
                        const RolloutGradients& gradient, const Loads<double>& loads, const Tableau& method,
                        const Monitor& monitor) {
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv()),
                    K = steps_of(model, tau);
  const bool geometry = !gradient.geometry.empty();
  check_motion(model, step, loads, method,
               {{"q", q, nq, "nq"},
                {"v", v, nv, "nv"},
                {"tau", tau, K * nv, "K nv"},
                {"w_q", w_q, (K + 1) * nv, "(K + 1) nv"},
                {"w_v", w_v, (K + 1) * nv, "(K + 1) nv"}},
               {{"gradient.q", gradient.q, nv, "nv"},
                {"gradient.v", gradient.v, nv, "nv"},
                {"gradient.tau", gradient.tau, K * nv, "K nv"},
                {"gradient.geometry", gradient.geometry,
                 geometry ? 6 * static_cast<std::size_t>(model.n_bodies()) : 0, "n_bodies * 6"}});
  if (geometry && model.springs().between_frames())
    throw std::invalid_argument("model \"" + model.name() +
                                "\" has springs between frames, whose derivatives by geometry are not known");
  AdjointStep one(model, method, loads);
  std::vector<double> q_k(q.begin(), q.end()),
      v_k(v.begin(), v.end());  // the states at the ends of all steps
  Solvability verdict;
  const auto find = [&](std::size_t k) {
    if (monitor && !monitor()) return Solvability{.not_finite = true};
    return one.find(step, &q_k[k * nq], &v_k[k * nv], &tau[k * nv]);
  };
  for (std::size_t k = 0; k < K && verdict.ok(); ++k) {
    verdict = find(k);
    q_k.insert(q_k.end(), one.q.begin(), one.q.end());
    v_k.insert(v_k.end(), one.v.begin(), one.v.end());
  }
  std::ranges::fill(gradient.tau, 0.0);
  std::ranges::fill(gradient.geometry, 0.0);
  const Eigen::Index n = model.nv();
  Matrix by_q = Eigen::Map<const Matrix>(w_q.data() + K * nv, n, 1),
         by_v = Eigen::Map<const Matrix>(w_v.data() + K * nv, n, 1);
  for (std::size_t k = K; k-- > 0 && verdict.ok();) {
    if (k + 1 < K) verdict = find(k);
    if (!verdict.ok()) break;
    one.back(step, by_q, by_v, &gradient.tau[k * nv], geometry ? gradient.geometry.data() : nullptr);
    by_q += Eigen::Map<const Matrix>(w_q.data() + k * nv, n, 1);
    by_v += Eigen::Map<const Matrix>(w_v.data() + k * nv, n, 1);
  }
  std::copy_n(by_q.data(), nv, gradient.q.data());
  std::copy_n(by_v.data(), nv, gradient.v.data());
  return solved_or_nan(verdict, {gradient.q, gradient.v, gradient.tau, gradient.geometry});
}

}  // namespace axode
