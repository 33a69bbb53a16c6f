#include "axode/constraints/mobility.hpp"

#include <algorithm>
#include <cmath>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/loop_system/independent_rows.hpp"
#include "axode/constraints/vector_text.hpp"
#include "axode/recursion/decompositions.hpp"

namespace axode {
namespace {

/// Describes in words a wrench W that is given about the point O, in the axes of the inertial frame.
std::string in_words(const Wrench<Spatial>& W, const Vec3<>& O) {
  const double f = norm(W.f), m = norm(W.m);
  if (!(f > 1e-9 * m)) return "couple about " + rounded_text((1 / m) * W.m);
  const double pitch = dot(W.m, W.f) / (f * f);
  std::string words = "force along " + rounded_text((1 / f) * W.f) + " through " +
                      rounded_text(O + (1 / (f * f)) * cross(W.f, W.m));
  if (std::abs(pitch) > 1e-9) words += " with pitch " + to_text(pitch);
  return words;
}

/// Whether some linear combination of symmetric matrices (quadratic forms, scaled to size 1) is positive
/// definite. Rosenblatt's rule finds its factors: as long as the present combination is not positive at some
/// vector, the value of each form at this vector is added to the factor of the form.
bool has_definite_combination(const std::vector<Eigen::MatrixXd>& forms) {
  constexpr int most = 500;
  const auto count = static_cast<Eigen::Index>(forms.size());
  const auto is_definite = [](const Eigen::VectorXd& lambda) {  // in ascending order
    return lambda[0] > 1e-7 * lambda.cwiseAbs().maxCoeff();
  };
  Eigen::VectorXd factors(count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const Eigen::MatrixXd& form = forms[static_cast<std::size_t>(n)];
    const Eigen::VectorXd lambda = symmetric_eigen(form).values;
    if (is_definite(lambda) || is_definite(-lambda.reverse())) return true;
    factors[n] = form.trace();
  }
  for (int k = 0; k < most && count > 1; ++k) {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(forms[0].rows(), forms[0].cols());
    for (Eigen::Index n = 0; n < count; ++n) sum += factors[n] * forms[static_cast<std::size_t>(n)];
    const SymmetricEigen found = symmetric_eigen(sum);
    if (is_definite(found.values)) return true;
    const Eigen::VectorXd x = found.vectors.col(0);
    for (Eigen::Index n = 0; n < count; ++n) factors[n] += x.dot(forms[static_cast<std::size_t>(n)] * x);
  }
  return false;
}

/// Decides by a test of second order whether the velocities x with A x = 0 (the loop equations) belong to
/// finite motions; `kernel` spans these velocities. Along a finite motion n·γ(x) = 0 for every dependency nᵀ
/// A = 0 of the equations (the columns of `dependencies`), where γ is the part of (A x)' that is quadratic in
/// x. If all forms n·γ are 0, the result is Mobility::regular. If a definite combination of them is found,
/// only x = 0 satisfies the condition: the loops allow velocities, but no finite motion (Mobility::shaky).
/// Otherwise several finite motions may pass through q (Mobility::branches).
Mobility second_order(LoopSystem<double>& system, std::span<const double> q, const Eigen::MatrixXd& kernel,
                      const Eigen::MatrixXd& dependencies) {
  const Eigen::Index f = kernel.cols();
  if (f == 0) return Mobility::regular;
  Eigen::VectorXd h(kernel.rows()), gamma(dependencies.rows());
  const auto form = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    system.move(q.data(), x.data(), {}, h.data());
    system.bias(gamma.data());
    return dependencies.transpose() * gamma;
  };
  std::vector<Eigen::MatrixXd> forms(static_cast<std::size_t>(dependencies.cols()), Eigen::MatrixXd(f, f));
  for (Eigen::Index a = 0; a < f; ++a)
    for (Eigen::Index b = 0; b <= a; ++b) {
      const Eigen::VectorXd x = kernel.col(a), y = kernel.col(b), both = 0.25 * (form(x + y) - form(x - y));
      for (std::size_t n = 0; n < forms.size(); ++n)
        forms[n](a, b) = forms[n](b, a) = both[static_cast<Eigen::Index>(n)];
    }
  std::vector<Eigen::MatrixXd> restricting;
  for (std::size_t n = 0; n < forms.size(); ++n) {
    const double size = symmetric_eigen(forms[n]).values.cwiseAbs().maxCoeff();
    if (size > 1e-7 * dependencies.col(static_cast<Eigen::Index>(n)).norm())
      restricting.push_back(forms[n] / size);
  }
  if (restricting.empty()) return Mobility::regular;
  return has_definite_combination(restricting) ? Mobility::shaky : Mobility::branches;
}

}  // namespace

std::string_view to_string(Mobility mobility) {
  switch (mobility) {
    case Mobility::regular: return "regular";
    case Mobility::branches: return "branches";
    case Mobility::shaky: return "shaky";
  }
  return "";
}

LoopMobility loop_mobility(const Model& model, std::span<const double> q) {
  LoopWorkspace<double> workspace(model);
  LoopSystem<double>& system = checked<double>(model, workspace, q);
  LoopMobility found{.degrees_of_freedom = model.nv(), .redundant = {}, .indeterminate = {}, .kernel = {}};
  system.update_kinematics(q.data());
  Eigen::VectorXd r(model.loops().residuals);
  system.residual(q.data(), r.data());
  const double open = r.size() > 0 ? r.norm() : 0;
  const IndependentRows<double> rows(system, ConstraintLevel::velocity, std::max(1e-8, open));
  found.rank = rows.rank();
  found.degrees_of_freedom = model.nv() - found.rank;
  found.kernel = rows.kernel();
  for (std::size_t n = 0; n < rows.redundant.size(); ++n) {
    const Eigen::VectorXd dependency = rows.dependencies.col(static_cast<Eigen::Index>(n));
    const std::vector<LoopRows>& loops = model.loops().all;
    const auto of = std::ranges::find_if(
        loops, [&](const LoopRows& loop) { return rows.redundant[n] < loop.first_row + loop.rows; });
    const auto k = static_cast<std::size_t>(of - loops.begin());
    found.redundant.push_back({rows.redundant[n], of->name, dependency,
                               k < model.loops().joints.size()
                                   ? in_words(system.wrench(k, dependency.data()), system.origin(k))
                                   : "coupling"});
  }
  const Eigen::VectorXd size = system.scale().head(model.loops().rows);
  for (int k = 0; k < model.loops().rows; ++k)
    if (std::ranges::any_of(found.redundant, [&](const RedundantRow& row) {
          return std::abs(row.dependency[k]) * size[k] > 1e-8 * size[row.row];
        }))
      found.indeterminate.push_back(k);
  found.mobility = second_order(system, q, found.kernel, rows.dependencies);
  return found;
}

}  // namespace axode
