#pragma once
#include <concepts>
#include <memory>
#include <span>

#include "axode/batch/compiled_dynamics.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/integration/prescribed/closed_motion.hpp"
#include "axode/model/finite.hpp"

namespace axode::batch {

/// Computes the accelerations in one motion of a mechanism, without SIMD lanes. If the caller has forward
/// dynamics that was compiled for the model (CompiledDynamics), it is used; otherwise the library's functions
/// are. Models with loops need double precision.
template <class S> class Accelerations {
 public:
  Accelerations(const Model& model, const CompiledDynamics<S>& compiled, bool damping)
      : model_(&model), compiled_(compiled), workspace_(model, cut_tree), damping_(damping) {
    if (!model.loops().empty()) loops_ = std::make_shared<ClosedMotion>(model);
  }

  /// The loops of the mechanism, or null.
  ClosedMotion* loops() const { return loops_.get(); }

  /// Adds the forces of springs to the joint forces tau, and computes the accelerations a. Forward dynamics
  /// that was compiled for the model leaves out damping. If it is used and damping acts, the forces of
  /// damping are added to tau as well.
  Solvability compute(std::span<const S> q, std::span<const S> v, std::span<S> tau, std::span<S> a) {
    if (!model_->springs().empty()) add_spring_forces(*model_, workspace_, q, v, tau);
    const std::span<const S> forces = tau;
    if (compiled_.call) {
      const std::span damping(model_->tree<S>().damping);
      if (damping_)
        for (std::size_t c = 0; c < v.size(); ++c) tau[c] -= S(damping[c]) * v[c];
      const S* const arguments[]{q.data(), v.data(), tau.data()};
      unsigned char maybe_singular = 0;
      compiled_.call(1, arguments, a.data(), nullptr, &maybe_singular);
      if (!maybe_singular) return {.not_finite = !finite(a)};
      return axode::forward_dynamics(*model_, workspace_, q, v, forces, a);
    }
    const Loads<S> loads{.joint_losses = damping_ && model_->gears().empty()};
    if constexpr (std::same_as<S, double>)
      if (loops_) return loops_->accelerate(q, v, forces, loads, a);
    return axode::forward_dynamics(*model_, workspace_, q, v, forces, a, loads);
  }

 private:
  const Model* model_;
  CompiledDynamics<S> compiled_;
  Workspace<S> workspace_;
  bool damping_;
  std::shared_ptr<ClosedMotion> loops_;
};

/// The joint losses that act in a motion: `damping` is set if damping acts, and `friction` if dry friction or
/// losses of gears act. With `friction`, steps must find out which joints stick and slide.
struct Losses {
  bool damping, friction;
};

}  // namespace axode::batch
