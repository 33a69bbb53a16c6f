#pragma once
#include <initializer_list>
#include <string>
#include <utility>

#include "axode/codegen/recording.hpp"

namespace axode::codegen {

/// `text` with every @KEY@ replaced.
std::string filled(std::string text, std::initializer_list<std::pair<const char*, std::string>> values);

/// How numbers are written.
struct Precision {
  bool single;
  const char* type() const { return single ? "float" : "double"; }
  /// The shortest decimal from which the number is read back.
  std::string literal(double x) const;
};

/// What a function computes on: one state, one in each lane of a vector (types axode_lanes and axode_mask), or one of n that lie
/// side by side, which is a thread's of a GPU (axode_at).
enum class Width { one, lanes, thread };

/// `void NAME(const double *AXODE_RESTRICT q, ...)`.
std::string c_signature(const Recording& recording, const std::string& name, const Precision& precision,
                        Width width = Width::one);

struct Definition {
  std::string text;
  int scratch = 0;  ///< numbers that the function keeps in an array
};
/// The definition of the function; sine_cosine is the name of the function for n angles at once, to
/// which `_lanes` is added in lanes. A long one is
/// cut into parts, so that compilers take time in proportion to its length; what one part hands to
/// another lies in an array. In lanes the function is `static`, returns a mask where it returns a doubt, and has that
/// array as its last argument. For a thread it is a device function.
Definition c_definition(const Recording& recording, const std::string& name, const std::string& sine_cosine,
                        const Precision& precision, Width width = Width::one);

/// Whether the function takes roots or angles, for which it needs <math.h>.
bool calls_math_library(const Recording& recording);

}  // namespace axode::codegen
