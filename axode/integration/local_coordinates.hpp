#pragma once
#include <array>
#include <string_view>
#include <utility>

namespace axode {

/// The local coordinates x of a step from q to q ⊕ x on the group of configurations: exponential or Cayley.
enum class LocalCoordinates {
  exponential,  ///< canonical coordinates: q exp x
  cayley,       ///< q cay x (D14.3): rational; half a turn has an infinite x
};

/// The names of local coordinates.
inline constexpr std::array<std::pair<std::string_view, LocalCoordinates>, 2> local_coordinate_kinds{
    {{"exponential", LocalCoordinates::exponential}, {"cayley", LocalCoordinates::cayley}}};

}  // namespace axode
