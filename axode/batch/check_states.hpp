#pragma once
#include <stdexcept>
#include <string>

#include "axode/kinematics/check_arguments.hpp"

namespace axode::batch {

/// Checks q, the coordinates of several states, and the number of threads, and returns the number of states.
/// Throws std::invalid_argument for a wrong size, a quaternion that is not of unit norm, and threads < 1.
template <class S> std::size_t check_states(const Model& model, std::span<const S> q, int threads) {
  if (threads < 1)
    throw std::invalid_argument("threads is " + std::to_string(threads) + "; expected 1 or more");
  const std::size_t nq = model.nq();
  if (nq == 0) {
    if (!q.empty()) check_size("q", q.size(), 0, "nq N");
    return 0;
  }
  if (q.size() % nq != 0)
    throw std::invalid_argument("q has " + std::to_string(q.size()) +
                                " entries; expected a multiple of nq = " + std::to_string(nq));
  if (!model.tree<double>()->quaternion_bodies.empty())
    for (std::size_t k = 0; k < q.size() / nq; ++k) {
      try {
        check_configuration(model, q.subspan(k * nq, nq));
      } catch (const std::invalid_argument& error) {
        throw std::invalid_argument("state " + std::to_string(k) + ": " + error.what());
      }
    }
  return q.size() / nq;
}

}  // namespace axode::batch
