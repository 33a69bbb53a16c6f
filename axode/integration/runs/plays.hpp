#pragma once
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "axode/integration/prescribed/closed_motion.hpp"
#include "axode/integration/trajectory.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// The couplings of joints with play (backlash) in a simulation. Hard stops of a joint can be included as a
/// play of this joint between its limits. A play is either free or at one of its two ends. At an end, the
/// coupling acts like one without play, as long as the end pushes; it cannot pull (D16.18).
class Plays {
 public:
  using Span = std::span<const double>;
  using Events = std::vector<Trajectory::PlayEvent>;
  static constexpr int upper = 1, lower = -1;  ///< the ends of a play
  /// Callback that makes the constraint equations of the motion anew, at the present configuration and time,
  /// after plays (backlash of couplings) have opened or closed: those of the loops, and those of plays at an
  /// end. Returns null if there are no such equations.
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

  /// The model with the same coordinates in which couplings at an end of their play (backlash) are couplings
  /// without play. It is built the first time that this combination of ends occurs.
  const Model& engaged();

  /// gap_to() is the signed distance of play k (the backlash of a coupling) from its lower end (side = -1) or
  /// its upper end (side = 1); it is negative beyond the end. rate() is the rate of the coupling's Σ factor
  /// q, positive towards the upper end.
  double gap_to(std::size_t k, int side, Span q) const;
  double rate(std::size_t k, Span v) const;
  /// The rounding error of the gap between play k and one of its ends; smaller gaps count as 0.
  double gap_resolution(std::size_t k, Span q) const;
  /// A number that becomes negative when play k (the backlash of a coupling) must open or close. For a free
  /// play it is the gap to its nearer end, plus a bound on rounding errors and the distance by which the play
  /// is allowed to be beyond this end. For a play at an end it is the force with which the end pushes, which
  /// `loops` computed with its last accelerations.
  double reserve(std::size_t k, Span q, const ClosedMotion* loops) const;
  /// Stores for each play (the backlash of a coupling) how far it is beyond its nearer end at q, and
  /// tolerates this from now on: a free play closes only if it moves farther beyond the end. It is called
  /// after an event and at the start of a motion.
  void allow_overshoot(Span q);
  /// Reduces the tolerated distances of plays beyond their ends for plays that are less far beyond them at q.
  void reduce_overshoot(Span q);

  /// Starts a motion at (q, v). Plays (backlash of couplings) that are at an end and move against it have an
  /// impact, which changes v. Returns the events of these plays, without times. Throws std::invalid_argument
  /// for a play beyond an end.
  Events start(Span q, std::span<double> v, const Engage& engage);
  /// Changes the plays (backlash of couplings) whose number in `reserves` is negative. This number is the gap
  /// to the nearer end for a free play, and the force with which the end pushes for a play at an end. A free
  /// play that moves towards its nearer end has an impact there, which changes v, and a play at an end
  /// becomes free. Returns the events, without times.
  Events change(Span reserves, Span q, std::span<double> v, const Engage& engage);
  /// Frees each play (the backlash of a coupling) whose end would have to pull, because an end can only push.
  /// The force of the end is the multiplier of the coupling in the last accelerations that `loops` computed.
  /// Returns the events of these plays, without times. If there are any, the caller must set up the
  /// constraint equations again.
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
  /// Computes the impact of play k (backlash of a coupling) on its upper (`side` = 1) or lower (`side` = -1)
  /// end, with the restitution of the coupling, or with 0 if the speed is below the threshold for impacts.
  /// Changes the velocities v. If the restitution is 0, the play stays at the end, otherwise it is free
  /// afterwards. Another play becomes free if it is at an end that would have to pull during the impact.
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
