#include "axode/integration/runs/plays.hpp"

#include <algorithm>
#include <cmath>

#include "axode/model/building/builder.hpp"
#include "axode/model/building/placement.hpp"

namespace axode {

Plays::Plays(const Model& model)
    : model_(model),
      threshold_(model.description().contact.value_or(ContactDescription{}).threshold),
      side_(model.loops().backlashes.size(), 0),
      overshoot_(side_.size(), 0) {}

bool Plays::any_at_an_end() const {
  return std::ranges::any_of(side_, [](int side) { return side != 0; });
}

const Model& Plays::engaged() {
  if (const auto known = engaged_.find(side_); known != engaged_.end()) return known->second;
  Description description = model_.description();
  for (std::size_t k = 0; k < description.couplings.size(); ++k) {
    CouplingDescription& coupling = description.couplings[k];
    const std::string its_name = coupling_name(coupling, k);
    coupling.name = its_name;
    const auto play = std::ranges::find(plays(), its_name, &Backlash::name);
    if (play == plays().end()) continue;
    const int side = side_[static_cast<std::size_t>(play - plays().begin())];
    if (side == 0) continue;
    coupling.offset += side * coupling.play / 2;
    coupling.play = coupling.restitution = 0;
  }
  return engaged_.emplace(side_, ModelBuilder(std::move(description)).build()).first->second;
}

double Plays::deflection(std::size_t k, Span q) const {
  double sum = -plays()[k].offset;
  for (const LoopCoupling::Term& term : plays()[k].terms)
    sum += term.factor * q[static_cast<std::size_t>(term.coordinate)];
  return sum;
}

double Plays::rate(std::size_t k, Span v) const {
  double sum = 0;
  for (const LoopCoupling::Term& term : plays()[k].terms)
    sum += term.factor * v[static_cast<std::size_t>(term.velocity)];
  return sum;
}

double Plays::restitution(std::size_t k, double speed) const {
  return speed > threshold_ ? plays()[k].restitution : 0;
}

double Plays::beyond(std::size_t k, Span q) const {
  return std::max(0.0, std::abs(deflection(k, q)) - half(k));
}

double Plays::gap(std::size_t k, Span q) const {
  return half(k) - std::abs(deflection(k, q)) + overshoot_[k];
}

void Plays::allow_overshoot(Span q) {
  for (std::size_t k = 0; k < size(); ++k) overshoot_[k] = beyond(k, q);
}

void Plays::reduce_overshoot(Span q) {
  for (std::size_t k = 0; k < size(); ++k) overshoot_[k] = std::min(overshoot_[k], beyond(k, q));
}

double Plays::gap_resolution(std::size_t k, Span q) const {
  double size = plays()[k].play + std::abs(plays()[k].offset);
  for (const LoopCoupling::Term& term : plays()[k].terms)
    size += std::abs(term.factor * q[static_cast<std::size_t>(term.coordinate)]);
  constexpr double closed = 2e-13, rounding = 1e-14;  // what the projection of loops leaves open
  return closed + rounding * size;
}

}  // namespace axode
