#include "axode/integration/dry_friction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/eigen.hpp"

namespace axode {

namespace {

/// The acceleration of a sticking joint counts as 0 up to a tolerance, the sum of two parts (D9.6). The first
/// is by_friction times the acceleration that the joint's own friction can cause. The second is by_largest
/// times the energy norm of the accelerations of all joints, converted to an acceleration of this joint: the
/// acceleration that has this norm if all others are 0.
constexpr double by_friction = 1e-9, by_largest = 1e-13;

}  // namespace

DryFriction::DryFriction(const Tree<double>& tree, std::span<const Gear> gears, bool enabled) : tree_(&tree) {
  if (!enabled) return;
  has_gears_ = !gears.empty();
  for (int c = 0; c < tree->nv; ++c) {
    const auto gear = std::ranges::find(gears, c, &Gear::velocity);
    if (tree.friction[at(c)] > 0 || gear != gears.end())
      joints_.push_back({.velocity = c,
                         .friction = tree.friction[at(c)],
                         .direction = 0,
                         .force = 0,
                         .gear = gear == gears.end() ? Gear{} : *gear});
  }
  list_sticking();
}

void DryFriction::list_sticking() {
  for (std::vector<int>* velocities : {&sticking_, &resisting_}) velocities->clear();
  for (std::vector<std::size_t>* joints : {&sticking_joints_, &resisting_joints_}) joints->clear();
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    const Joint& joint = joints_[k];
    if (joint.direction == 0) {
      sticking_.push_back(joint.velocity);
      sticking_joints_.push_back(k);
    }
    if (joint.direction == 0 || joint.gear.loss > 0 || joint.gear.loss_back > 0) {
      resisting_.push_back(joint.velocity);
      resisting_joints_.push_back(k);
    }
  }
}

void DryFriction::start(Span v) {
  for (Joint& joint : joints_) {
    const double v_c = v[at(joint.velocity)];
    joint.direction = (v_c > 0) - (v_c < 0);
    joint.force = 0;
  }
  list_sticking();
}

void DryFriction::add_losses(Span v, std::span<double> tau) const {
  for (std::size_t c = 0; c < tau.size(); ++c) tau[c] -= tree_->damping[c] * v[c];
  for (const Joint& joint : joints_) tau[at(joint.velocity)] -= joint.direction * joint.friction;
}

int DryFriction::apply_friction(const Matrix& compliance, Span own, const EnergyNorm& norm, Span v,
                                Span drive, std::span<double> a) {
  if (has_gears_) return apply_with_gears(compliance, own, norm, v, drive, a);
  const auto k = static_cast<Eigen::Index>(sticking_joints_.size());
  const double size = norm.of_velocities(as_eigen(Span(a)));
  A_.resize(k, k);
  a_0_.resize(k);
  tolerance_.resize(k);
  for (Eigen::Index i = 0; i < k; ++i) {
    const Joint& joint = sticking_joint(i);
    A_.row(i) = compliance.row(joint.velocity);
    a_0_[i] = a[at(joint.velocity)];
    tolerance_[i] = by_friction * A_(i, i) * joint.friction + by_largest * norm.alone(joint.velocity, size);
  }
  find_forces(*std::ranges::max_element(own));
  for (Eigen::Index i = 0; i < k; ++i)
    sticking_joint(i).set_margin(sticking_joint(i).friction, a_[i], tolerance_[i], own[at(i)]);
  for (Eigen::Index i = 0; i < k; ++i)
    for (std::size_t c = 0; c < a.size(); ++c)
      a[c] += compliance(static_cast<Eigen::Index>(c), i) * sticking_joint(i).force;
  for (Eigen::Index i = 0; i < k; ++i) {
    const double slip = std::abs(a_[i]) / tolerance_[i];
    violation_ = std::max(violation_, slip);
    a[at(sticking_[at(i)])] = slip > 1 ? a_[i] : 0;
  }
  return -1;
}

int DryFriction::apply_with_gears(const Matrix& compliance, Span own, const EnergyNorm& norm, Span v,
                                  Span drive, std::span<double> a) {
  const auto k = static_cast<Eigen::Index>(resisting_.size());
  const double size = norm.of_velocities(as_eigen(Span(a)));
  const Eigen::MatrixXd Phi = compliance(resisting_, Eigen::all);
  resistances_.clear();
  a_0_.resize(k);
  for (Eigen::Index i = 0; i < k; ++i) {
    const Joint& joint = joints_[resisting_joints_[at(i)]];
    a_0_[i] = a[at(joint.velocity)];
    resistances_.push_back({.drive = through_gear(joint, v, drive),
                            .friction = joint.direction == 0 ? joint.friction : 0,
                            .rotor = joint.gear.rotor,
                            .loss = joint.gear.loss,
                            .loss_back = joint.gear.loss_back,
                            .direction = joint.direction,
                            .compliance = own[at(i)]});
  }
  if (const int locked = gear_forces_.find(Phi, a_0_, resistances_); locked >= 0)
    return resisting_[static_cast<std::size_t>(locked)];
  as_eigen(a) += compliance * gear_forces_.x();
  for (Eigen::Index i = 0; i < k; ++i) {
    Joint& joint = joints_[resisting_joints_[at(i)]];
    if (joint.direction != 0) continue;
    const double a_i = gear_forces_.a()[i], bound = gear_forces_.bound(i, a_i < 0 ? -1 : 1);
    const double tolerance = by_friction * own[at(i)] * bound + by_largest * norm.alone(joint.velocity, size);
    const double slip = std::abs(a_i) / tolerance;
    joint.force = gear_forces_.x()[i];
    joint.set_margin(gear_forces_.bound(i, joint.force > 0 ? -1 : 1), a_i, tolerance, own[at(i)]);
    violation_ = std::max(violation_, slip);
    a[at(joint.velocity)] = slip > 1 ? a_i : 0;
  }
  return -1;
}

void DryFriction::add_gear_losses(Span v, Span a, Span drive, std::span<double> r) {
  for (Joint& joint : joints_) {
    if (joint.direction == 0) continue;
    const std::size_t c = at(joint.velocity);
    const double F = r[c] + through_gear(joint, v, drive) - joint.gear.rotor * a[c];
    joint.slope = joint.direction * F > 0 ? joint.gear.loss : -joint.gear.loss_back;
    r[c] += joint.slope * F;
  }
}

void DryFriction::scale_derivatives(std::initializer_list<std::span<double>> derivatives) const {
  const auto nv = static_cast<Eigen::Index>((*tree_)->nv);
  for (const Joint& joint : joints_) {
    if (joint.direction == 0) continue;
    for (const std::span<double> derivative : derivatives)
      Eigen::Map<Matrix>(derivative.data(), nv, nv).row(joint.velocity) *= 1 + joint.slope;
    const std::size_t c = at(joint.velocity);
    derivatives.begin()->data()[c * static_cast<std::size_t>(nv) + c] -= joint.slope * joint.gear.rotor;
  }
}

void DryFriction::factorize(double size) {
  const double little = 1e-12 * size;  // a regularisation, because with loops Φ may be singular
  const auto m = static_cast<Eigen::Index>(free_.size());
  factor_.resize(m);
  auto& F = factor_.matrix();
  for (Eigen::Index r = 0; r < m; ++r)
    for (Eigen::Index s = 0; s < m; ++s) F(r, s) = A_(free_[at(r)], free_[at(s)]) + (r == s ? little : 0);
  factor_.factorize(m);
}

void DryFriction::constrain_derivatives(std::initializer_list<std::span<double>> derivatives) {
  const auto k = static_cast<Eigen::Index>(sticking_.size());
  if (k == 0) return;
  const auto nv = static_cast<Eigen::Index>((*tree_)->nv);
  const Matrix compliance = Eigen::Map<const Matrix>(derivatives.begin()->data(), nv, nv);
  A_ = compliance(sticking_, sticking_);
  free_.resize(sticking_.size());
  for (Eigen::Index i = 0; i < k; ++i) free_[at(i)] = i;
  factorize(compliance.diagonal().maxCoeff());
  step_.resize(RowCholesky<double>::room(k));
  for (const std::span<double> derivative : derivatives) {
    Eigen::Map<Matrix> D(derivative.data(), nv, nv);
    for (Eigen::Index column = 0; column < nv; ++column) {
      step_.setZero();
      for (Eigen::Index i = 0; i < k; ++i) step_[i] = D(sticking_[at(i)], column);
      factor_.solve(k, step_);
      for (Eigen::Index i = 0; i < k; ++i) D.col(column) -= step_[i] * compliance.col(sticking_[at(i)]);
    }
    for (const int c : sticking_) D.row(c).setZero();
  }
}

/// Finds the friction forces x of sticking joints that minimise x·(Φ x/2 + a_0) under |x_c| ≤ f_c (D9.4),
/// with Φ = ∂a/∂τ, the accelerations a_0 without these forces, and the friction limits f_c. The method is an
/// active-set iteration. In each iteration the forces inside their bounds move towards their minimum, with
/// the forces at a bound held constant, until one of them reaches its bound or the minimum is reached. At the
/// minimum, one of the forces at a bound that do not oppose the acceleration of their joint becomes free.
void DryFriction::find_forces(double size) {
  const Eigen::Index k = A_.rows();
  const auto accelerations = [&] {
    a_ = a_0_;
    for (Eigen::Index i = 0; i < k; ++i) a_ += sticking_joint(i).force * A_.col(i);
  };
  bound_.assign(sticking_joints_.size(), 0);
  for (Eigen::Index i = 0; i < k; ++i)
    bound_[at(i)] = std::abs(sticking_joint(i).force) >= sticking_joint(i).friction;
  step_.resize(RowCholesky<double>::room(k));
  for (Eigen::Index tries = 0; tries < 20 + 20 * k; ++tries) {
    free_.clear();
    for (Eigen::Index i = 0; i < k; ++i)
      if (!bound_[at(i)]) free_.push_back(i);
    const auto m = static_cast<Eigen::Index>(free_.size());
    factorize(size);
    bool blocked = false;
    for (int twice = 0; twice < 2 && !blocked; ++twice) {  // the second pass removes the regularisation of
                                                           // factorize()
      accelerations();
      step_.setZero();
      for (Eigen::Index r = 0; r < m; ++r) step_[r] = -a_[free_[at(r)]];
      factor_.solve(m, step_);
      double part = 1;
      Eigen::Index first = -1;
      for (Eigen::Index r = 0; r < m; ++r) {
        const Joint& joint = sticking_joint(free_[at(r)]);
        const double room = (step_[r] > 0 ? joint.friction : -joint.friction) - joint.force;
        if (!(std::abs(step_[r]) * part > std::abs(room))) continue;
        part = room / step_[r];
        first = r;
      }
      for (Eigen::Index r = 0; r < m; ++r) sticking_joint(free_[at(r)]).force += part * step_[r];
      if (first < 0) continue;
      Joint& joint = sticking_joint(free_[at(first)]);
      joint.force = step_[first] > 0 ? joint.friction : -joint.friction;
      bound_[at(free_[at(first)])] = 1;
      blocked = true;
    }
    accelerations();
    if (blocked) continue;
    Eigen::Index worst = -1;
    double most = 1e-3;
    for (Eigen::Index i = 0; i < k; ++i) {
      if (!bound_[at(i)]) continue;
      const double wrong = a_[i] * (sticking_joint(i).force > 0 ? 1 : -1) / tolerance_[i];
      if (!(wrong > most)) continue;
      most = wrong;
      worst = i;
    }
    if (worst < 0) return;
    bound_[at(worst)] = 0;
  }
}

bool DryFriction::reverses(Span v_0, Span a_0, Span v_1, Span a_1, double h) const {
  constexpr double none = -1e-9;
  for (const Joint& joint : joints_) {
    if (joint.direction == 0) continue;
    const std::size_t c = at(joint.velocity);
    const double y_0 = joint.direction * v_0[c], y_1 = joint.direction * v_1[c];
    if (y_1 < 0 || (y_1 == 0 && joint.direction * a_1[c] < 0)) return true;
    // The velocity is interpolated by the cubic y(s) with the velocities and accelerations of both ends. Its
    // minimum is where y' = 0 and y'' > 0.
    const double d_0 = joint.direction * h * a_0[c], d_1 = joint.direction * h * a_1[c], D = y_1 - y_0;
    const double k_3 = d_0 + d_1 - 2 * D, k_2 = 3 * D - 2 * d_0 - d_1;
    const double root = k_2 * k_2 - 3 * k_3 * d_0;
    if (!(root > 0)) continue;
    const double s = k_2 > 0 ? -d_0 / (k_2 + std::sqrt(root)) : (std::sqrt(root) - k_2) / (3 * k_3);
    if (!(s > 0 && s < 1)) continue;
    const double least = y_0 + s * (d_0 + s * (k_2 + s * k_3));
    if (least < none * std::max(y_0, y_1)) return true;
  }
  return false;
}

double DryFriction::reserve(std::size_t k, Span v) const {
  constexpr double least = 1e-12;
  const Joint& joint = joints_[k];
  return joint.direction == 0 ? joint.margin : joint.direction * v[at(joint.velocity)] + least;
}

double DryFriction::time_to_stop(Span v, Span a) const {
  double first = std::numeric_limits<double>::infinity();
  for (const Joint& joint : joints_) {
    const double v_c = joint.direction * v[at(joint.velocity)], a_c = joint.direction * a[at(joint.velocity)];
    if (joint.direction != 0 && a_c < 0) first = std::min(first, -v_c / a_c);
  }
  return std::isfinite(first) ? first : 0;
}

bool DryFriction::stop_sliding(std::span<double> v, Span a, double within) {
  bool any = false;
  for (Joint& joint : joints_) {
    double& v_c = v[at(joint.velocity)];
    const double braking = -joint.direction * a[at(joint.velocity)];
    if (joint.direction * v_c > std::max(0.0, braking) * within) continue;
    v_c = 0;
    if (joint.direction == 0 || !(braking > 0)) continue;
    joint.force = -joint.direction * joint.friction;
    joint.direction = 0;
    any = true;
  }
  list_sticking();
  return any;
}

void DryFriction::start_sliding(Span a) {
  for (std::size_t i = 0; i < sticking_joints_.size(); ++i) {
    const double a_c = a[at(sticking_[i])];
    if (a_c != 0) joints_[sticking_joints_[i]].direction = a_c > 0 ? 1 : -1;
  }
  list_sticking();
}

}  // namespace axode
