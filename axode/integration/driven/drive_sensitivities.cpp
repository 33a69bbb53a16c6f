#include "axode/integration/driven/drive_sensitivities.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/derivatives/displacement/forward_first_order.hpp"
#include "axode/derivatives/displacement/scratch.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/driven/drive_steps.hpp"
#include "axode/integration/runs/sized_arguments.hpp"
#include "axode/integration/schemes/spring_terms.hpp"
#include "axode/integration/schemes/tangent_steps.hpp"
#include "axode/model/finite.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

using Span = std::span<const double>;
using Vector = std::vector<double>;
using Matrix = TangentSteps::Matrix;
using Row = TangentSteps::Row;
using Rows = SpringTerms::Rows;
using Monitor = std::function<bool()>;

Eigen::Index eigen_index(std::size_t n) { return static_cast<Eigen::Index>(n); }

/// Numbers of coordinates, velocities, states and inputs of a mechanism with drives, and of steps.
struct Sizes {
  std::size_t nq, nv, nx, nu, K;

  Sizes(const Model& model, const DriveSystem& drives, Span tau)
      : nq(static_cast<std::size_t>(model.nq())),
        nv(static_cast<std::size_t>(model.nv())),
        nx(drives.nx()),
        nu(drives.inputs().size()),
        K(steps_of(model, tau)) {}
  std::size_t n() const { return 2 * nv + nx; }
};

/// A motion with drives, step by step, with the displacements of its state along several directions. A
/// displacement is the first-order change of the state when the initial state, the forces or the inputs
/// change along a direction.
class DriveTangentSteps {
 public:
  using End = DriveSteps::End;

  DriveTangentSteps(const Model& model, const DriveSystem& drives, const Loads<double>& loads,
                    const Tableau& method, Eigen::Index directions)
      : steps(model, method, drives),
        tangent(model, method, directions + 1, drives.nx()),
        tree_(model.tree<double>()),
        loads_(loads),
        springs_(model),
        dynamics_(model.topology()),
        tau_t_(steps.v.size()),
        by_q_(model.nv(), model.nv()),
        by_v_(by_q_),
        by_tau_(by_q_) {
    tangent.dt = tangent.dh = Row::Zero(directions + 1);
  }

  DriveSteps steps;  ///< present state
  /// The displacements of the present state: dq of q, and dy of the velocities v and the states x of the
  /// drives, with a column for each direction and one more. The last column is the derivative of the state by
  /// the length of the last part of the step (per s). A step is divided into parts at the times when laws of
  /// drives change their form.
  TangentSteps tangent;

  /// Advances the motion to the time t_1 under the drive forces tau (nv). Also advances the displacements of
  /// the state, which are its first-order changes along several directions. In direction k the drive forces
  /// change by column k of dtau (nv × directions) and the inputs by column k of du (nu × directions).
  Solvability advance(double t_1, Span tau, const Matrix& dtau, const Matrix& du) {
    const Eigen::Index m = dtau.cols();
    const auto rates = [&](double t, Span q, Span v, Span x, std::span<double> a, std::span<double> dx) {
      return compute_rates(t, tau, q, v, x, a, dx);
    };
    const auto closed = [](std::span<double>, std::span<double>) { return true; };
    const auto differentiate = [&](double t, const Row& dt, Span q, Span y, const Matrix& dq,
                                   const Matrix& dy, std::span<double> dydt, Matrix& by) {
      return linearize(t, dt, tau, dtau, du, q, y, dq, dy, dydt, by);
    };
    Row begins_later = Row::Zero(m);  // the change of the time at which a part of the step begins
    while (steps.t() < t_1) {
      const double t_0 = steps.t();
      std::ranges::copy(steps.q, tangent.q.begin());
      std::ranges::copy(steps.v, tangent.y.begin());
      std::ranges::copy(steps.x, tangent.y.begin() + eigen_index(steps.v.size()));
      const End end = steps.take_step(t_1, rates, closed);
      if (end != End::none) return found_.ok() ? Solvability{.not_finite = true} : found_;
      tangent.dq.col(m).setZero();
      tangent.dy.col(m).setZero();
      tangent.dt << begins_later, 0;
      tangent.dh << -begins_later, 1;
      if (!tangent.run(t_0, steps.t() - t_0, differentiate)) return found_;
      begins_later = steps.t() < t_1 ? change_of_time(du) : Row::Zero(m).eval();
      tangent.dq.leftCols(m) += tangent.dq.col(m) * begins_later;
      tangent.dy.leftCols(m) += tangent.dy.col(m) * begins_later;
      steps.switch_now();
    }
    return {};
  }

 private:
  bool compute_rates(double t, Span tau, Span q, Span v, Span x, std::span<double> a, std::span<double> dx) {
    found_ = {.not_finite = true};
    if (!finite(q) || !finite(v)) return false;
    std::ranges::copy(tau, tau_t_.begin());
    steps.drives().evaluate(t, q, v, x, tau_t_, dx);
    if (!finite(Span(tau_t_)) || !finite(Span(dx))) return false;
    const double* const forces = springs_.forces(q, v, tau_t_.data());
    found_ = dynamics_->forward.run(tree_, q.data(), v.data(), forces, loads_);
    std::copy_n(dynamics_->forward.a, a.size(), a.data());
    return found_.ok();
  }

  /// Computes the rates dydt of y = (v, x), the velocities v and the states x of the drives, and their
  /// changes `by` along displacements of q, y, the drive forces τ and the inputs u (D17.19).
  bool linearize(double t, const Row& dt, Span tau, const Matrix& dtau, const Matrix& du, Span q, Span y,
                 const Matrix& dq, const Matrix& dy, std::span<double> dydt, Matrix& by) {
    const std::size_t nv = steps.v.size();
    const Span v = y.first(nv), x = y.subspan(nv);
    std::ranges::copy(tau, tau_t_.begin());
    steps.drives().evaluate(t, q, v, x, tau_t_, dydt.subspan(nv));
    const DriveDerivatives d = steps.drives().derivatives(t, q, v, x);
    const double* const forces = springs_.forces(q, v, tau_t_.data());
    found_ =
        dynamics_->run(tree_, q.data(), v.data(), forces, loads_, by_q_.data(), by_v_.data(), by_tau_.data());
    if (!found_.ok()) return false;
    std::copy_n(dynamics_->forward.a, nv, dydt.data());
    const auto dv = dy.topRows(eigen_index(nv)), dx = dy.bottomRows(eigen_index(x.size()));
    Matrix inputs_by = steps.drives().input_rates(t) * dt;
    inputs_by.leftCols(du.cols()) += du;
    Matrix forces_by = d.tau_q * dq + d.tau_v * dv + d.tau_x * dx + d.tau_u * inputs_by;
    forces_by.leftCols(dtau.cols()) += dtau;
    if (springs_.any()) {
      springs_.differentiate(q, v);
      forces_by += springs_.by_q * dq;
      forces_by += springs_.by_v * dv;
    }
    by.topRows(eigen_index(nv)) = by_q_ * dq + by_v_ * dv + by_tau_ * forces_by;
    by.bottomRows(eigen_index(x.size())) = d.f_q * dq + d.f_v * dv + d.f_x * dx + d.f_u * inputs_by;
    return true;
  }

  /// The changes of the present time for all directions, if it is that at which a status changes (D17.20).
  Row change_of_time(const Matrix& du) {
    DriveSystem& drives = steps.drives();
    const double t = steps.t();
    const Eigen::Index m = du.cols(), nv = eigen_index(steps.v.size()), nx = eigen_index(steps.x.size());
    if (!(drives.least_margin(t, steps.q, steps.v, steps.x) < 0)) return Row::Zero(m);  // an input jumps
    const MarginDerivatives by = drives.margin_derivatives(t, steps.q, steps.v, steps.x);
    const Row change = by.q * tangent.dq + by.v * tangent.dy.topRows(nv) + by.x * tangent.dy.bottomRows(nx);
    const double rate = change[m] + by.u.dot(drives.input_rates(t));
    if (!(rate < 0)) return Row::Zero(m);
    return -(change.head(m) + by.u * du) / rate;
  }

  const Tree<double>& tree_;
  const Loads<double>& loads_;
  SpringTerms springs_;
  WithScratch<double, ForwardFirstOrder<double>> dynamics_;
  Vector tau_t_;
  Rows by_q_, by_v_, by_tau_;
  Solvability found_;
};

void check_motion(const Model& model, const DriveSystem& drives, double t, Span q, Span v, Span x,
                  const Loads<double>& loads, const Tableau& method, double step) {
  check(method);
  check_step(step);
  check_loads(model, loads);
  catalog::check_counts<"rollout_derivatives_with_drives">(model);
  check_configuration(model, q);
  if (const std::string bad = first_not_finite(model, q, v); !bad.empty())
    throw std::invalid_argument(bad + "; it must be finite");
  for (std::size_t k = 0; k < x.size(); ++k)
    if (!finite(x[k])) throw std::invalid_argument("x of \"" + drives.states()[k].name + "\" is not finite");
  if (!finite(t)) throw std::invalid_argument("t is not finite");
}

/// Row k of a list of rows of `width` numbers, as a matrix of one column.
Matrix column(Span rows, std::size_t k, std::size_t width) {
  return Eigen::Map<const Matrix>(rows.data() + k * width, eigen_index(width), 1);
}

}  // namespace

Solvability rollout_derivatives_with_drives(const Model& model, const DriveSystem& drives, double t, Span q,
                                            Span v, Span x, Span tau, double step,
                                            const DriveRolloutDerivatives& out, const Loads<double>& loads,
                                            const Tableau& method, const Monitor& monitor) {
  const Sizes at(model, drives, tau);
  const std::size_t K = at.K, n = at.n();
  check_sizes({{"q", q, at.nq, "nq"},
               {"v", v, at.nv, "nv"},
               {"x", x, x.empty() ? 0 : at.nx, "nx"},
               {"tau", tau, K * at.nv, "K nv"}},
              {{"out.q", out.q, (K + 1) * at.nq, "(K + 1) nq"},
               {"out.v", out.v, (K + 1) * at.nv, "(K + 1) nv"},
               {"out.x", out.x, (K + 1) * at.nx, "(K + 1) nx"},
               {"out.A", out.A, K * n * n, "K (2nv + nx) (2nv + nx)"},
               {"out.B", out.B, K * n * at.nv, "K (2nv + nx) nv"},
               {"out.C", out.C, K * n * at.nu, "K (2nv + nx) nu"}});
  check_motion(model, drives, t, q, v, x, loads, method, step);
  const Eigen::Index nv = eigen_index(at.nv), nx = eigen_index(at.nx), nu = eigen_index(at.nu),
                     m = eigen_index(n);
  DriveTangentSteps motion(model, drives, loads, method, m + nv + nu);
  Matrix dtau = Matrix::Zero(nv, m + nv + nu), du = Matrix::Zero(nu, m + nv + nu);
  dtau.middleCols(m, nv).setIdentity();
  du.rightCols(nu).setIdentity();
  motion.steps.begin(t, q, v, x);
  const auto write = [&](std::size_t k) {
    std::ranges::copy(motion.steps.q, &out.q[k * at.nq]);
    std::ranges::copy(motion.steps.v, &out.v[k * at.nv]);
    std::ranges::copy(motion.steps.x, out.x.begin() + eigen_index(k * at.nx));
  };
  write(0);
  Solvability verdict;
  for (std::size_t k = 0; k < K && verdict.ok(); ++k) {
    if (monitor && !monitor()) {
      verdict.not_finite = true;
      break;
    }
    motion.tangent.dq.setZero();
    motion.tangent.dy.setZero();
    motion.tangent.dq.leftCols(nv).setIdentity();
    motion.tangent.dy.middleCols(nv, nv + nx).setIdentity();
    verdict = motion.advance(t + static_cast<double>(k + 1) * step, tau.subspan(k * at.nv, at.nv), dtau, du);
    write(k + 1);
    Matrix all(m, m + nv + nu + 1);
    all << motion.tangent.dq, motion.tangent.dy;
    Eigen::Map<Rows>(out.A.data() + k * n * n, m, m) = all.leftCols(m);
    Eigen::Map<Rows>(out.B.data() + k * n * at.nv, m, nv) = all.middleCols(m, nv);
    Eigen::Map<Rows>(out.C.data() + k * n * at.nu, m, nu) = all.middleCols(m + nv, nu);
  }
  return solved_or_nan(verdict, {out.q, out.v, out.x, out.A, out.B, out.C});
}

Solvability rollout_jvp_with_drives(const Model& model, const DriveSystem& drives, double t, Span q, Span v,
                                    Span x, Span tau, double step, const DriveTangents& d,
                                    const DriveRows<double>& out, const Loads<double>& loads,
                                    const Tableau& method, const Monitor& monitor) {
  const Sizes at(model, drives, tau);
  const std::size_t K = at.K;
  check_sizes({{"q", q, at.nq, "nq"},
               {"v", v, at.nv, "nv"},
               {"x", x, x.empty() ? 0 : at.nx, "nx"},
               {"tau", tau, K * at.nv, "K nv"},
               {"d.q", d.q, at.nv, "nv"},
               {"d.v", d.v, at.nv, "nv"},
               {"d.x", d.x, at.nx, "nx"},
               {"d.tau", d.tau, K * at.nv, "K nv"},
               {"d.u", d.u, K * at.nu, "K nu"}},
              {{"out.q", out.q, (K + 1) * at.nv, "(K + 1) nv"},
               {"out.v", out.v, (K + 1) * at.nv, "(K + 1) nv"},
               {"out.x", out.x, (K + 1) * at.nx, "(K + 1) nx"}});
  check_motion(model, drives, t, q, v, x, loads, method, step);
  DriveTangentSteps motion(model, drives, loads, method, 1);
  motion.steps.begin(t, q, v, x);
  TangentSteps& tangent = motion.tangent;
  tangent.dq.col(0) = column(d.q, 0, at.nv);
  tangent.dy.col(0) << column(d.v, 0, at.nv), column(d.x, 0, at.nx);
  const auto write = [&](std::size_t k) {
    std::copy_n(tangent.dq.data(), at.nv, out.q.data() + k * at.nv);
    std::copy_n(tangent.dy.data(), at.nv, out.v.data() + k * at.nv);
    std::copy_n(tangent.dy.data() + at.nv, at.nx, out.x.data() + k * at.nx);
  };
  write(0);
  Solvability verdict;
  for (std::size_t k = 0; k < K && verdict.ok(); ++k) {
    verdict = monitor && !monitor()
                  ? Solvability{.not_finite = true}
                  : motion.advance(t + static_cast<double>(k + 1) * step, tau.subspan(k * at.nv, at.nv),
                                   column(d.tau, k, at.nv), column(d.u, k, at.nu));
    write(k + 1);
  }
  return solved_or_nan(verdict, {out.q, out.v, out.x});
}

Solvability rollout_vjp_with_drives(const Model& model, const DriveSystem& drives, double t, Span q, Span v,
                                    Span x, Span tau, double step, const DriveRows<const double>& w,
                                    const DriveGradients& gradient, const Loads<double>& loads,
                                    const Tableau& method, const Monitor& monitor) {
  const Sizes at(model, drives, tau);
  const std::size_t K = at.K, n = at.n();
  check_sizes({{"q", q, at.nq, "nq"},
               {"v", v, at.nv, "nv"},
               {"x", x, x.empty() ? 0 : at.nx, "nx"},
               {"tau", tau, K * at.nv, "K nv"},
               {"w.q", w.q, (K + 1) * at.nv, "(K + 1) nv"},
               {"w.v", w.v, (K + 1) * at.nv, "(K + 1) nv"},
               {"w.x", w.x, (K + 1) * at.nx, "(K + 1) nx"}},
              {{"gradient.q", gradient.q, at.nv, "nv"},
               {"gradient.v", gradient.v, at.nv, "nv"},
               {"gradient.x", gradient.x, at.nx, "nx"},
               {"gradient.tau", gradient.tau, K * at.nv, "K nv"},
               {"gradient.u", gradient.u, K * at.nu, "K nu"}});
  Vector q_out((K + 1) * at.nq), v_out((K + 1) * at.nv), x_out((K + 1) * at.nx);
  Vector A(K * n * n), B(K * n * at.nv), C(K * n * at.nu);
  const Solvability verdict = rollout_derivatives_with_drives(
      model, drives, t, q, v, x, tau, step, {q_out, v_out, x_out, A, B, C}, loads, method, monitor);
  const auto of_state = [&](std::size_t k) {
    Matrix all(eigen_index(n), 1);
    all << column(w.q, k, at.nv), column(w.v, k, at.nv), column(w.x, k, at.nx);
    return all;
  };
  Matrix by = of_state(K);
  const auto back = [&](const Vector& all, std::size_t k, std::size_t width, double* out) {
    const Eigen::Map<const Rows> step_matrix(all.data() + k * n * width, eigen_index(n), eigen_index(width));
    Eigen::Map<Matrix>(out, eigen_index(width), 1) = step_matrix.transpose() * by;
  };
  Vector before(n);
  for (std::size_t k = K; k-- > 0;) {
    back(B, k, at.nv, gradient.tau.data() + k * at.nv);
    back(C, k, at.nu, gradient.u.data() + k * at.nu);
    back(A, k, n, before.data());
    by = column(before, 0, n) + of_state(k);
  }
  std::copy_n(by.data(), at.nv, gradient.q.data());
  std::copy_n(by.data() + at.nv, at.nv, gradient.v.data());
  std::copy_n(by.data() + 2 * at.nv, at.nx, gradient.x.data());
  return solved_or_nan(verdict, {gradient.q, gradient.v, gradient.x, gradient.tau, gradient.u});
}

}  // namespace axode
