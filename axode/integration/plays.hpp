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
  /// The gap at an end of play k that cannot be told from 0.
  double gap_resolution(std::size_t k, Span q) const;

 private:
  const std::vector<Backlash>& plays() const { return model_.loops().backlashes; }

  Model model_;
  double threshold_;  ///< speed below which nothing bounces
  std::vector<int> side_;
  std::map<std::vector<int>, Model> engaged_;
};

}  // namespace axode
