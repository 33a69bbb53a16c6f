#include "axode/recursion/changes.hpp"

#include <algorithm>

namespace axode {
namespace {

using Eigen::Index;

/// The number of rows that are added to another one at once.
constexpr Index together = 4;

/// Adds factor · Σ a_k x_k for the rows first <= k < last of x to the row `out`, n columns of each. The steps
/// are the distances of the numbers a_k and of the rows of x in memory.
inline void add_rows(const double* a, Index column_step, const double* x, Index row_step, Index first,
                     Index last, double factor, double* __restrict out, Index n) {
  Index k = first;
  for (; k + together <= last; k += together) {
    const auto coefficient = [&](Index row) { return factor * a[row * column_step]; };
    const double a0 = coefficient(k), a1 = coefficient(k + 1), a2 = coefficient(k + 2),
                 a3 = coefficient(k + 3);
    if (a0 == 0 && a1 == 0 && a2 == 0 && a3 == 0) continue;
    const double *x0 = x + k * row_step, *x1 = x0 + row_step, *x2 = x1 + row_step, *x3 = x2 + row_step;
    for (Index c = 0; c < n; ++c) out[c] += (a0 * x0[c] + a1 * x1[c]) + (a2 * x2[c] + a3 * x3[c]);
  }
  for (; k < last; ++k) {
    const double a0 = factor * a[k * column_step];
    if (a0 == 0) continue;
    const double* x0 = x + k * row_step;
    for (Index c = 0; c < n; ++c) out[c] += a0 * x0[c];
  }
}

/// Adds factor · A x to `out`.
void add_multiple(double factor, const MatrixView& A, const ChangesArgument& x, ChangesResult& out) {
  const auto is_zero = [](double number) { return number == 0; };
  const bool many_rows = A.rows > together;  // then it pays to look for zeros
  for (Index k = 0; k < A.columns; k += together) {
    const Index last_row = std::min(k + together, A.columns);
    Index first = many_rows ? x.cols() : 0,
          last = many_rows ? 0 : x.cols();  // these rows of x are 0 elsewhere
    for (Index row = k; row < last_row && many_rows; ++row) {
      const double *begin = x.data() + row * x.outerStride(), *end = begin + x.cols();
      first = std::find_if_not(begin, begin + first, is_zero) - begin;
      while (end > begin + last && is_zero(end[-1])) --end;
      last = end - begin;
    }
    if (first >= last) continue;
    for (Index row = 0; row < A.rows; ++row)
      add_rows(A.data + row * A.row_step, A.column_step, x.data() + first, x.outerStride(), k, last_row,
               factor, out.data() + row * out.outerStride() + first, last - first);
  }
}

}  // namespace

void add_product(const MatrixView& A, const ChangesArgument& x, ChangesResult out) {
  add_multiple(1, A, x, out);
}

void subtract_product(const MatrixView& A, const ChangesArgument& x, ChangesResult out) {
  add_multiple(-1, A, x, out);
}

Changes product(const MatrixView& A, const ChangesArgument& x) {
  Changes out = Changes::Zero(A.rows, x.cols());
  add_product(A, x, out);
  return out;
}

void solve_lower(const MatrixView& L, bool unit_diagonal, Changes& x) {
  for (Index row = 0; row < x.rows(); ++row) {
    double* const out = x.data() + row * x.cols();
    add_rows(L.data + row * L.row_step, L.column_step, x.data(), x.cols(), 0, row, -1, out, x.cols());
    if (unit_diagonal) continue;
    const double inverse = 1 / L(row, row);
    for (Index c = 0; c < x.cols(); ++c) out[c] *= inverse;
  }
}

void solve_upper(const MatrixView& U, Changes& x) {
  for (Index row = x.rows(); row-- > 0;) {
    double* const out = x.data() + row * x.cols();
    add_rows(U.data + row * U.row_step, U.column_step, x.data(), x.cols(), row + 1, x.rows(), -1, out,
             x.cols());
    const double inverse = 1 / U(row, row);
    for (Index c = 0; c < x.cols(); ++c) out[c] *= inverse;
  }
}

}  // namespace axode
