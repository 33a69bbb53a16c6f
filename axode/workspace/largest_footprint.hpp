#pragma once
#include "axode/derivatives/displacement/forward_first_order.hpp"
#include "axode/derivatives/displacement/scratch.hpp"
#include "axode/derivatives/second_order/tensors.hpp"
#include "axode/dynamics/scratch.hpp"
#include "axode/fast/composite_bodies.hpp"
#include "axode/fast/forward_dynamics.hpp"
#include "axode/fast/jacobians.hpp"
#include "axode/fast/motion.hpp"
#include "axode/kinematics/scratch.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/composite_bodies.hpp"
#include "axode/recursion/momentum.hpp"

namespace axode {

template <class Rep, class T> std::size_t footprint_of_representation(const Topology& t) {
  return footprint<TreeMotion<Rep, T>, BiasForces<Rep, T>, ForwardDynamicsRecursion<Rep, T>,
                   CompositeBodies<Rep, T>, FrameResponse<Rep, T>, StateForm<Rep, T>, MomentumForm<Rep, T>>(
      t);
}

/// The largest scratch memory, in bytes, of any algorithm that uses a Workspace<T>, for the instruction set
/// for which the calling code is compiled.
template <class T> std::size_t largest_footprint(const Topology& t) {
  return std::max(
      {footprint_of_representation<BodyFixed, T>(t), footprint_of_representation<Spatial, T>(t),
       footprint_of_representation<Hybrid, T>(t), footprint_of_representation<Mixed, T>(t),
       footprint<FramePoses<T>, SubtreeInertias<T>, MovingMass<T>, PosesAndMotion<T>, CoriolisBodies<T>,
                 SpatialMomentumForm<T>, BiasForces<Fast, T>, FastForwardDynamics<T>, FastInverse<T>,
                 FastCompositeBodies<T>, FastJacobians<T>, FastMotion<T, true>, FastBodyFixedMotion<T, true>,
                 ForwardFirstOrder<T>, ForwardJvp<T>, ForwardVjp<T>, HessiansOfAccelerations<T>,
                 SecondOrderTensors<T>, ForwardGeometryDerivatives<T>, CarryingScrews<T>, SpringColumns<T>,
                 TermDerivatives<T>, MomentumFirstOrder<T>, SecondOrderRecursion<BodyFixed, T>,
                 SecondOrderRecursion<Hybrid, T>, EnergyGradient<T>>(t)});
}

/// largest_footprint<T>() in the code for the instruction set that the library has chosen for this processor.
template <class T> std::size_t chosen_largest_footprint(const Topology& t);

}  // namespace axode
