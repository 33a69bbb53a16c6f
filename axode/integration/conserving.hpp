#pragma once
#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "axode/integration/composition.hpp"
#include "axode/integration/floating_bases.hpp"
#include "axode/integration/midpoint.hpp"

namespace axode {

/// A step of a symmetric composition of the midpoint rule on (q, p), what floats seen from its centre of mass. Velocities of
/// the same part of the steps before, extrapolated, are the guesses. Part is Midpoint or ClosedMidpoint. A System is one of its
/// that has with bases() its FloatingBases, says with pushes_bases() whether something acted on one of them in the last
/// evaluation, and with close(t, q, p), which has p open no loops, whether it could.
template <class System, class Part> class ConservingStep {
 public:
  using Numbers = std::vector<double>;
  using Outcome = typename Midpoint<System>::Outcome;

  /// From a state with p = M v.
  ConservingStep(System& system, Part part, int order, const Numbers& q_0, const Numbers& p_0,
                 const Numbers& v_0)
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

  /// Takes q and p at time t to t + h.
  Outcome run(double t, double h) {
    FloatingBases& bases = system_->bases();
    for (std::size_t k = 0; k < lengths_.size(); ++k) {
      const double part = lengths_[k] * h;
      guesses_[k].extrapolate(midpoint_.v);
      if (const Outcome outcome = midpoint_.run(t, part, q, p); outcome != Outcome::found) return outcome;
      guesses_[k].take(midpoint_.v);
      q = midpoint_.q, p = midpoint_.p, t += part;
      bases.advance(midpoint_.q_middle.data(), part, system_->pushes_bases(), midpoint_.f.data(), y_.data());
      bases.settle(q.data());
      bases.to_momenta(q.data(), y_.data(), p.data());
      if (!system_->close(t, q, p)) return Outcome::impossible;
    }
    return Outcome::found;
  }

  Numbers q, p;

 private:
  /// The next of equally spaced values, from as many as four.
  class Extrapolation {
   public:
    void take(const Numbers& v) {
      if (last_.size() < 4) {
        last_.push_back(v);
      } else {
        std::rotate(last_.begin(), last_.begin() + 1, last_.end());
        last_.back() = v;
      }
    }
    /// Leaves v as it is before there are any.
    void extrapolate(Numbers& v) const {
      if (last_.empty()) return;
      static constexpr double weights[4][4] = {{1}, {-1, 2}, {1, -3, 3}, {-1, 4, -6, 4}};
      std::ranges::fill(v, 0.0);
      for (std::size_t j = 0; j < last_.size(); ++j)
        for (std::size_t c = 0; c < v.size(); ++c) v[c] += weights[last_.size() - 1][j] * last_[j][c];
    }

   private:
    std::vector<Numbers> last_;
  };

  System* system_;
  Part midpoint_;
  std::span<const double> lengths_;
  std::vector<Extrapolation> guesses_;
  Numbers y_;
};

}  // namespace axode
