#pragma once
#include <vector>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/dynamics/gear_losses.hpp"

namespace axode {

/// Computes accelerations and multipliers by LoopSystem::accelerate(), with the losses of moving gears of the
/// model if joint losses act: accelerations without these losses come first, then those under the forces of
/// the gears (D9.10). Throws as MovingGears.
template <class T>
Solvability accelerate_with_losses(LoopSystem<T>& system, const Model& model, NumberSpan<T> q,
                                   NumberSpan<T> v, NumberSpan<T> tau, const Loads<T>& loads, std::span<T> a,
                                   T* lambda) {
  if (!loads.joint_losses || model.gears().empty())
    return system.accelerate(q.data(), v.data(), tau.data(), loads, a.data(), lambda);
  const std::vector<T> q_t(q.begin(), q.end()), v_t(v.begin(), v.end());
  std::vector<T> forces(tau.begin(), tau.end());
  MovingGears gears(model, v, tau);
  const auto accelerate = [&] {
    return system.accelerate(q_t.data(), v_t.data(), forces.data(), loads, a.data(), lambda);
  };
  const Solvability found = accelerate();
  if (!found.ok() || gears.velocities().empty()) return found;
  const std::vector<T> before(a.begin(), a.end());
  std::vector<T> responses(gears.velocities().size() * a.size());
  static_cast<void>(system.factorize(q_t.data()));
  T* response = responses.data();
  for (const int c : gears.velocities()) {
    response[c] = T(1);
    system.force_response(response, response);
    response += a.size();
  }
  const Solvability unique =
      gears.add_forces(model, std::span(before), std::span<const T>(responses), std::span(forces));
  return unique.ok() ? accelerate() : solved(unique, std::ssize(a), a.data());
}

}  // namespace axode
