#pragma once
#include <span>
#include <string_view>

#include "axode/model/model.hpp"

/// New models from old ones, which never change. All build leniently: what no matter can have is a warning of the new
/// model, as estimates and the files of real robots have it. Cylindrical and universal joints become their chains of two.
/// See also ModelBuilder(model), and `reduced`, in axode/model/builder.hpp.
namespace axode {

/// The same mechanism with other inertial parameters (axode/model/inertial_parameters.hpp), 10 n_bodies numbers, so
/// that Y pi with the regressor Y are its drive forces. What is fixed to a moving body stays as a massless frame: its
/// inertia is part of that body's parameters. Throws std::invalid_argument for a wrong size and for a body with a moment
/// but no mass, ModelError for numbers that are not finite and for negative masses.
Model with_parameters(const Model& model, std::span<const double> pi);

/// The same mechanism in another gravity, m/s² in the construction frame. Throws ModelError where it is not finite.
Model with_gravity(const Model& model, const Vec3<>& g);

/// The same mechanism with a body of inertia M, given in a frame of the model, fixed to that frame; `name` becomes a
/// frame, too. Throws std::invalid_argument for an unknown frame, ModelError for a name that is taken and for an inertia
/// that no matter can have.
Model with_payload(const Model& model, std::string_view frame, const Inertia<>& M,
                   std::string_view name = "payload");

/// The mechanism with another one mounted on one of its frames, which takes the place of the other's ground; a hand on
/// the flange of an arm. The prefix goes before all names of bodies, joints, frames and loops of the other one, whose gravity
/// does not matter. Bodies are numbered depth-first as ever, so the other's coordinates need not be the last ones.
/// Throws std::invalid_argument for an unknown frame, and that lists the names which both have.
Model append(const Model& model, std::string_view frame, const Model& other, std::string_view prefix = "");

}  // namespace axode
