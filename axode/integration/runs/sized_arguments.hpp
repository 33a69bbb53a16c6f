#pragma once
#include <initializer_list>

#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// An argument or a result of a function: its name, its numbers, and its required size with that in words.
template <class T> struct Sized {
  const char* name;
  std::span<T> x;
  std::size_t size;
  const char* meaning;
};

/// Throws std::invalid_argument unless all arguments and results have their sizes, and no result overlaps
/// another one or an argument.
inline void check_sizes(std::initializer_list<Sized<const double>> arguments,
                        std::initializer_list<Sized<double>> results) {
  for (const auto& in : arguments) check_size(in.name, in.x.size(), in.size, in.meaning);
  for (const auto* out = results.begin(); out != results.end(); ++out) {
    check_size(out->name, out->x.size(), out->size, out->meaning);
    for (const auto& in : arguments) check_separate(out->name, out->x, in.name, in.x);
    for (const auto* other = results.begin(); other != out; ++other)
      check_separate(out->name, out->x, other->name, other->x);
  }
}

/// Adds to the status of a motion, `verdict`, whether all results are finite, and returns it. If the motion
/// failed or a result is not finite, sets all results to NaN.
inline Solvability solved_or_nan(const Solvability& verdict,
                                 std::initializer_list<std::span<double>> results) {
  const Solvability all = solved(verdict, results);
  return all.ok() ? all : solved(all, results);
}

/// The number K of the steps of a motion, from the size K nv of its drive forces; 0 if nv is 0.
inline std::size_t steps_of(const Model& model, std::span<const double> tau) {
  return model.nv() == 0 ? 0 : tau.size() / static_cast<std::size_t>(model.nv());
}

}  // namespace axode
