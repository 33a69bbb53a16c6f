#pragma once
#include <cstddef>

namespace axode {

/// What is done to screws and inertias as a whole: transformations of a screw, twist or wrench by Ad_C, Ad_R or
/// Ad_r, congruences of an inertia with one of them, Lie brackets ad and adᵀ.
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

/// Lives as long as an operation on numbers T is under way, for a scalar that counts; nothing for any other. Of
/// operations within each other the outermost counts.
template <class T> struct [[maybe_unused]] Noted {
  constexpr explicit Noted(ScrewOperation) {}
};

}  // namespace axode
