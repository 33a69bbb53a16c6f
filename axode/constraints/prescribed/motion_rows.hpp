#pragma once
#include <span>
#include <string>
#include <vector>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/constraints/prescribed/prescribed_motion.hpp"

namespace axode {

/// The motions of a mechanism as rows of its loops.
class MotionRows {
 public:
  struct Row {
    std::string of;  ///< joint or rod
    PrescribedRow<double> place;
    double drawn;  ///< the length of a rod as drawn, 0 for a joint
    MotionFunction function;
  };

  /// The motions of the description, followed by `more`. Throws std::invalid_argument for a name that is
  /// neither a joint of one velocity nor a rod, and for a second motion of one joint or rod.
  explicit MotionRows(const Model& model, std::span<const PrescribedMotion> more = {});

  bool empty() const { return rows_.empty(); }
  std::span<const Row> rows() const { return rows_; }
  /// The mechanism in which every motion is a loop: its rod, or a coupling that has the joint alone. Its
  /// state has the same coordinates. It is the mechanism itself if there are no motions.
  const Model& model() const { return model_; }

  /// Gives the rows of a system of model() the right sides that they have at a time.
  void impose(double t, LoopSystem<double>& system);
  /// Gives them the right sides 0, for the response to forces.
  void release(LoopSystem<double>& system) const { system.prescribe({}); }

  /// The first time after t at which a step of an integration should end; infinite if there is none.
  double next_jump(double t) const;
  /// Throws std::invalid_argument if a motion is not known from one time to another.
  void check_times(double from, double until) const;
  /// The motion whose row differs from 0 most, by its joint or rod; empty if no row differs by more than the
  /// tolerance.
  std::string worst(std::span<const double> rows, double tolerance) const;

 private:
  Model model_;
  std::vector<Row> rows_;
  std::vector<PrescribedRow<double>> imposed_;
};

}  // namespace axode
