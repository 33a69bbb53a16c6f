#pragma once
#include "axode/lie/twist.hpp"

namespace axode {

/// Tag in place of a representation, for algorithms that run in the frames in which they are fastest.
struct Fast {};

/// A representation (BodyFixed, Spatial, Hybrid or Mixed) or Fast, for results that do not depend on it.
template <class Rep>
concept RecursionChoice = RecursionRepresentation<Rep> || std::same_as<Rep, Fast>;

}  // namespace axode
