#pragma once
#include <span>

#include "axode/model/model.hpp"

namespace axode {

/// New values for the n collision shapes of a model: for each shape a coefficient of friction, a restitution,
/// and a displacement on its body, which is the exponential of a twist in the frame of the shape (six
/// numbers, angular in rad before linear in m). The shapes of the ground are first, then those of the bodies
/// in the order of the description, as in ContactShapes. A span has entries for all shapes, or is empty if
/// the shapes keep their values.
struct ShapeNumbers {
  std::span<const double> friction = {};     ///< n: coefficients of sliding friction
  std::span<const double> restitution = {};  ///< n
  /// Displacements of the shapes on their bodies: six numbers π_u for each shape (rad and m), along the
  /// unit screws U_u of the frame of the shape, angular before linear. The pose P of the shape becomes P
  /// exp(Σ π_u U_u).
  std::span<const double> placement = {};
};

/// Returns a copy of a model whose collision shapes have other friction, restitution or poses on their
/// bodies. Throws std::invalid_argument for spans of another size, and ModelError for numbers that a shape
/// cannot have. Allocates.
Model with_shapes(const Model& model, const ShapeNumbers& numbers);

}  // namespace axode
