#include "axode/constraints/assembly.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/constraints/prescribed/motion_rows.hpp"
#include "axode/constraints/stable_norm.hpp"
#include "axode/eigen.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"
#include "axode/recursion/decompositions.hpp"

namespace axode {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// The search for a configuration with closed loops. All residuals and steps are without units: lengths are
/// divided by the largest distance of a body on a loop from the first body on its path from the ground.
class Assembly {
 public:
  /// Searches in the model of `motions`, in which every prescribed motion is a loop, see MotionRows.
  Assembly(MotionRows& motions, const AssemblyOptions& options)
      : model_(motions.model()), options_(options), workspace_(model_), system_(workspace_.system(model_)) {
    motions.impose(options.time, system_);
  }

  AssemblyResult run(std::span<const double> q, std::span<const double> v) {
    result_.q.assign(q.begin(), q.end());
    result_.v.assign(v.begin(), v.end());
    result_.v.resize(static_cast<std::size_t>(model_.nv()));
    system_.update_kinematics(neutral(model_).data());
    size_ = size();
    unit_of_velocity_.setOnes(model_.nv());
    for (const Joint& joint : model_.joints())
      if (!joint.leader)
        with_subgroup(joint.kind, 1.0, [&](const auto& kind) {
          for (int k = kind.angles; k < kind.nv; ++k) unit_of_velocity_[joint.iv + k] = size_;
        });
    unit_of_residual_ = units_of_rows(ConstraintLevel::position);
    unit_of_row_ = units_of_rows(ConstraintLevel::velocity);
    result_.status = close();
    if (result_.status == AssemblyStatus::closed && !v.empty()) result_.status = adapt_velocities();
    report(residual_of(result_.q).cwiseProduct(unit_of_residual_));
    return std::move(result_);
  }

 private:
  static constexpr int patience = 5;

  AssemblyStatus close() {
    Vector r = residual_of(result_.q);
    const double enough = options_.tolerance;
    double damping = 1e-4;
    int slow = 0;  // number of consecutive steps that hardly reduced the residual
    const auto closed = [&] { return std::isfinite(r.norm()) && r.norm() <= enough; };
    const auto closed_to_rounding = [&] { return r.norm() <= std::max(1e3 * enough, rounding()); };
    for (; !closed(); ++result_.iterations) {
      if (result_.iterations == options_.iterations || (options_.monitor && !options_.monitor()))
        return AssemblyStatus::iteration_limit;
      const Matrix R = rows(ConstraintLevel::position);
      const double slope = (R.transpose() * r).norm(), before = r.norm();
      if (!(slope > 1e-9 * std::pow(before, 1.5))) {
        if (result_.iterations > 0 && closed_to_rounding()) return AssemblyStatus::closed;
        const bool at_guess = result_.iterations == 0 && std::isfinite(slope);
        return at_guess ? AssemblyStatus::singular_guess : AssemblyStatus::open;
      }
      bool better = false;
      for (int attempt = 0; attempt < 30 && !better; ++attempt) {
        const std::vector<double> q =
            integrate(model_, result_.q, as_numbers(unit_of_velocity_.cwiseProduct(step(R, r, damping))));
        const Vector r_there = residual_of(q);
        better = r_there.norm() < r.norm();
        damping *= better ? 0.1 : 10;
        if (!better) continue;
        result_.q = q;
        r = r_there;
      }
      static_cast<void>(residual_of(result_.q));
      if (!better) return closed_to_rounding() ? AssemblyStatus::closed : AssemblyStatus::open;
      slow = r.norm() > 0.9 * before ? slow + 1 : 0;
      if (slow >= patience && closed_to_rounding()) return AssemblyStatus::closed;
    }
    return AssemblyStatus::closed;
  }
  /// The damped least-squares solution x = -Rᵀ (R Rᵀ + small I)⁻¹ r of R x = -r.
  static Vector least(const Matrix& R, const Vector& r, double small) {
    Matrix S = R * R.transpose();
    S.diagonal().array() += small;
    return -R.transpose() * LdltFactor(S).solve(r);
  }
  /// The damped Gauss-Newton step x towards closed loops, for the residual r and its Jacobian R, without
  /// units: x minimises |r + R x|² + μ |x|² with μ = damping |r| + 1e-12 |R|². If an entry is above 0.5,
  /// which means half a radian or half the length by which all lengths are divided, the whole step is
  /// shortened until the largest entry is 0.5.
  static Vector step(const Matrix& R, const Vector& r, double damping) {
    const Vector x = least(R, r, damping * r.norm() + 1e-12 * R.squaredNorm());
    const double largest = x.cwiseAbs().maxCoeff();
    return largest > 0.5 ? Vector((0.5 / largest) * x) : x;
  }
  static std::vector<double> as_numbers(const Vector& x) { return {x.begin(), x.end()}; }

  /// Computes the residual r(q) without units, and updates the kinematics of the system to q.
  Vector residual_of(const std::vector<double>& q) {
    Vector r(model_.loops().residuals);
    system_.update_kinematics(q.data());
    system_.residual(q.data(), r.data());
    return r.cwiseQuotient(unit_of_residual_);
  }
  /// The units by which loop equations are divided: the length (m) by which all lengths are divided for an
  /// equation whose constraint wrench has a force, 1 for an equation whose wrench is a couple, and the unit
  /// of its first term for a coupling of joints.
  Vector units_of_rows(ConstraintLevel level) {
    system_.make_rows(level);
    Vector units = Vector::Ones(system_.size(level));
    Vector one = Vector::Zero(system_.size(level));
    const LoopTable& table = system_.table();
    for (std::size_t k = 0; k < table.paths.size(); ++k) {
      const LoopPath& path = table.paths[k];
      const LoopPath::Range rows = level == ConstraintLevel::position ? path.residuals : path.rows;
      for (int r = rows.first; r < rows.first + rows.count; ++r) {
        if (k >= table.joints.size()) {
          units[r] = unit_of(model_.loops().couplings[k - table.joints.size()]);
          continue;
        }
        one[r] = 1;
        if (norm(system_.wrench(k, one.data()).f) > 0) units[r] = size_;
        one[r] = 0;
      }
    }
    return units;
  }
  double unit_of(const LoopCoupling& coupling) const {
    const LoopCoupling::Term& first = coupling.terms.front();
    return std::abs(first.factor) * unit_of_velocity_[first.velocity];
  }
  /// The Jacobian of the loop residuals (position level) or of the loop equations for velocities (velocity
  /// level) at the present kinematics, made free of units. Columns of velocities that are held fixed are 0.
  Matrix rows(ConstraintLevel level) {
    LoopSystem<double>::RowByRow R(system_.size(level), model_.nv());
    system_.make_rows(level);
    system_.write(R.data());
    for (const int c : options_.held) R.col(c).setZero();
    const Vector& unit = level == ConstraintLevel::position ? unit_of_residual_ : unit_of_row_;
    return unit.cwiseInverse().asDiagonal() * R * unit_of_velocity_.asDiagonal();
  }
  AssemblyStatus adapt_velocities() {
    if (options_.held.empty()) {
      const bool found = impact(model_, workspace_, result_.q, result_.v, 0.0, result_.v).ok();
      return found ? AssemblyStatus::closed : AssemblyStatus::singular;
    }
    static_cast<void>(residual_of(result_.q));
    Vector rates(model_.loops().rows);
    system_.make_rows(ConstraintLevel::velocity);
    system_.velocity_residual(result_.v.data(), rates.data());
    rates.array() /= unit_of_row_.array();
    const Matrix A = rows(ConstraintLevel::velocity);
    Eigen::Map<Vector> v(result_.v.data(), model_.nv());
    const double first = stable_norm(as_span(rates));
    for (int n = 0; n < 3; ++n) {  // each step reduces the residual A v to a small part of it
      const Vector dv = least(A, rates, 1e-8 * A.squaredNorm());
      v += unit_of_velocity_.cwiseProduct(dv);
      rates += A * dv;
    }
    constexpr double tolerable = 1e-8;
    const Vector without_units = v.cwiseQuotient(unit_of_velocity_);
    const double size = first + A.norm() * stable_norm(as_span(without_units));
    return is_within(stable_norm(as_span(rates)), tolerable * size) ? AssemblyStatus::closed
                                                                    : AssemblyStatus::held_velocities;
  }
  /// The length (m) by which all lengths are divided: the largest distance of a body on a loop from the first
  /// body on its path from the ground, or of a loop joint from the origin of its body; 1 if all these
  /// distances are 0. It must be called with the kinematics of the neutral configuration.
  double size() const {
    double largest = 0;
    for (const LoopPath& path : system_.table().paths) {
      for (const int i : path.bodies) largest = std::max(largest, norm(system_.link(i).C.r));
      for (const Loop::End& end : path.ends) largest = std::max(largest, norm(end.F.r));
    }
    return largest > 0 ? largest : 1;
  }
  /// A bound on the rounding errors of the residual without units, at the present configuration.
  double rounding() const {
    double sum = 0;
    const LoopTable& table = system_.table();
    for (std::size_t k = 0; k < table.paths.size(); ++k)
      sum += static_cast<double>(table.paths[k].bodies.size() + 4) *
             (k < table.joints.size() ? largest_term(table.paths[k])
                                      : largest_term(model_.loops().couplings[k - table.joints.size()]));
    return 4 * std::numeric_limits<double>::epsilon() * sum;
  }
  /// An upper estimate of the terms from which the residual of a loop is computed, without unit; the bound on
  /// rounding errors is proportional to it. For a loop joint it is the largest coordinate or distance, or
  /// product of an angle and a distance; for a coupling of joints, the offset or the largest product of a
  /// factor and a coordinate.
  double largest_term(const LoopCoupling& coupling) const {
    double largest = std::abs(coupling.offset);
    for (const LoopCoupling::Term& term : coupling.terms)
      largest =
          std::max(largest, std::abs(term.factor * result_.q[static_cast<std::size_t>(term.coordinate)]));
    return largest / unit_of(coupling);
  }
  double largest_term(const LoopPath& path) const {
    const std::vector<double>& q = result_.q;
    double length = 0, angle = 0, lever = size_;
    for (const int root : path.root)
      if (root > 0) length = std::max(length, norm(system_.root_origins()[root]));
    for (const Loop::End& end : path.ends) length = std::max(length, norm(end.F.r));
    for (const int i : path.bodies) {
      lever = std::max(lever, norm(system_.link(i).C.r));
      const Joint& joint = model_.joint(i);
      const std::array<bool, 6> free = free_directions(joint.kind);
      for (int k = 0; k < joint.nq; ++k) {
        double& largest = k == 0 && free[2] && !free[0] ? angle : length;
        largest = std::max(largest, std::abs(q[static_cast<std::size_t>(joint.iq + k)]));
      }
    }
    return std::max({length, lever, lever * angle}) / size_;
  }
  void report(const Vector& r) {
    result_.residual = r.norm();
    for (const LoopRows& loop : model_.loops().all)
      result_.open.push_back(r.segment(loop.first_residual, loop.residuals).norm());
  }

  const Model& model_;
  const AssemblyOptions& options_;
  LoopWorkspace<double> workspace_;
  LoopSystem<double>& system_;
  double size_ = 1;                        ///< size of the loops, m; see size()
  Vector unit_of_velocity_;                ///< unit of each velocity: size_ for a length, and 1 for an angle
  Vector unit_of_residual_, unit_of_row_;  ///< units of the rows R and A, see units_of_rows()
  AssemblyResult result_;
};

}  // namespace

std::string_view to_string(AssemblyStatus status) {
  switch (status) {
    case AssemblyStatus::closed: return "closed";
    case AssemblyStatus::open: return "open";
    case AssemblyStatus::singular_guess: return "singular_guess";
    case AssemblyStatus::iteration_limit: return "iteration_limit";
    case AssemblyStatus::singular: return "singular";
    case AssemblyStatus::held_velocities: return "held_velocities";
  }
  return "";
}

std::string to_string(const Model& model, const AssemblyResult& result) {
  if (result.status == AssemblyStatus::closed) return "all loops are closed";
  if (result.status == AssemblyStatus::singular)
    return "the loops are closed, but the mass matrix of the tree is singular, so velocities cannot be "
           "adapted";
  if (result.status == AssemblyStatus::held_velocities)
    return "the loops are closed, but no velocities with the held ones keep them closed; hold fewer "
           "velocities, "
           "or give v that fits the loops";
  const MotionRows motions(model);
  const std::vector<LoopRows>& loops = motions.model().loops().all;
  std::vector<std::size_t> order(loops.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order,
                           [&](std::size_t a, std::size_t b) { return result.open[a] > result.open[b]; });
  const bool singular = result.status == AssemblyStatus::singular_guess;
  std::string text =
      singular ? "the guess is singular, stretched or folded: to first order no joint that may move "
                 "closes a loop further: "
      : result.status == AssemblyStatus::open
          ? "does not close from this guess: "
          : "is not closed after " + std::to_string(result.iterations) + " iterations: ";
  const char* separator = "";
  for (const std::size_t k : order) {
    if (result.open[k] < 1e-3 * result.open[order[0]]) break;
    text += separator + ("loop \"" + loops[k].name + "\" stays open by " + to_text(result.open[k]));
    separator = ", ";
  }
  return text + (singular ? " (rad and m); turn one of its joints a little and try again"
                          : " (rad and m); another guess may close it");
}

AssemblyResult assemble(const Model& model, std::span<const double> q, std::span<const double> v,
                        const AssemblyOptions& options) {
  check_configuration(model, q);
  if (!v.empty()) check_size("v", v.size(), static_cast<std::size_t>(model.nv()), "nv");
  if (const std::string bad = first_not_finite(model, q, v); !bad.empty())
    throw std::invalid_argument("assemble: " + bad + "; it must be finite");
  for (const int c : options.held)
    if (c < 0 || c >= model.nv())
      throw std::invalid_argument("held: there is no velocity " + std::to_string(c) + "; model \"" +
                                  model.name() + "\" has velocities 0 to " + std::to_string(model.nv() - 1));
  MotionRows motions(model);
  return Assembly(motions, options).run(q, v);
}

}  // namespace axode
