#pragma once
#include <span>
#include <string_view>

#include "axode/model/model.hpp"

namespace axode {

/// What becomes of what is doubtful and can be computed all the same: bodies that no matter can make
/// (inertia_not_realisable, a mass of 0), and in files what other readers forgive.
enum class Strictness {
  lenient,  ///< a warning: the files of real robots have it
  strict,   ///< an error
};

/// Collects a description, checks all of it and compiles it.
///
///     Model arm = ModelBuilder("arm")
///         .add({.name = "upper arm", .joint = {.name = "shoulder", .kind = JointKind::revolute, .axis = {0, 1, 0}},
///               .inertia = MassProperties{.mass = 2, .com = {0.2, 0, 0}, .Theta = {.01, .02, .02, 0, 0, 0}}})
///         .build();
class ModelBuilder {
 public:
  explicit ModelBuilder(std::string_view name = "mechanism") { description_.name = name; }
  /// Edit a model into a new one, or compile what a reader has read.
  explicit ModelBuilder(const Model& model) : description_(model.description()) {}
  explicit ModelBuilder(Description description) : description_(std::move(description)) {}

  ModelBuilder& add(BodyDescription body);
  ModelBuilder& add(FrameDescription frame);
  ModelBuilder& add(SpringDescription spring);
  ModelBuilder& add(LoopDescription loop);
  ModelBuilder& add(CouplingDescription coupling);
  ModelBuilder& gravity(const Vec3<>& g);  ///< m/s², in the construction frame

  /// The description of a body, to change it. Throws std::invalid_argument for an unknown name.
  BodyDescription& body(std::string_view name);
  const Description& description() const { return description_; }

  /// Everything wrong or doubtful with the description, errors and warnings, without building it.
  std::vector<Fault> check(Strictness strictness = Strictness::lenient) const;
  /// Throws ModelError with every fault if there is one of severity error; warnings stay on the model.
  Model build(Strictness strictness = Strictness::lenient) const;

 private:
  Description description_;
};

/// The description with its one body fixed to the ground set free by a joint named `free_base` (or free_base_2, ...
/// where there is one); as it is where bodies are free on the ground and none is fixed. Otherwise throws ModelError (rule
/// no_base) where not exactly one body is fixed to the ground.
Description with_free_base(Description description);
/// The description with all bodies that are free on the ground fixed to it: one by a joint named `fixed_base`, several
/// by joints without a name.
Description with_fixed_base(Description description);

/// A new model in which the named joints are fixed at their place in q (nq coordinates of `model`); a joint
/// coupled to a locked one is locked with it. Loops between bodies that no longer move against each other, and couplings
/// without a joint that moves, are left out, closed or not. Throws std::invalid_argument for an unknown or coupled joint
/// and a wrong q.
Model reduced(const Model& model, std::span<const std::string_view> locked, std::span<const double> q);

}  // namespace axode
