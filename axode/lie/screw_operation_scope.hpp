#pragma once
#include <cstddef>

namespace axode {

/// The kinds of screw operations that the number type Counted counts: transformations of screws, twists and
/// wrenches by Ad_C, Ad_R or Ad_r, transformations of inertias and other 6×6 tensors by these, and the Lie
/// brackets ad and adᵀ.
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
