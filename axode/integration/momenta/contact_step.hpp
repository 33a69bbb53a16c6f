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

/// One step of a motion with contact (D11.12): impulses at the start of the step, so that gaps and loops are
/// closed at its end and sticking contacts stick in its middle; the free motion by the midpoint rule; and
/// impulses at the end, so that velocities obey the law of ContactLaw.
class ContactStep {
 public:
  using Vector = Eigen::VectorXd;

  /// `dry_friction` says whether the dry friction of joints acts.
  ContactStep(ContactSimulationRun& run, const Model& model, ContactShapes shapes, bool dry_friction);

  /// Steps from (q_0, v_0) at time t over h. A step whose certificate is above 1e-9 is repeated in up to 16
  /// parts. Sets the public members. Allocates nothing, unless there are more contacts than ever before and
  /// than 64.
  Failure run(double t, double h, const Vector& q_0, const Vector& v_0);

  /// Forgets the multipliers of earlier steps. A motion after it does not depend on the motions before.
  void restart() noexcept;

  Vector q, v;  ///< at the end of the step
  /// The largest certificate of the problems of the step, see certificate(). If the iteration for the
  /// impulses at its start does not converge, also the last change of the motion by them, as a part of the
  /// motion.
  double certificate = 0;
  bool touched = false;  ///< whether an impulse acted
  /// A displacement (m) by which the end of the step may be wrong, because a contact began to stick within it.
  double unresolved = 0;
  /// Whether run() leaves in `kept` what its parts have decided.
  bool keep_parts = false;
  std::vector<ContactPart> kept;
  /// The points of contact at the end of the step, with the mean forces of the step.
  std::span<const ContactForce> forces() const { return record_.contacts(); }

 private:
  /// The rows and multipliers of the problem at one end of the step.
  struct End {
    ContactSystem system;
    std::vector<Contact> contacts = {};
    std::vector<double> lambda = {};  ///< multipliers in scaled rows
    std::vector<double> u = {};       ///< velocities of the rows before the impulses
    std::vector<double> u_after = {};
    Vector x = {}, v = {};  ///< scratch (nv)

    End(const Model& model, int rows, std::size_t capacity, bool dry_friction)
        : system(model, rows, capacity, dry_friction), x(model.nv()), v(model.nv()) {}
    std::size_t rows() const { return system.problem().r.size(); }
  };
  /// Multipliers of a contact at both ends, kept from step to step.
  struct Remembered {
    std::uint64_t key;
    std::array<std::array<double, LawBlock::most_rows>, 2> lambda;
  };

  Failure attempt(double t, double h, const Vector& q_0, const Vector& v_0);
  Failure find(const Vector& q, double margin, std::vector<Contact>& contacts, double t);
  double reach(double h, const Vector& v_0);
  /// Iterates for the impulses at the start and the free motion after them.
  Failure move(double t, double h, const Vector& q_0, const Vector& v_0, double margin);
  /// The certificate of the multipliers of the last free motion in the law at its end, which is the problem
  /// with the r that set_r_of_start() has found. It is small where rounding moves the multipliers, because
  /// friction determines them badly.
  double law_error();
  void set_compliances(double h);
  double unresolved_slip(double h) const;
  /// Sets r of the problem at the start by the last free motion.
  void set_r_of_start(double h, bool choose);
  /// Solves the problem at the end of the free motion.
  Failure land(double t, double h);
  void set_r_of_end(double bounciness);
  void select_active();
  double closed(const Contact& contact) const;
  bool overlaps(const Contact& contact) const;  ///< by more than rounding
  /// Moves q so that overlaps and loops close, by the motion that moves the masses least (D11.15).
  Failure separate(double t, double h);
  /// Solves a problem in the step that begins at time t, sets hard_ and the certificate, and fails if it is
  /// interrupted.
  Failure solve(double t, const VelocityProblem& problem, std::vector<double>& lambda, double tolerance,
                double& e);
  void apply(End& end, const Vector& v, Vector& v_after);
  double work();
  void keep_start(double h, const Vector& q_0, const Vector& v_0, double margin);
  void keep_end(double bounciness);
  void recall(End& end, std::size_t which);
  void remember();
  void record();  ///< the points and impulses of an attempt
  static const Contact* with_key(const std::vector<Contact>& contacts, std::uint64_t key, std::size_t hint);

  ContactSimulationRun* run_;
  Model model_;
  ConfigurationGroup<double> group_;
  ContactFinder finder_;
  End start_, end_;
  VelocitySolver solver_;
  ContactRecord record_;
  std::vector<double> reach_of_shape_;  ///< from the origin of the body, m
  double size_ = 0;                     ///< extent of the largest shape that is no plane, m
  std::vector<SE3<>> C_;
  std::vector<Contact> middle_, found_;
  std::vector<double> slip_;      ///< velocities of the rows in the middle, in the axes of the start
  std::vector<char> slides_;      ///< of each contact at the start: friction against the mean velocity
  std::vector<double> openings_;  ///< of loop rows, m or rad
  std::vector<Remembered> remembered_;
  std::vector<char> bounces_;  ///< of each contact and stop at the start
  Vector v_after_, change_, q_part_, v_part_, nothing_;
  std::vector<double> before_;   ///< multipliers of the last iteration, or before recall()
  std::vector<double> r_;        ///< right sides of the last problem at the start
  std::vector<double> weights_;  ///< 1/d of the rows at the start
  Multisecant secants_;          ///< of the right sides
  std::vector<double> scratch_;  ///< of law_error()
  std::vector<double> between_;  ///< velocities of the rows at the start after its impulses; multipliers
  bool hard_ = false;            ///< whether the last problem needed further starts
  Failure interruption_ = {};    ///< of the last problem
};

}  // namespace axode
