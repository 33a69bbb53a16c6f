#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// The couplings of joints with play (backlash) in a simulation. A play is free or at one of its two ends,
/// where the coupling acts like one without play that pushes and does not pull (D16.18).
class Plays {
 public:
  using Span = std::span<const double>;

  explicit Plays(const Model& model);

  bool any() const { return !plays().empty(); }
  std::size_t size() const { return plays().size(); }
  const std::string& name(std::size_t k) const { return plays()[k].name; }
  /// The end at which play k is: -1 for the lower one, 1 for the upper one, 0 if the play is free.
  int side(std::size_t k) const { return side_[k]; }
  void set_side(std::size_t k, int side) { side_[k] = side; }
  bool any_at_an_end() const;

  /// The model, in the same coordinates, in which couplings whose play is at an end hold there without play.
  /// It is built when a combination of ends first occurs.
  const Model& engaged();

  /// deflection() is the signed distance δ = Σ factor q - offset of play k from its middle; rate() is δ'.
  double deflection(std::size_t k, Span q) const;
  double rate(std::size_t k, Span v) const;
  double half(std::size_t k) const { return plays()[k].play / 2; }
  /// The restitution if play k meets its end at a speed: 0 below the mechanism's threshold for impacts.
  double restitution(std::size_t k, double speed) const;
  /// The rounding error of the gap between play k and one of its ends; smaller gaps count as 0.
  double gap_resolution(std::size_t k, Span q) const;
  /// The gap between play k and its nearer end, negative beyond it, plus the overshoot of allow_overshoot().
  double gap(std::size_t k, Span q) const;
  /// Allows each play (backlash) to be as far beyond one of its ends as it is at q after an event or at the
  /// start of a motion: gap() is then not negative there.
  void allow_overshoot(Span q);
  /// Reduces the overshoot that is allowed for plays that are less far beyond their end at q.
  void reduce_overshoot(Span q);

 private:
  const std::vector<Backlash>& plays() const { return model_.loops().backlashes; }
  /// The distance of play k beyond the nearer one of its ends; 0 if it is between them.
  double beyond(std::size_t k, Span q) const;

  Model model_;
  double threshold_;  ///< speed below which nothing bounces
  std::vector<int> side_;
  std::vector<double> overshoot_;  ///< how far each play may be beyond an end while it is free
  std::map<std::vector<int>, Model> engaged_;
};

}  // namespace axode
