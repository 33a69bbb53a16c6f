#pragma once
#include <concepts>
#include <span>
#include <type_traits>

#include "axode/lie/twist.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/workspace.hpp"

namespace axode {

/// A read-only view of contiguous numbers: a std::span that can also be made of an Eigen vector.
template <class T> class NumberSpan : public std::span<const T> {
 public:
  using std::span<const T>::span;
  constexpr NumberSpan() = default;
  constexpr NumberSpan(std::span<const T> numbers)  // NOLINT(google-explicit-constructor): a view
      : std::span<const T>(numbers) {}
  template <class Vector>
    requires(bool(Vector::IsVectorAtCompileTime) && Vector::InnerStrideAtCompileTime == 1 &&
             std::same_as<typename Vector::Scalar, T>)
  constexpr NumberSpan(const Vector& vector)  // NOLINT(google-explicit-constructor): vectors convert, too
      : std::span<const T>(vector.data(), static_cast<std::size_t>(vector.size())) {}
};

/// The type of a read-only argument of several numbers, such as a std::vector<T> or an Eigen::VectorX<T>.
template <class T> using Numbers = std::type_identity_t<NumberSpan<T>>;

}  // namespace axode
