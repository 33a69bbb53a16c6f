#include "axode/dynamics/gear_losses.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "axode/recursion/decompositions.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode {

namespace {

/// Tolerance for rounding errors, relative to the magnitude of the forces that are compared.
constexpr double rounding = 1e-13;
/// A small number, relative to the compliance (the acceleration of a joint for a unit force on it), that is
/// added to the diagonal of the equations of sticking joints, because in loops these may be singular.
/// Iterative refinement removes its effect on the accelerations. It is also the tolerance, relative to the
/// compliance of the joint, within which a pivot counts as 0 in the test whether the friction forces are
/// unique (D9.12).
constexpr double regularisation = 1e-12;

}  // namespace

double ResistingForces::magnitude(Eigen::Index i, const Vector& a_0) const {
  const ResistingJoint& joint = joints_[at(i)];
  const double by_a = joint.compliance > 0 ? std::abs(a_0[i]) / joint.compliance : 0;
  return std::abs(tau_[i]) + joint.friction + by_a;
}

double ResistingForces::bound(Eigen::Index i, int direction) const {
  const double F_i = transmitted(i);
  return joints_[at(i)].friction + part_lost(i, direction, F_i < 0 ? -1 : 1) * std::abs(F_i);
}

/// Checks the condition (D9.12) under which the friction forces of joints with gears are unique: Φ + diag(δ)
/// must be positive definite, except that pivots of joints with δ = 0 may be 0. Φ = ∂a/∂τ is the response of
/// the accelerations to joint forces. κ_b is the part of the transmitted force that a gear loses when it is
/// driven back (0 without a gear), and I the armature of the joint, which is the inertia of the rotor as it
/// acts on the joint. For joints that move or have κ_b > 1, δ is (1 - κ_b)/(κ_b I), and the joint is left out
/// of Φ if κ_b I = 0. For all other joints δ is 0. Returns -1 if the condition holds, and otherwise the index
/// i of the joint with the most negative δ_i/Φ_ii.
int ResistingForces::not_unique(const Matrix& Phi) const {
  std::vector<Eigen::Index> rows;  // joints that stick in the worst case come first
  std::vector<double> diagonal;
  const auto add = [&](bool sticking) {
    for (Eigen::Index i = 0; i < Phi.rows(); ++i) {
      const ResistingJoint& joint = joints_[at(i)];
      const bool free = joint.direction != 0 || joint.loss_back > 1;
      const double by_a = joint.loss_back * joint.rotor;
      if (free == sticking || (free && by_a == 0)) continue;  // then x does not depend on a
      rows.push_back(i);
      diagonal.push_back(free ? (1 - joint.loss_back) / by_a : 0);
    }
  };
  add(true);
  add(false);
  const auto k = static_cast<Eigen::Index>(rows.size());
  Matrix B = Phi(rows, rows);
  Eigen::Index worst = -1;
  for (Eigen::Index i = 0; i < k; ++i) {
    const double own = B(i, i);
    if (diagonal[at(i)] < 0 && (worst < 0 || diagonal[at(i)] / own < diagonal[at(worst)] / B(worst, worst)))
      worst = i;
  }
  if (worst < 0) return -1;
  const int culprit = static_cast<int>(rows[at(worst)]);
  for (Eigen::Index i = 0; i < k; ++i) B(i, i) += diagonal[at(i)];
  for (Eigen::Index i = 0; i < k; ++i) {
    const bool sticks = diagonal[at(i)] == 0;
    if (!(B(i, i) > regularisation * joints_[at(rows[at(i)])].compliance)) {
      if (!sticks) return culprit;
      continue;  // the joints before this one hold it already
    }
    for (Eigen::Index r = i + 1; r < k; ++r) {
      const double factor = B(r, i) / B(i, i);
      for (Eigen::Index c = i + 1; c < k; ++c) B(r, c) -= factor * B(i, c);
    }
  }
  return -1;
}

/// Sets the friction forces and the data of a start problem, from which a continuation method moves the data
/// along a straight line to those of the given problem. The solution of the start problem is known: joints at
/// rest stick without a friction force. In moving joints the drive drives the gear, and the friction force is
/// the loss of the gear.
///
/// The friction laws are linear in pieces: a piece of a joint ends when the joint begins or ceases to slide,
/// or when the force that its gear transmits changes its sign. The method changes the piece of one joint at a
/// time. Therefore the transmitted forces of the start problem differ from joint to joint. If they were
/// equal, several joints of a symmetric mechanism would reach the ends of their pieces at the same time.
void ResistingForces::start(const Matrix& Phi, const Vector& a_0) {
  const Eigen::Index k = Phi.rows();
  x_ = a_ = Vector::Zero(k);
  for (Eigen::Index i = 0; i < k; ++i) {
    const ResistingJoint& joint = joints_[at(i)];
    double size = magnitude(i, a_0);
    if (!(size > 0)) size = 1;
    size *= 1 + 0.3 * std::abs(std::sin(1.0 + static_cast<double>(i)));
    const int sign = joint.direction != 0 ? joint.direction : (tau_[i] < 0 ? -1 : 1);
    pieces_[at(i)] = {joint.direction, sign};
    x_[i] = joint.direction != 0 ? -sign * part_lost(i, sign, sign) * size : 0;
    tau_[i] = sign * size - x_[i];
  }
  start_a_0_ = -Phi * x_;
}

/// Solves the equations (D9.10) for the friction forces x. They are linear for the present pieces_, which say
/// for each joint whether it sticks or in which direction it slides, and which sign the force of its gear
/// has. If `little` is positive, it is added to the diagonal of the equations of sticking joints, and changes
/// x. If it is 0, a smaller number is added, whose effect on x is removed by iterative refinement.
ResistingForces::Vector ResistingForces::solve(const Matrix& Phi, const Vector& a_0, const Vector& tau,
                                               double little) const {
  const Eigen::Index k = Phi.rows();
  Matrix A(k, k);
  Vector rhs(k), regular = Vector::Zero(k);
  for (Eigen::Index i = 0; i < k; ++i) {
    const ResistingJoint& joint = joints_[at(i)];
    const auto& [slide, sign] = pieces_[at(i)];
    if (slide == 0) {
      A.row(i) = Phi.row(i) / joint.compliance;
      rhs[i] = -a_0[i] / joint.compliance;
      regular[i] = little > 0 ? little : regularisation;
    } else {
      const double part = slide * sign * part_lost(i, slide, sign);
      A.row(i) = -part * joint.rotor * Phi.row(i);
      A(i, i) += 1 + part;
      rhs[i] = -slide * joint.friction - part * (tau[i] - joint.rotor * a_0[i]);
    }
  }
  Matrix regularised = A;
  regularised.diagonal() += regular;
  const LuFactor factors(regularised);
  Vector x = factors.solve(rhs);
  if (little == 0)
    for (int pass = 0; pass < 2; ++pass) x += factors.solve(rhs - A * x);
  return x;
}

std::vector<ResistingForces::Boundary> ResistingForces::boundaries(Eigen::Index i, const Vector& x,
                                                                   const Vector& a, const Vector& tau) const {
  const ResistingJoint& joint = joints_[at(i)];
  const Piece piece = pieces_[at(i)];
  const double size = F(i, x, a, tau) * piece.sign;
  std::vector<Boundary> all;
  if (has_gear(i)) all.push_back({size, {piece.slide, -piece.sign}});
  if (joint.direction != 0) return all;
  if (piece.slide != 0) {
    all.push_back({piece.slide * a[i] / joint.compliance, {0, piece.sign}});
    return all;
  }
  for (const int slide : {1, -1}) {
    const double most = joint.friction + part_lost(i, slide, piece.sign) * size;
    all.push_back({most + slide * x[i], {slide, piece.sign}});
  }
  return all;
}

/// Finds the friction forces by continuation: moves the data of the equations along a straight line from a
/// start problem with a known solution to the given a_0 (accelerations without friction) and `tau` (drive
/// forces), and follows the solution from one piece in which the equations are linear to the next. Writes the
/// friction forces to x_. `little` regularises the equations of sticking joints. Returns false if the given
/// problem is not reached after a limited number of pieces.
bool ResistingForces::follow(const Matrix& Phi, const Vector& a_0, const Vector& tau, double little) {
  const Eigen::Index k = Phi.rows();
  tau_ = tau;
  start(Phi, a_0);
  Vector now_a_0 = start_a_0_, now_x = x_, now_tau = tau_;
  tau_ = tau;
  for (Eigen::Index tries = 0; tries < 100 + 40 * k; ++tries) {
    const Vector x = solve(Phi, a_0, tau, little), a = a_0 + Phi * x, now_a = now_a_0 + Phi * now_x;
    double part = 1;
    Eigen::Index first = -1;
    Piece beyond{};
    for (Eigen::Index i = 0; i < k; ++i) {
      const std::vector<Boundary> now = boundaries(i, now_x, now_a, now_tau), end = boundaries(i, x, a, tau);
      const double none = rounding * (magnitude(i, a_0) + std::abs(x[i]));
      for (std::size_t b = 0; b < end.size(); ++b) {
        if (!(end[b].value < -none)) continue;
        const double from = std::max(now[b].value, 0.0), at_end = from / (from - end[b].value);
        if (first >= 0 && !(at_end < part)) continue;
        part = at_end;
        first = i;
        beyond = end[b].beyond;
      }
    }
    if (first < 0) {
      x_ = x;
      return true;
    }
    now_x += part * (x - now_x);
    now_tau += part * (tau - now_tau);
    now_a_0 += part * (a_0 - now_a_0);
    pieces_[at(first)] = beyond;
  }
  return false;
}

int ResistingForces::find(const Matrix& Phi, const Vector& a_0, std::span<const ResistingJoint> joints) {
  joints_ = joints;
  const Eigen::Index k = Phi.rows();
  const bool known = pieces_.size() == joints.size();  // the pieces of the last problem are the first guess
  pieces_.resize(joints.size());
  Vector tau(k);
  for (Eigen::Index i = 0; i < k; ++i) tau[i] = joints[at(i)].drive;
  tau_ = tau;
  if (const int joint = not_unique(Phi); joint >= 0) return joint;
  const auto inside = [&](const Vector& x, const Vector& a) {
    for (Eigen::Index i = 0; i < k; ++i) {
      if (pieces_[at(i)].slide != joints[at(i)].direction && joints[at(i)].direction != 0) return false;
      for (const Boundary& each : boundaries(i, x, a, tau))
        if (each.value < -rounding * (magnitude(i, a_0) + std::abs(x[i]))) return false;
    }
    return true;
  };
  const auto finish = [&](const Vector& x) {
    x_ = x;
    a_ = a_0 + Phi * x;
    for (Eigen::Index i = 0; i < k; ++i)
      if (sticks(i)) a_[i] = 0;
    return -1;
  };
  if (known) {
    const Vector x = solve(Phi, a_0, tau);
    if (x.allFinite() && inside(x, a_0 + Phi * x)) return finish(x);
  }
  if (follow(Phi, a_0, tau, 0)) return finish(x_);
  constexpr double little = 1e-8;
  if (follow(Phi, a_0, tau, little)) {
    const Vector x = solve(Phi, a_0, tau);
    return finish(x.allFinite() && inside(x, a_0 + Phi * x) ? x : x_);
  }
  pieces_.clear();
  const auto geared =
      std::ranges::find_if(joints, [](const ResistingJoint& j) { return j.loss + j.loss_back > 0; });
  return geared == joints.end() ? 0 : static_cast<int>(geared - joints.begin());
}

template <class T> MovingGears::MovingGears(const Model& model, NumberSpan<T> v, NumberSpan<T> tau) {
  refuse_springs_with_gears("forward_dynamics", "simulate counts both", model);
  const Tree<T>& tree = model.tree<T>();
  for (const Gear& gear : model.gears()) {
    const std::size_t c = static_cast<std::size_t>(gear.velocity);
    const int direction = (v[c] > 0) - (v[c] < 0);
    if (direction == 0) continue;
    velocities_.push_back(gear.velocity);
    joints_.push_back({.drive = static_cast<double>(tau[c] - joint_loss(tree, gear.velocity, v[c])),
                       .rotor = gear.rotor,
                       .loss = gear.loss,
                       .loss_back = gear.loss_back,
                       .direction = direction});
  }
}

template <class T>
Solvability MovingGears::add_forces(const Model& model, std::span<const T> a, std::span<const T> responses,
                                    std::span<T> tau) {
  const auto k = static_cast<Eigen::Index>(joints_.size());
  ResistingForces::Matrix Phi(k, k);
  ResistingForces::Vector a_0(k);
  for (Eigen::Index i = 0; i < k; ++i) {
    const auto c = static_cast<std::size_t>(velocities_[static_cast<std::size_t>(i)]);
    a_0[i] = static_cast<double>(a[c]);
    for (Eigen::Index r = 0; r < k; ++r)
      Phi(i, r) = static_cast<double>(responses[static_cast<std::size_t>(r) * a.size() + c]);
    joints_[static_cast<std::size_t>(i)].compliance = Phi(i, i);
  }
  ResistingForces forces;
  if (const int locked = forces.find(Phi, a_0, joints_); locked >= 0)
    return {.locked_body = body_of_velocity(model.topology(), velocities_[static_cast<std::size_t>(locked)])};
  for (Eigen::Index i = 0; i < k; ++i)
    tau[static_cast<std::size_t>(velocities_[static_cast<std::size_t>(i)])] += static_cast<T>(forces.x()[i]);
  return {};
}

template <class T> GearLosses<T>::GearLosses(const Model& model, NumberSpan<T> v, NumberSpan<T> a) {
  const Tree<T>& tree = model.tree<T>();
  for (const Gear& gear : model.gears()) {
    const std::size_t c = static_cast<std::size_t>(gear.velocity);
    if (v[c] == T(0)) continue;
    moving_.push_back({gear, v[c] > T(0) ? T(1) : T(-1),
                       static_cast<T>(gear.rotor) * a[c] + joint_loss(tree, gear.velocity, v[c])});
  }
}

template <class T> void GearLosses<T>::add(std::span<T> tau) const {
  for (const auto& [gear, direction, own] : moving_) {
    T& tau_c = tau[static_cast<std::size_t>(gear.velocity)];
    const T along = direction * (tau_c - own);  // positive if the drive drives
    tau_c += direction * static_cast<T>(along > 0 ? gear.loss : -gear.loss_back) * along;
  }
}

void refuse_springs_with_gears(const char* function, const char* instead, const Model& model) {
  if (model.gears().empty() || model.springs().empty()) return;
  throw std::invalid_argument(
      std::string(function) + " counts losses of gears in mechanisms without springs, and model \"" +
      model.name() + "\" has springs, whose forces in tau would not pass through the gears; " + instead);
}

template MovingGears::MovingGears(const Model&, NumberSpan<double>, NumberSpan<double>);
template MovingGears::MovingGears(const Model&, NumberSpan<float>, NumberSpan<float>);
template Solvability MovingGears::add_forces(const Model&, std::span<const double>, std::span<const double>,
                                             std::span<double>);
template Solvability MovingGears::add_forces(const Model&, std::span<const float>, std::span<const float>,
                                             std::span<float>);
template class GearLosses<double>;
template class GearLosses<float>;

}  // namespace axode
