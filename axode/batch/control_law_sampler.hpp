#pragma once
#include <optional>
#include <vector>

#include "axode/batch/kernels.hpp"
#include "axode/integration/drives.hpp"

namespace axode::batch {

/// A drive of axode/integration/drives.hpp as motions in lanes take it. What it follows is found once for all
/// of them.
template <class S> class ControlLawSampler {
 public:
  ControlLawSampler(const Model& model, const Drive& drive);

  /// Whether it is one of these, and its feedforward is given by samples.
  bool known() const { return known_; }
  /// For the stages of steps begin to end - 1; until the next call.
  const ControlLaw<S>& law(const Tableau& method, double step, std::size_t begin, std::size_t end);

 private:
  void track(const Tracking& drive);

  std::size_t nq_, nv_;
  bool known_ = false, computes_ = false;
  std::optional<Reference> reference_;
  std::optional<SampledDrive> forces_;
  std::vector<S> kp_, kd_, limit_, rows_;
  ControlLaw<S> law_{};
};

/// When a stage of step k is, as simulate_fixed() has it.
inline double time_of(const Tableau& method, double step, std::size_t k, std::size_t stage) {
  const double t = static_cast<double>(k) * step;
  return t + method.c[stage] * (static_cast<double>(k + 1) * step - t);
}

}  // namespace axode::batch
