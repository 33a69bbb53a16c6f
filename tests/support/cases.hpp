#pragma once
#include <gtest/gtest.h>

#include <concepts>
#include <string>

#include "axode/fast/fast.hpp"

/// The combinations of representation and scalar for which every law must hold.
namespace axode::test {

template <class Representation, class Scalar> struct Case {
  using Rep = Representation;
  using T = Scalar;
};
using Cases =
    testing::Types<Case<BodyFixed, double>, Case<Spatial, double>, Case<Hybrid, double>, Case<Mixed, double>,
                   Case<BodyFixed, float>, Case<Spatial, float>, Case<Hybrid, float>, Case<Mixed, float>>;
/// And for which those of forces and accelerations must.
using CasesWithFast =
    testing::Types<Case<BodyFixed, double>, Case<Spatial, double>, Case<Hybrid, double>, Case<Mixed, double>,
                   Case<Fast, double>, Case<BodyFixed, float>, Case<Spatial, float>, Case<Hybrid, float>,
                   Case<Mixed, float>, Case<Fast, float>>;
struct CaseNames {
  template <class C> static std::string GetName(int) {
    using Rep = typename C::Rep;
    return std::string(std::same_as<Rep, BodyFixed> ? "body"
                       : std::same_as<Rep, Spatial> ? "spatial"
                       : std::same_as<Rep, Hybrid>  ? "hybrid"
                       : std::same_as<Rep, Mixed>   ? "mixed"
                                                    : "fast") +
           (std::same_as<typename C::T, double> ? "_double" : "_float");
  }
};

}  // namespace axode::test
