#include "axode/constraints/prescribed/motion_rows.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "axode/model/building/builder.hpp"
#include "axode/model/building/checks/value_checks.hpp"
#include "axode/model/building/nearest_name.hpp"
#include "axode/model/building/placement.hpp"

namespace axode {
namespace {

/// All prescribed motions of a mechanism, and the names of the loops that they become.
struct Motions {
  std::vector<PrescribedMotion> all;
  std::vector<std::string> names;
};
Motions motions_of(const Model& model, std::span<const PrescribedMotion> more) {
  Motions motions;
  for (const MotionDescription& it : model.motions()) {
    motions.all.push_back({it.of, MotionFunction(it)});
    motions.names.push_back(motion_name(it));
  }
  for (const PrescribedMotion& it : more) {
    motions.all.push_back(it);
    motions.names.push_back(motion_name({.name = {}, .of = it.of}));
  }
  return motions;
}

const Loop* rod_named(const Model& model, std::string_view name) {
  for (const Loop& loop : model.loops().joints)
    if (loop.name == name && traits(loop.kind).has("length")) return &loop;
  return nullptr;
}

/// Throws std::invalid_argument if a prescribed motion is not that of a joint with one velocity or of the
/// length of a rod, or if two motions move the same joint or rod.
void check(const Model& model, std::span<const PrescribedMotion> motions) {
  for (std::size_t k = 0; k < motions.size(); ++k) {
    const std::string& of = motions[k].of;
    for (std::size_t j = 0; j < k; ++j)
      if (motions[j].of == of)
        throw std::invalid_argument("motions: " + quoted(of) + " has two motions; it can follow one");
    if (rod_named(model, of) != nullptr) continue;
    const std::span<const Joint> joints = model.joints();
    const auto joint = std::ranges::find(joints, of, &Joint::name);
    if (joint == joints.end())
      throw std::invalid_argument("motions: model " + quoted(model.name()) + " has no joint and no rod " +
                                  quoted(of) +
                                  did_you_mean(of, joints, [](const Joint& j) { return j.name; }));
    if (joint->dof.size() != 1)
      throw std::invalid_argument(
          "motions: joint " + quoted(of) + " has " + std::to_string(joint->dof.size()) +
          " velocities; a motion prescribes a joint of one velocity, or a rod: remove it "
          "from the motions");
  }
}

/// Returns the mechanism without motions and with an additional coupling for each motion of a joint.
Model with_rows(const Model& model, const Motions& motions) {
  if (motions.all.empty()) return model;
  check(model, motions.all);
  Description d = model.description();
  d.motions.clear();
  d.warnings.clear();
  for (std::size_t k = 0; k < motions.all.size(); ++k)
    if (rod_named(model, motions.all[k].of) == nullptr)
      d.couplings.push_back({.name = motions.names[k], .terms = {{motions.all[k].of, 1}}});
  return ModelBuilder(std::move(d)).build();
}

}  // namespace

MotionRows::MotionRows(const Model& model, std::span<const PrescribedMotion> more) : model_(model) {
  Motions motions = motions_of(model, more);
  model_ = with_rows(model, motions);
  const Loops& loops = model_.loops();
  std::size_t coupling = model.loops().couplings.size();
  for (PrescribedMotion& motion : motions.all) {
    const Loop* rod = rod_named(model_, motion.of);
    const LoopRows& rows = rod != nullptr ? static_cast<const LoopRows&>(*rod) : loops.couplings[coupling++];
    rows_.push_back({.of = motion.of,
                     .place = {.row = rows.first_row, .residual = rows.first_residual},
                     .drawn = rod != nullptr ? rod->size : 0,
                     .function = std::move(motion.function)});
  }
}

std::span<const PrescribedRow<double>> MotionRows::at(double t) {
  imposed_.clear();
  for (const Row& row : rows_) {
    const MotionValue value = row.function(t);
    imposed_.push_back({row.place.row, row.place.residual, value.s - row.drawn, value.ds, value.dds});
  }
  return imposed_;
}

double MotionRows::next_jump(double t) const {
  double next = std::numeric_limits<double>::infinity();
  for (const Row& row : rows_)
    for (const double jump : row.function.jumps())
      if (jump > t) next = std::min(next, jump);
  return next;
}

void MotionRows::check_times(double from, double until) const {
  for (const Row& row : rows_) {
    const MotionFunction& f = row.function;
    if (!(f.begin() <= from) || !(until <= f.end()))
      throw std::invalid_argument("motions: the motion of " + quoted(row.of) + " is known from " +
                                  to_text(f.begin()) + " s to " + to_text(f.end()) + " s, and times from " +
                                  to_text(from) + " s to " + to_text(until) + " s need more samples");
  }
}

std::string MotionRows::worst(std::span<const double> rows, double tolerance) const {
  std::string name;
  for (const Row& row : rows_) {
    const double x = std::abs(rows[static_cast<std::size_t>(row.place.row)]);
    if (x <= tolerance) continue;
    tolerance = x;
    name = row.of;
  }
  return name;
}

}  // namespace axode
