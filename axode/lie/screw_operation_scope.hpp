#pragma once
#include <cstddef>

namespace axode {

/// The kinds of operations on whole screws and inertias: maps of a screw, twist or wrench by Ad_C, Ad_R or
/// Ad_r, congruences of an inertia with these, and the Lie brackets ad and adᵀ.
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

/// Scope guard that counts an operation on screws if T is Counted; only the outermost if nested.
template <class T> struct [[maybe_unused]] ScrewOperationScope {
  constexpr explicit ScrewOperationScope(ScrewOperation) {}
};

}  // namespace axode
