#include "axode/batch/control_law_sampler.hpp"

#include <algorithm>

namespace axode::batch {

template <class S>
ControlLawSampler<S>::ControlLawSampler(const Model& model, const Drive& drive)
    : nq_(model.nq()), nv_(static_cast<std::size_t>(model.nv())) {
  if (const auto* samples = drive.target<SampledDrive>()) {
    known_ = true;
    forces_ = *samples;
  } else if (const auto* pd = drive.target<ProportionalDerivative>()) {
    const auto* forward = pd->feedforward().template target<SampledDrive>();
    known_ = forward || !pd->feedforward();
    if (forward) forces_ = *forward;
    track(*pd);
    limit_.assign(pd->limit().begin(), pd->limit().end());
  } else if (const auto* computed = drive.target<ComputedTorque>(); computed && computed->drives_all()) {
    known_ = computes_ = true;
    track(*computed);
  }
}

template <class S> void ControlLawSampler<S>::track(const Tracking& drive) {
  kp_.assign(drive.kp().begin(), drive.kp().end());
  kd_.assign(drive.kd().begin(), drive.kd().end());
  reference_ = drive.reference();
}

template <class S>
const ControlLaw<S>& ControlLawSampler<S>::law(const Tableau& method, double step, std::size_t begin,
                                               std::size_t end) {
  const std::size_t width = nq_ + 2 * nv_, stages = method.c.size();
  rows_.assign((end - begin) * stages * width, S(0));
  std::vector<double> w(nv_);
  auto row = rows_.begin();
  for (std::size_t k = begin; k < end; ++k)
    for (std::size_t i = 0; i < stages; ++i, row += static_cast<std::ptrdiff_t>(width)) {
      const double t = time_of(method, step, k, i);
      const auto v_d = row + static_cast<std::ptrdiff_t>(nq_);
      if (reference_) {
        reference_->find(t);
        std::ranges::copy(reference_->q(), row);
        std::ranges::copy(reference_->v(), v_d);
      }
      if (forces_) (*forces_)(t, {}, {}, w);
      std::ranges::copy(computes_ ? reference_->a() : w, v_d + static_cast<std::ptrdiff_t>(nv_));
    }
  law_ = {.tracks = reference_.has_value(),
          .computes = computes_,
          .kp = kp_.data(),
          .kd = kd_.data(),
          .limit = limit_.empty() ? nullptr : limit_.data(),
          .rows = rows_.data()};
  return law_;
}

template class ControlLawSampler<double>;
template class ControlLawSampler<float>;

}  // namespace axode::batch
