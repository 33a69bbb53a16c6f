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

/// The directions along which a step with contact is differentiated: changes of drive forces and of the
/// surfaces of shapes, a column for each of k directions. `tau` has nv rows. The other matrices have a row
/// for each of the ContactShapes, or are empty if surfaces do not change.
struct ContactDirections {
  Eigen::MatrixXd tau;          ///< drive forces, nv × k
  Eigen::MatrixXd friction;     ///< coefficient of sliding friction
  Eigen::MatrixXd restitution;  ///< if a pair has two equal ones, the first one's change acts
  Eigen::MatrixXd thickness;    ///< thickness of a layer, m: radius of a
                                ///< sphere, height of a plane
};

/// The derivative of a step with contact by implicit differentiation of its equations at their solution
/// (D11.19 to D11.23), along k directions that are propagated together. Which contacts touch, stick, slide or
/// bounce is taken as unchanged along the directions. An object is the scratch memory of one thread.
class ContactStepDerivative {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::MatrixXd;

  /// `dry_friction` and `damping` say whether the dry friction and the damping
  /// of joints acted in the step. Allocates.
  ContactStepDerivative(const Model& model, const ContactShapes& shapes, bool dry_friction, bool damping);

  /// Replaces the changes dq, dv (nv × k) of the state at the start of a part of a step by the changes at its
  /// end, along directions in which drive forces and surfaces may also change. dq is left-trivialised.
  /// Returns false if the points of a contact have no formula that can be differentiated; then why() says
  /// which. Allocates. It takes O(n k + nv² k + m³) for m scalar constraints by contacts, stops, dry joints
  /// and loops.
  bool run(const ContactPart& part, Matrix& dq, Matrix& dv, const ContactDirections& directions);

  const std::string& why() const { return why_; }
  /// `unique` says whether every derivative so far exists, and `at_kink`
  /// whether a contact, stop or dry joint was within rounding of the boundary
  /// between two branches of its law, see ProblemDerivative.
  bool unique = true, at_kink = false;

 private:
  /// At a state (q, v): the mass matrix M, its factor, the derivative Mv_q of the momenta M v by q, and the
  /// derivatives F_q and F_v of F = ∂L/∂q by q and v, with the kinetic energy L (nv × nv each).
  struct Momenta {
    Matrix M, Mv_q, F_q, F_v;
    Eigen::LLT<Matrix> factor;
  };
  /// A floating base during a part of a step: the velocity u of its centre of
  /// mass, with which its moving frame moves, and the changes du of u along the
  /// directions.
  struct Base {
    int body;
    Eigen::Index first;
    bool constant;
    double mass;
    Vec3<> u;
    Eigen::Matrix3Xd du;
  };
  /// The contacts in one configuration and how they change along the directions. For each contact: its point,
  /// normal and gap with their derivatives (ContactJet), whether it was found in this configuration, its
  /// changes, its axes, and the changes of its axes.
  struct Rows {
    std::vector<ContactJet> jets = {};
    std::vector<char> found = {};
    std::vector<ContactChanges> changes = {};
    std::vector<ContactFrame> axes = {};
    std::vector<FrameChanges> daxes = {};
  };
  /// The impulses at one end of a part of a step: the Jacobian J of the constraints, whose rows belong to
  /// contacts, stops, dry joints and loops; a factor c for each row, by which its multiplier is scaled; and
  /// the multipliers. The joint impulses are Jᵀ physical().
  struct Impulses {
    Matrix J;
    Vector c, lambda;  ///< λ in scaled rows
    Vector physical() const { return c.cwiseProduct(lambda); }
  };

  /// The start of a part of a step. Matrices of changes have k columns along the directions, and then one
  /// along each multiplier of the impulses at the start.
  struct Start {
    Eigen::Index k = 0;
    Matrix dq, dv, dtau, friction;
    Rows rows;
    Impulses first;
    Momenta momenta;  ///< at the velocities before impulses, in moving frames
    Vector v_a, p;    ///< velocities and momenta after impulses; p in moving frames
    Matrix dp;
    Vector u;  ///< velocities of the rows before the impulses
    Matrix du, du_rolling;
  };
  /// Changes of q and v in the middle of the free motion, and of q and p at its
  /// end.
  struct Flight {
    Matrix dq_m, dv_m, dq_1, dp_1;
  };
  /// The velocities of the contact rows in the middle of the free motion.
  struct Slip {
    Rows rows;
    Vector u;
    Matrix du;
  };

  /// The norm √(xᵀ M x) of velocities x; if x has several columns, the root of
  /// the sum of their squared norms.
  static double mass_norm(const Matrix& M, const Matrix& x);
  void take_momenta(const Vector& q, const Vector& v, Momenta& out);
  /// Finds the points, normals and gaps of contacts at the poses of motion_, and how they change along its
  /// directions. `margin` is the gap up to which a contact is found. Returns false if a contact has no
  /// formula that can be differentiated.
  bool find(const std::vector<Contact>& contacts, double margin, Rows& out);
  /// Changes (rows × k) of the factors c by which the multipliers are scaled, if the coefficients of sliding
  /// friction of the shapes change by `friction`. For a row of friction, c is the coefficient of friction.
  Matrix coefficient_changes(const std::vector<Contact>& contacts, Eigen::Index rows,
                             const Matrix& friction) const;
  /// Changes of the restitution of a contact (1 × k) by those of its shapes.
  Eigen::RowVectorXd restitution_changes(const Contact& contact) const;
  void set_axes(const std::vector<Contact>& contacts, Rows& out);
  Impulses set_rows(const Vector& q, const std::vector<Contact>& contacts, double h, double stop_margin,
                    const std::vector<double>& lambda);
  /// Changes (nv × k) of the joint impulses Jᵀ λ along the directions for constant multipliers λ =
  /// `physical`; J is the Jacobian of the constraints.
  Matrix impulse_changes(const Vector& q, const Rows& rows, const Vector& physical, const Matrix& dq);
  /// Changes (rows × k) of J x along the directions for constant velocities x, with the Jacobian J of the
  /// constraints; writes J x to `u`. motion_ must have run at (q, x).
  Matrix velocity_changes(const Vector& q, const Vector& x, const Rows& rows, const Matrix& dq, Vector& u);
  void begin_bases(const ContactPart& part, const Vector& v_a, const Matrix& M, const Matrix& dq,
                   const Matrix& dp);
  /// Changes (loop rows × k) of the velocities along the rows of the loops that the linear problem at the
  /// start of the step predicts. They determine the impulses of rolling contacts, whose rows have no residual
  /// in positions.
  Matrix rolling_changes(const ContactPart& part, const Rows& start, const Impulses& first, const Matrix& dp,
                         const Matrix& dq, const Matrix& dv);
  Matrix Ad_transpose(const Vector& y, Matrix x) const;
  Matrix dexp_transpose(const Vector& y, Matrix x) const;
  /// The derivatives of Ad_{exp y}ᵀ p or of dexp_yᵀ p by y.
  Matrix turn_of(const Vector& y, const Vector& p, bool Ad) const;
  /// Velocities of the moving frames of floating bases at a time t after the
  /// start of the part, as velocities of their joints (nv numbers).
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
  bool impulses_at_end(const ContactPart& part, const Start& start, const Slip& middle, const Matrix& dlambda,
                       const Matrix& dp, const Matrix& friction, Matrix& dq, Matrix& dv);
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
  Matrix thickness_, restitution_;  ///< changes along the directions of
                                    ///< motion_ and of the part, or empty
  std::vector<int> place_;          ///< index of each velocity in its joint
  std::string why_;
};

}  // namespace axode
