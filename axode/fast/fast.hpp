#pragma once
#include "axode/lie/twist.hpp"

namespace axode {

/// In the place of a representation: the algorithm in the frames, mixed as they may be, in which it is quickest.
struct Fast {};

/// What may be asked for where results do not depend on the representation: one of the four, or Fast.
template <class Rep>
concept RecursionChoice = RecursionRepresentation<Rep> || std::same_as<Rep, Fast>;

}  // namespace axode
