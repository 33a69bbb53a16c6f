#pragma once
#include "axode/constraints/embedding/limbs.hpp"
#include "axode/constraints/embedding/row_elimination.hpp"
#include "axode/constraints/loops/loop_table.hpp"
#include "axode/scalar/index.hpp"
#include "axode/scalar/instruction_set.hpp"

namespace axode {

/// Finds drive forces τ and multipliers λ of the loop equations A v = 0 such that τ + Aᵀ λ = f, for the joint
/// forces f that a motion of the spanning tree needs, by elimination limb by limb ((D18.7) to (D18.9) of
/// docs/derivations). A limb is a part of the mechanism that is coupled to the rest only through the joints
/// on the path in the spanning tree from the ground to a body called the platform. O(limbs) for limbs of
/// bounded size. The constructor allocates all memory.
template <class T> class AXODE_ENTRY DriveElimination {
 public:
  DriveElimination(const Model& model, const LoopTable& table);

  /// Computes the drive forces τ (nv) and, unless `lambda` is null, the multipliers λ (a number for each loop
  /// equation) with τ + Aᵀ λ = f, for given joint forces f and the Jacobian A of the loop equations. If there
  /// are more drives than needed, τ has the least sum of squares (of numbers in N m and N). `driven` (nv)
  /// flags the velocities with drives. entries[k] has the entries of A for the equations of loop k, column by
  /// column, with the columns of LoopPath::columns: one for each joint screw on the path of the loop, or for
  /// each term of a coupling. `considerable` is a magnitude of entries of A that are no rounding errors.
  /// Returns false, without results, if the mechanism can move while all drives are locked, if λ is wanted
  /// and not unique, or if a pivot of the elimination may be a rounding error, being small compared with the
  /// larger of `considerable` and the largest entry of A.
  bool solve(const std::vector<std::vector<T>>& entries, const T& considerable, const char* driven,
             const T* f, T* tau, T* lambda) noexcept;

 private:
  /// The matrix of the loop equations of one limb (a chain that carries the platform), with columns for its
  /// velocities without a drive, then for those with a drive, and then for those of the joints on the path in
  /// the spanning tree from the ground to the platform.
  struct Part {
    std::vector<int> passive, active;
    std::vector<int> rows;     ///< index in A of each row of the limb
    std::vector<int> columns;  ///< column of `matrix` for each column of the paths of the limb's loops
    RowElimination<T> matrix;
    std::vector<T> mu;  ///< multipliers of the rows of `matrix` after the elimination
  };
  static int size(const std::vector<int>& of) { return static_cast<int>(of.size()); }
  /// The index of the first column in `part.matrix` for a velocity of the joints on the path in the spanning
  /// tree from the ground to the platform. The matrix has the loop equations of one limb (a chain that
  /// carries the platform), with the columns of the limb's own velocities before those of this path.
  static int carrying_column(const Part& part) { return size(part.passive) + size(part.active); }

  void sort_velocities(const char* driven) noexcept;
  bool eliminate_limbs(const std::vector<std::vector<T>>& entries, const T& considerable,
                       const T* f) noexcept;
  bool eliminate_carrying(const T& considerable, const T* f) noexcept;
  /// Sets the multipliers Part::mu of the loop equations that are left over after the velocities without a
  /// drive of all limbs (chains that carry the platform) have been eliminated. These equations are the rows
  /// of `remaining_`, from which the velocities without a drive of the joints between the ground and the
  /// platform have then been eliminated. `nu` has the multipliers of the rows after this second elimination
  /// and is overwritten.
  void set_remaining(T* nu) noexcept;
  /// Subtracts the constraint forces of the loop equations of all limbs (chains that carry the platform), for
  /// the multipliers Part::mu, from the entries of `forces` (nv) at velocities with drives. If
  /// `only_remaining` is set, only those equations of each limb count that are left over after the
  /// elimination of the limb's velocities without a drive. Returns the largest magnitude of a subtracted
  /// term, the product of a multiplier and an entry of an equation.
  T subtract_rows(bool only_remaining, T* forces) const noexcept;
  /// Replaces the drive forces `forces` (nv) by those of least norm that cause the same motion. A loop
  /// equation that is left over after the elimination of all velocities without a drive contains only
  /// velocities with drives. Its constraint forces are therefore drive forces without effect on the motion,
  /// and `forces` is projected onto the orthogonal complement of all of them. They are 0 if the equation is
  /// redundant. Returns false if rounding errors leave open how many of them are independent.
  bool take_least(const T& considerable, T* forces) noexcept;

  const LoopTable& table_;
  Limbs limbs_;
  std::vector<char> driven_;
  std::vector<int> column_;  ///< nv: column of each velocity in the matrix of its limb, or its index among
                             ///< the velocities of the joints between the ground and the platform
  std::vector<char> carries_;
  std::vector<int> carrying_passive_, carrying_active_;
  std::vector<Part> parts_;
  RowElimination<T> remaining_;  ///< remaining rows of all limbs, with one column for each of
                                 ///< carrying_passive_
  std::vector<T> b_, nu_, x_, forces_;
  std::vector<T> basis_;  ///< orthonormal basis of the forces that drives exert against each other, nv
                          ///< numbers for each vector
};

}  // namespace axode
