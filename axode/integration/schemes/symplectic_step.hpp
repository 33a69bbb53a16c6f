#pragma once
#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "axode/integration/schemes/floating_bases.hpp"
#include "axode/integration/schemes/midpoint.hpp"
#include "axode/integration/tableau.hpp"

namespace axode {

/// A step of a symmetric composition (D8.11) of the midpoint rule on (q, p). Part, which is Midpoint or
/// ClosedMidpoint, is the scheme of a part of the step; its first guess of the velocity in the middle of a
/// part is extrapolated from the same part of the last steps. System is the class of the mechanism. It must
/// have the member functions of MomentumSimulationRun that are called here and in Part.
template <class System, class Part> class SymplecticStep {
 public:
  using Vector = Eigen::VectorXd;

  /// Starts at the state (q_0, v_0) with p_0 = M v_0.
  SymplecticStep(System& system, Part part, int order, const Vector& q_0, const Vector& p_0,
                 const Vector& v_0)
      : q(q_0),
        p(p_0),
        system_(&system),
        midpoint_(std::move(part)),
        lengths_(symmetric_composition(order)),
        guesses_(lengths_.size()),
        y_(p_0) {
    midpoint_.v = v_0;
    system.bases().begin(q.data(), y_.data());
    system.bases().to_momenta(q.data(), y_.data(), p.data());
  }

  /// Advances q, p and the states of the drives, which start at the present ones, from time t to t + h.
  Failure run(double t, double h) {
    FloatingBases& bases = system_->bases();
    DriveStates& drives = system_->drives();
    drive_states = drives.x;
    for (std::size_t k = 0; k < lengths_.size(); ++k) {
      const double part = lengths_[k] * h;
      guesses_[k].extrapolate(midpoint_.v);
      drives.begin_midpoint_step(part, drive_states);
      if (Failure failure = midpoint_.run(t, part, q, p)) return failure;
      if (drives.too_fast(part)) return {t + part, DriveStates::runs_backwards};
      drives.end_midpoint_step(drive_states);
      guesses_[k].take(midpoint_.v);
      q = midpoint_.q;
      p = midpoint_.p;
      t += part;
      bases.advance(midpoint_.q_middle.data(), part, system_->pushes_bases(), midpoint_.f.data(), y_.data());
      bases.restore_centers(q.data());
      bases.to_momenta(q.data(), y_.data(), p.data());
      if (Failure failure = system_->close(t, q, p)) return failure;
    }
    return {};
  }

  Vector q, p, drive_states;

 private:
  /// Extrapolates equally spaced values to the next one, from the last four values, or fewer at the start.
  class Extrapolation {
   public:
    void take(const Vector& v) {
      if (last_.cols() < 4)
        last_.conservativeResize(v.size(), last_.cols() + 1);
      else
        last_.leftCols(3) = last_.rightCols(3).eval();
      last_.rightCols(1) = v;
    }
    /// Sets v to the extrapolated value. If there are no values yet, v remains unchanged.
    void extrapolate(Vector& v) const {
      static const Eigen::Matrix4d weights{{1, -1, 1, -1}, {0, 2, -3, 4}, {0, 0, 3, -6}, {0, 0, 0, 4}};
      const Eigen::Index n = last_.cols();
      if (n > 0) v.noalias() = last_ * weights.col(n - 1).head(n);
    }

   private:
    Eigen::MatrixXd last_;
  };

  System* system_;
  Part midpoint_;
  std::span<const double> lengths_;
  std::vector<Extrapolation> guesses_;
  Vector y_;
};

}  // namespace axode
