#pragma once
#include "axode/batch.hpp"
#include "axode/batch/compiled_dynamics.hpp"

/// The rollouts of axode/batch.hpp with forward dynamics that was compiled for the model.
namespace axode::batch {

template <class S>
Outcome rollout(const Model& model, const CompiledDynamics<S>& compiled, Numbers<S> q, Numbers<S> v,
                Numbers<S> tau, double step, std::type_identity_t<std::span<S>> q_out,
                std::type_identity_t<std::span<S>> v_out, const Tableau& method, int threads,
                const Monitor& monitor, bool joint_losses);
template <class S>
Outcome rollout(const Model& model, const CompiledDynamics<S>& compiled, Numbers<S> q, Numbers<S> v,
                const Drive& drive, std::size_t K, double step, std::type_identity_t<std::span<S>> q_out,
                std::type_identity_t<std::span<S>> v_out, const Tableau& method, int threads,
                const Monitor& monitor, bool joint_losses);

}  // namespace axode::batch
