#pragma once
#include <Eigen/Core>

#include "axode/scalar/instruction_set.hpp"

namespace axode {

/// Changes of some numbers along k directions: a row for each number and a column for each direction. The
/// entries of a row are neighbours in memory, because what is computed for one number is computed for all
/// directions at once. With the functions below, the changes along a direction are the same to the last bit
/// whatever the other directions are, which Eigen's products do not promise.
using Changes = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
/// Changes, or some of their rows or columns.
using ChangesArgument = Eigen::Ref<const Changes, 0, Eigen::OuterStride<>>;
using ChangesResult = Eigen::Ref<Changes, 0, Eigen::OuterStride<>>;

/// A matrix of any storage order, or a part or the transposed of one, that is not copied.
struct MatrixView {
  const double* data;
  Eigen::Index rows, columns, row_step, column_step;  ///< steps from an entry to the next row and column

  template <class Derived>
  MatrixView(const Eigen::MatrixBase<Derived>& A)
      : data(A.derived().data()),
        rows(A.rows()),
        columns(A.cols()),
        row_step(A.derived().rowStride()),
        column_step(A.derived().colStride()) {}

  double operator()(Eigen::Index row, Eigen::Index column) const {
    return data[row * row_step + column * column_step];
  }
};

/// Returns A x, the changes of numbers whose derivatives by the numbers of x are A. Costs O(rows · columns)
/// for each direction, but less if A or x have many zeros.
AXODE_ENTRY Changes product(const MatrixView& A, const ChangesArgument& x);
/// Adds A x to `out`, or subtracts it; `out` must not share memory with x.
AXODE_ENTRY void add_product(const MatrixView& A, const ChangesArgument& x, ChangesResult out);
AXODE_ENTRY void subtract_product(const MatrixView& A, const ChangesArgument& x, ChangesResult out);

/// Replaces x by L⁻¹ x for a lower triangular matrix L. Entries above its diagonal are not read, and if
/// unit_diagonal is set, its diagonal is not read either.
AXODE_ENTRY void solve_lower(const MatrixView& L, bool unit_diagonal, Changes& x);
/// Replaces x by U⁻¹ x for an upper triangular matrix U. Entries below its diagonal are not read.
AXODE_ENTRY void solve_upper(const MatrixView& U, Changes& x);

}  // namespace axode
