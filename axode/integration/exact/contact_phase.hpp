#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "axode/contact/contact_finder.hpp"
#include "axode/contact/contact_force.hpp"
#include "axode/contact/derivatives/displaced_motion.hpp"
#include "axode/contact/law/contact_system.hpp"
#include "axode/contact/law/velocity_solver.hpp"
#include "axode/integration/exact/central_load.hpp"
#include "axode/integration/trajectory.hpp"

namespace axode {

/// A contact or hard stop that is closed, or a joint with dry friction, and whether it sticks or slides.
struct ClosedConstraint {
  ContactLaw law = ContactLaw::contact;  ///< contact, stop or dry_friction
  std::uint64_t key = 0;                 ///< key of a contact, or index of a stop or dry joint
  LawBranch branch = LawBranch::stick;   ///< stick or slide; a stop, and a contact without friction, slide
  /// The direction of sliding of a contact: `along` is that of the sliding velocity, and `about` that of the
  /// angular velocity of drilling and rolling, both in inertial axes. Each component of the velocity is
  /// multiplied by the coefficient of friction in its direction, and both vectors together have norm 1. For a
  /// joint with dry friction, along.x is the sign of its velocity.
  Vec3<> along = {}, about = {};

  bool same_as(const ClosedConstraint& other) const { return law == other.law && key == other.key; }
};

/// The distance of an open contact or hard stop and its rates in time.
struct Gap {
  ContactLaw law = ContactLaw::contact;  ///< contact or stop
  std::uint64_t key = 0;
  double g = 0, dg = 0;
  double ddg = 0;  ///< NaN if the pair of shapes has no closed form
};

/// The motion of a mechanism in one phase (D11.29). In a phase the same contacts and hard stops are closed,
/// and no contact and no joint with dry friction changes between sticking and sliding. An object also
/// computes the changes at the end of a phase: the velocities after impacts (D11.34), and which constraints
/// of the next phase are closed, stick or slide (D11.32). Each thread needs an object of its own. Most
/// functions allocate. Functions that can fail return the reason, or an empty string if they succeed.
class ContactPhase {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::MatrixXd;

  /// The remedy in the messages of what this method cannot decide.
  static constexpr const char* instead = "; use the method contact or contact_adaptive";

  /// `model` has the prescribed motions of the simulation as loop equations, see
  /// SimulationRun::closed_model().
  ContactPhase(const Model& model, ContactShapes shapes, bool dry_friction);

  /// Sets the right sides of prescribed motions, rows of the loops, for all later calls (D12.1).
  void follow(std::span<const PrescribedRow<double>> rows) { system_.prescribe(rows); }

  /// The forces at a state: joint forces τ (nv) without those of contacts, and loads.
  struct Forces {
    std::span<const double> tau;
    Loads<> loads;
  };

  std::vector<ClosedConstraint> closed;  ///< the constraints of this phase
  /// The error of velocities in the integration, m/s.
  double resolution = 0;
  bool any() const { return !closed.empty() || !model_.loops().empty(); }

  /// Computes the accelerations (nv) under the constraints that are closed now. Fails if the mass matrix is
  /// singular, if the point of a contact cannot be found or has no formula that can be differentiated, or if
  /// the accelerations are not unique.
  std::string accelerate(const Vector& q, const Vector& v, const Forces& forces, std::span<double> a);

  // After accelerate():
  /// Returns a number without unit that is negative if the closed constraints need normal forces that pull,
  /// or friction beyond its limit (D11.31). The margin of a constraint is the force by which it is within its
  /// limits, times the norm of the acceleration that a unit of this force causes. The norm of an acceleration
  /// a is √(aᵀ M a) with the mass matrix M. The result is the least margin of all closed constraints, divided
  /// by the sum of the norms of the accelerations without and with constraint forces, and 0 if both are 0.
  /// Different constraint forces may give the same accelerations. If the result for the forces that
  /// accelerate() found is not above 0.001, the forces with the largest least margin replace them.
  double reserve();
  /// For each constraint in the list `closed` of contacts, stops and joints with dry friction, speeds() has
  /// the norm of its sliding velocity, and slips() the component of this velocity along the direction of
  /// sliding that is stored for the constraint. In a contact, each component of the velocity (sliding,
  /// drilling, rolling) is multiplied by the coefficient of friction in its direction. Both numbers are
  /// infinite for a constraint that has no friction or does not slide.
  std::span<const double> slips() const { return slips_; }
  std::span<const double> speeds() const { return speeds_; }
  /// The certificate of the accelerations and forces of the phase (D11.7).
  double certificate();
  /// The contact forces of the phase.
  std::vector<ContactForce> forces();
  /// Replaces the stored directions of sliding by those of the sliding velocities at the velocities v and the
  /// configuration of the last project(). For slow velocities they are those of (D11.29a).
  void follow_directions(const Vector& v);

  /// The open contacts and stops at a state with accelerations a (nv).
  std::string gaps(const Vector& q, const Vector& v, const Vector& a, std::vector<Gap>& out);

  /// Moves q and v to the nearest state in which the constraints of the phase hold (D11.30).
  std::string project(Vector& q, Vector& v);

  /// Decides for each constraint in the list `closed` of contacts, stops and joints with friction whether it
  /// opens, sticks or slides (D11.32). Before the call, constraints with the branch `slide` must have a
  /// sliding velocity, and those with the branch `stick` must be at rest.
  std::string decide(const Vector& q, const Vector& v, const Forces& forces);

  /// Begins the phase with the constraints `next`. For contacts that begin to slide, `next` has the direction
  /// of the sliding acceleration that decide() has found. If such a contact stuck before, and this direction
  /// is almost opposite to its present friction force (the cosine of the angle is -0.99 or less), it is
  /// replaced by the direction exactly opposite to the force. If it is not, the contact is set in motion by
  /// the friction of other contacts, and its direction in `next` is kept. All directions in `next` are kept
  /// if the friction forces are not unique.
  void take_next(const std::vector<ClosedConstraint>& next);

  /// A constraint with an impulse in an impact.
  struct Impact {
    ContactLaw law;
    std::uint64_t key;
    double speed;    ///< of approach
    bool bounces;    ///< whether it is open afterwards
    bool shortened;  ///< whether it stays closed because its next bounces are below rounding
  };
  /// Says of a contact or stop that approaches with a speed and bounces whether this is its last bounce.
  using IsLast = std::function<bool(const Gap& of, double restitution)>;
  /// Computes the velocities v after the impacts of all contacts and stops that touch at q. Those that
  /// approach are added to `met`; is_last() says of each that bounces whether this is its last bounce.
  /// `certificate` receives the relative error of the laws of contact. Afterwards the list `closed` has the
  /// constraints that may remain closed; whether each of them opens, sticks or slides is not decided yet.
  std::string impact(const Vector& q, Vector& v, const IsLast& is_last, std::vector<Impact>& met,
                     double& certificate);

  /// Whether the last call failed because a closed contact is no point of contact any more: the points at
  /// which faces and edges touch change when a corner of one passes an edge of the other.
  bool points_change() const { return points_change_; }
  /// Points of contact of the pairs of shapes that have closed contacts.
  struct Points {
    std::vector<std::uint64_t> keys = {};
    bool apart = true;  ///< whether no two of those that touch coincide to rounding
    bool operator==(const Points&) const = default;
  };
  std::string points_at(const Vector& q, Points& out);
  /// Replaces the contacts of the pairs of shapes whose points have changed by those points that touch at q.
  /// The velocities v decide which of the new contacts stick and which slide. `lost` receives the contacts
  /// of pairs that do not touch any more.
  std::string replace_points(const Vector& q, const Vector& v, std::vector<ClosedConstraint>& lost);

  /// Closes open contacts and stops that touch, and moves q and v so that their velocities and those of all
  /// closed ones are 0. Whether each of them opens, sticks or slides is not decided yet.
  std::string close(const std::vector<Gap>& touching, Vector& q, Vector& v);

  /// The largest gap (m) of a contact that counts as closed: the rounding error of positions.
  double touching() const { return touching_; }
  const ContactShapes& shapes() const { return finder_.shapes(); }
  const ContactSystem& system() const { return system_; }
  std::string name_of(ContactLaw law, std::uint64_t key) const;
  /// The stops and contacts that overlap by more than `most` at q, as a sentence; empty if there are none.
  std::string overlap(const Vector& q, double most);
  /// Sets `closed` to the candidates that touch at the start: gaps below `most`, and all dry joints.
  std::string start(const Vector& q, const Vector& v, double most, bool& impacts);

 private:
  /// A margin (m) beyond all distances.
  static constexpr double everywhere = 1e6;

  /// A row (scalar constraint) of the contact problem whose multiplier is computed together with the
  /// accelerations. If the row is the normal row of a sliding contact, `friction` has the multipliers of the
  /// contact's friction rows, divided by that of this row.
  struct Active {
    std::size_t constraint;  ///< index in `closed`; its size for loops
    int row;
    std::array<double, LawBlock::most_rows - 1> friction = {};  ///< forces of the friction rows per unit
  };
  void list_touching(const Vector& q, double most);
  /// Computes the velocities of all rows, and the speed of the mechanism measured by its kinetic energy.
  void set_velocities(const Vector& v);
  /// Chooses whether contact k of `closed` sticks or slides, after set_velocities(). It sticks if its sliding
  /// velocity counts as 0, see select_slow().
  void choose_branch(std::size_t k, double of_motion);
  /// Chooses from the velocities v which constraints in the list `closed` of contacts, stops and joints with
  /// dry friction stick and which slide. Removes the contacts and stops whose distance increases. `impacts`
  /// receives whether the distance of a contact or stop decreases, so that there is an impact. A velocity of
  /// a constraint counts as 0 if it is at most `of_motion` times the largest one that the constraint could
  /// have with the same kinetic energy of the mechanism.
  void select_slow(const Vector& v, double of_motion, bool& impacts);
  std::string find(const Vector& q);  ///< finds all points of contact at q
  const ContactPoint* point(std::uint64_t key) const;
  bool is_closed(ContactLaw law, std::uint64_t key) const;  ///< whether `closed` has this constraint
  bool has_closed(std::uint64_t key) const;  ///< whether `closed` has a contact of the shapes of this key
  /// Makes the rows of all constraints in `closed` at q. Dry joints have their friction times h as bounds.
  std::string make_rows(const Vector& q, double h = 1);
  int row_of(std::size_t k) const;  ///< the first row of a constraint in `closed`, after make_rows()
  /// Calls make_rows(), and computes the velocities and biases of the rows and the motion without them.
  std::string set_motion(const Vector& q, const Vector& v, const Forces& forces);
  bool has_friction(std::size_t k) const;
  double largest_row() const { return Y_.size() > 0 ? Y_.colwise().norm().maxCoeff() : 0; }
  /// Writes the direction of the present sliding velocity of a contact to `s`, and returns the norm of this
  /// velocity. The components of the velocity are the velocities in the friction rows of the contact, each
  /// multiplied by the coefficient of friction of its row. Near rest, an error of the velocity turns its
  /// direction. Therefore, if a direction d_0 is stored for the contact, the part of the velocity
  /// perpendicular to d_0 is first shortened by `resolution`, the error of velocities (m/s), or set to 0 if
  /// it is shorter (D11.29a). If the velocity has no component in the direction of d_0, the contact would
  /// have stopped before, and `s` is d_0.
  double direction(std::size_t k, double* s) const;
  /// The components of the stored direction of a contact in the axes of its friction rows.
  std::array<double, LawBlock::most_rows - 1> stored_direction(std::size_t k) const;
  /// Writes the direction `s` of the friction rows of a contact to `along` and `about`.
  void store_direction(std::size_t k, const double* s);
  ContactFrame axes_of(std::size_t k) const { return contact_frame(contacts_[k].normal); }
  /// Sets problem() of the system to the laws of `closed` for accelerations, with directed friction (D11.32).
  void set_directed_problem();
  /// Lists the rows whose velocities the present phase holds at 0 or at a prescribed value. If `of_places` is
  /// set, lists only those that constrain q: the rows of closed contacts and stops, and of loop equations
  /// with a position level.
  std::vector<int> held_rows(bool of_places) const;
  /// Computes the vector x of least norm with Rᵀ x = -u for the given constraint rows (D11.30). x is a change
  /// of the motion, in coordinates in which the mass matrix is the identity, and changes the gaps or
  /// velocities u of these rows to 0. The columns of R are those of Y_ = D^-½ L⁻ᵀ Jᵀ for the rows, with the
  /// Jacobian J of all constraint rows and the mass matrix Lᵀ D L.
  Vector correction(const std::vector<int>& rows, const Vector& u) const;
  /// The conditions for `loads_`: normal forces press, and friction is within its limits.
  std::vector<LoadCondition> load_conditions() const;
  /// Chooses the loads of contacts that share a load while they slide in different directions, so that the
  /// motion depends on the choice (D11.29b). Normal forces are those of equal springs under the points. If
  /// these violate a condition, loads are moved towards those with the largest reserve until they do not.
  void share_loads();
  double limit_of(const ClosedConstraint& c) const;  ///< friction of a dry joint, N m or N

  Model model_;
  ConfigurationGroup<double> group_;
  ContactFinder finder_;
  ContactSystem system_;
  ContactJets jets_;
  DisplacedMotion motion_;
  VelocitySolver solver_;
  std::vector<SE3<>> C_;
  std::vector<Contact> contacts_;
  std::vector<double> c_;  ///< coefficients of the rows
  Matrix Y_;               ///< D^-½ L⁻ᵀ Jᵀ of all rows, nv × rows, in physical units
  Vector w_, u_, bias_, lambda_, x_;
  std::vector<double> slips_, speeds_;
  std::vector<Active> active_;
  Vector loads_, weights_;  ///< forces of active_, and the motions of unit forces of their rows
  Matrix free_loads_;       ///< basis of the loads of active_ that do not move the held rows
  bool points_change_ = false;
  bool loads_move_ = false;  ///< whether free_loads_ cause motions, because friction depends on them
  double touching_ = 0, speed_ = 0;
};

}  // namespace axode
