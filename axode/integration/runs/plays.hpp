#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// The couplings with play of a mechanism in a simulation. A play is free or at one of its ends, where it
/// acts as a coupling that pushes and does not pull, see (D16.18) of docs/derivations.
class Plays {
 public:
  using Span = std::span<const double>;

  explicit Plays(const Model& model);

  bool any() const { return !plays().empty(); }
  std::size_t size() const { return plays().size(); }
  const std::string& name(std::size_t k) const { return plays()[k].name; }
  /// -1 at the lower end of play k, 1 at the upper one, 0 in between.
  int side(std::size_t k) const { return side_[k]; }
  void set_side(std::size_t k, int side) { side_[k] = side; }
  bool any_at_an_end() const;

  /// The mechanism in which every play at an end is a loop. It has the coordinates of the mechanism.
  const Model& engaged();

  /// δ = Σ factor q - offset of play k, and its rate.
  double deflection(std::size_t k, Span q) const;
  double rate(std::size_t k, Span v) const;
  double half(std::size_t k) const { return plays()[k].play / 2; }
  /// The restitution of an impact on the end of play k at a speed: 0 below the threshold of the mechanism.
  double restitution(std::size_t k, double speed) const;
  /// The rounding error of the gap between play k and one of its ends; smaller gaps count as 0.
  double gap_resolution(std::size_t k, Span q) const;
  /// The gap between play k and the end that is nearer, plus what it may be beyond this end while it is free.
  double gap(std::size_t k, Span q) const;
  /// Lets free plays be as far beyond their ends as they are now, where an event or the start has left them.
  void allow_overshoot(Span q);
  /// Takes back what the free plays no longer need of allow_overshoot().
  void reduce_overshoot(Span q);

 private:
  const std::vector<Backlash>& plays() const { return model_.loops().backlashes; }
  /// The distance of play k beyond one of its ends; 0 if it is between them.
  double beyond(std::size_t k, Span q) const;

  Model model_;
  double threshold_;  ///< speed below which nothing bounces
  std::vector<int> side_;
  std::vector<double> overshoot_;  ///< how far each play may be beyond an end while it is free
  std::map<std::vector<int>, Model> engaged_;
};

}  // namespace axode
