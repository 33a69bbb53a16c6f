#pragma once
#include <optional>
#include <vector>

#include "axode/batch/kernels.hpp"
#include "axode/integration/drives.hpp"

namespace axode::batch {

/// Evaluates a drive of axode/integration/drives.hpp for several simulated motions, which are computed at
/// once in SIMD lanes. If the drive is a controller, its reference and its feedforward are evaluated once for
/// all of these motions.
template <class S> class ControlLawSampler {
 public:
  ControlLawSampler(const Model& model, const Drive& drive);

  /// Whether this class can evaluate the drive: a SampledDrive, a ProportionalDerivative with a SampledDrive
  /// or nothing as feedforward, or a ComputedTorque that drives all joints.
  bool known() const { return known_; }
  /// The control law, with the values of its reference and feedforward at the stages of the Runge-Kutta
  /// method `method` in the steps begin to end - 1, each of length `step`. It is valid until the next call.
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

/// The time of a stage of step k (s), by the formula that simulate_fixed() uses.
inline double time_of(const Tableau& method, double step, std::size_t k, std::size_t stage) {
  const double t = static_cast<double>(k) * step;
  return t + method.c[stage] * (static_cast<double>(k + 1) * step - t);
}

}  // namespace axode::batch
