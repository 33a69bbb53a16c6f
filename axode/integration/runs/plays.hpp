#pragma once
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "axode/integration/closed_motion.hpp"
#include "axode/integration/trajectory.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// The couplings of joints with play (backlash) in a simulation and, if wanted, hard stops of joints, which
/// are plays of one joint between its limits. A play is free or at one of its two ends, where the coupling
/// acts like one without play that pushes and does not pull (D16.18).
class Plays {
 public:
  using Span = std::span<const double>;
  using Events = std::vector<Trajectory::PlayEvent>;
  /// Sets up the loops of a motion anew, with engaged() if any_at_an_end(), at the present configuration and
  /// time. Returns null if there are none.
  using Engage = std::function<ClosedMotion*()>;

  /// Takes the couplings with play and, if `stops` is true, the hard stops of a model. All are free.
  explicit Plays(const Model& model, bool stops = false);

  bool any() const { return !all_.empty(); }
  std::size_t size() const { return all_.size(); }
  const std::string& name(std::size_t k) const { return all_[k].name; }
  /// The name of the joint whose hard stop play k is; empty for a coupling.
  const std::string& stopped_joint(std::size_t k) const { return all_[k].joint; }
  /// The end at which play k is: -1 for the lower one, 1 for the upper one, 0 if the play is free.
  int side(std::size_t k) const { return side_[k]; }
  bool any_at_an_end() const;

  /// The model, in the same coordinates, in which couplings whose play is at an end hold there without play.
  /// It is built when a combination of ends first occurs.
  const Model& engaged();

  /// gap_to() is the signed distance of play k from its lower or upper end (`side` -1 or 1), negative beyond
  /// it; rate() is the rate of Σ factor q, which increases towards the upper end.
  double gap_to(std::size_t k, int side, Span q) const;
  double rate(std::size_t k, Span v) const;
  /// The rounding error of the gap between play k and one of its ends; smaller gaps count as 0.
  double gap_resolution(std::size_t k, Span q) const;
  /// A number that becomes negative when play k must change. If it is free, this is the gap to its nearer
  /// end, plus gap_resolution() and the overshoot of allow_overshoot(); if it is at an end, the force with
  /// which the end pushes, from the last accelerations of `loops`.
  double reserve(std::size_t k, Span q, const ClosedMotion* loops) const;
  /// Allows each play to be as far beyond one of its ends as it is at q after an event or at the start of a
  /// motion, so that reserve() is not negative there.
  void allow_overshoot(Span q);
  /// Reduces the overshoot that is allowed for plays that are less far beyond their end at q.
  void reduce_overshoot(Span q);

  /// Starts at (q, v): plays at an end meet it, which may change v. Returns their events, without times.
  /// Throws std::invalid_argument for a play beyond an end.
  Events start(Span q, std::span<double> v, const Engage& engage);
  /// Changes plays with negative reserves (one for each play): a free one that moves towards its nearer end
  /// meets it, which changes v, and one at an end becomes free. Returns the events, without times.
  Events change(Span reserves, Span q, std::span<double> v, const Engage& engage);
  /// Lets plays at an end become free if the end would pull in the last accelerations of `loops`. Returns the
  /// events, without times; unless it is empty, the loops must be set up anew.
  Events release_pulled(const ClosedMotion* loops);

 private:
  struct Play {
    std::string name, joint;
    std::vector<LoopCoupling::Term> terms;
    double offset, lower, upper;  ///< ends of Σ factor q - offset; infinite if there is none
    double restitution;
  };
  double deflection(std::size_t k, Span q) const;
  int nearer_end(std::size_t k, Span q) const { return gap_to(k, 1, q) < gap_to(k, -1, q) ? 1 : -1; }
  double nearer_gap(std::size_t k, Span q) const { return gap_to(k, nearer_end(k, q), q); }
  /// The restitution if play k meets its end at a speed: 0 below the mechanism's threshold for impacts.
  double restitution(std::size_t k, double speed) const;
  void refuse_beyond(std::size_t k, Span q) const;
  /// Computes the impact of play k on an end, which changes v. Another play at an end becomes free if the
  /// impact would pull there.
  Trajectory::PlayEvent meet_end(std::size_t k, int side, Span q, std::span<double> v, const Engage& engage);
  Trajectory::PlayEvent leave_end(std::size_t k);

  Model model_;
  std::vector<Play> all_;
  double threshold_;  ///< speed below which nothing bounces
  std::vector<int> side_;
  std::vector<double> overshoot_;  ///< how far each play may be beyond an end while it is free
  std::map<std::vector<int>, Model> engaged_;
};

}  // namespace axode
