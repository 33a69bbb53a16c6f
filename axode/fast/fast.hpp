#pragma once
#include "axode/lie/twist.hpp"

namespace axode {

/// Tag that is used instead of a representation: the algorithm runs in the frames in which it is fastest,
/// which may be different ones for different quantities.
struct Fast {};

/// The choices for algorithms whose results do not depend on the representation: one of the four
/// representations BodyFixed, Spatial, Hybrid and Mixed, or Fast.
template <class Rep>
concept RecursionChoice = RecursionRepresentation<Rep> || std::same_as<Rep, Fast>;

}  // namespace axode
