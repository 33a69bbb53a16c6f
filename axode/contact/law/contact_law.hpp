#pragma once
#include <Eigen/Core>

/// The laws that impulses obey when rigid bodies touch, stop, rub or close loops. See
/// docs/derivations/contact.md.
namespace axode {

/// The law of a block of rows: velocities u after a step, and impulses λ.
enum class ContactLaw {
  contact,       ///< 0 ≤ λ_N ⊥ u_N ≥ 0, and Coulomb's cone |λ_T| ≤ λ_N with u_T = -s λ_T, s ≥ 0
  stop,          ///< 0 ≤ λ ⊥ u ≥ 0
  dry_friction,  ///< |λ| ≤ bound, and u = -s λ on the bound, s ≥ 0
  loop,          ///< u = 0
  pressed,  ///< a contact whose normal impulse is given: |λ_T| ≤ bound, u_T = -s λ_T, s ≥ 0, and λ_N = 0
};

/// Rows that share one law. A contact has its normal row first and then two rows of sliding friction, one of
/// drilling and two of rolling friction: 3, 4 or 6 rows. Every other block has one row. Friction rows are
/// multiplied by their coefficients, so that the cone of every contact has a slope of 1.
struct LawBlock {
  static constexpr int most_rows = 6;

  ContactLaw law = ContactLaw::contact;
  int first = 0;     ///< the first row
  int rows = 0;      ///< 1, 3, 4 or 6
  double bound = 0;  ///< largest impulse of dry friction, or the given normal impulse of a pressed contact
};

/// The branch of a law that holds at a point z.
enum class LawBranch {
  open,   ///< no impulse
  stick,  ///< u = 0
  slide,  ///< the impulse is on the boundary of its cone or bound
};

/// λ = resolve(z): λ obeys the law together with u if and only if λ = resolve(λ - u/R), for any R > 0
/// (D11.2). z and λ have an entry for each row of the block.
void resolve(const LawBlock& block, const double* z, double* lambda) noexcept;

template <int rows> using LawMatrix = Eigen::Matrix<double, rows, rows>;

/// The derivative Z of resolve at z (D11.3). It is not symmetric if a contact slides, 0 if a block is open,
/// and 1 if it sticks. `rows` must be those of the block.
template <int rows>
LawBranch differentiate(const LawBlock& block, const double* z, LawMatrix<rows>& Z) noexcept;

/// The branch of the law at z.
LawBranch branch_of(const LawBlock& block, const double* z) noexcept;

/// Projects z on the cone of a contact with the law `contact`, and otherwise computes resolve(z). It is the resolvent of a convex
/// neighbour of the law, in which sliding contacts part.
void project(const LawBlock& block, const double* z, double* lambda) noexcept;

/// Calls f with the number of rows of a block as a constant.
template <class F> decltype(auto) with_rows(const LawBlock& block, const F& f) {
  switch (block.rows) {
    case 1: return f(std::integral_constant<int, 1>{});
    case 3: return f(std::integral_constant<int, 3>{});
    case 4: return f(std::integral_constant<int, 4>{});
    default: return f(std::integral_constant<int, 6>{});
  }
}

}  // namespace axode
