#pragma once
#include <vector>

#include "tests/support/subject.hpp"

/// Time derivatives by Taylor series. The kernels run on series in t of a motion q(t), v(t) that passes
/// through a state at time 0, with the velocities and accelerations of that state; numbers are doubles.
namespace axode::test {

/// The columns of Ṙ and ṙ of every frame, frame after frame.
std::vector<Vec3<>> rates_of_poses(const Model& model, const State<double>& state);
/// The rates of the components of the twists of all frames.
std::vector<Six> rates_of_twists(Representation representation, const Model& model,
                                 const State<double>& state);
/// The rate of the energy T + U, computed with twists in a representation. The inertia of rotors counts as
/// their armature.
double rate_of_energy(Representation representation, const Model& model, const State<double>& state);
/// The rate of the total momentum of all bodies about the inertial origin.
Six rate_of_momentum(Representation representation, const Model& model, const State<double>& state);

}  // namespace axode::test
