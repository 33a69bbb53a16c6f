#pragma once
#include <span>
#include <type_traits>

#include "axode/lie/twist.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/workspace.hpp"

namespace axode {

/// A read-only argument, e.g. a std::vector<T>.
template <class T> using Numbers = std::type_identity_t<std::span<const T>>;

}  // namespace axode
