#pragma once
#include <span>
#include <string_view>

#include "axode/model/model.hpp"

namespace axode {

/// Whether a defect of a description that does not prevent computations is a warning or an error: for example
/// a mass of 0, or an inertia that no mass distribution has. The same holds for a joint in a file whose lower
/// limit is above the upper one; with a warning it is read without limits.
enum class Strictness {
  lenient,  ///< such defects are warnings, because files of real robots have them
  strict,   ///< such defects are errors
};

/// Collects the elements of a mechanism in a description, checks the description, and makes a Model of it.
///
///     Model arm = ModelBuilder("arm")
///         .add({.name = "upper arm",
///               .joint = {.name = "shoulder", .kind = JointKind::revolute, .axis = {0, 1, 0}},
///               .inertia = MassProperties{.mass = 2, .com = {.2, 0, 0}, .Theta = {.01, .02, .02, 0, 0, 0}}})
///         .build();
class ModelBuilder {
 public:
  explicit ModelBuilder(std::string_view name = "mechanism") { description_.name = name; }
  /// Starts from the description of a model, or from a description that a reader made, to edit it.
  explicit ModelBuilder(const Model& model) : description_(model.description()) {}
  explicit ModelBuilder(Description description) : description_(std::move(description)) {}

  ModelBuilder& add(BodyDescription body);
  ModelBuilder& add(FrameDescription frame);
  ModelBuilder& add(SpringDescription spring);
  ModelBuilder& add(LoopDescription loop);
  ModelBuilder& add(CouplingDescription coupling);
  ModelBuilder& add(MotionDescription motion);
  ModelBuilder& add(DriveDescription drive);
  ModelBuilder& state(InitialStateDescription state);
  ModelBuilder& gravity(const Vec3<>& g);  ///< m/s², in the construction frame

  /// The description of a body, for changes. Throws std::invalid_argument if no body has the name.
  BodyDescription& body(std::string_view name);
  const Description& description() const { return description_; }

  /// All errors and warnings about the description. Nothing is thrown for a description with errors.
  std::vector<Fault> check(Strictness strictness = Strictness::lenient) const;
  /// Builds the model, which keeps warnings. Throws ModelError with every fault if one of them is an error.
  Model build(Strictness strictness = Strictness::lenient) const;

 private:
  Description description_;
};

/// Replaces the joint of the one body that is fixed to the ground by a free joint `free_base` (or
/// `free_base_2`, ... if the name is taken). If no body is fixed to the ground and at least one is free on
/// it, the description does not change. Throws ModelError if several bodies are fixed to the ground, or if
/// none is fixed to it or free on it.
Description with_free_base(Description description);
/// Fixes all bodies that a free joint connects to the ground. The joint of a single one is named
/// `fixed_base`; if there are several, their joints have no names. The initial states of these joints are
/// left out with a warning.
Description with_fixed_base(Description description);

/// Returns a model in which the named joints are fixed at their position in q (nq coordinates of `model`).
/// Joints that follow one of them as their leader are fixed as well. The new model has no initial state, and
/// no prescribed motions of fixed joints. It has no loops between bodies that can no longer move relative to
/// each other, and no couplings or springs that act on fixed joints alone, even if such a loop or coupling is
/// not closed at q. Throws std::invalid_argument for a joint that is unknown, follows a leader, or is acted
/// on by a drive with states, and for a q of a wrong size or with a quaternion that is not of unit norm.
Model reduced(const Model& model, std::span<const std::string_view> locked, std::span<const double> q);

}  // namespace axode
