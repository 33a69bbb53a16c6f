#pragma once
#include <span>
#include <vector>

#include "axode/contact/law/contact_law.hpp"

namespace axode {

/// The problem to find the multipliers (impulses) λ of constraint rows with the Jacobian J, such that the
/// velocities u = Yᵀ (w + Y λ) + r of the rows obey the laws of contact, friction and loops together with λ
/// (D11.5). r are given velocities, such as those with which contacts bounce. A block consists of consecutive
/// rows that obey one law together, such as the rows of one contact.
///
/// With the mass matrix M = Lᵀ D L and joint velocities v, x = D^½ L v are velocities in the metric of the
/// masses: |x|² = vᵀ M v. w is x for the motion without impulses, and Y = D^-½ L⁻ᵀ Jᵀ has a column for each
/// row of J. The support of a block is a given set of velocities. Only the entries of the block's columns of
/// Y for these velocities are stored; all others are 0.
///
/// The caller gives rows in physical units together with a factor c for each row, which is the coefficient of
/// friction for friction rows and 1 for all others. finish() multiplies the rows by c; they are then called
/// scaled rows. A multiplier λ of a scaled row means the impulse c λ.
class VelocityProblem {
 public:
  using Vector = Eigen::VectorXd;
  using Columns = Eigen::Map<const Eigen::MatrixXd>;

  struct Block : LawBlock {
    std::size_t support = 0;  ///< index of its first entry in supports_
    int width = 0;            ///< number of velocities that the block moves
    std::size_t columns = 0;  ///< index of its first entry in Y_, width × rows, column by column
    int compliances = 0;      ///< 1 if the last of these velocities is that of its compliance, otherwise 0
  };

  /// A problem without blocks for a mechanism with nv velocities.
  explicit VelocityProblem(int nv) : w(Vector::Zero(nv)), joint_velocities_(nv) {}

  /// Allocates memory for `blocks` blocks that have 6 rows each and move all velocities.
  void reserve(std::size_t blocks);
  /// Removes all constraint rows. Sets the number of compliant contacts, each of which adds an unknown
  /// velocity to those of the mechanism (D11.26).
  void clear(int compliances = 0);
  /// Appends a block of constraint rows with the Jacobian J to the problem. `support` has the velocities that
  /// the block moves, in ascending order; if `compliant`, the last of these is the additional unknown of a
  /// compliant contact. Returns the memory for the block's part of Y = D^-½ L⁻ᵀ Jᵀ, where Lᵀ D L is the mass
  /// matrix: a column for each row of the block, with a number for each velocity in `support`. The caller
  /// must write this memory before the next call. Before finish() it may set two numbers of each row: r (0 by
  /// default) is added to the velocity of the row, and finish() multiplies the row by c (1 by default), the
  /// coefficient of friction of a friction row. Allocates if more memory is needed than was reserved.
  double* add(ContactLaw law, int rows, std::span<const int> support, double bound = 0,
              bool compliant = false);
  /// Sets the compliance C of a block with a compliant contact, after finish(): the law of its normal row
  /// then holds for u + C λ instead of the velocity u.
  void set_compliance(const Block& block, double C) noexcept;
  double compliance(const Block& block) const noexcept;
  /// Completes the problem. Multiplies each constraint row by its factor c, which is a coefficient of
  /// friction or 1. Then computes the scale d² of each row from the diagonal of Yᵀ Y = J M⁻¹ Jᵀ (D11.6), with
  /// the Jacobian J of the rows and the mass matrix M. d² is the entry of the row; all rows of a contact have
  /// the larger of two numbers: the entry of the normal row, and half of the largest entry of the contact.
  /// Sets rows of loops that move nothing to 0, see moves(). If the normal impulse of a contact is given,
  /// adds the motion by this impulse to w, the motion without impulses.
  void finish() noexcept;
  /// Writes the normal impulses that were given for some contacts (ContactLaw::pressed) into the multipliers
  /// `lambda` of a solution, in which they are 0.
  void complete(double* lambda) const noexcept;

  /// The number of entries of w: the velocities of the mechanism, and one more for each compliant contact.
  int nv() const { return static_cast<int>(w.size()); }
  int rows() const { return static_cast<int>(r.size()); }
  std::span<const Block> blocks() const { return blocks_; }
  std::span<const int> support(const Block& b) const {
    return std::span(supports_).subspan(b.support, static_cast<std::size_t>(b.width));
  }
  /// The velocities of the mechanism that a block moves.
  std::span<const int> joint_support(const Block& b) const {
    return support(b).first(static_cast<std::size_t>(b.width - b.compliances));
  }
  /// The part of Y that belongs to a block, width × rows.
  template <int rows = Eigen::Dynamic> auto columns(const Block& b) const {
    return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, rows>>(Y_.data() + b.columns, b.width,
                                                                         b.rows);
  }
  const std::vector<double>& squared_scales() const { return d2_; }
  /// Whether an impulse of a constraint row changes the motion; it is known after finish(). It is false only
  /// for a row of a loop whose Jacobian is 0 up to rounding, because joints of the tree satisfy the
  /// constraint in any motion. finish() sets two data of such a row to 0: its column of Y = D^-½ L⁻ᵀ Jᵀ, with
  /// the Jacobian J of the rows and the mass matrix Lᵀ D L, and its given velocity r. A caller that changes Y
  /// or r afterwards must leave both 0 for this row.
  bool moves(std::size_t row) const { return moves_[row] != 0; }

  /// Computes x += factor Y λ, for rows() multipliers λ and nv() numbers x.
  void add_product(double factor, const double* lambda, double* x) const noexcept;
  /// Computes u += Yᵀ x, for nv() numbers x and rows() numbers u.
  void add_transposed(const double* x, double* u) const noexcept;
  /// Computes the Delassus operator G = Yᵀ Y (rows × rows) of the scaled rows.
  void delassus(Eigen::Ref<Eigen::MatrixXd> G) const noexcept;

  Vector w;               ///< nv(); 0 for compliances
  std::vector<double> r;  ///< an entry for each row
  std::vector<double> c;  ///< an entry for each row

 private:
  template <class F> void each_group(const F& f) const noexcept;
  double scale(const Block& b) const noexcept;

  Eigen::Index joint_velocities_;
  std::vector<Block> blocks_;
  std::vector<int> supports_;
  std::vector<double> Y_, d2_;
  std::vector<char> moves_;
};

/// The certificate of multipliers λ of constraint rows: the error of the laws of contact relative to the
/// motion, 0 if the laws hold ((D11.7) of docs/derivations). It is
/// |d (λ - resolve(λ - u/d²))| / (|w| + |Y λ|), where `resolve` maps a trial impulse to the impulse that the
/// law allows, and u = Yᵀ (w + Y λ) + r are the velocities of the rows. w is D^½ L v for the joint velocities
/// v without impulses and the mass matrix Lᵀ D L, Y λ is the part that the impulses add, and Y = D^-½ L⁻ᵀ Jᵀ
/// for the Jacobian J of the rows. r is a given velocity for each row, such as that with which a contact
/// bounces. d² is about the diagonal entry of Yᵀ Y for a row, so that u/d² is an impulse and d λ has the unit
/// of w. The certificate is NaN if a number is not finite. `scratch` is memory for 2 rows() + nv() numbers.
double certificate(const VelocityProblem& problem, const double* lambda, double* scratch) noexcept;
/// Computes the certificate |d ρ| / (|w| + |t|) of multipliers λ of constraint rows: the error of the laws of
/// contact relative to the motion ((D11.7) of docs/derivations). `residual` has ρ = λ - resolve(λ - u/d²) for
/// each row, where u are the velocities of the rows for λ, and `resolve` maps a trial impulse to the impulse
/// that the law allows. w is D^½ L v for the joint velocities v without impulses and the mass matrix Lᵀ D L,
/// and t = Y λ (nv() numbers) is the part that the impulses add. Y is D^-½ L⁻ᵀ Jᵀ for the Jacobian J of the
/// rows, and d² is about the diagonal entry of Yᵀ Y for a row.
double certificate_of(const VelocityProblem& problem, const double* residual, const double* t) noexcept;

}  // namespace axode
