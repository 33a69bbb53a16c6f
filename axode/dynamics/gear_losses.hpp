#pragma once
#include <Eigen/Core>
#include <span>
#include <type_traits>
#include <vector>

#include "axode/kinematics/arguments.hpp"
#include "axode/model/model.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// A velocity whose friction force x depends on the accelerations: its gear loses a part of the force that it
/// transmits, or dry friction or the gear may hold it at rest.
struct ResistingJoint {
  double drive = 0;     ///< τ, the drive force less damping and, in a sliding joint, less dry friction
  double friction = 0;  ///< bound of the dry friction of a joint at rest; 0 if the joint moves
  double rotor = 0, loss = 0, loss_back = 0;  ///< as in Gear; 0 if there is no gear
  int direction = 0;                          ///< of the motion, 1 or -1; 0 at rest
  double compliance = 0;  ///< acceleration that a unit force causes in the tree without loops
};

/// The friction forces x of resisting joints and their accelerations a = a_0 + Φ x, by (D9.10) and (D9.11). F
/// = τ - I a + x is the force that a gear transmits. The equations are linear as long as every F keeps its
/// sign and every joint at rest either sticks or slides in one direction. A path leads from a problem whose
/// solution is known to the given one, through one such piece after the other (Katzenelson). It ends if the
/// solution is unique for all forces, which is checked by (D9.12). The forces of joints that stick in loops
/// may be indeterminate; the path is followed with regularised forces then.
class ResistingForces {
 public:
  using Matrix = Eigen::MatrixXd;
  using Vector = Eigen::VectorXd;

  /// Computes x and a. `Phi` is ∂a/∂τ of these joints, symmetric. Returns -1 or, if there is no unique
  /// solution, the index of a joint whose gear locks itself too strongly. O(k³) for each piece on the path.
  int find(const Matrix& Phi, const Vector& a_0, std::span<const ResistingJoint> joints);

  const Vector& x() const { return x_; }
  const Vector& a() const { return a_; }
  bool sticks(Eigen::Index i) const { return pieces_[at(i)].slide == 0; }
  /// The force F that the gear of a joint transmits.
  double transmitted(Eigen::Index i) const { return F(i, x_, a_, tau_); }
  /// The friction force that opposes joint i if it slides, or begins to slide, in a direction.
  double bound(Eigen::Index i, int direction) const;

 private:
  /// The piece of a joint: whether it slides and where to, and the sign of F.
  struct Piece {
    int slide, sign;
    bool operator==(const Piece&) const = default;
  };
  /// A boundary of a piece: the value, which is positive inside, and the piece on its other side.
  struct Boundary {
    double value;
    Piece beyond;
  };
  static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }
  bool has_gear(Eigen::Index i) const { return joints_[at(i)].loss > 0 || joints_[at(i)].loss_back > 0; }
  double F(Eigen::Index i, const Vector& x, const Vector& a, const Vector& tau) const {
    return tau[i] - joints_[at(i)].rotor * a[i] + x[i];
  }
  /// The part of |F| that is lost if the joint moves in a direction and F has a sign.
  double part_lost(Eigen::Index i, int direction, int sign) const {
    return direction == sign ? joints_[at(i)].loss : joints_[at(i)].loss_back;
  }
  int not_unique(const Matrix& Phi) const;
  void start(const Matrix& Phi, const Vector& a_0);
  Vector solve(const Matrix& Phi, const Vector& a_0, const Vector& tau, double little = 0) const;
  bool follow(const Matrix& Phi, const Vector& a_0, const Vector& tau, double little);
  std::vector<Boundary> boundaries(Eigen::Index i, const Vector& x, const Vector& a, const Vector& tau) const;
  double magnitude(Eigen::Index i, const Vector& a_0) const;

  std::span<const ResistingJoint> joints_;
  std::vector<Piece> pieces_;
  Vector x_, a_, tau_, start_a_0_;
};

/// The gears of joints that move, in forward dynamics. Joints at rest have no loss there: like that of dry
/// friction, their loss depends on how they came to rest, and simulations determine it.
class MovingGears {
 public:
  /// `tau` are the drive forces, without springs; the losses by damping and dry friction are subtracted from
  /// them. Throws std::invalid_argument if the model has springs, because `tau` could contain their forces,
  /// which do not pass through gears.
  template <class T> MovingGears(const Model& model, NumberSpan<T> v, NumberSpan<T> tau);

  /// The velocities of the gears.
  std::span<const int> velocities() const { return velocities_; }
  /// Adds the forces of the gears to `tau`. `a` (nv) are the accelerations without these forces, and the rows
  /// of `responses`, k × nv, are the accelerations that a unit force on each of velocities() causes.
  template <class T>
  Solvability add_forces(const Model& model, std::span<const T> a, std::span<const T> responses,
                         std::span<T> tau);

 private:
  std::vector<int> velocities_;
  std::vector<ResistingJoint> joints_;
};

/// Computes accelerations `a` with the losses of moving gears: those without these losses come first, then
/// those under the forces of the gears (D9.10). q, v and tau may share memory with `a`. accelerate(q, v, tau)
/// computes `a`, and respond(q, velocities, responses) writes the accelerations that a unit force on each of
/// these velocities causes, one row after the other. Throws as MovingGears.
template <class T, class Accelerate, class Respond>
Solvability accelerate_with_gears(const Model& model, NumberSpan<T> q, NumberSpan<T> v, NumberSpan<T> tau,
                                  std::span<T> a, const Accelerate& accelerate, const Respond& respond) {
  const std::vector<T> q_t(q.begin(), q.end()), v_t(v.begin(), v.end());
  std::vector<T> forces(tau.begin(), tau.end());
  MovingGears gears(model, v, tau);
  const Solvability found = accelerate(q_t.data(), v_t.data(), forces.data());
  if (!found.ok() || gears.velocities().empty()) return found;
  std::vector<T> responses(gears.velocities().size() * a.size());
  respond(q_t.data(), gears.velocities(), responses.data());
  const Solvability unique =
      gears.add_forces(model, std::span<const T>(a), std::span<const T>(responses), std::span(forces));
  if (!unique.ok()) return solved(unique, std::ssize(a), a.data());
  return accelerate(q_t.data(), v_t.data(), forces.data());
}

/// The forces that the gears lose in inverse dynamics, where the motion (v, a) is given. A joint at rest has
/// no loss.
template <class T> class GearLosses {
 public:
  /// Reads v and a, so that they may share memory with the forces afterwards.
  GearLosses(const Model& model, NumberSpan<T> v, NumberSpan<T> a);
  /// Adds the losses to drive forces, which contain the forces against armatures, damping and dry friction,
  /// but none of springs (D9.9).
  void add(std::span<T> tau) const;

 private:
  struct Moving {
    Gear gear;
    T direction, own;  ///< `own` is the force on armature, damping and dry friction
  };
  std::vector<Moving> moving_;
};

/// Throws std::invalid_argument if the model has springs and gears with losses.
void refuse_springs_with_gears(const char* function, const char* instead, const Model& model);

}  // namespace axode
