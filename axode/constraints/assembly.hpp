#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "axode/constraints/loops.hpp"

namespace axode {

struct AssemblyOptions {
  double tolerance = 1e-12;  ///< of the residual, as a part of the size of the mechanism; but see assemble()
  int iterations = 200;      ///< at most
  std::span<const int> held = {};      ///< velocities of joints that shall stay where they are: drives
  std::function<bool()> monitor = {};  ///< asked at every iteration; false ends the search
};

enum class AssemblyStatus {
  closed,
  open,            ///< no small step closes the loops further: a statement about this guess
  singular_guess,  ///< at the guess itself no velocity closes them to first order: it is stretched, folded, or held
  iteration_limit,  ///< or the monitor ended the search
  singular,         ///< the loops are closed, but velocities need a mass matrix that is not
};
std::string_view to_string(AssemblyStatus status);

struct AssemblyResult {
  AssemblyStatus status{};
  std::vector<double> q, v;  ///< the best configuration met, and velocities that keep it closed
  double residual = 0;       ///< |r|, rad and m
  std::vector<double> open;  ///< |r| of each loop
  int iterations = 0;
};
/// One sentence for the user: which loops stay open by how much, the worst one first.
std::string to_string(const Model& model, const AssemblyResult& result);

/// A closed configuration near q, by Levenberg and Marquardt's way on the group; and of velocities v, or none, what is left
/// after the loops have closed suddenly, which moves the masses least. Redundant rows do no harm; where two branches of the
/// motion meet it is slow. A residual that stops shrinking within the rounding of the poses and coordinates it is made of, or
/// within a thousand times the tolerance, is taken as closed. Coordinates are not limited. Allocates, O(m nv²) an iteration. Throws std::invalid_argument for
/// wrong sizes and a q, v that is not finite.
[[nodiscard]] AssemblyResult assemble(const Model& model, std::span<const double> q,
                                      std::span<const double> v = {}, const AssemblyOptions& options = {});

}  // namespace axode
