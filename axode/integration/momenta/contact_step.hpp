#pragma once
#include <vector>

#include "axode/contact/contact_finder.hpp"
#include "axode/contact/law/contact_system.hpp"
#include "axode/contact/law/velocity_solver.hpp"
#include "axode/integration/momenta/contact_part.hpp"
#include "axode/integration/momenta/contact_record.hpp"
#include "axode/integration/momenta/multisecant.hpp"
#include "axode/integration/runs/contact_simulation_run.hpp"

namespace axode {

/// One step of a motion with contact (D11.12): impulses at its start, the free motion (without contact) by
/// the midpoint rule, and impulses at its end, which make the velocities obey the laws of contact. The
/// impulses at the start have three effects: rigid contacts do not begin to overlap in the step, loops are
/// closed at its end, and sticking contacts do not slide in its middle. Prescribed motions are loops whose
/// equations have functions of time as right sides (D12.1).
class ContactStep {
 public:
  using Vector = Eigen::VectorXd;

  /// `model` has the prescribed motions of the simulation as loop equations, see
  /// ContactSimulationRun::closed_model(). `dry_friction` says whether the dry friction of joints acts.
  ContactStep(ContactSimulationRun& run, const Model& model, ContactShapes shapes, bool dry_friction);

  /// Computes the step of length h (s) from the configuration q_0 and the velocities v_0 at time t, and sets
  /// the public members. x_0 are the states of the drives at time t. Their inputs, and their statuses
  /// (integers that say which form of each drive's law holds), do not change in the step. If `certificate`,
  /// the relative error of the laws of contact in the step, is above 1e-9, the step is repeated in 4, and
  /// then in 16 equal parts; the result of 16 parts is always accepted. Allocates only if there are more than
  /// 64 contacts and more than ever before, and in the first step that needs Newton's matrix of the midpoint
  /// rule (D8.6). Fails if the mass matrix is singular, a number is not finite, there are too many points of
  /// contact, or SimulationOptions::monitor, a function of the caller, returns false.
  Failure run(double t, double h, const Vector& q_0, const Vector& v_0, const Vector& x_0 = {});

  /// Forgets the multipliers of earlier steps, so that the next motion does not depend on earlier ones.
  void restart() noexcept;
  /// Takes the multipliers of the last step of another motion of the same mechanism as first guesses.
  void continue_from(const ContactStep& other);

  Vector q, v, drive_states;  ///< state at the end of the step
  /// The relative error of the laws of contact in the step: the larger one of those for the impulses at its
  /// start and at its end. If the step is computed in parts, it is the largest one of all parts. The error of
  /// impulses is their difference from the impulses that the laws give for the velocities after them. The
  /// relative error is the norm of the velocities that this difference causes, divided by the sum of the
  /// norms of the velocities without impulses and of those that the impulses add. The norm of velocities v is
  /// √(vᵀ M v) with the mass matrix M. An error at the start that is not larger than the effect of rounding
  /// the positions does not count.
  double certificate = 0;
  bool touched = false;  ///< whether an impulse acted
  /// An estimate of the error of the end of the step, a displacement (m), that arises because a contact began
  /// to stick at an unknown time in the step.
  double unresolved = 0;
  /// Whether run() stores in `kept` what a derivative of the step needs, one entry for each part of the step.
  bool keep_parts = false;
  std::vector<ContactPart> kept;
  /// The points of contact at the end of the step, with the mean forces of the step.
  std::span<const ContactForce> forces() const { return record_.contacts(); }

 private:
  /// The rows and multipliers of the contact problem at the start or at the end of the step.
  struct End {
    ContactSystem system;
    VelocitySolver solver = {};
    std::vector<Contact> contacts = {};
    std::vector<double> lambda = {};  ///< multipliers in scaled rows
    std::vector<double> u = {};       ///< velocities of the rows before the impulses
    std::vector<double> u_after = {};
    Vector x = {}, v = {};  ///< scratch (nv)

    End(const Model& model, int rows, std::size_t capacity, bool dry_friction)
        : system(model, rows, capacity, dry_friction), x(model.nv()), v(model.nv()) {}
    std::size_t rows() const { return system.problem().r.size(); }
  };
  /// The multipliers of a contact (its normal impulse, and its friction impulses divided by the coefficient
  /// of friction) that are stored for the next step. `start` has those at the start of the last step. `guess`
  /// has first guesses for the iterations of the next step, for the multipliers at its start and at its end.
  /// The guess for the end has the multipliers at the end of the last step, or 0 if the contact was not
  /// active there. The guess for the start is `start`, or is extrapolated linearly from the starts of the
  /// last two steps if these steps have the same length and the normal impulse was positive in the earlier
  /// one and did not fall to half or less.
  struct Remembered {
    using Multipliers = std::array<double, LawBlock::most_rows>;
    std::uint64_t key;
    std::array<Multipliers, 2> guess;
    Multipliers start;
  };

  Failure attempt(double t, double h, const Vector& q_0, const Vector& v_0, const Vector& x_0);
  /// Finds the contacts with gaps up to `margin` of bodies with the poses C_.
  Failure find(double margin, std::vector<Contact>& contacts, double t);
  double reach(double h, const Vector& v_0);
  /// Computes, by iteration, the impulses that act at the start of the step and the free motion after them.
  Failure move(double t, double h, const Vector& v_0, double margin);
  Failure fly(double enough);
  /// The relative error of the laws of contact, see `certificate`, for the impulses that act at the start of
  /// the step. They are computed by iteration; the error is that of the last iterate. It becomes small even
  /// if, because of friction, the laws hardly determine the impulses.
  double law_error();
  double rounding_error(double h) const;
  void set_compliances(double h);
  double unresolved_slip(double h) const;
  /// Sets the right sides of the equations for the impulses at the start of the step. They follow from the
  /// free motion after these impulses that was computed last: from the gaps of contacts and stops and the
  /// residuals of loops at the end of the step, and from the sliding velocities in its middle. If `choose` is
  /// true, also decides which contacts slide, and returns whether this decision changed.
  bool set_r_of_start(double h, bool choose);
  /// Makes the constraint rows for the configuration at the end of the step, and computes the joint
  /// velocities there, before the impulses at the end. The free motion up to there begins after the impulses
  /// at the start.
  Failure reach_end(double t, double h);
  /// Finds the impulses of contacts, stops, dry friction and loops at the end of the step, and the joint
  /// velocities after these impulses. reach_end() must have been called.
  Failure land(double t);
  void set_r_of_end(double bounciness);
  void select_active();
  double closed(const Contact& contact) const;
  bool overlaps(const Contact& contact) const;  ///< whether its gap is negative beyond rounding
  /// Moves q so that overlaps and loops are closed, by the displacement that moves the masses least (D11.15).
  Failure separate(double t, double h);
  /// Improves the multipliers `lambda` of the contact problem of an end until they obey the laws of contact
  /// to the tolerance, and writes the remaining residual to `e`. t is the time at which the step begins. In
  /// long computations, SimulationOptions::monitor, a function of the caller, is called with t; if it returns
  /// false, solve() fails.
  Failure solve(double t, End& end, std::vector<double>& lambda, double tolerance, double& e);
  void apply(End& end, const Vector& v, Vector& v_after);
  Failure work(double t, double& sum);
  void keep_start(double h, const Vector& q_0, const Vector& v_0, double margin);
  void keep_end(double bounciness);
  void recall(End& end, std::size_t which);
  void remember(double h);
  void record();  ///< adds the points and impulses of an attempt to record_
  static const Contact* with_key(const std::vector<Contact>& contacts, std::uint64_t key, std::size_t hint);

  ContactSimulationRun* run_;
  Model model_;
  ConfigurationGroup<double> group_;
  ContactFinder finder_;
  End start_, end_;
  ContactRecord record_;
  std::vector<double> reach_of_shape_;  ///< distance from the origin of the body, m
  double size_ = 0;                     ///< extent of the largest shape that is no plane, m
  std::vector<SE3<>> C_;
  std::vector<Contact> middle_, found_;
  std::vector<double> slip_;      ///< contact velocities in the middle, in the axes of the start
  std::vector<char> slides_;      ///< for contacts at the start: friction opposes the mean velocity
  std::vector<double> openings_;  ///< residual of each loop row, m or rad
  std::vector<Remembered> remembered_, forgotten_;
  std::vector<char> bounces_;  ///< whether contacts, and then stops, at the start bounce
  Vector p_0_, p_a_;           ///< momenta before and after the impulses at the start
  Vector v_before_, v_after_;  ///< velocities before the impulses at the end, and after those at the start
  Vector q_part_, v_part_, x_part_;
  std::vector<double> before_;   ///< multipliers before recall()
  std::vector<double> r_;        ///< right sides of the last problem at the start
  std::vector<double> weights_;  ///< 1/d for the scale d of each row at the start
  Multisecant secants_;          ///< acceleration of the iteration of r_
  std::vector<double> scratch_;  ///< memory for law_error()
  std::vector<double> between_;  ///< row velocities after the first impulses; multipliers
  double h_of_remembered_ = 0;   ///< step in which the remembered multipliers acted
  bool hard_ = false;            ///< whether the solver had to start again in the last problem
  Failure interruption_ = {};    ///< by the monitor, in the last problem
};

}  // namespace axode
