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
  Vec3<> point;           ///< in the inertial frame, m
  Vec3<> normal;          ///< unit vector from a to b, in inertial axes
  double gap = 0;         ///< m, negative in overlap
  SurfacePair surface;    ///< friction and restitution
  std::uint64_t key = 0;  ///< the same from step to step, see ContactPoint
  /// Normal impulse of a compliant contact, N s, if it is known
  std::optional<double> normal_impulse = {};
};

/// The axes of the rows of a contact: the normal and two tangents, which are continuous functions of the
/// normal but where n_z changes its sign (Duff et al., Building an orthonormal basis, revisited, 2017).
struct ContactFrame {
  Vec3<> n, t1, t2;
};
ContactFrame contact_frame(const Vec3<>& normal) noexcept;
/// The axes of a contact, turned to another normal without a turn about it, so that velocities at two times
/// are in the same axes also where contact_frame() jumps.
ContactFrame turned(const ContactFrame& axes, const Vec3<>& normal) noexcept;

/// A limit of a joint that stops it: side (q - limit) ≥ 0.
struct JointStop {
  int coordinate = 0, velocity = 0;
  double limit = 0, side = 1;  ///< rad or m
  double restitution = 0;
};
/// Dry friction of a joint of one velocity.
struct DryJoint {
  int velocity = 0;
  double force = 0;  ///< N m or N
};

/// The rows of everything unilateral, dry or closed of a mechanism at a configuration, and its mass matrix M
/// = Lᵀ D L by articulated bodies. Blocks of rows are, in this order: contacts, with the rows n, t1, t2 for
/// the velocity of b's point against a's, and then the relative angular velocity about n and about t1, t2;
/// stops; dry joints; loops, with the rows of loop_jacobian(). A column of Y takes one sweep to the root
/// along the paths of the two bodies (D11.4). It is the scratch memory of one thread.
class ContactSystem {
 public:
  /// `contact_rows` is the number of rows of each contact: 3, 4 with drilling friction, or 6 with rolling
  /// friction. `capacity` is the number of contacts for which memory is reserved. Stops are the hard stops of
  /// the model at finite limits; dry joints are its joints of one velocity with friction, unless dry_friction
  /// is false.
  explicit ContactSystem(const Model& model, int contact_rows = 3, std::size_t capacity = 64,
                         bool dry_friction = true);

  const Model& model() const { return model_; }
  int contact_rows() const { return contact_rows_; }
  std::span<const JointStop> stops() const { return stops_; }
  std::span<const DryJoint> dry_joints() const { return dry_; }

  /// Computes the poses of the internal frames of all bodies at q, n_bodies + 1 entries, for a ContactFinder.
  /// It moves the kinematics to q, and the rows and factors of an earlier set() are no longer valid.
  void poses(const double* q, SE3<>* C) noexcept;
  /// Computes the twists of all bodies for velocities v, at the q of the last poses() or set().
  void move_bodies(const double* v) noexcept;
  /// Computes the velocities of the rows of a contact (contact_rows() numbers) along given axes, after
  /// move_bodies().
  void contact_velocity(const Contact& contact, const ContactFrame& axes, double* u) const noexcept;
  /// The largest speed of points of a body up to a distance from its origin, m/s, after move_bodies().
  double speed(int body, double distance) const noexcept;
  /// Computes by how far each loop is open, at the q of the last poses() or set(): a number for each row of
  /// the loops, rad or m. It is 0 for rows that constrain velocities alone, as those of a rolling contact do.
  void loop_openings(const double* q, double* openings) noexcept;

  /// Factorises the mass matrix and makes all rows at q; of the stops only those with less room than
  /// `stop_margin`. After this problem() has the rows, with r and w equal to 0 and dry bounds equal to the
  /// forces times h. Allocates only if there are more contacts than the capacity.
  Solvability set(const double* q, std::span<const Contact> contacts, double h,
                  double stop_margin = std::numeric_limits<double>::infinity());

  /// The rows as a problem of velocities. The caller sets r in physical units and w, and calls finish().
  VelocityProblem& problem() { return problem_; }
  const VelocityProblem& problem() const { return problem_; }
  std::span<const int> active_stops() const { return active_; }  ///< indices of stops()
  /// The first row after those of contacts, stops and dry joints: that of the loops.
  int first_loop_row() const { return first_loop_row_; }
  /// Whether a row of the loops has a residual, so that its opening has a rate.
  bool has_residual(std::size_t row) const {
    return residual_rows_[row - static_cast<std::size_t>(first_loop_row_)] != 0;
  }
  /// The gap of each contact, and then of each active stop; of the loops what is open, by row.
  std::span<const double> room() const { return room_; }

  /// x = D^-½ L⁻ᵀ p of momenta or forces p, and v = L⁻¹ D^-½ x (nv numbers). The arguments may be the same.
  void pull(const double* p, double* x) noexcept;
  void push(const double* x, double* v) noexcept;
  /// u = J v and p += Jᵀ λ, in physical units.
  void times(const double* v, double* u) const noexcept;
  void add_transposed_times(const double* lambda, double* p) const noexcept;
  /// Writes J, rows × nv, row by row.
  void write(double* J) const noexcept;
  /// The momenta M v (nv) at the configuration of set(), armature included.
  void momenta(const double* v, double* p) noexcept;
  /// h(q, v) (nv), the forces of gravity, Coriolis and centrifugal terms and loads of the tree, at the q of
  /// set().
  void bias_forces(const double* q, const double* v, const Loads<>& loads, double* h) noexcept {
    loops_.move(q, v, loads, h);
  }
  /// The impulse that contacts with impulses λ give to the ground, (moment; force) about the inertial origin.
  Wrench<Spatial> on_ground(std::span<const Contact> contacts, const double* lambda) const noexcept;

 private:
  const Tree<double>& tree() const { return model_.tree<double>(); }
  struct PathBody {
    int body, side;  ///< 1 on the path of b, -1 on that of a, 0 on both
  };
  /// Finds the bodies on the paths of a and b to the ground, and the velocities that are eliminated there.
  void find_path(int a, int b);
  /// Writes Y of one row by the backward sweep along the path, for a wrench on b, its opposite on a, and
  /// forces x on velocities.
  void pull_row(int a, int b, const Wrench<Spatial>& on_a, const Wrench<Spatial>& on_b, const double* x,
                double* Y) noexcept;
  /// Appends a block with the present path. Returns its part of J, which is laid out as that of Y.
  double* add_block(ContactLaw law, int rows, double bound, double*& Y, bool compliant = false);
  /// Adds a contact, whose compliance has the index `compliance` if it is compliant and its normal impulse is
  /// not known.
  void add_contact(const Contact& contact, int& compliance);
  void add_unit_row(ContactLaw law, int velocity, double side, double bound);
  void add_loops(const double* q);
  /// The wrench of a force and a moment at a point about the origin of the root of a body.
  Wrench<Spatial> at_root(int body, const Vec3<>& point, const Wrench<Spatial>& W) const noexcept;

  Model model_;
  int contact_rows_;
  LoopSystem<double> loops_;
  std::vector<JointStop> stops_;
  std::vector<DryJoint> dry_;
  VelocityProblem problem_;
  std::vector<double> J_;  ///< laid out as Y
  std::vector<double> root_, room_, unit_, residual_, A_;
  std::vector<char> residual_rows_;  ///< whether each row of the loops has a residual
  std::vector<Twist<Spatial>> V_;
  std::vector<Momentum<Spatial>> Pi_;
  std::vector<int> root_body_;        ///< the root of each body
  std::vector<int> eliminated_at_;    ///< the body where each velocity is eliminated
  std::vector<int> active_;           ///< indices of the stops that have rows
  std::vector<PathBody> path_;        ///< in descending order of the bodies
  std::vector<int> support_, place_;  ///< velocities of the path; place_[velocity]: its index in support_
  std::array<int, 2> ends_of_path_{-1, -1};
  int first_loop_row_ = 0;
};

}  // namespace axode
