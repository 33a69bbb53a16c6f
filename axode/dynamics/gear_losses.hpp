#pragma once
#include <Eigen/Core>
#include <span>
#include <type_traits>
#include <vector>

#include "axode/kinematics/arguments.hpp"
#include "axode/model/model.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// A velocity of a joint whose friction force x depends on the accelerations: its gear loses a part of the
/// force that it transmits, or the joint is at rest and dry friction or the gear may hold it.
struct ResistingJoint {
  double drive = 0;     ///< τ: drive force minus damping and, if the joint moves, minus dry friction
  double friction = 0;  ///< bound of the dry friction of a joint at rest; 0 if the joint moves
  double rotor = 0, loss = 0, loss_back = 0;  ///< the members of Gear; 0 if the joint has no gear
  int direction = 0;                          ///< sign of the velocity, 1 or -1; 0 at rest
  double compliance = 0;  ///< scale for accelerations: that of the joint for a unit force on the joint
};

/// Computes the friction forces x of k joints with dry friction or gear losses, and the accelerations a = a_0
/// + Φ x of these joints ((D9.10), (D9.11)). a_0 are the accelerations without friction forces, and Φ = ∂a/∂τ
/// (k × k) is the response to joint forces. A gear with armature I and drive force τ transmits the force F =
/// τ - I a + x. The equations for x are linear in pieces: a piece ends where a force F changes its sign, or
/// where a joint at rest changes between sticking and sliding.
///
/// The method is Katzenelson's: it starts at a problem with a known solution, changes its data along a
/// straight line to the data of the given problem, and follows the solution from one linear piece to the
/// next. It reaches the end if the solution is unique for all forces, which is checked by (D9.12). If forces
/// of sticking joints in loops are indeterminate, they are regularised.
class ResistingForces {
 public:
  using Matrix = Eigen::MatrixXd;
  using Vector = Eigen::VectorXd;

  /// Computes the friction forces x() and the accelerations a() of the k joints in `joints`. `a_0` are the
  /// accelerations without friction forces, and column j of `Phi` (k × k, symmetric) has the accelerations by
  /// a unit force on joint j. Returns -1 or, if the solution is not unique or not found, the index in
  /// `joints` of a joint, in general one whose gear is so strongly self-locking that the condition of
  /// uniqueness (D9.12) fails. The equations are linear in pieces; the cost is O(k³) for each piece that the
  /// method passes.
  int find(const Matrix& Phi, const Vector& a_0, std::span<const ResistingJoint> joints);

  const Vector& x() const { return x_; }
  const Vector& a() const { return a_; }
  bool sticks(Eigen::Index i) const { return pieces_[at(i)].slide == 0; }
  /// The force F that the gear of joint i transmits.
  double transmitted(Eigen::Index i) const { return F(i, x_, a_, tau_); }
  /// The magnitude of the friction force (dry friction plus loss of the gear) on joint i if it slides, or
  /// begins to slide, in `direction` (1 or -1).
  double bound(Eigen::Index i, int direction) const;

 private:
  /// The state of a joint that makes its friction law linear: the direction `slide` in which it slides (1 or
  /// -1, or 0 if it sticks), and the sign of the force that its gear transmits.
  struct Piece {
    int slide, sign;
    bool operator==(const Piece&) const = default;
  };
  /// A limit of the present piece of a joint, within which its friction law is linear. The law relates the
  /// friction force x, the transmitted force F and the acceleration a of the joint. `value` is positive
  /// before the limit and 0 at it. `beyond` is the piece after the limit: the direction of sliding, or 0 if
  /// the joint sticks, and the sign of F.
  struct Boundary {
    double value;
    Piece beyond;
  };
  static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }
  bool has_gear(Eigen::Index i) const { return joints_[at(i)].loss > 0 || joints_[at(i)].loss_back > 0; }
  double F(Eigen::Index i, const Vector& x, const Vector& a, const Vector& tau) const {
    return tau[i] - joints_[at(i)].rotor * a[i] + x[i];
  }
  /// The fraction (0 or more) of the transmitted force of sign `sign` that the gear of joint i loses if the
  /// joint moves in `direction` (both 1 or -1).
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

/// The gears with losses whose joints move, for forward dynamics. Forward dynamics leaves out the losses of
/// gears whose joints are at rest, because these depend on how the joints came to rest.
class MovingGears {
 public:
  /// Selects the gears with losses whose joints move, and their drive forces: `tau` (nv) minus damping and
  /// dry friction. Throws std::invalid_argument if the model has springs in addition to gears with losses,
  /// because `tau` could contain the forces of the springs, which do not pass through gears.
  template <class T> MovingGears(const Model& model, NumberSpan<T> v, NumberSpan<T> tau);

  /// The indices of the joint velocities of the k selected gears.
  std::span<const int> velocities() const { return velocities_; }
  /// Adds the friction forces of the k selected gears to the joint forces `tau` (nv). `a` (nv) are the
  /// accelerations without friction forces, and row i of `responses` (k × nv) has the accelerations by a unit
  /// force on the joint of gear i. If the friction forces are not unique because a gear is too strongly
  /// self-locking (D9.12), or if they are not found, the returned Solvability names the body of a gear, and
  /// `tau` does not change.
  template <class T>
  Solvability add_forces(const Model& model, std::span<const T> a, std::span<const T> responses,
                         std::span<T> tau);

 private:
  std::vector<int> velocities_;
  std::vector<ResistingJoint> joints_;
};

/// Computes the accelerations `a` under the joint forces `tau` and the losses of the gears of moving joints
/// (D9.10): first without losses and, if there are such gears, again with the friction forces of their joints
/// added to a copy of `tau`. accelerate(q, v, tau) must compute `a` and return a Solvability. To find the
/// friction forces, respond(q, velocities, responses) must write for each of `velocities` a row of nv
/// numbers: the accelerations by a unit force on this velocity. q, v and tau may share memory with `a`.
/// Throws std::invalid_argument if the model has springs in addition to gears with losses.
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

/// The forces that gears of moving joints lose at given v and a (velocities and accelerations).
template <class T> class GearLosses {
 public:
  /// Reads v and a (nv each). Their memory may be overwritten afterwards, for example by the forces of add().
  GearLosses(const Model& model, NumberSpan<T> v, NumberSpan<T> a);
  /// Adds the losses of the gears to the drive forces `tau` (nv), which must contain the forces against
  /// armatures, damping and dry friction, but none of springs (D9.9).
  void add(std::span<T> tau) const;

 private:
  struct Moving {
    Gear gear;
    T direction, own;  ///< sign of the velocity; force against armature, damping and dry friction
  };
  std::vector<Moving> moving_;
};

/// Throws std::invalid_argument if the model has springs and gears with losses, with a message that names
/// `function` and ends with the advice `instead`.
void refuse_springs_with_gears(const char* function, const char* instead, const Model& model);

}  // namespace axode
