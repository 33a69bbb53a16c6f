#include "axode/integration/runs/plays.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "axode/model/building/builder.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/scalar/text.hpp"

namespace axode {

Plays::Plays(const Model& model, bool stops)
    : model_(model), threshold_(model.description().contact.value_or(ContactDescription{}).threshold) {
  for (const Backlash& it : model.loops().backlashes)
    all_.push_back({it.name, {}, it.terms, it.offset, -it.play / 2, it.play / 2, it.restitution});
  for (const Joint& joint : model.joints()) {
    if (!stops || joint.dof.size() != 1 || !joint.dof[0].hard_stops) continue;
    const Joint& own = joint.leader ? model.joint(joint.leader->joint) : joint;
    const Dof& dof = joint.dof[0];
    all_.push_back({"hard stop of " + joint.name,
                    joint.name,
                    {{own.iq, own.iv, joint.leader ? joint.leader->ratio : 1}},
                    joint.leader ? -joint.leader->offset : 0,
                    dof.lower,
                    dof.upper,
                    dof.restitution});
  }
  side_.resize(all_.size());
  overshoot_.resize(all_.size());
}

bool Plays::any_at_an_end() const {
  return std::ranges::any_of(side_, [](int side) { return side != 0; });
}

const Model& Plays::engaged() {
  if (const auto known = engaged_.find(side_); known != engaged_.end()) return known->second;
  Description description = model_.description();
  for (std::size_t k = 0; k < description.couplings.size(); ++k)
    description.couplings[k].name = coupling_name(description.couplings[k], k);
  for (std::size_t k = 0; k < all_.size(); ++k) {
    const Play& play = all_[k];
    if (side_[k] == 0) continue;
    auto coupling = std::ranges::find(description.couplings, play.name, &CouplingDescription::name);
    if (!play.joint.empty()) {
      const Joint& joint = model_.joint(model_.joint_index(play.joint));
      const std::string& own = joint.leader ? model_.joint(joint.leader->joint).name : joint.name;
      description.couplings.push_back({.name = play.name, .terms = {{own, play.terms[0].factor}}});
      coupling = description.couplings.end() - 1;
    }
    coupling->offset = play.offset + (side_[k] == upper ? play.upper : play.lower);
    coupling->play = coupling->restitution = 0;
  }
  return engaged_.emplace(side_, ModelBuilder(std::move(description)).build()).first->second;
}

double Plays::deflection(std::size_t k, Span q) const {
  double sum = -all_[k].offset;
  for (const LoopCoupling::Term& term : all_[k].terms)
    sum += term.factor * q[static_cast<std::size_t>(term.coordinate)];
  return sum;
}

double Plays::gap_to(std::size_t k, int side, Span q) const {
  return side == upper ? all_[k].upper - deflection(k, q) : deflection(k, q) - all_[k].lower;
}

double Plays::rate(std::size_t k, Span v) const {
  double sum = 0;
  for (const LoopCoupling::Term& term : all_[k].terms)
    sum += term.factor * v[static_cast<std::size_t>(term.velocity)];
  return sum;
}

double Plays::restitution(std::size_t k, double speed) const {
  return speed > threshold_ ? all_[k].restitution : 0;
}

double Plays::reserve(std::size_t k, Span q, const ClosedMotion* loops) const {
  return side_[k] == 0 ? nearer_gap(k, q) + overshoot_[k] + gap_resolution(k, q)
                       : -side_[k] * loops->multiplier(name(k));
}

void Plays::allow_overshoot(Span q) {
  for (std::size_t k = 0; k < size(); ++k) overshoot_[k] = std::max(0.0, -nearer_gap(k, q));
}

void Plays::reduce_overshoot(Span q) {
  for (std::size_t k = 0; k < size(); ++k)
    overshoot_[k] = std::min(overshoot_[k], std::max(0.0, -nearer_gap(k, q)));
}

double Plays::gap_resolution(std::size_t k, Span q) const {
  double size = std::abs(all_[k].offset);
  for (const double end : {all_[k].lower, all_[k].upper})
    if (std::isfinite(end)) size += std::abs(end);
  for (const LoopCoupling::Term& term : all_[k].terms)
    size += std::abs(term.factor * q[static_cast<std::size_t>(term.coordinate)]);
  constexpr double closed = 2e-13, rounding = 1e-14;  // what the projection of loops leaves open
  return closed + rounding * size;
}

void Plays::refuse_beyond(std::size_t k, Span q) const {
  const Play& play = all_[k];
  const double x = deflection(k, q);
  if (play.joint.empty())
    throw std::invalid_argument("coupling \"" + play.name + "\" is " + to_text(x) +
                                " from the middle of its play at the start; its play is " +
                                to_text(play.upper - play.lower) + " from end to end");
  throw std::invalid_argument("joint \"" + play.joint + "\" is at " + to_text(x) +
                              " at the start; its hard stops are at " + to_text(play.lower) + " and " +
                              to_text(play.upper));
}

Plays::Events Plays::start(Span q, std::span<double> v, const Engage& engage) {
  constexpr double tolerance = 1e-9;
  Events events;
  for (std::size_t k = 0; k < size(); ++k) {
    const int side = nearer_end(k, q);
    const double gap = nearer_gap(k, q), reach = std::abs(side == upper ? all_[k].upper : all_[k].lower);
    if (gap < -tolerance * (1 + reach)) refuse_beyond(k, q);
    if (gap > gap_resolution(k, q)) continue;
    if (!(side * rate(k, v) < 0)) events.push_back(meet_end(k, side, q, v, engage));
  }
  return events;
}

Plays::Events Plays::change(Span reserves, Span q, std::span<double> v, const Engage& engage) {
  std::vector<std::size_t> reaching;  // a play that leaves its end now does not meet it again
  Events events;
  for (std::size_t k = 0; k < size(); ++k) {
    if (!(reserves[k] < 0)) continue;
    if (side_[k] == 0)
      reaching.push_back(k);
    else
      events.push_back(leave_end(k));
  }
  if (!events.empty()) engage();
  for (const std::size_t k : reaching) {
    const int side = nearer_end(k, q);
    if (side * rate(k, v) > 0) events.push_back(meet_end(k, side, q, v, engage));
  }
  return events;
}

Plays::Events Plays::release_pulled(const ClosedMotion* loops) {
  Events events;
  for (std::size_t k = 0; k < size(); ++k)
    if (side_[k] != 0 && side_[k] * loops->multiplier(name(k)) > 0) events.push_back(leave_end(k));
  return events;
}

Trajectory::PlayEvent Plays::leave_end(std::size_t k) {
  return {.coupling = name(k), .side = std::exchange(side_[k], 0), .impact = false};
}

Trajectory::PlayEvent Plays::meet_end(std::size_t k, int side, Span q, std::span<double> v,
                                      const Engage& engage) {
  const double speed = side * rate(k, v), e = restitution(k, speed);
  side_[k] = side;
  std::vector<double> after;
  ClosedMotion* loops = nullptr;
  for (bool again = true; again;) {
    loops = engage();
    after.assign(v.begin(), v.end());
    if (!loops->bounce(q, e, after)) break;
    again = false;
    for (std::size_t j = 0; j < size(); ++j) {
      if (j == k || side_[j] == 0 || !(side_[j] * loops->multiplier(name(j)) > 0)) continue;
      side_[j] = 0;
      again = true;
    }
  }
  const Trajectory::PlayEvent event{.coupling = name(k),
                                    .side = side,
                                    .stays = e == 0,
                                    .speed = speed,
                                    .impulse = -side * loops->multiplier(name(k))};
  std::ranges::copy(after, v.begin());
  if (e == 0) return event;
  side_[k] = 0;
  engage();
  return event;
}

}  // namespace axode
