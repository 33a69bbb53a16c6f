#pragma once
#include <cstddef>

namespace axode {

/// The kinds of operations on whole screws and inertias: transformations of a screw, twist or wrench by Ad_C,
/// Ad_R or Ad_r, congruences of an inertia with one of these maps, and the Lie brackets ad and adᵀ.
enum class ScrewOperation {
  transformation,
  rotation,
  translation,
  tensor_transformation,
  tensor_rotation,
  tensor_translation,
  bracket
};
inline constexpr std::size_t n_screw_operations = 7;

/// Scope guard that reports one screw operation to the counting scalar `Counted` and does nothing for other
/// scalars. Of nested guards only the outermost one counts.
template <class T> struct [[maybe_unused]] ScrewOperationScope {
  constexpr explicit ScrewOperationScope(ScrewOperation) {}
};

}  // namespace axode
