#pragma once
#include <span>
#include <string_view>

#include "axode/model/model.hpp"

namespace axode {

/// The treatment of defects that do not prevent a computation: inertias that no mass distribution has, masses
/// of 0, and defects of files that other readers accept.
enum class Strictness {
  lenient,  ///< they are warnings, because files of real robots have them
  strict,   ///< they are errors
};

/// Collects a description, checks all of it and compiles it.
///
///     Model arm = ModelBuilder("arm")
///         .add({.name = "upper arm",
///               .joint = {.name = "shoulder", .kind = JointKind::revolute, .axis = {0, 1, 0}},
///               .inertia = MassProperties{.mass = 2, .com = {.2, 0, 0}, .Theta = {.01, .02, .02, 0, 0, 0}}})
///         .build();
class ModelBuilder {
 public:
  explicit ModelBuilder(std::string_view name = "mechanism") { description_.name = name; }
  /// Starts from the description of a model, to edit it, or below from a description that a reader made.
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

  /// The description of a body, which may be changed. Throws std::invalid_argument for an unknown name.
  BodyDescription& body(std::string_view name);
  const Description& description() const { return description_; }

  /// All errors and warnings of the description, without building it.
  std::vector<Fault> check(Strictness strictness = Strictness::lenient) const;
  /// Builds the model. Throws ModelError with every fault if one of them is an error; if there are only
  /// warnings, the model keeps them.
  Model build(Strictness strictness = Strictness::lenient) const;

 private:
  Description description_;
};

/// The description in which the one body that is fixed to the ground hangs on it by a free joint `free_base`
/// (or free_base_2, ... if the name is taken). If no body is fixed and some are free, nothing changes.
/// Otherwise throws ModelError (rule no_base) unless exactly one body is fixed to the ground.
Description with_free_base(Description description);
/// The description in which all bodies that are free on the ground are fixed to it: a single one by a joint
/// `fixed_base`, several by joints without a name.
Description with_fixed_base(Description description);

/// A new model in which the named joints are fixed at their position in q (nq coordinates of `model`).
/// Joints that are coupled to a locked one are locked as well. The initial state and the motions of locked
/// joints are left out. Loops between bodies that no longer move relative to each other, and couplings
/// without a moving joint, are left out, whether they are closed or not. Throws std::invalid_argument for an
/// unknown or coupled joint and a wrong q.
Model reduced(const Model& model, std::span<const std::string_view> locked, std::span<const double> q);

}  // namespace axode
