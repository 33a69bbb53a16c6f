#pragma once
#include <string>

#include "axode/codegen/recording.hpp"

namespace axode::codegen {

/// How numbers are written.
struct Precision {
  bool single;
  const char* type() const { return single ? "float" : "double"; }
  /// The shortest decimal from which the number is read back.
  std::string literal(double x) const;
};

/// `void NAME(const double *AXODE_RESTRICT q, ...)`.
std::string c_signature(const Recording& recording, const std::string& name, const Precision& precision);

/// The definition of the function; sine_cosine is the name of the function for n angles at once.
std::string c_definition(const Recording& recording, const std::string& name, const std::string& sine_cosine,
                         const Precision& precision);

/// Whether the function takes roots or angles, for which it needs <math.h>.
bool calls_math_library(const Recording& recording);

/// The definition of the function for n angles, errors below 2 ulp up to 1e5 rad.
std::string c_sine_cosine(const std::string& name, const Precision& precision);

}  // namespace axode::codegen
