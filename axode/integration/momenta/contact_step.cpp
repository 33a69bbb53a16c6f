#include "axode/integration/momenta/contact_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/kinematics/check_arguments.hpp"
#include "axode/scalar/index.hpp"

namespace axode {
namespace {

// Certificates of steps that are accepted at all, of steps with rounding errors alone, and of solved
// problems.
constexpr double accepted = 1e-9, precise = 5e-13, of_solver = 1e-13;
/// Contacts for which memory is reserved.
constexpr std::size_t capacity = 64;

}  // namespace

ContactStep::ContactStep(ContactSimulationRun& run, const Model& model, ContactShapes touching,
                         bool dry_friction)
    : q(model.nq()),
      v(model.nv()),
      run_(&run),
      model_(model),
      group_(model_.tree<double>()),
      finder_(std::move(touching)),
      start_(model, finder_.shapes().contact_rows(), capacity, dry_friction),
      end_(model, finder_.shapes().contact_rows(), capacity, dry_friction),
      record_(finder_.shapes(), 2 * capacity),
      C_(index(model.n_bodies()) + 1),
      p_0_(model.nv()),
      p_a_(model.nv()),
      v_before_(model.nv()),
      v_after_(model.nv()),
      q_part_(model.nq()),
      v_part_(model.nv()) {
  if (dry_friction) refuse_gears(model);
  const ContactShapes& shapes = finder_.shapes();
  const std::size_t others = start_.system.stops().size() + start_.system.dry_joints().size() +
                             static_cast<std::size_t>(model.loops().rows);
  const std::size_t rows = capacity * static_cast<std::size_t>(start_.system.contact_rows()) + others;
  for (End* end : {&start_, &end_}) {
    end->contacts.reserve(capacity);
    for (std::vector<double>* x : {&end->lambda, &end->u, &end->u_after}) x->reserve(rows);
  }
  for (std::vector<double>* x : {&slip_, &openings_, &before_, &between_, &r_, &weights_, &scratch_})
    x->reserve(rows);
  for (std::vector<char>* x : {&slides_, &bounces_}) x->reserve(capacity + others);
  for (std::vector<Contact>* x : {&middle_, &found_}) x->reserve(capacity);
  remembered_.reserve(capacity);
  forgotten_.reserve(capacity);
  secants_.reserve(rows);
  for (End* end : {&start_, &end_}) {
    end->solver.reserve(model.nv(), static_cast<int>(rows));
    end->solver.keeps_factors = true;
  }
  for (int i = 0; i < shapes.size(); ++i)
    reach_of_shape_.push_back(norm(shapes[i].pose.r) + shapes[i].convex.extent);
  for (int i = 0; i < shapes.size(); ++i)
    if (shapes[i].kind != ShapeKind::plane) size_ = std::max(size_, shapes[i].convex.extent);
}

/// The gap (m) up to which a contact is closed: the rounding error of points at its distance from the origin.
double ContactStep::closed(const Contact& contact) const {
  constexpr double of_size = 1e-12, of_places = 32 * std::numeric_limits<double>::epsilon();
  return std::max(of_size * size_, of_places * (norm(contact.point) + size_));
}

bool ContactStep::overlaps(const Contact& contact) const {
  constexpr double parted = 100;
  return !contact.surface.compliance && contact.gap < -parted * closed(contact);
}

Failure ContactStep::run(double t, double h, const Vector& q_0, const Vector& v_0, const Vector& x_0) {
  constexpr int most_parts = 16;
  for (int parts = 1; parts <= most_parts; parts *= 4) {
    q_part_ = q_0;
    v_part_ = v_0;
    x_part_ = x_0;
    double worst = 0, slip = 0;
    kept.clear();
    bool any = false;
    record_.clear();
    for (int k = 0; k < parts; ++k) {
      if (Failure failure = attempt(t + k * h / parts, h / parts, q_part_, v_part_, x_part_)) return failure;
      if (!std::isfinite(certificate))
        return {t + k * h / parts,
                "the impulses of contacts are not finite; reduce speeds, stiffnesses or masses"};
      worst = std::max(certificate, worst);
      slip = std::max(unresolved, slip);
      any = any || touched;
      q_part_ = q;
      v_part_ = v;
      x_part_ = drive_states;
    }
    certificate = worst;
    unresolved = slip;
    touched = any;
    record_.finish(h);
    if (worst <= accepted) break;
  }
  return {};
}

void ContactStep::restart() noexcept {
  remembered_.clear();
  for (End* end : {&start_, &end_}) {
    end->lambda.clear();
    end->solver.forget_factors();
  }
  hard_ = false;
}

void ContactStep::continue_from(const ContactStep& other) {
  remembered_ = other.remembered_;
  h_of_remembered_ = other.h_of_remembered_;
  for (const auto& [end, from] : {std::pair{&start_, &other.start_}, std::pair{&end_, &other.end_}}) {
    end->lambda = from->lambda;
    end->solver.continue_from(from->solver);
  }
  hard_ = other.hard_;
}

/// An estimate of the largest distance (m) that a point of a shape moves in the step.
double ContactStep::reach(double h, const Vector& v_0) {
  const ContactShapes& shapes = finder_.shapes();
  start_.system.move_bodies(v_0.data());
  double fastest = 0;
  for (int i = 0; i < shapes.size(); ++i)
    fastest = std::max(fastest, start_.system.speed(shapes[i].body, reach_of_shape_[index(i)]));
  return 1.5 * h * (2 * fastest + h * norm(model_.gravity()));
}

Failure ContactStep::find(double margin, std::vector<Contact>& contacts, double t) {
  if (!finder_.find(C_, margin)) return {t, "there are more points of contact than there is memory for"};
  contacts.clear();
  const ContactShapes& shapes = finder_.shapes();
  for (const ContactPoint& point : finder_.points())
    contacts.push_back({.a = shapes[point.a].body,
                        .b = shapes[point.b].body,
                        .point = point.point,
                        .normal = point.normal,
                        .gap = point.gap,
                        .surface = shapes.surface(point.a, point.b),
                        .key = point.key});
  return {};
}

const Contact* ContactStep::with_key(const std::vector<Contact>& contacts, std::uint64_t key,
                                     std::size_t hint) {
  if (hint < contacts.size() && contacts[hint].key == key) return &contacts[hint];
  const auto found = std::ranges::find(contacts, key, &Contact::key);
  return found == contacts.end() ? nullptr : &*found;
}

Failure ContactStep::attempt(double t, double h, const Vector& q_0, const Vector& v_0, const Vector& x_0) {
  certificate = unresolved = 0;
  touched = false;
  if (Failure failure = run_->check_finite(t, q_0, v_0)) return failure;
  start_.system.prescribe(run_->motion_rows(t));
  end_.system.prescribe(run_->motion_rows(t + h));
  start_.system.poses(q_0.data(), C_.data());
  const double margin = finder_.shapes().margin() + reach(h, v_0);
  if (Failure failure = find(margin, start_.contacts, t)) return failure;
  constexpr double any_stop = std::numeric_limits<double>::infinity();
  // Impulses then have about the same effect in the problem as in the free motion (D11.13a).
  const Solvability verdict =
      start_.system.set(q_0.data(), start_.contacts, h / 2, any_stop, run_->resistance(h));
  if (Failure failure = run_->checked(t, verdict)) return failure;
  start_.system.momenta(v_0.data(), p_0_.data());
  run_->begin(t, h, q_0, v_0, x_0, start_.system.bodies());
  const bool free = start_.rows() == 0;
  if (Failure failure = free ? run_->fly(p_0_, 0) : move(t, h, v_0, margin)) return failure;
  run_->arrive(v_0);
  if (free) found_.clear();
  if (Failure failure = reach_end(t, h)) return failure;
  keep_start(h, q_0, v_0, margin);
  if (!free) {
    unresolved = unresolved_slip(h);
    if (Failure failure = land(t)) return failure;
  }
  run_->advance_drives(t, h, q_0, v_0, v, x_0, drive_states);
  if (free) {
    record_.locate({});
    return {};
  }
  remember(h);
  record();
  return separate(t, h);
}

void ContactStep::recall(End& end, std::size_t which) {
  const std::size_t width = index(end.system.contact_rows());
  // Stops, dry joints and loops keep their multipliers if their number is the same.
  const std::size_t old = end.lambda.size(), fresh = end.rows();
  std::vector<double>& lambda = before_;
  lambda.assign(fresh, 0.0);
  const std::size_t others = fresh - end.contacts.size() * width;
  if (old >= others)
    std::copy(end.lambda.end() - static_cast<std::ptrdiff_t>(others), end.lambda.end(),
              lambda.end() - static_cast<std::ptrdiff_t>(others));
  for (std::size_t k = 0; k < end.contacts.size(); ++k)
    for (const Remembered& known : remembered_)
      if (known.key == end.contacts[k].key)
        std::copy_n(known.guess[which].begin(), width,
                    lambda.begin() + static_cast<std::ptrdiff_t>(k * width));
  for (const VelocityProblem::Block& b : end.system.problem().blocks())
    if (b.law == ContactLaw::pressed) lambda[index(b.first)] = 0;
  end.lambda = lambda;
}

void ContactStep::remember(double h) {
  const std::size_t width = index(start_.system.contact_rows());
  remembered_.swap(forgotten_);
  remembered_.clear();
  for (std::size_t k = 0; k < start_.contacts.size(); ++k) {
    Remembered known{start_.contacts[k].key, {}, {}};
    auto& [at_start, at_end] = known.guess;
    std::copy_n(start_.lambda.begin() + static_cast<std::ptrdiff_t>(k * width), width, known.start.begin());
    at_start = known.start;
    const auto before = std::ranges::find(forgotten_, known.key, &Remembered::key);
    if (h == h_of_remembered_ && before != forgotten_.end() && before->start[0] > 0 &&
        2 * at_start[0] > before->start[0]) {
      constexpr double at_rest = 1e-10;  // smaller changes are rounding errors, which must not grow
      double most = 0;
      for (std::size_t row = 0; row < width; ++row)
        most = std::max(most, std::abs(at_start[row] - before->start[row]));
      if (most > at_rest * at_start[0])
        for (std::size_t row = 0; row < width; ++row) at_start[row] += at_start[row] - before->start[row];
    }
    if (const Contact* same = with_key(end_.contacts, known.key, k))
      std::copy_n(end_.lambda.begin() + (same - end_.contacts.data()) * static_cast<std::ptrdiff_t>(width),
                  width, at_end.begin());
    remembered_.push_back(known);
  }
  h_of_remembered_ = h;
}

void ContactStep::record() {
  record_.locate(found_);
  record_.add(start_.system.problem(), start_.contacts, start_.lambda.data(), slip_.data(), v.norm());
  record_.add(end_.system.problem(), end_.contacts, end_.lambda.data(), end_.u_after.data(), v.norm());
}

Failure ContactStep::solve(double t, End& end, std::vector<double>& lambda, double tolerance, double& e) {
  const VelocityProblem& problem = end.system.problem();
  end.solver.reserve(problem.nv(), problem.rows());
  interruption_ = {};
  const VelocitySolution solution = end.solver.solve(problem, lambda.data(), tolerance, [this, t] {
    interruption_ = run_->interruption(t);
    return !interruption_;
  });
  hard_ = solution.restarts > 0;
  e = solution.certificate;
  return interruption_;
}

/// Computes v_after = v_before + M⁻¹ Jᵀ λ, and the velocities of the rows after it.
void ContactStep::apply(End& end, const Vector& v_before, Vector& v_after) {
  end.x.setZero(end.system.problem().nv());
  end.system.problem().add_product(1, end.lambda.data(), end.x.data());
  end.system.push(end.x.data(), v_after.data());
  v_after += v_before;
  end.system.times(v_after.data(), end.u_after.data());
}

Failure ContactStep::move(double t, double h, const Vector& v_0, double margin) {
  constexpr int most = 25, first_fixed = 2, settled = 8, most_failed = 2, most_tangents = 6;
  constexpr double nearly_precise = 1e-11;
  VelocityProblem& problem = start_.system.problem();
  ContactSystem& system = start_.system;
  start_.u.resize(start_.rows());
  start_.u_after.resize(start_.rows());
  slip_.resize(start_.rows());
  openings_.assign(start_.rows(), 0.0);
  slides_.assign(start_.contacts.size(), 0);
  system.times(v_0.data(), start_.u.data());
  const double threshold = finder_.shapes().threshold();
  bounces_.clear();
  for (std::size_t k = 0; k < start_.contacts.size() + system.active_stops().size(); ++k) {
    const double e = k < start_.contacts.size() ? start_.contacts[k].surface.restitution
                                                : system.stops()[k - start_.contacts.size()].restitution;
    const double u = start_.u[index(problem.blocks()[k].first)];
    bounces_.push_back(e > 0 && u < -threshold);  // if it is closed at the end of the step
  }
  // Sets w to about the free velocities in the middle, which are the size of the problem.
  system.momenta(v_0.data(), start_.v.data(), h / 2 * model_.gravity());
  system.pull(start_.v.data(), problem.w.data());
  problem.finish();
  recall(start_, 0);
  int failed = 0;
  double least_error = std::numeric_limits<double>::infinity(), enough = 1e-4;
  for (int k = 0;; ++k) {
    if (k > first_fixed || hard_)
      if (Failure failure = run_->interruption(t)) return failure;
    if (Failure failure = fly(enough)) return failure;
    end_.system.poses(run_->q_middle.data(), C_.data());
    if (Failure failure = find(margin, middle_, t)) return failure;
    end_.system.move_bodies(run_->v_middle.data());
    for (std::size_t c = 0; c < start_.contacts.size(); ++c) {
      const std::size_t row = index(problem.blocks()[c].first);
      const Contact* same = with_key(middle_, start_.contacts[c].key, c);
      const Contact& contact = same ? *same : start_.contacts[c];
      const ContactFrame axes = turned(contact_frame(start_.contacts[c].normal), contact.normal);
      end_.system.contact_velocity(contact, axes, &slip_[row]);
    }
    end_.system.poses(run_->q_end.data(), C_.data());
    if (Failure failure = find(margin, found_, t + h)) return failure;
    const bool tangents = k == 0 || (problem.nv() > model_.nv() && k < most_tangents);
    if (tangents) {
      set_compliances(h);
      weights_.clear();
      for (const double d2 : problem.squared_scales()) weights_.push_back(1 / std::sqrt(d2));
    }
    const bool chosen = set_r_of_start(h, k < first_fixed);
    certificate = law_error();
    if (certificate <= rounding_error(h)) certificate = std::min(certificate, precise);
    const bool stalled = certificate >= 0.5 * least_error;
    if (certificate <= precise || k >= most || failed == most_failed ||
        (stalled && k >= first_fixed && certificate <= (k > settled ? accepted : nearly_precise))) {
      if (run_->is_exact()) return {};
      enough = 0;
      continue;
    }
    least_error = std::min(least_error, certificate);
    enough = 1e-5 * certificate;
    if (tangents || chosen)
      secants_.restart();
    else
      secants_.update(r_, weights_, problem.r);
    r_ = problem.r;
    double e = 0;
    if (Failure failure = solve(t, start_, start_.lambda, of_solver, e)) return failure;
    failed = e <= accepted ? 0 : failed + 1;
  }
}

/// Computes the free motion after the impulses at the start of the step, see ContactSimulationRun::fly().
Failure ContactStep::fly(double enough) {
  const VelocityProblem& problem = start_.system.problem();
  for (std::size_t k = 0; k < start_.rows(); ++k) start_.u_after[k] = problem.c[k] * start_.lambda[k];
  p_a_ = p_0_;
  start_.system.add_transposed_times(start_.u_after.data(), p_a_.data());
  return run_->fly(p_a_, enough);
}

/// Selects for end_.contacts those of found_ that are closed or had an impulse at the start.
void ContactStep::select_active() {
  end_.contacts.clear();
  for (std::size_t k = 0; k < found_.size(); ++k) {
    const Contact* same = with_key(start_.contacts, found_[k].key, k);
    const double normal_impulse = same
                                      ? start_.lambda[index(start_.system.contact_rows()) *
                                                      static_cast<std::size_t>(same - start_.contacts.data())]
                                      : 0;
    const bool compliant(found_[k].surface.compliance);
    if (!(normal_impulse > 0 || (!compliant && found_[k].gap <= closed(found_[k])))) continue;
    end_.contacts.push_back(found_[k]);
    if (compliant) end_.contacts.back().normal_impulse = normal_impulse;
  }
}

Failure ContactStep::reach_end(double t, double h) {
  select_active();
  q = run_->q_end;
  const Solvability verdict = end_.system.set(q.data(), end_.contacts, h / 2, ContactPart::near_stop);
  if (Failure failure = run_->checked(t + h, verdict)) return failure;
  end_.system.pull(run_->p_end.data(), end_.x.data());
  end_.system.push(end_.x.data(), v_before_.data());
  run_->leave_moving_frames(v_before_);
  v = v_before_;
  return run_->check_finite(t + h, q, v);
}

Failure ContactStep::land(double t) {
  touched = std::ranges::any_of(start_.lambda, [](double x) { return x != 0; });
  VelocityProblem& problem = end_.system.problem();
  if (problem.rows() == 0) return {};
  end_.u.resize(end_.rows());
  end_.u_after.resize(end_.rows());
  end_.system.times(v.data(), end_.u.data());
  end_.system.pull_velocities(v.data(), problem.w.data());
  problem.finish();
  recall(end_, 1);
  const double before = certificate;
  const bool any_bounces = std::ranges::any_of(bounces_, [](char x) { return x != 0; });
  for (double bounciness = 1; bounciness >= 0; bounciness -= 0.25) {
    set_r_of_end(bounciness);
    if (Failure failure = solve(t, end_, end_.lambda, precise, certificate)) return failure;
    certificate = std::max(certificate, before);
    problem.complete(end_.lambda.data());
    apply(end_, v_before_, v);
    constexpr double rounding = 1e-12;
    keep_end(bounciness);
    if (!any_bounces) break;
    double sum = 0;
    if (Failure failure = work(t, sum)) return failure;
    if (sum <= rounding * problem.w.squaredNorm()) break;
  }
  touched = true;
  return {};
}

/// Computes the work (J) of the impulses of the step, except the normal ones of compliant contacts: each
/// impulse times the mean of the velocities before and after it. For a prescribed motion the impulse times
/// the prescribed velocity, which is the work of its drive, is subtracted.
Failure ContactStep::work(double t, double& sum) {
  sum = 0;
  between_.resize(start_.rows());
  if (Failure failure = run_->velocity(t, q_part_, p_a_, v_after_)) return failure;
  start_.system.times(v_after_.data(), between_.data());
  const auto add = [&](const End& end, const std::vector<double>& after) {
    for (const VelocityProblem::Block& b : end.system.problem().blocks()) {
      // A compliance gives back what it has taken, so that its normal impulse is left out.
      const bool compliant = b.law == ContactLaw::pressed || b.compliances > 0;
      for (std::size_t k = index(b.first) + (compliant ? 1 : 0); k < index(b.first + b.rows); ++k)
        sum += end.system.problem().c[k] * end.lambda[k] * (end.u[k] + after[k]) / 2;
    }
    for (const PrescribedRow<double>& it : end.system.prescribed()) {
      const std::size_t k = index(end.system.first_loop_row() + it.row);
      sum -= end.system.problem().c[k] * end.lambda[k] * it.ds;
    }
  };
  add(start_, between_);
  add(end_, end_.u_after);
  return {};
}

Failure ContactStep::separate(double t, double h) {
  if (std::ranges::none_of(found_, [&](const Contact& contact) { return overlaps(contact); })) return {};
  std::erase_if(found_, [](const Contact& contact) { return bool(contact.surface.compliance); });
  for (Contact& contact : found_) contact.surface = {};
  // Dry friction does not resist the displacements that remove overlaps: its bound is 0.
  if (Failure failure = run_->checked(t + h, end_.system.set(q.data(), found_, 0))) return failure;
  VelocityProblem& problem = end_.system.problem();
  const double most = 5 * finder_.shapes().threshold() * h;
  problem.w.setZero();
  const std::span<const double> room = end_.system.room();
  const std::size_t unilateral = found_.size() + end_.system.active_stops().size();
  for (std::size_t k = 0; k < unilateral; ++k)
    problem.r[index(problem.blocks()[k].first)] = std::max(room[k], -most);
  const std::size_t first = index(end_.system.first_loop_row());
  for (std::size_t row = first; row < problem.r.size(); ++row)
    problem.r[row] = room[unilateral + row - first];
  problem.finish();
  between_.assign(problem.r.size(), 0.0);
  double e = 0;
  if (Failure failure = solve(t, end_, between_, 1e-12, e)) return failure;
  if (!(e <= accepted)) return {};
  end_.x.setZero(problem.nv());
  problem.add_product(1, between_.data(), end_.x.data());
  end_.system.push(end_.x.data(), end_.v.data());
  if (keep_parts) {
    kept.back().apart = found_;
    kept.back().lambda_apart = between_;
    kept.back().most_apart = most;
  }
  group_.move(q, end_.v, q);
  return {};
}

void ContactStep::keep_start(double h, const Vector& q_0, const Vector& v_0, double margin) {
  if (!keep_parts) return;
  const bool rows = start_.rows() > 0;
  ContactPart part{.h = h,
                   .margin = margin,
                   .q_0 = q_0,
                   .v_0 = v_0,
                   .q_middle = run_->q_middle,
                   .v_middle = run_->v_middle,
                   .q_1 = run_->q_end,
                   .v_before_end = v_before_,
                   .v_1 = v_before_,
                   .start = start_.contacts};
  run_->bases().each([&](int body, bool constant) { part.bases.push_back({body, constant}); });
  if (rows) {
    part.lambda_start = start_.lambda;
    part.slides = slides_;
    part.bounces = bounces_;
  }
  for (const Contact& contact : part.start) part.overlaps.push_back(overlaps(contact));
  kept.push_back(std::move(part));
}

void ContactStep::keep_end(double bounciness) {
  if (!keep_parts) return;
  kept.back().v_1 = v;
  kept.back().end = end_.contacts;
  for (Contact& contact : kept.back().end) contact.normal_impulse.reset();  // the derivative knows its law
  kept.back().lambda_end = end_.lambda;
  kept.back().bounciness = bounciness;
}

}  // namespace axode
