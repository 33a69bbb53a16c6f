#pragma once
#include <span>

namespace axode {

/// Inverts a symmetric, positive semi-definite 6×6 matrix in place. Returns its rank: the number of
/// eigenvalues above 1e-12 in double, 1e-5 in float, after scaling to a unit diagonal. If the rank is less
/// than 6, the result is NaN.
template <class T> int invert_definite(std::span<T, 36> matrix);

}  // namespace axode
