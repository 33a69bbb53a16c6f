#pragma once
#include <span>
#include <string>
#include <vector>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/constraints/prescribed/prescribed_motion.hpp"

namespace axode {

/// The prescribed motions of a mechanism, imposed as rows of loops.
class MotionRows {
 public:
  struct Row {
    std::string of;  ///< name of the joint or rod
    PrescribedRow<double> place;
    double drawn;  ///< length of the rod as drawn, m; 0 for a joint
    MotionFunction function;
  };

  /// Takes the prescribed motions of the model, followed by those in `more`. Throws std::invalid_argument for
  /// a name that is neither that of a joint with one velocity nor that of a rod, and for a second motion of
  /// one joint or rod.
  explicit MotionRows(const Model& model, std::span<const PrescribedMotion> more = {});

  bool empty() const { return rows_.empty(); }
  std::span<const Row> rows() const { return rows_; }
  /// The mechanism in which every prescribed motion is a loop equation, with the same coordinates and
  /// velocities. If the length of a rod is prescribed, this is the equation of the rod. If the motion of a
  /// joint is prescribed, a coupling is added that has this joint as its only term.
  const Model& model() const { return model_; }

  /// The loop equations that impose the prescribed motions in the mechanism that model() returns, with their
  /// right sides at time t (s). They are valid until the next call.
  std::span<const PrescribedRow<double>> at(double t);
  /// Sets the right sides of the loop equations that impose the prescribed motions to their values at time t
  /// (s). `system` must belong to the mechanism that model() returns, in which every prescribed motion is a
  /// loop equation.
  void impose(double t, LoopSystem<double>& system) { system.prescribe(at(t)); }
  /// Sets the right sides of the loop equations that impose the prescribed motions to 0, so that `system`
  /// computes responses to forces.
  void release(LoopSystem<double>& system) const { system.prescribe({}); }

  /// The first time after t at which a derivative of a prescribed motion jumps; infinite if there is none.
  double next_jump(double t) const;
  /// Throws std::invalid_argument if a motion is not known at all times from `from` to `until`.
  void check_times(double from, double until) const;
  /// The name of the joint or rod whose prescribed motion is violated most. `rows` has the residual of each
  /// loop equation of model(), for example of its second time derivative. Residuals up to `tolerance` count
  /// as 0. Empty if this holds for all prescribed motions.
  std::string worst(std::span<const double> rows, double tolerance) const;

 private:
  Model model_;
  std::vector<Row> rows_;
  std::vector<PrescribedRow<double>> imposed_;
};

}  // namespace axode
