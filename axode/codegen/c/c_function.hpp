#pragma once
#include <initializer_list>
#include <string>
#include <utility>

#include "axode/codegen/tape/recording.hpp"

namespace axode::codegen {

/// Returns `text` with every @KEY@ replaced by its value.
std::string filled(std::string text, std::initializer_list<std::pair<const char*, std::string>> values);

/// How numbers are written.
struct Precision {
  bool single;
  const char* type() const { return single ? "float" : "double"; }
  /// The shortest decimal from which the number is read back.
  std::string literal(double x) const;
};

/// `HEAD(const TYPE *AXODE_RESTRICT q, ..., TYPE *AXODE_RESTRICT tauTAIL)`.
std::string c_declaration(const Recording& recording, const std::string& head, const std::string& type,
                          const std::string& tail);
/// `void NAME(const double *AXODE_RESTRICT q, ..., double *AXODE_RESTRICT tauTAIL)`.
std::string c_signature(const Recording& recording, const std::string& name, const Precision& precision,
                        const std::string& tail = "");

struct Definition {
  std::string text;
  int scratch = 0;  ///< length of the array of numbers that the parts of the function exchange
};
/// The definition of a function in C. `sine_cosine` is the name of the function for n angles at once. A long
/// function is cut into parts, so that compilers take time in proportion to its length. Numbers that one part
/// computes and a later part uses lie in an array.
Definition c_definition(const Recording& recording, const std::string& name, const std::string& sine_cosine,
                        const Precision& precision);
/// The definition for a state in each lane of a vector (types axode_lanes and axode_mask). `_lanes` is added
/// to the name `sine_cosine`. The function is `static`, returns a mask (the lanes whose mass matrix may be
/// singular), and its last argument is the array of numbers that its parts exchange.
Definition lanes_definition(const Recording& recording, const std::string& name,
                            const std::string& sine_cosine, const Precision& precision);

/// Whether the function computes square roots or angles, which need <math.h>.
bool calls_math_library(const Recording& recording);

}  // namespace axode::codegen
