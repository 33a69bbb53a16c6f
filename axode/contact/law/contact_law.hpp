#pragma once
#include <Eigen/Core>

/// The laws of the impulses between rigid bodies at contacts, hard stops, joints with dry friction, and
/// closed loops, (D11.1) of docs/derivations/contact.md.
namespace axode {

/// The law between the velocities u after a step and the impulses λ of a block of constraint rows. For a
/// contact, the indices N and T mean the normal row and the friction rows, which are multiplied by their
/// coefficients of friction.
enum class ContactLaw {
  contact,       ///< 0 ≤ λ_N ⊥ u_N ≥ 0, and Coulomb's cone |λ_T| ≤ λ_N with u_T = -s λ_T, s ≥ 0
  stop,          ///< 0 ≤ λ ⊥ u ≥ 0
  dry_friction,  ///< |λ| ≤ bound, and u = -s λ on the bound, s ≥ 0
  loop,          ///< u = 0
  pressed,  ///< a contact whose normal impulse is given: |λ_T| ≤ bound, u_T = -s λ_T, s ≥ 0, and λ_N = 0
};

/// Consecutive constraint rows that obey one law together. A contact has its normal row first, and then two
/// rows of sliding friction, one of drilling and two of rolling friction: 3, 4 or 6 rows. Every other block
/// has one row. Friction rows are multiplied by their coefficients, so that the friction cone of every
/// contact is |λ_T| ≤ λ_N for the impulses λ_N of the normal row and λ_T of the friction rows.
struct LawBlock {
  static constexpr int most_rows = 6;

  ContactLaw law = ContactLaw::contact;
  int first = 0;     ///< the first row
  int rows = 0;      ///< 1, 3, 4 or 6
  double bound = 0;  ///< largest impulse of dry friction, or the given normal impulse of a pressed contact
};

/// The branch of a law at a trial impulse z, the argument of resolve().
enum class LawBranch {
  open,   ///< no impulse
  stick,  ///< u = 0
  slide,  ///< the impulse is on the boundary of its cone or bound
};

/// Computes λ = resolve(z), the resolvent of the law of a block of constraint rows, such as the rows of one
/// contact (D11.2), with which impulses λ and velocities u obey the law if and only if λ = resolve(λ - u/R),
/// for any number R > 0. z and λ have an entry for each row of the block.
void resolve(const LawBlock& block, const double* z, double* lambda) noexcept;

template <int rows> using LawMatrix = Eigen::Matrix<double, rows, rows>;

/// Computes, for a block of constraint rows such as the rows of one contact, the derivative Z of resolve(),
/// which maps a trial impulse z to the impulse that the law allows (D11.3). Returns the branch (stick, slide
/// or open) at z. Z is 0 if the block is open or if dry friction of a joint slides, and 1 if the block
/// sticks. If a contact slides, Z is not symmetric. `rows` must be the number of rows of the block.
template <int rows>
LawBranch differentiate(const LawBlock& block, const double* z, LawMatrix<rows>& Z) noexcept;

/// The branch of the law of a block at the trial impulse z.
LawBranch branch_of(const LawBlock& block, const double* z) noexcept;

/// Writes to `lambda` the projection of the trial impulse z of a block of constraint rows, for a convex
/// approximation of the law in which contacts separate when they slide. For a contact it is the projection of
/// z on the friction cone |λ_T| ≤ λ_N, where λ_N belongs to the normal row and λ_T to the friction rows,
/// which are multiplied by their coefficients of friction. For a stop, dry friction, a loop and a contact
/// with a given normal impulse it is resolve(z), the nearest impulse to z that the exact law allows.
void project(const LawBlock& block, const double* z, double* lambda) noexcept;

/// Calls f with the number of rows of a block as a compile-time constant.
template <class F> decltype(auto) with_rows(const LawBlock& block, const F& f) {
  switch (block.rows) {
    case 1: return f(std::integral_constant<int, 1>{});
    case 3: return f(std::integral_constant<int, 3>{});
    case 4: return f(std::integral_constant<int, 4>{});
    default: return f(std::integral_constant<int, 6>{});
  }
}

}  // namespace axode
