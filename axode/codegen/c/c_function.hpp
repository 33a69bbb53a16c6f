#pragma once
#include <initializer_list>
#include <string>
#include <utility>

#include "axode/codegen/tape/recording.hpp"

namespace axode::codegen {

/// Returns `text` with every @KEY@ replaced by its value.
std::string filled(std::string text, std::initializer_list<std::pair<const char*, std::string>> values);

/// The precision of generated code: the type and the literals of its numbers.
struct Precision {
  bool single;
  const char* type() const { return single ? "float" : "double"; }
  /// The shortest decimal text from which the number is read back exactly (rounded to float if `single`).
  std::string literal(double x) const;
};

/// Makes the declaration of a recorded function (a list of operations) in C: `HEAD(const TYPE *AXODE_RESTRICT
/// q, ..., TYPE *AXODE_RESTRICT tauTAIL)`. q and tau stand for the names of its arguments and its result.
/// HEAD and TYPE are the texts `head` and `type`, and TAIL is the text `tail`: further parameters, each after
/// a comma, or nothing.
std::string c_declaration(const Recording& recording, const std::string& head, const std::string& type,
                          const std::string& tail);
/// Makes the declaration of a recorded function (a list of operations) with the name NAME in C: `void
/// NAME(const double *AXODE_RESTRICT q, ..., double *AXODE_RESTRICT tauTAIL)`. q and tau stand for the names
/// of its arguments and its result, and TAIL is the text `tail`: further parameters, each after a comma, or
/// nothing. The return type is int if the function reports that the mass matrix may be singular. In single
/// precision, float replaces double.
std::string c_signature(const Recording& recording, const std::string& name, const Precision& precision,
                        const std::string& tail = "");

struct Definition {
  std::string text;
  int scratch = 0;  ///< length of the array of numbers that the parts of the function exchange
};
/// Writes the definition of a recorded function (a list of operations) in C for one state. `sine_cosine` is
/// the name of the function that computes sines and cosines of n angles at once. A long function is cut into
/// parts, so that compilers take time in proportion to its length. Parts pass numbers to later parts in an
/// array.
Definition c_definition(const Recording& recording, const std::string& name, const std::string& sine_cosine,
                        const Precision& precision);
/// Writes the definition of a recorded function (a list of operations) in C that computes several states at
/// once, one in each lane of a vector (the types axode_lanes and axode_mask of the generated code). The
/// written function is `static`. It returns a mask of the lanes whose mass matrix may be singular, or nothing
/// if the recorded function does not test this. It computes sines and cosines by calling the function whose
/// name is `sine_cosine` followed by `_lanes`. A long function is cut into parts, which pass numbers to later
/// parts in an array, the last argument of the written function.
Definition lanes_definition(const Recording& recording, const std::string& name,
                            const std::string& sine_cosine, const Precision& precision);

/// Whether the function computes square roots or angles, which need <math.h>.
bool calls_math_library(const Recording& recording);

}  // namespace axode::codegen
