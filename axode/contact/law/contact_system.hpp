#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/law/velocity_problem.hpp"
#include "axode/recursion/spatial_tree.hpp"

namespace axode {

/// A point at which two bodies may touch.
struct Contact {
  int a = 0, b = 0;       ///< bodies; 0 is the ground
  Vec3<> point;           ///< position in the inertial frame, m
  Vec3<> normal;          ///< unit vector from a to b, in inertial axes
  double gap = 0;         ///< distance of the surfaces, m, negative in overlap
  SurfacePair surface;    ///< friction and restitution
  std::uint64_t key = 0;  ///< identifies the contact from step to step, see ContactPoint
  /// Normal impulse of a compliant contact, N s, if it is known
  std::optional<double> normal_impulse = {};
};

/// The axes of a contact: the normal n and two tangents. contact_frame() makes them from the normal. The
/// tangents are continuous functions of the normal except where n_z changes its sign (Duff et al., Building
/// an orthonormal basis, revisited, 2017).
struct ContactFrame {
  Vec3<> n, t1, t2;
};
AXODE_ENTRY ContactFrame contact_frame(const Vec3<>& normal) noexcept;
/// The axes of a contact for another normal: the new t1 is the tangent t1 of `axes`, projected on the plane
/// that is perpendicular to `normal` and normalised, so that the axes do not rotate about the normal. If the
/// old t1 is nearly parallel to the normal, the tangents are chosen from the normal alone.
AXODE_ENTRY ContactFrame turned(const ContactFrame& axes, const Vec3<>& normal) noexcept;

/// A hard stop at a limit of a joint with one velocity: side (q - limit) ≥ 0, where side is 1 or -1.
struct JointStop {
  int coordinate = 0, velocity = 0;
  double limit = 0, side = 1;  ///< `limit` in rad or m
  double restitution = 0;

  /// The distance from the stop at q, rad or m; it is negative beyond the stop.
  double room(const double* q) const { return side * (q[coordinate] - limit); }
};
/// Dry friction of a joint with one velocity.
struct DryJoint {
  int velocity = 0;
  double force = 0;  ///< largest friction force, N m or N
};

/// The constraint rows of all contacts, hard stops, joints with dry friction and closed loops (in this order)
/// of a mechanism at a configuration, and its mass matrix M = Lᵀ D L, factorised by articulated bodies. A
/// contact of bodies a and b has rows for the velocity of b relative to a at the point of contact, along the
/// normal n and the tangents t1 and t2, and, with drilling and rolling friction, for the angular velocity of
/// b relative to a, along n, t1 and t2. The columns of Y = D^-½ L⁻ᵀ Jᵀ, with the Jacobian J of the rows, are
/// computed by sweeps along the paths of bodies to the ground (D11.4). An object is the scratch memory of one
/// thread.
class AXODE_ENTRY ContactSystem {
 public:
  /// Reserves memory for the constraint rows of `capacity` contacts, and of all hard stops, joints with
  /// dry friction and loops of the model. A contact has `contact_rows` rows: 3, or 4 with drilling
  /// friction, or 6 with drilling and rolling friction. stops() has the hard stops at finite limits of
  /// joints with one velocity. dry_joints() has the joints of one velocity with dry friction, or none if
  /// `dry_friction` is false. A joint that is coupled to a leader is in neither list.
  explicit ContactSystem(const Model& model, int contact_rows = 3, std::size_t capacity = 64,
                         bool dry_friction = true);

  const Model& model() const { return model_; }
  int contact_rows() const { return contact_rows_; }
  std::span<const JointStop> stops() const { return stops_; }
  std::span<const DryJoint> dry_joints() const { return dry_; }
  /// Prescribes the right sides s, s' and s'' of some loop equations, for position, velocity and
  /// acceleration (D12.1). In later calls, loop_openings() subtracts s from the position residuals of the
  /// loops, and loop_bias() subtracts s'' from the biases of the loop equations. prescribed() returns
  /// these right sides.
  void prescribe(std::span<const PrescribedRow<double>> rows) { loops_.prescribe(rows); }
  std::span<const PrescribedRow<double>> prescribed() const { return loops_.prescribed(); }

  /// Computes the poses of the internal frames (joint frames) of all bodies at q (n_bodies + 1 entries). The
  /// constraint rows and the factors of the mass matrix are invalid afterwards.
  void poses(const double* q, SE3<>* C) noexcept;
  /// The bodies whose mass matrix set() has factorised.
  const ArticulatedBodies<Spatial, double>& bodies() { return loops_.bodies(); }
  /// Computes the twists of all bodies for the velocities v, at the q of the last call of poses() or set().
  /// The ground moves with the velocity `ground` (m/s).
  void move_bodies(const double* v, const Vec3<>& ground = {}) noexcept;
  /// Computes the relative velocities (contact_rows() numbers) at a contact along the given axes, for the
  /// motion of the bodies that was computed last.
  void contact_velocity(const Contact& contact, const ContactFrame& axes, double* u) const noexcept;
  /// An upper bound of the speed of all points of a body that are at most `distance` (m) away from its
  /// origin, m/s, for the motion of the bodies that was computed last.
  double speed(int body, double distance) const noexcept;
  /// Computes the position residual of each scalar loop constraint (row) at the configuration q for which the
  /// poses were computed last, rad or m. It is 0 for constraints of velocities alone, such as rolling.
  void loop_openings(const double* q, double* openings) noexcept;

  /// Factorises the mass matrix and makes all constraint rows at q. Only hard stops that are nearer than
  /// `stop_margin` (rad or m) get rows. The rows of problem() are in physical units until its function
  /// finish() multiplies friction rows by their coefficients of friction; the friction cone of a contact is
  /// then |λ_T| ≤ λ_N for the multipliers λ_N of the normal row and λ_T of the friction rows. The impulse of
  /// a joint with dry friction is at most its friction force times the step h. `resistance` has an inertia
  /// for each velocity that is added to the mass matrix, or is null. Allocates only if there are more
  /// contacts than the capacity.
  Solvability set(const double* q, std::span<const Contact> contacts, double h,
                  double stop_margin = std::numeric_limits<double>::infinity(),
                  const double* resistance = nullptr);

  /// The problem to find the impulses λ of the constraint rows, such that λ and the velocities u = Yᵀ (w + Y
  /// λ) + r of the rows obey the laws of contact, friction and loops. set() makes Y = D^-½ L⁻ᵀ Jᵀ from the
  /// Jacobian J of the rows and the mass matrix Lᵀ D L. Then the caller must write w and r to the problem and
  /// call its function finish(), which scales the rows. w is D^½ L v for the joint velocities v of the motion
  /// without impulses. r has a number in m/s or rad/s for each row, for example the gap of a contact divided
  /// by the step, or e u⁻ for an impact with the coefficient of restitution e and the velocity u⁻ before it.
  VelocityProblem& problem() { return problem_; }
  const VelocityProblem& problem() const { return problem_; }
  std::span<const int> active_stops() const { return active_; }  ///< indices in stops()
  /// The index of the first row of the loops. The rows of contacts, stops and dry joints are before it.
  int first_loop_row() const { return first_loop_row_; }
  /// Whether constraint `row` of the problem, one of the loops, constrains positions, not only velocities.
  bool has_residual(std::size_t row) const {
    return residual_rows_[row - static_cast<std::size_t>(first_loop_row_)] != 0;
  }
  /// The distances to the constraints at the q for which the rows were made: the gap of each contact, then
  /// the distance of each active stop from its limit, then the position residual of each row of the loops; m
  /// or rad.
  std::span<const double> room() const { return room_; }

  /// With the mass matrix M = Lᵀ D L, pull() computes x = D^-½ L⁻ᵀ p from momenta or forces p, and push()
  /// computes the velocities v = L⁻¹ D^-½ x, nv numbers each. One after the other they solve M v = p. The two
  /// arguments of a call may be the same memory.
  void pull(const double* p, double* x) noexcept;
  void push(const double* x, double* v) noexcept;
  /// The inverse of push(): computes x = D^½ L v from the velocities v. set() must have factorised the mass
  /// matrix with the armature of the model alone.
  void pull_velocities(const double* v, double* x) noexcept;
  /// With the Jacobian J of all constraint rows, times() computes the velocities u = J v of the rows from the
  /// joint velocities v, and add_transposed_times() adds the generalised impulses Jᵀ λ of the impulses λ of
  /// the rows to p. The velocities u (m/s, rad/s) and the impulses λ (N s, N m s) are physical: they are not
  /// scaled by coefficients of friction, even after finish() of the problem has scaled its rows.
  void times(const double* v, double* u) const noexcept;
  void add_transposed_times(const double* lambda, double* p) const noexcept;
  /// Writes the Jacobian J of all rows, rows × nv numbers, row by row.
  void write(double* J) const noexcept;
  /// Computes the momenta p = M v (nv) at the configuration of set(), armature included. If the ground moves
  /// with the velocity `ground` (m/s), all bodies move with it; p then also contains the impulses that give
  /// each body this velocity.
  void momenta(const double* v, double* p, const Vec3<>& ground = {}) noexcept;
  /// Computes the forces (nv) of gravity, Coriolis and centrifugal terms and loads at the q of set().
  void bias_forces(const double* q, const double* v, const Loads<>& loads, double* h) noexcept;
  /// Computes, for each row of the loops with the Jacobian A, the part of (A v)' that does not depend on
  /// joint accelerations, for the motion (q, v) of which the bias forces were computed last.
  void loop_bias(double* gamma) noexcept { loops_.bias(gamma); }
  /// The sum of the impulses that all contacts exert on the ground, (moment; force) about the inertial
  /// origin, from the impulses `lambda` of the rows of all contacts in physical units.
  Wrench<Spatial> on_ground(std::span<const Contact> contacts, const double* lambda) const noexcept;

 private:
  const Tree<double>& tree() const { return model_.tree<double>(); }
  double root(int velocity) const { return loops_.root()[velocity]; }  ///< entry of D^-½
  /// Whether the tree has coupled joints. Without these, the sweeps over the tree are plain loops here, which
  /// makes a step of a standing quadruped 5 % faster.
  bool is_coupled() const { return !tree()->coupled_bodies.empty(); }
  /// Calls f(c, s) for each screw s of the joint of body i, with the index c of its velocity; the second
  /// function begins with the last screw.
  template <class F> void each_screw(int i, const F& f) const {
    const int first = tree()->first_screw[i], end = tree()->first_screw[i + 1], c = tree()->iv[i] - first;
    for (int s = first; s < end; ++s) f(c + s, s);
  }
  template <class F> void each_screw_backwards(int i, const F& f) const {
    const int first = tree()->first_screw[i], end = tree()->first_screw[i + 1], c = tree()->iv[i] - first;
    for (int s = end; s-- > first;) f(c + s, s);
  }
  /// Updates the poses and joint screws to q, unless they are already those at q.
  void place(const double* q) noexcept;
  struct PathBody {
    int body, side;  ///< side: 1 on the path of b, -1 on the path of a, 0 on both
  };
  /// Finds the bodies on the paths from bodies a and b to the ground, and the velocities that the
  /// articulated-body algorithm eliminates at them. The functions that add constraint rows between a and b
  /// use them.
  void find_path(int a, int b);
  /// Computes the column of Y = D^-½ L⁻ᵀ Jᵀ that belongs to one row of the Jacobian J, with the mass matrix
  /// Lᵀ D L. The row has the generalised forces of the wrench `on_a` on body a and of the wrench `on_b` on
  /// body b, plus the generalised forces x (nv numbers). Each wrench is in inertial axes, about the origin of
  /// the root body, which is the first body on the path from the ground to the body on which the wrench acts.
  /// A backward sweep passes the bodies on the paths of a and b to the ground, which find_path(a, b) must
  /// have found before.
  void pull_row(int a, int b, const Wrench<Spatial>& on_a, const Wrench<Spatial>& on_b, const double* x,
                double* Y) noexcept;
  /// Appends a block of constraint rows with the Jacobian J, whose columns belong to the velocities in
  /// support_; find_path() sets these to the velocities on the paths of two bodies to the ground. Returns the
  /// memory for the block's part of J, filled with zeros, and sets Y to the memory for its part of D^-½ L⁻ᵀ
  /// Jᵀ, with the mass matrix M = Lᵀ D L; both have the same layout.
  double* add_block(ContactLaw law, int rows, double bound, double*& Y, bool compliant = false);
  /// Adds the constraint rows of a contact. If the contact is compliant, its normal force is an additional
  /// unknown, unless Contact::normal_impulse has its impulse. `compliance` is the index of this unknown, and
  /// is then increased.
  void add_contact(const Contact& contact, int& compliance);
  void add_rows(const Contact& contact, double* J, double* Y) noexcept;
  /// The wrenches on a body for unit multipliers of the rows of a contact.
  using WrenchesOfRows = std::array<Wrench<Spatial>, LawBlock::most_rows>;
  /// Computes rows `first` to `first` + n - 1 of the Jacobian of a contact and their columns of Y, in the
  /// lanes of a register, by one sweep along the paths that find_path() has found. The tree must not have
  /// coupled joints.
  template <int n>
  void add_rows_in_lanes(const WrenchesOfRows& on_a, const WrenchesOfRows& on_b, int first, double* J,
                         double* Y) noexcept;
  void add_unit_row(ContactLaw law, int velocity, double side, double bound);
  void add_loops(const double* q);
  /// Expresses a wrench W on a body, whose moment is about `point`, about the origin of the root body (the
  /// first body on the path from the ground to the body).
  Wrench<Spatial> at_root(int body, const Vec3<>& point, const Wrench<Spatial>& W) const noexcept;

  Model model_;
  int contact_rows_;
  LoopSystem<double> loops_;
  std::vector<JointStop> stops_;
  std::vector<DryJoint> dry_;
  VelocityProblem problem_;
  std::vector<double> J_;  ///< entries of the Jacobian, with the layout of Y
  std::vector<double> room_, unit_, residual_, A_, armature_;
  std::vector<char> residual_rows_;  ///< has_residual() of each row of the loops
  std::vector<Twist<Spatial>> V_;
  std::vector<Momentum<Spatial>> Pi_;
  std::vector<double> q_;             ///< at which place() has computed the kinematics, or NaN
  std::vector<int> root_body_;        ///< the first body on the path from the ground to each body
  std::vector<int> eliminated_at_;    ///< the body where each velocity is eliminated
  std::vector<int> active_;           ///< indices of the stops that have rows
  std::vector<PathBody> path_;        ///< bodies on the paths of a and b, in descending order
  std::vector<int> support_, place_;  ///< velocities of the path; place_[velocity]: its index in support_
  std::array<int, 2> ends_of_path_{-1, -1};
  int first_loop_row_ = 0;
};

}  // namespace axode
