#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "axode/constraints/loops.hpp"

namespace axode {

struct AssemblyOptions {
  double tolerance = 1e-12;        ///< bound on |r|, with lengths in r divided by the size of the loops; see
                                   ///< assemble()
  int iterations = 200;            ///< largest number of iterations
  std::span<const int> held = {};  ///< indices of joint velocities, such as those of drives, that must not
                                   ///< change
  double time = 0;                 ///< time at which the prescribed motions of the model are evaluated, s
  std::function<bool()> monitor = {};  ///< called at every iteration; false ends the search
};

enum class AssemblyStatus {
  closed,
  open,             ///< no small step reduces the residual any more
  singular_guess,   ///< at the first iterate no velocity reduces the residual to first order: a chain is
                    ///< stretched or folded, or too many velocities are held
  iteration_limit,  ///< the iterations were used up, or the monitor ended the search
  singular,         ///< the loops are closed, but velocities were not found, because the mass matrix of the
                    ///< tree is singular
  held_velocities,  ///< the loops are closed, but no velocities with the held ones keep them closed
};
std::string_view to_string(AssemblyStatus status);

struct AssemblyResult {
  AssemblyStatus status{};
  std::vector<double> q, v;  ///< the best configuration found and, if v was given, velocities that keep it
                             ///< closed
  double residual = 0;       ///< norm of the residual r of all loops and motions at q, rad and m
  std::vector<double> open;  ///< norm of the residual of each loop, followed by that of each prescribed
                             ///< motion of a joint
  int iterations = 0;
};
/// One sentence for the user. If loops are open, it has the residual of each open loop, the largest first.
std::string to_string(const Model& model, const AssemblyResult& result);

/// Finds a configuration near q in which the loops are closed and the model's prescribed motions are followed
/// at the time options.time, by the method of Levenberg and Marquardt on the configuration manifold. Unless v
/// is empty, also finds velocities that keep the loops closed and follow the motions. Of these velocities,
/// those with the least kinetic energy of the difference from v are taken. If some velocities are held fixed
/// (options.held), those with the least Euclidean norm of the difference are taken, in which lengths are
/// divided by the largest distance of a body on a loop from the first body on its path from the ground.
///
/// Redundant loop equations are allowed. Convergence is slow near configurations from which the mechanism can
/// move in several ways. If the residual of the loops and motions stops decreasing, it counts as 0 if it is
/// within a bound on its rounding errors, or within a thousand times the tolerance. Limits of coordinates are
/// ignored. Allocates; O(m nv²) for each iteration with m loop equations. Throws std::invalid_argument for
/// wrong sizes, for numbers in q or v that are not finite, and if an entry of options.held is not the index
/// of a velocity.
[[nodiscard]] AssemblyResult assemble(const Model& model, std::span<const double> q,
                                      std::span<const double> v = {}, const AssemblyOptions& options = {});

}  // namespace axode
