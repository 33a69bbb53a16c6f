#pragma once
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <string>
#include <vector>

#include "axode/constraints/loops.hpp"
#include "axode/contact/derivatives/displaced_motion.hpp"
#include "axode/contact/law/problem_derivative.hpp"
#include "axode/derivatives/displacement/momentum_first_order.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/momenta/contact_part.hpp"
#include "axode/integration/schemes/group_derivatives.hpp"

namespace axode {

/// Changes of drive forces and of the surfaces of shapes along k directions.
/// Matrices of surfaces may be empty, and have a row for each of the
/// ContactShapes otherwise.
struct ContactDirections {
  Eigen::MatrixXd tau;          ///< nv × k
  Eigen::MatrixXd friction;     ///< coefficient of sliding friction
  Eigen::MatrixXd restitution;  ///< of a pair with two equal ones the first shape's counts
  Eigen::MatrixXd thickness;    ///< of a layer on the surface, m: radius of a
                                ///< sphere, height of a plane
};

/// The derivative of a step with contact by implicit differentiation of its
/// equations at their solution (D11.19 to D11.23), along k directions that are
/// propagated together. Which contacts touch, stick, slide or bounce does not
/// change along the directions. It is the scratch memory of one thread.
class ContactStepDerivative {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::MatrixXd;

  /// `dry_friction` must be that of the step. Allocates.
  ContactStepDerivative(const Model& model, const ContactShapes& shapes, bool dry_friction, bool damping);

  /// Replaces the changes dq, dv (nv × k) of the state at the start of a part
  /// by those at its end, for changes of forces and surfaces. dq is
  /// left-trivialised. Returns false if contact points are not differentiable;
  /// then why() says which. Allocates. It takes O(n k + nv² k + rows³).
  bool run(const ContactPart& part, Matrix& dq, Matrix& dv, const ContactDirections& directions);

  const std::string& why() const { return why_; }
  /// Whether every derivative so far exists and whether one was at a kink, see
  /// ProblemDerivative.
  bool unique = true, at_kink = false;

 private:
  /// M v and f = ∂L/∂q of the kinetic energy with their derivatives, at a state
  /// (q, v).
  struct Momenta {
    Matrix M, Mv_q, F_q, F_v;
    Eigen::LLT<Matrix> factor;
  };
  /// A floating base during a part: the velocity u of the centre of mass with
  /// which its frame moves.
  struct Base {
    int body;
    Eigen::Index first;
    bool constant;
    double mass;
    Vec3<> u;
    Eigen::Matrix3Xd du;
  };
  /// The rows of the contacts of one configuration and how they change.
  struct Rows {
    std::vector<ContactJet> jets = {};
    std::vector<char> found = {};
    std::vector<ContactChanges> changes = {};
    std::vector<ContactFrame> axes = {};
    std::vector<FrameChanges> daxes = {};
  };
  /// The matrices J (rows × nv) and c J of the impulses at one end, and the
  /// problem's rows.
  struct Impulses {
    Matrix J;
    Vector c, lambda;  ///< λ in scaled rows
    Vector physical() const { return c.cwiseProduct(lambda); }
  };

  /// The start of a part. Changes have k columns along the directions, and then one for each multiplier.
  struct Start {
    Eigen::Index k = 0;
    Matrix dq, dv, dtau, friction;
    Rows rows;
    Impulses first;
    Momenta momenta;  ///< at the velocities before the impulses, in the moving frames
    Vector v_a, p;    ///< after the impulses; p in the moving frames
    Matrix dp;
    Vector u;  ///< of the rows before the impulses
    Matrix du, du_rolling;
  };
  /// Changes of the middle and the end of the free motion.
  struct Flight {
    Matrix dq_m, dv_m, dq_1, dp_1;
  };
  /// The velocities of the rows in the middle.
  struct Slip {
    Rows rows;
    Vector u;
    Matrix du;
  };

  /// The size of velocities, or of columns of velocities, in the metric of the masses.
  static double mass_norm(const Matrix& M, const Matrix& x);
  void take_momenta(const Vector& q, const Vector& v, Momenta& out);
  /// Finds the jets of contacts at the poses of the motion, and how they
  /// change.
  bool find(const std::vector<Contact>& contacts, double margin, Rows& out);
  /// Changes of the coefficients c of the rows of contacts (rows × k).
  Matrix coefficient_changes(const std::vector<Contact>& contacts, Eigen::Index rows,
                             const Matrix& friction) const;
  /// Changes of the restitution of a contact (1 × k).
  Eigen::RowVectorXd restitution_changes(const Contact& contact) const;
  void set_axes(const std::vector<Contact>& contacts, Rows& out);
  Impulses set_rows(const Vector& q, const std::vector<Contact>& contacts, double h, double stop_margin,
                    const std::vector<double>& lambda);
  /// Changes of Jᵀ λ (nv × k) for constant λ.
  Matrix impulse_changes(const Vector& q, const Rows& rows, const Vector& physical, const Matrix& dq);
  /// Changes of J x (rows × k) for constant x, and J x in `u`. The motion must
  /// have run at (q, x).
  Matrix velocity_changes(const Vector& q, const Vector& x, const Rows& rows, const Matrix& dq, Vector& u);
  void begin_bases(const ContactPart& part, const Vector& v_a, const Matrix& M, const Matrix& dq,
                   const Matrix& dp);
  /// Changes of the velocities of those loop rows that have no residual, of
  /// rolling contacts, by which the impulses at the start are determined (rows
  /// of loops × k).
  Matrix rolling_changes(const ContactPart& part, const Rows& start, const Impulses& first, const Matrix& dp,
                         const Matrix& dq, const Matrix& dv);
  Matrix Ad_transpose(const Vector& y, Matrix x) const;
  Matrix dexp_transpose(const Vector& y, Matrix x) const;
  /// The derivatives of Ad_{exp y}ᵀ p or of dexp_yᵀ p by y.
  Matrix turn_of(const Vector& y, const Vector& p, bool Ad) const;
  /// Velocities of the bases against their frames after a time t, as velocities
  /// of joints.
  Vector frame_velocity(double t) const;
  void add_frame_changes(double time, double of_place, double of_velocity, const Matrix& dq_moving,
                         Matrix* dq, Matrix* dv) const;
  bool begin(const ContactPart& part, const Matrix& dq, const Matrix& dv, const ContactDirections& directions,
             Start& out);
  Flight fly(const ContactPart& part, const Start& start);
  void take_forces(const ContactPart& part, const Momenta& at_m, const Vector& v_m, Matrix& f_q, Matrix& f_v,
                   Matrix& df);
  bool take_slip(const ContactPart& part, const Start& start, const Flight& flight, Slip& out);
  bool take_start_velocities(const ContactPart& part, const Start& start, const Flight& flight,
                             const Slip& middle, Vector& u, Matrix& du);
  bool impulses_at_end(const ContactPart& part, const Start& start, const Slip& middle, const Matrix& dp,
                       const Matrix& friction, Matrix& dq, Matrix& dv);
  bool move_apart(const ContactPart& part, Matrix& dq);
  void note(const LawDerivative& law) {
    unique = unique && law.unique;
    at_kink = at_kink || law.at_kink;
  }

  Model model_;
  ContactShapes shapes_;
  const Tree<double>* tree_;
  bool damping_;
  Workspace<> workspace_;
  WithScratch<double, MomentumFirstOrder<double>> momenta_;
  ConfigurationGroup<double> group_;
  ConfigurationGroup<Displaced, double> displaced_group_;
  GroupDerivatives maps_;
  ContactSystem system_;
  LoopWorkspace<double> loops_;
  ContactJets jets_;
  DisplacedMotion motion_;
  std::vector<Base> bases_;
  Matrix thickness_, restitution_;  ///< changes along the directions of the
                                    ///< motion and of the part, or empty
  std::vector<int> place_;          ///< of each velocity in its joint
  std::string why_;
};

}  // namespace axode
