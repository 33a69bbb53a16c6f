#pragma once
#include "axode/constraints/embedding/limbs.hpp"
#include "axode/constraints/embedding/row_elimination.hpp"
#include "axode/constraints/loops/loop_table.hpp"
#include "axode/scalar/instruction_set.hpp"

namespace axode {

/// Drive forces τ and multipliers λ with τ + Aᵀ λ = f for forces f that the tree needs, limb by limb. In each
/// limb the velocities without a drive are eliminated from its rows; the rows that remain are the wrenches
/// that the limb transmits while its passive joints move freely. The carrying velocities without a drive are
/// eliminated from these. See (D18.7) to (D18.9) of docs/derivations. O(limbs) for limbs of bounded size. The
/// constructor allocates all memory.
template <class T> class AXODE_ENTRY DriveElimination {
 public:
  DriveElimination(const Model& model, const LoopTable& table);

  /// Computes τ (nv) and, unless it is null, λ (loops().rows). driven (nv) flags the velocities with drives.
  /// entries[k] are those of loop k, a column of its rows for each column of its path. `considerable` is the
  /// size below which entries may be rounding errors, see LoopSystem. If there are more drives than needed, τ
  /// is the least one. Returns false, without results, if some motion has no drive, if λ is wanted and not
  /// unique, or if rounding leaves a rank open.
  bool solve(const std::vector<std::vector<T>>& entries, const T& considerable, const char* driven,
             const T* f, T* tau, T* lambda) noexcept;

 private:
  /// The columns of a limb are its velocities without a drive, those with one, and the carrying ones.
  struct Part {
    std::vector<int> passive, active;
    std::vector<int> rows;     ///< the row of A of each row
    std::vector<int> columns;  ///< the column of each column of the paths of its loops
    RowElimination<T> matrix;
    std::vector<T> mu;  ///< multipliers of the rows after the elimination
  };
  static std::size_t index(int k) { return static_cast<std::size_t>(k); }
  static int size(const std::vector<int>& of) { return static_cast<int>(of.size()); }
  /// The first carrying column of a limb.
  static int carrying_column(const Part& part) { return size(part.passive) + size(part.active); }

  void sort_velocities(const char* driven) noexcept;
  bool eliminate_limbs(const std::vector<std::vector<T>>& entries, const T& considerable,
                       const T* f) noexcept;
  bool eliminate_carrying(const T& considerable, const T* f) noexcept;
  /// Writes multipliers ν of the carrying elimination as those of the rows that remain of the limbs.
  void set_remaining(T* nu) noexcept;
  /// Subtracts from the forces (nv) of the drives those of the rows with the present multipliers, and returns
  /// the size of the numbers from which the differences of the remaining rows are made.
  T subtract_rows(bool only_remaining, T* forces) const noexcept;
  /// Makes the forces (nv) of the drives the least ones. Returns false if rounding leaves open which rows
  /// change them.
  bool take_least(const T& considerable, T* forces) noexcept;

  const LoopTable& table_;
  Limbs limbs_;
  std::vector<char> driven_;
  std::vector<int> column_;  ///< nv: column of each velocity in its limb, or among the carrying ones
  std::vector<char> carries_;
  std::vector<int> carrying_passive_, carrying_active_;
  std::vector<Part> parts_;
  RowElimination<T> remaining_;  ///< what remains of all limbs: a column for each of carrying_passive_
  std::vector<T> b_, nu_, x_, forces_;
  std::vector<T> basis_;  ///< an orthonormal basis of the forces of drives against each other, nv for each
};

}  // namespace axode
