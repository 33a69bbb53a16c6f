#pragma once
#include <optional>
#include <vector>

#include "axode/batch/kernels.hpp"
#include "axode/integration/drives.hpp"

namespace axode::batch {

/// Evaluates a drive of axode/integration/drives.hpp for motions in lanes: the reference and the feedforward
/// are evaluated once for all motions.
template <class S> class ControlLawSampler {
 public:
  ControlLawSampler(const Model& model, const Drive& drive);

  /// Whether the drive is one of axode/integration/drives.hpp and its feedforward, if it has one, is given by
  /// samples.
  bool known() const { return known_; }
  /// The law at the stages of steps begin to end - 1. It is valid until the next call.
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

/// The time of a stage of step k, as simulate_fixed() computes it.
inline double time_of(const Tableau& method, double step, std::size_t k, std::size_t stage) {
  const double t = static_cast<double>(k) * step;
  return t + method.c[stage] * (static_cast<double>(k + 1) * step - t);
}

}  // namespace axode::batch
