#include "axode/model/workspace.hpp"
#include "axode/derivatives/displacement/forward_first_order.hpp"
#include "axode/derivatives/displacement/scratch.hpp"
#include "axode/derivatives/second_order/tensors.hpp"
#include "axode/dynamics/scratch.hpp"
#include "axode/fast/composite_bodies.hpp"
#include "axode/fast/forward_dynamics.hpp"
#include "axode/fast/jacobians.hpp"
#include "axode/fast/motion.hpp"
#include "axode/kinematics/scratch.hpp"
#include "axode/recursion/composite_bodies.hpp"

/// A workspace is as large as the largest of what the functions of the library take of it.
namespace axode {
namespace {

template <class Rep, class T> std::size_t of_representation(const Topology& t) {
  return footprint<TreeMotion<Rep, T>, BiasForces<Rep, T>, ForwardDynamicsRecursion<Rep, T>,
                   CompositeBodies<Rep, T>, FrameResponse<Rep, T>, StateForm<Rep, T>>(t);
}

template <class T> std::size_t of_all(const Topology& t) {
  return std::max(
      {of_representation<BodyFixed, T>(t), of_representation<Spatial, T>(t), of_representation<Hybrid, T>(t),
       of_representation<Mixed, T>(t),
       footprint<FramePoses<T>, SubtreeInertias<T>, MovingMass<T>, PosesAndMotion<T>, CoriolisBodies<T>,
                 MomentumForm<T>, BiasForces<Fast, T>, FastForwardDynamics<T>, FastInverse<T>,
                 FastCompositeBodies<T>, FastJacobians<T>, FastMotion<T, true>, FastBodyFixedMotion<T, true>,
                 ForwardFirstOrder<T>, ForwardJvp<T>, ForwardVjp<T>, HessiansOfAccelerations<T>,
                 SecondOrderTensors<T>, ForwardGeometryDerivatives<T>, CarryingScrews<T>, SpringColumns<T>,
                 TermDerivatives<T>, MomentumFirstOrder<T>, SecondOrderRecursion<BodyFixed, T>,
                 SecondOrderRecursion<Hybrid, T>, EnergyGradient<T>>(t)});
}

}  // namespace

template <>
Workspace<double>::Workspace(const Model& model)
    : Workspace(model.topology(), of_all<double>(model.topology())) {}
template <>
Workspace<float>::Workspace(const Model& model)
    : Workspace(model.topology(), of_all<float>(model.topology())) {}

}  // namespace axode
