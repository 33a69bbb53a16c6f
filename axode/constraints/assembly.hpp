#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "axode/constraints/loops.hpp"

namespace axode {

struct AssemblyOptions {
  double tolerance = 1e-12;        ///< on the residual, relative to the size of the mechanism; see assemble()
  int iterations = 200;            ///< upper limit
  std::span<const int> held = {};  ///< velocities of joints that must not move, such as drives
  double time = 0;                 ///< time at which prescribed motions are followed, s
  std::function<bool()> monitor = {};  ///< called at every iteration; false ends the search
};

enum class AssemblyStatus {
  closed,
  open,             ///< no small step reduces the residual any more
  singular_guess,   ///< no velocity closes the loops to first order, because a chain is stretched or folded,
                    ///< or velocities are held
  iteration_limit,  ///< the iterations were used up, or the monitor ended the search
  singular,         ///< the loops are closed, but the mass matrix is singular, so that no velocities were
                    ///< found
};
std::string_view to_string(AssemblyStatus status);

struct AssemblyResult {
  AssemblyStatus status{};
  std::vector<double> q, v;  ///< the best configuration found, and velocities that keep it closed
  double residual = 0;       ///< |r|, rad and m
  std::vector<double> open;  ///< |r| of each loop, then of each motion of a joint
  int iterations = 0;
};
/// A sentence for the user with the residual of each open loop, the largest first.
std::string to_string(const Model& model, const AssemblyResult& result);

/// Finds a closed configuration near q that follows the prescribed motions, by the Levenberg-Marquardt
/// method on the group. If v is not empty, also finds the velocities after an impact that closes the loops
/// and follows the motions, the nearest to v in kinetic energy. Redundant rows are allowed; where two
/// branches of the motion meet, convergence is slow. A residual that stops decreasing within the rounding of
/// the poses and coordinates, or within a thousand times the tolerance, counts as closed. Lengths are
/// measured by the size of the loops in the drawing, so that the unit of length does not matter. Limits of
/// coordinates are ignored. Allocates; O(m nv²) an iteration. Throws std::invalid_argument for wrong sizes
/// and for numbers in q or v that are not finite.
[[nodiscard]] AssemblyResult assemble(const Model& model, std::span<const double> q,
                                      std::span<const double> v = {}, const AssemblyOptions& options = {});

}  // namespace axode
