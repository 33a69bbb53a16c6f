#pragma once
#include <vector>

#include "tests/support/subject.hpp"

/// Rates by series: the kernels, in double, on the motion q(t), v(t) that passes through a state with its velocities and
/// accelerations.
namespace axode::test {

/// Of every frame the columns of R' and r'.
std::vector<Vec3<>> rates_of_poses(const Model& model, const State<double>& state);
/// Of the components of the twists of all frames.
std::vector<Six> rates_of_twists(Representation representation, const Model& model,
                                 const State<double>& state);
/// Of T + U, with the twists in a representation. Rotors count by their armature.
double rate_of_energy(Representation representation, const Model& model, const State<double>& state);
/// Of the momentum of all bodies about the inertial origin.
Six rate_of_momentum(Representation representation, const Model& model, const State<double>& state);

}  // namespace axode::test
