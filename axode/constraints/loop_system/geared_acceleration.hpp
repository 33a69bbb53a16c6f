#pragma once
#include <span>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/dynamics/gear_losses.hpp"

namespace axode {

/// Computes the accelerations a (nv) of a mechanism with loops and the multipliers λ of the loop equations (a
/// number for each equation). If loads.joint_losses is set, the losses of gears of moving joints are
/// included. The losses are computed from all of τ, but forces of springs, which callers may add to τ, do not
/// pass through gears. Therefore std::invalid_argument is thrown if loads.joint_losses is set and the model
/// has springs in addition to gears with losses.
template <class T>
Solvability accelerate_with_losses(LoopSystem<T>& system, const Model& model, NumberSpan<T> q,
                                   NumberSpan<T> v, NumberSpan<T> tau, const Loads<T>& loads, std::span<T> a,
                                   T* lambda) {
  if (!loads.joint_losses || model.gears().empty())
    return system.accelerate(q.data(), v.data(), tau.data(), loads, a.data(), lambda);
  return accelerate_with_gears<T>(
      model, q, v, tau, a,
      [&](const T* q_t, const T* v_t, const T* forces) {
        return system.accelerate(q_t, v_t, forces, loads, a.data(), lambda);
      },
      [&](const T* q_t, std::span<const int> velocities, T* response) {
        static_cast<void>(system.factorize(q_t));
        for (const int c : velocities) {
          response[c] = T(1);
          system.force_response(response, response);
          response += a.size();
        }
      });
}

}  // namespace axode
