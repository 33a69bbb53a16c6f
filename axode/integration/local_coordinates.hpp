#pragma once
#include <array>
#include <string_view>
#include <utility>

namespace axode {

/// The coordinates x of a step q ⊕ x on the group of configurations. Every scheme keeps its order with
/// either; docs/integration.md compares them.
enum class LocalCoordinates {
  exponential,  ///< canonical coordinates: q exp x
  cayley,       ///< q cay x (D14.3): rational, with half a turn at infinity
};

/// The names of local coordinates.
inline constexpr std::array<std::pair<std::string_view, LocalCoordinates>, 2> local_coordinate_kinds{
    {{"exponential", LocalCoordinates::exponential}, {"cayley", LocalCoordinates::cayley}}};

}  // namespace axode
