#pragma once
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
#include "axode/recursion/decompositions.hpp"

namespace axode {

/// Directions for the derivative of a step with contact: changes of drive forces, of the surfaces of shapes,
/// and of the parameters of the mechanism. The matrices `tau`, `friction`, `restitution` and `thickness` have
/// a column for each of k directions. `tau` has nv rows; the other three have a row for each shape, or are
/// empty if surfaces do not change. `parameters` has the changes of inertias, of geometric parameters, and of
/// the placements of shapes on their bodies. Its matrices are empty, or have p <= k columns for the last p of
/// the k directions; along the other directions parameters do not change.
struct ContactDirections {
  Changes tau;                     ///< drive forces, nv × k
  Changes friction;                ///< coefficient of sliding friction
  Changes restitution;             ///< if a pair has two equal ones, the first one's change acts
  Changes thickness;               ///< thickness of a layer, m: radius of a
                                   ///< sphere, height of a plane
  ParameterDirections parameters;  ///< for the last p of the k directions
};

/// The derivative of a step with contact along k directions, by implicit differentiation of its equations
/// (D11.19 to D11.23). Which contacts touch, stick, slide or bounce is taken as unchanged. An object is the
/// scratch memory of one thread.
class ContactStepDerivative {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::MatrixXd;

  /// dry_friction and damping say whether those of joints acted in the step. Allocates.
  ContactStepDerivative(const Model& model, const ContactShapes& shapes, bool dry_friction, bool damping);

  /// Replaces the changes dq (left-trivialised) and dv (nv × k) of the state at the start of a substep (a
  /// step of a simulation or a part of one) by those at its end, along k directions. `directions` has the
  /// changes of drive forces, of the surfaces of shapes, and of the parameters of the mechanism along the
  /// same directions. Returns false if the points of a contact have no formula that can be differentiated;
  /// why() then says which. Allocates. O(n (k + nv) + nv² k + m³) for n bodies and m scalar constraints by
  /// contacts, stops, dry friction and loops.
  bool run(const ContactPart& part, Changes& dq, Changes& dv, const ContactDirections& directions);

  const std::string& why() const { return why_; }
  /// Two flags on all calls of run() so far. `unique` says whether all derivatives exist; they may not exist
  /// if contacts are redundant, so that the laws do not determine how they share a load. `at_kink` says
  /// whether a contact, stop or dry friction was within rounding of the boundary between two branches of its
  /// law, such as stick and slide; the derivatives are then those of the branch that the step took.
  bool unique = true, at_kink = false;

 private:
  /// The mass matrix M at a configuration q, and its factor.
  struct Mass {
    Matrix M;
    CholeskyFactor factor;
  };
  /// The derivative Mv_q of the momenta M v at a state (q, v) by q, and the derivatives F_q and F_v by q and
  /// v of the rates F that the momenta have without drive forces, gravity, loads and losses (nv × nv each).
  struct Kinetic {
    Matrix Mv_q, F_q, F_v;
  };
  /// A floating base in a substep (a step or a part of one). Its coordinates are relative to a moving frame.
  /// This frame begins with the velocity u that the centre of mass of the base with its subtree has after the
  /// impulses at the start, and falls with gravity. du are the changes of u along the directions of
  /// differentiation.
  struct Base {
    int body;
    Eigen::Index first;
    bool constant;
    double mass;
    Vec3<> u;
    VectorChanges du;
    VectorChanges turn;    ///< rotations by geometric parameters, in inertial axes; 3 × p or empty
    VectorChanges center;  ///< changes of the centre of mass at the start by parameters, 3 × p or empty
  };
  /// A list of contacts, evaluated in one configuration. For each contact, `jets` has the point, the normal
  /// and the gap with their derivatives by a displacement of one body relative to the other, and `axes` has
  /// the normal and two tangents, along which its velocities are resolved. `changes` and `daxes` have the
  /// changes of the point, the normal, the gap and these axes along the displacements of motion_. `found`
  /// says whether the gap of the contact is below the margin within which find() searches for contacts. If
  /// it is not, find() leaves the entries of the contact in `jets` and `changes` empty.
  struct Rows {
    std::vector<ContactJet> jets = {};
    std::vector<char> found = {};
    std::vector<ContactChanges> changes = {};
    std::vector<ContactFrame> axes = {};
    std::vector<FrameChanges> daxes = {};
  };
  /// The joint impulses Jᵀ (c λ) at one end of a substep (a step of a simulation or a part of one), with the
  /// Jacobian J of the constraint rows of contacts, stops, dry friction and loops, and their multipliers λ
  /// (`lambda`). The factor c of a row is the coefficient of friction for friction rows of contacts, and 1
  /// for all others. physical() returns the impulses c λ of the rows.
  struct Impulses {
    Matrix J;
    Vector c, lambda;  ///< factors and multipliers of the rows
    Vector physical() const { return c.cwiseProduct(lambda); }
  };

  /// Quantities at the start of a substep (a step of a simulation or a part of one). dq and dv are the
  /// changes of q and v before the impulses, and du those of the velocities u of the constraint rows before
  /// the impulses. dp are the changes of the momenta p after the impulses, dtau those of the drive forces,
  /// and `friction` those of the coefficients of friction of the shapes.
  ///
  /// Each of these matrices has k columns for the directions of differentiation, at constant multipliers, and
  /// then a column for each multiplier with the derivative by it. A multiplier is the impulse of a constraint
  /// row at the start of the substep, divided by the coefficient of friction if it is a friction row of a
  /// contact.
  struct Start {
    Changes dq, dv, dtau, friction;
    Rows rows;
    Impulses first;
    Mass mass;      ///< at q
    Vector v_a, p;  ///< velocities and momenta after impulses; p in moving frames
    Changes dp;
    Vector u;  ///< velocities of the rows before the impulses
    Changes du, du_rolling;
  };
  /// Changes of q and v in the middle of the free motion, and of q and momenta p at its end, with the mass
  /// matrix there.
  struct Flight {
    Changes dq_m, dv_m, dq_1, dp_1;
    Mass at_1;
  };
  /// The velocities of the contact rows in the middle of the free motion.
  struct Slip {
    Rows rows;
    Vector u;
    Changes du;
  };

  /// The norm √(xᵀ M x) of velocities x; for several columns, the square root of the sum of their squared
  /// norms.
  static double mass_norm(const Matrix& M, const ChangesArgument& x);
  Matrix mass_matrix_at(const Vector& q);
  Mass mass(const Vector& q);
  Kinetic kinetic(const Vector& q, const Vector& v);
  Matrix momenta_by_q(const Vector& q, const Vector& v);  ///< Mv_q alone
  /// Computes the motion of the bodies at (q, v), displaced along each coordinate of q by itself. If shapes
  /// or their places change along the k directions of differentiation, k displacements at constant q follow.
  void displace_each(const Vector& q, const Vector& v);
  /// Computes the motion of the bodies at (q, v), displaced by changes dq and dv of the state. Their first k
  /// columns are along the directions of differentiation, so that shapes and their places change, too.
  void displace(const Vector& q, const Vector& v, const Changes& dq, const Changes& dv);
  /// The changes, along changes dq of q, of what has the changes x along the displacements of
  /// displace_each(). The first k columns of dq are along the directions of differentiation.
  Changes chain(const ChangesArgument& x, const Changes& dq) const;
  /// Finds the points, normals and gaps of contacts with gaps up to `margin`, and their changes along the
  /// displacements of motion_. Returns false if a contact has no formula that can be differentiated.
  bool find(const std::vector<Contact>& contacts, double margin, Rows& out);
  /// The changes of the factors c of the constraint rows, a row for each constraint row and a column for each
  /// column of `friction`. c is the impulse of a constraint row divided by its multiplier: the coefficient of
  /// friction for friction rows of contacts, and 1 for all others. Only the factors of sliding friction
  /// change. `friction` has the changes of the coefficients of sliding friction of the shapes, a row for each
  /// shape.
  Changes coefficient_changes(const std::vector<Contact>& contacts, Eigen::Index rows,
                              const Changes& friction) const;
  /// The changes of a contact by the displacements of its shapes on their bodies (p columns).
  ContactChanges placement_changes(std::uint64_t key, const ContactJet& jet) const;
  /// The p columns of a matrix x along the directions of the parameters of the mechanism.
  auto by_parameters(Changes& x) const { return x.middleCols(first_, p_); }
  /// Changes of the restitution of a contact (1 × k) by those of its shapes.
  Eigen::RowVectorXd restitution_changes(const Contact& contact) const;
  void set_axes(const std::vector<Contact>& contacts, Rows& out);
  Impulses set_rows(const Vector& q, const std::vector<Contact>& contacts, double h, double stop_margin,
                    const std::vector<double>& lambda);
  /// The changes of Jᵀ λ along dq, nv rows, for constant impulses λ = `physical` of the constraints with the
  /// Jacobian J. displace_each() must have been called at q.
  Changes impulse_changes(const Vector& q, const Rows& rows, const Vector& physical, const Changes& dq);
  /// The changes of J x along dq for constant velocities x and the constraint Jacobian J, a row for each
  /// constraint. Writes J x to `u`. displace_each() must have been called at (q, x).
  Changes velocity_changes(const Vector& q, const Vector& x, const Rows& rows, const Changes& dq, Vector& u);
  Eigen::Matrix3d rotation(int base, const Vector& q) const;  ///< of a floating base, to inertial axes
  void begin_bases(const ContactPart& part, const Start& start);
  void differentiate_bases(const ContactPart& part, const Start& start, const Matrix& Mv_q);
  /// Computes the changes of the velocities J v of the loop rows at the start of a substep (a step of a
  /// simulation or a part of one) of length h. J is the Jacobian of the loops at the configuration q_0 at the
  /// start, and v = v_0 + M⁻¹ (P - h G/2), with the velocities v_0 before the substep, the mass matrix M, the
  /// joint impulses P at the start, and the forces G that balance gravity at q_0. If a loop constrains
  /// velocities alone, as a rolling contact does, the impulses make its J v equal to 0. The result has a row
  /// for each loop row. It has the columns of dq, dv and dp, the changes of q_0, v_0 and P: k columns for the
  /// directions along which the step is differentiated, at constant multipliers, and then a column for each
  /// multiplier of the impulses at the start.
  Changes rolling_changes(const ContactPart& part, const Start& start, const Changes& dp);
  /// The product of a transposed map of maps_ and momenta x.
  template <class M> M transposed(GroupDerivatives::Block GroupDerivatives::Joints::*map, const M& x) const;
  /// The derivatives of Ad_{exp y}ᵀ p or of dexp_yᵀ p by y.
  Matrix turn_of(const Vector& y, const Vector& p, bool Ad) const;
  /// Velocities (nv) of the moving frames of floating bases, as joint velocities at q, a time t after the
  /// start.
  Vector frame_velocity(const Vector& q, double t) const;
  void add_frame_changes(const Vector& q, double time, double of_place, double of_velocity,
                         const Changes& dq_moving, Changes* dq, Changes* dv) const;
  bool begin(const ContactPart& part, const Changes& dq, const Changes& dv,
             const ContactDirections& directions, Start& out);
  Flight fly(const ContactPart& part, const Start& start);
  void take_forces(const ContactPart& part, const Matrix& M, const Kinetic& at_m, const Vector& v_m,
                   Matrix& f_q, Matrix& f_v, Changes& df);
  bool take_slip(const ContactPart& part, const Start& start, const Flight& flight, Slip& out);
  bool take_start_velocities(const ContactPart& part, const Start& start, const Flight& flight,
                             const Slip& middle, Vector& u, Changes& du);
  bool impulses_at_end(const ContactPart& part, const Start& start, const Slip& middle,
                       const Changes& dlambda, const Mass& at_1, const Changes& dp, const Changes& friction,
                       Changes& dq, Changes& dv);
  bool move_apart(const ContactPart& part, const Mass& at_1, Changes& dq);
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
  ParameterChanges parameter_changes_;
  ParameterDirections along_;
  /// The number k of directions of differentiation, the first one of along_, and their number. The column of
  /// the first direction among the displacements of motion_, if there is one.
  Eigen::Index k_ = 0, first_ = 0, p_ = 0, first_column_ = 0;
  Changes each_, none_;  ///< the displacements of displace_each(), and as many zeros
  std::vector<Base> bases_;
  Changes thickness_, restitution_;  ///< changes along the directions of differentiation, or empty
  std::vector<int> place_;           ///< index of each velocity in its joint
  std::string why_;
};

}  // namespace axode
