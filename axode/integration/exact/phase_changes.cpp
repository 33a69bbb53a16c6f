#include <algorithm>
#include <cmath>
#include <utility>

#include "axode/eigen.hpp"
#include "axode/integration/exact/contact_phase.hpp"
#include "axode/model/building/fault.hpp"
#include "axode/recursion/least_squares.hpp"
#include "axode/scalar/index.hpp"

/// The part of ContactPhase for the changes between phases.
namespace axode {
namespace {

constexpr double change_accepted = 1e-9, change_precise = 1e-15;  // certificates
/// Part of the largest velocity with the same energy up to which a constraint is at rest after an impact.
constexpr double at_rest_after = 1e-10;
/// The largest gap, divided by touching_, of points that touch after a change of points. Corners that have
/// passed an edge by no more than the rounding error of clipping count as such points.
constexpr double clipped = 20;

}  // namespace

void ContactPhase::set_directed_problem() {
  // The velocity that stands for a given direction is so large that accelerations do not turn it.
  constexpr double directed = 1e13;
  VelocityProblem& problem = system_.problem();
  problem.w = w_;
  problem.finish();
  const std::vector<double>& d2 = problem.squared_scales();
  double size = w_.norm();
  for (Eigen::Index row = 0; row < bias_.size(); ++row) {
    const std::size_t k = index(row);
    problem.r[k] = problem.moves(k) ? c_[k] * bias_[row] : 0;
    size = std::max(size, std::abs(problem.r[k]) / std::sqrt(d2[k]));
  }
  if (size == 0) size = 1;
  const std::size_t n = contacts_.size();
  for (std::size_t k = 0; k < system_.stops().size(); ++k) {
    const std::size_t row = index(problem.blocks()[n + k].first);
    if (!is_closed(ContactLaw::stop, k)) problem.r[row] = directed * size * std::sqrt(d2[row]);
  }
  for (std::size_t k = 0; k < closed.size(); ++k) {
    if (closed[k].branch != LawBranch::slide || !has_friction(k)) continue;
    const std::size_t row = index(row_of(k));
    const double far = directed * size * std::sqrt(d2[row]);
    if (closed[k].law == ContactLaw::dry_friction) {
      problem.r[row] = far * closed[k].along.x;
      continue;
    }
    std::array<double, LawBlock::most_rows - 1> s{};
    direction(k, s.data());
    for (std::size_t i = 0; i + 1 < index(system_.contact_rows()); ++i) problem.r[row + 1 + i] = far * s[i];
  }
}

std::string ContactPhase::decide(const Vector& q, const Vector& v, const Forces& forces) {
  if (std::string why = set_motion(q, v, forces); !why.empty()) return why;
  for (std::size_t k = 0; k < closed.size(); ++k)
    if (closed[k].law == ContactLaw::dry_friction && closed[k].branch == LawBranch::slide)
      closed[k].along = {u_[row_of(k)] < 0 ? -1.0 : 1.0, 0, 0};
  set_directed_problem();
  const VelocityProblem& problem = system_.problem();
  Vector lambda = Vector::Zero(problem.rows());
  solver_.reserve(problem.nv(), problem.rows());
  const VelocitySolution solution = solver_.solve(problem, lambda.data(), change_precise);
  if (!solution.holds(change_accepted))
    return "no accelerations were found that obey the laws of contact (certificate " +
           to_text(solution.certificate) + ")" + instead;
  x_ = w_;
  problem.add_product(1, lambda.data(), x_.data());
  Vector u = as_eigen(std::span<const double>(problem.r));
  problem.add_transposed(x_.data(), u.data());
  const double size = w_.norm() + (x_ - w_).norm();
  constexpr double at_rest = 1e-9;
  std::vector<char> opens(closed.size());
  for (std::size_t k = 0; k < closed.size(); ++k) {
    ClosedConstraint& c = closed[k];
    const int row = row_of(k);
    const double tolerance = at_rest * size * std::sqrt(problem.squared_scales()[index(row)]);
    if (c.law == ContactLaw::dry_friction) {
      if (c.branch == LawBranch::slide || !(std::abs(u[row]) > tolerance)) continue;
      c.branch = LawBranch::slide;
      c.along = {u[row] < 0 ? -1.0 : 1.0, 0, 0};
      continue;
    }
    opens[k] = u[row] > tolerance;
    if (opens[k] || c.law == ContactLaw::stop) continue;
    const int n = system_.contact_rows() - 1;
    std::array<double, LawBlock::most_rows - 1> s{};
    if (!has_friction(k)) {
      c.branch = LawBranch::slide;
      c.along = c.about = {};
      continue;
    }
    if (c.branch == LawBranch::slide) {
      direction(k, s.data());
      store_direction(k, s.data());
      continue;
    }
    const double speed = u.segment(row + 1, n).norm();
    if (!(speed > tolerance)) continue;
    for (int i = 0; i < n; ++i) s[index(i)] = u[row + 1 + i] / speed;
    c.branch = LawBranch::slide;
    store_direction(k, s.data());
  }
  std::size_t k = 0;
  std::erase_if(closed, [&](const ClosedConstraint&) { return opens[k++] != 0; });
  return {};
}

void ContactPhase::take_next(const std::vector<ClosedConstraint>& next) {
  std::vector<ClosedConstraint> begun = next;
  if (free_loads_.cols() > 0) closed.clear();  // the friction of each contact is arbitrary
  for (ClosedConstraint& c : begun) {
    if (c.law != ContactLaw::contact || c.branch != LawBranch::slide) continue;
    const auto old = std::ranges::find_if(closed, [&](const auto& x) { return x.same_as(c); });
    if (old == closed.end() || old->branch != LawBranch::stick) continue;
    const auto k = static_cast<std::size_t>(old - closed.begin());
    const int row = row_of(k), n = system_.contact_rows() - 1;
    std::array<double, LawBlock::most_rows - 1> s{};
    double squares = 0;
    for (int i = 0; i < n; ++i) {
      const double factor = c_[index(row + 1 + i)];
      s[index(i)] = factor > 0 ? -lambda_[row + 1 + i] / factor : 0;
      squares += s[index(i)] * s[index(i)];
    }
    if (!(squares > 0)) continue;
    for (double& x : s) x /= std::sqrt(squares);
    store_direction(k, s.data());
    // Contacts that do not slide away from their friction began to slide by the friction of others.
    constexpr double alike = 0.99;
    if (dot(closed[k].along, c.along) + dot(closed[k].about, c.about) < alike) continue;
    c.along = closed[k].along;
    c.about = closed[k].about;
  }
  closed = std::move(begun);
}

std::vector<int> ContactPhase::held_rows(bool of_places) const {
  std::vector<int> rows;
  for (std::size_t k = 0; k < closed.size(); ++k) {
    const ClosedConstraint& c = closed[k];
    const int row = row_of(k);
    const bool sticks = c.branch == LawBranch::stick && !of_places;
    if (c.law != ContactLaw::dry_friction || sticks) rows.push_back(row);
    if (c.law != ContactLaw::contact || !sticks) continue;
    for (int i = row + 1; i < row + system_.contact_rows(); ++i)
      if (c_[index(i)] > 0) rows.push_back(i);
  }
  const int loops = system_.first_loop_row();
  for (int row = loops; row < system_.problem().rows(); ++row)
    if (!of_places || system_.has_residual(index(row))) rows.push_back(row);
  constexpr double rounding = 1e-10;
  std::erase_if(rows,
                [&, least = rounding * largest_row()](int row) { return !(Y_.col(row).norm() > least); });
  return rows;
}

ContactPhase::Vector ContactPhase::correction(const std::vector<int>& rows, const Vector& u) const {
  const auto m = static_cast<Eigen::Index>(rows.size());
  Matrix R(Y_.rows(), m);
  Vector b(m);
  for (Eigen::Index j = 0; j < m; ++j) {
    R.col(j) = Y_.col(rows[index(j)]);
    const double size = R.col(j).norm();
    R.col(j) /= size;
    b[j] = -u[rows[index(j)]] / size;
  }
  // Rows that depend on each other where the loops are closed seem to be independent if they are a little
  // open.
  constexpr double dependent = 1e-5;
  return least_squares(R.transpose(), b, dependent);
}

std::string ContactPhase::project(Vector& q, Vector& v) {
  Vector change(model_.nv());
  for (int pass = 0;; ++pass) {
    if (std::string why = make_rows(q); !why.empty()) return why;
    const std::vector<int> rows = held_rows(true);
    Vector room = Vector::Zero(system_.problem().rows());
    const std::size_t unilateral = contacts_.size() + system_.stops().size();
    for (std::size_t k = 0; k < unilateral; ++k)
      room[system_.problem().blocks()[k].first] = system_.room()[k];
    for (int row = system_.first_loop_row(); row < room.size(); ++row)
      room[row] = system_.room()[unilateral + index(row - system_.first_loop_row())];
    double most = 0;
    for (const int row : rows) most = std::max(most, std::abs(room[row]));
    constexpr double closed_places = 1e-16, least_lost = 1e-6, roundings = 1e5;
    constexpr int passes = 3;
    if (most > std::max(least_lost, roundings * touching_))
      return "closed contacts, stops or loops come apart; use smaller tolerances";
    if (!(most > closed_places) || pass == passes) break;
    const Vector x = correction(rows, room);
    system_.push(x.data(), change.data());
    group_.move(q, change, q);
  }
  const std::vector<int> rows = held_rows(false);
  if (rows.empty()) return {};
  u_.resize(system_.problem().rows());
  system_.times(v.data(), u_.data());
  for (const PrescribedRow<double>& it : system_.prescribed()) u_[system_.first_loop_row() + it.row] -= it.ds;
  const Vector x = correction(rows, u_);
  system_.push(x.data(), change.data());
  v += change;
  return {};
}

std::string ContactPhase::overlap(const Vector& q, double most) {
  if (std::string why = find(q); !why.empty()) return why;
  for (const ContactPoint& at : finder_.points())
    if (at.gap < -most)
      return jets_.names(at.key) + " overlap by " + to_text(-at.gap) +
             " m, and the exact mode does not part them; begin without overlap, or use the method contact";
  for (std::size_t k = 0; k < system_.stops().size(); ++k) {
    const JointStop& stop = system_.stops()[k];
    const double room = stop.room(q.data());
    if (room < -most)
      return "joint \"" + name_of(ContactLaw::stop, k) + "\" is beyond its stop by " + to_text(-room) +
             "; begin within its limits, or use the method contact";
  }
  return {};
}

/// Lists what touches at q, and all dry joints, in `closed`, without branches.
void ContactPhase::list_touching(const Vector& q, double most) {
  std::vector<ClosedConstraint> touching;
  for (const ContactPoint& at : finder_.points())
    if (at.gap <= most || is_closed(ContactLaw::contact, at.key))
      touching.push_back({.law = ContactLaw::contact, .key = at.key});
  for (std::size_t k = 0; k < system_.stops().size(); ++k) {
    const JointStop& stop = system_.stops()[k];
    if (stop.room(q.data()) <= most || is_closed(ContactLaw::stop, k))
      touching.push_back({.law = ContactLaw::stop, .key = k, .branch = LawBranch::slide});
  }
  for (std::size_t k = 0; k < system_.dry_joints().size(); ++k)
    touching.push_back({.law = ContactLaw::dry_friction, .key = k});
  closed = std::move(touching);
}

void ContactPhase::set_velocities(const Vector& v) {
  u_.resize(system_.problem().rows());
  system_.times(v.data(), u_.data());
  Vector p(v.size());
  system_.momenta(v.data(), p.data());
  speed_ = std::sqrt(std::max(0.0, p.dot(v)));
}

void ContactPhase::choose_branch(std::size_t k, double of_motion) {
  const int row = row_of(k);
  double squares = 0, largest = 0;
  for (int i = row + 1; i < row + system_.contact_rows(); ++i) {
    squares += std::pow(c_[index(i)] * u_[i], 2);
    largest = std::max(largest, c_[index(i)] * Y_.col(i).norm());
  }
  const bool slides = std::sqrt(squares) > of_motion * speed_ * largest;
  closed[k].branch = slides || !has_friction(k) ? LawBranch::slide : LawBranch::stick;
  closed[k].along = closed[k].about = {};
}

void ContactPhase::select_slow(const Vector& v, double of_motion, bool& impacts) {
  set_velocities(v);
  impacts = false;
  std::vector<char> leaves(closed.size());
  for (std::size_t k = 0; k < closed.size(); ++k) {
    ClosedConstraint& c = closed[k];
    const int row = row_of(k);
    const double tolerance = of_motion * speed_ * Y_.col(row).norm();
    if (c.law == ContactLaw::dry_friction) {
      c.branch = std::abs(u_[row]) > tolerance ? LawBranch::slide : LawBranch::stick;
      continue;
    }
    leaves[k] = u_[row] > tolerance;
    impacts = impacts || u_[row] < -tolerance;
    if (c.law == ContactLaw::contact) choose_branch(k, of_motion);
  }
  std::size_t k = 0;
  std::erase_if(closed, [&](const ClosedConstraint&) { return leaves[k++] != 0; });
}

std::string ContactPhase::start(const Vector& q, const Vector& v, double most, bool& impacts) {
  if (std::string why = find(q); !why.empty()) return why;
  closed.clear();
  list_touching(q, most);
  if (std::string why = make_rows(q); !why.empty()) return why;
  constexpr double of_motion = 1e-11;
  select_slow(v, of_motion, impacts);
  return {};
}

std::string ContactPhase::impact(const Vector& q, Vector& v, const IsLast& is_last, std::vector<Impact>& met,
                                 double& certificate) {
  if (std::string why = find(q); !why.empty()) return why;
  list_touching(q, touching_);
  if (std::string why = make_rows(q, 0); !why.empty()) return why;
  VelocityProblem& problem = system_.problem();
  const Eigen::Index nv = model_.nv(), rows = problem.rows();
  u_.resize(rows);
  system_.times(v.data(), u_.data());
  Vector p(nv), x(nv), lambda = Vector::Zero(rows), after(rows), v_after(nv);
  system_.momenta(v.data(), p.data());
  speed_ = std::sqrt(std::max(0.0, p.dot(v)));
  system_.pull(p.data(), problem.w.data());
  problem.finish();
  // Stops that do not touch have so much room that they are not reached.
  constexpr double far = 1e6;
  for (std::size_t k = 0; k < system_.stops().size(); ++k) {
    const int row = problem.blocks()[contacts_.size() + k].first;
    problem.r[index(row)] = far * speed_ * Y_.col(row).norm();
  }
  for (const PrescribedRow<double>& it : system_.prescribed())
    problem.r[index(system_.first_loop_row() + it.row)] = -it.ds;
  std::vector<Impact> all(closed.size());
  std::vector<double> restitution(closed.size());
  for (std::size_t k = 0; k < closed.size(); ++k) {
    const ClosedConstraint& c = closed[k];
    if (c.law == ContactLaw::dry_friction) continue;
    const int row = row_of(k);
    all[k] = {c.law, c.key, -u_[row], false, false};
    const double e =
        c.law == ContactLaw::stop ? system_.stops()[c.key].restitution : contacts_[k].surface.restitution;
    problem.r[index(row)] = 0;
    if (!(e > 0 && u_[row] < -shapes().threshold())) continue;
    all[k].shortened = is_last({c.law, c.key, 0, u_[row], 0}, e);
    if (!all[k].shortened) restitution[k] = e;
  }
  const bool any = std::ranges::any_of(restitution, [](double e) { return e > 0; });
  solver_.reserve(problem.nv(), problem.rows());
  constexpr double rounding = 1e-12;
  for (double part = 1; part >= 0; part -= 0.25) {
    for (std::size_t k = 0; k < closed.size(); ++k)
      if (restitution[k] > 0) problem.r[index(row_of(k))] = part * restitution[k] * u_[row_of(k)];
    certificate = solver_.solve(problem, lambda.data(), change_precise).certificate;
    x = problem.w;
    problem.add_product(1, lambda.data(), x.data());
    system_.push(x.data(), v_after.data());
    system_.times(v_after.data(), after.data());
    double work = 0;
    for (Eigen::Index row = 0; row < rows; ++row)
      work += c_[index(row)] * lambda[row] * (u_[row] + after[row]) / 2;
    for (const PrescribedRow<double>& it : system_.prescribed())
      work -= lambda[system_.first_loop_row() + it.row] * it.ds;
    if (!any || work <= rounding * problem.w.squaredNorm()) break;
  }
  if (!(certificate <= change_accepted))
    return "no impulses were found that obey the laws of contact (certificate " + to_text(certificate) + ")" +
           instead;
  const double size = problem.w.norm() + (x - problem.w).norm();
  for (std::size_t k = 0; k < closed.size(); ++k) {
    const int row = row_of(k);
    const double tolerance = at_rest_after * size * Y_.col(row).norm();
    if (closed[k].law == ContactLaw::dry_friction || !(all[k].speed > tolerance)) continue;
    all[k].bounces = after[row] > tolerance;
    met.push_back(all[k]);
  }
  v = v_after;
  bool again = false;
  select_slow(v, at_rest_after, again);
  return {};
}

bool ContactPhase::has_closed(std::uint64_t key) const {
  return std::ranges::any_of(closed, [&](const ClosedConstraint& c) {
    return c.law == ContactLaw::contact && of_one_pair(c.key, key);
  });
}

std::string ContactPhase::points_at(const Vector& q, Points& out) {
  if (std::string why = find(q); !why.empty()) return why;
  constexpr double together = 1e3;  // times touching_
  out = {};
  std::vector<Vec3<>> near;
  for (const ContactPoint& at : finder_.points()) {
    if (!has_closed(at.key)) continue;
    out.keys.push_back(at.key);
    if (at.gap > clipped * touching_) continue;
    for (const Vec3<>& other : near) out.apart = out.apart && norm(other - at.point) > together * touching_;
    near.push_back(at.point);
  }
  return {};
}

std::string ContactPhase::replace_points(const Vector& q, const Vector& v,
                                         std::vector<ClosedConstraint>& lost) {
  if (std::string why = find(q); !why.empty()) return why;
  std::vector<std::uint64_t> changed;
  for (const ClosedConstraint& c : closed)
    if (c.law == ContactLaw::contact && !(point(c.key) && jets_.find(c.key, C_, everywhere)))
      changed.push_back(c.key);
  const auto has_changed = [&](std::uint64_t key) {
    return std::ranges::any_of(changed, [&](std::uint64_t old) { return of_one_pair(old, key); });
  };
  lost.clear();
  std::erase_if(closed, [&](const ClosedConstraint& c) {
    const bool changes = c.law == ContactLaw::contact && has_changed(c.key);
    if (changes) lost.push_back(c);
    return changes;
  });
  for (const ContactPoint& at : finder_.points())
    if (has_changed(at.key) && at.gap <= clipped * touching_)
      closed.push_back({.law = ContactLaw::contact, .key = at.key});
  if (std::string why = make_rows(q); !why.empty()) return why;
  set_velocities(v);
  constexpr double leaving = 1e-7;
  std::vector<char> leaves(closed.size());
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (!has_changed(closed[k].key)) continue;
    leaves[k] = u_[row_of(k)] > leaving * speed_ * Y_.col(row_of(k)).norm();
    choose_branch(k, at_rest_after);
  }
  std::size_t k = 0;
  std::erase_if(closed, [&](const ClosedConstraint&) { return leaves[k++] != 0; });
  std::erase_if(lost, [&](const ClosedConstraint& c) { return has_closed(c.key); });
  return {};
}

std::string ContactPhase::close(const std::vector<Gap>& touching, Vector& q, Vector& v) {
  for (const Gap& gap : touching)
    closed.push_back({.law = gap.law, .key = gap.key, .branch = LawBranch::slide});
  if (std::string why = project(q, v); !why.empty()) return why;
  bool impacts = false;
  select_slow(v, at_rest_after, impacts);
  return {};
}

}  // namespace axode
