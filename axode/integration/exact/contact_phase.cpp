#include "axode/integration/exact/contact_phase.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/eigen.hpp"
#include "axode/recursion/least_squares.hpp"
#include "axode/scalar/index.hpp"

namespace axode {
namespace {

/// Contacts for which memory is reserved.
constexpr std::size_t phase_capacity = 16;

}  // namespace

ContactPhase::ContactPhase(const Model& model, ContactShapes touching, bool dry_friction)
    : model_(model),
      group_(model_.tree<double>()),
      finder_(std::move(touching)),
      system_(model, finder_.shapes().contact_rows(), phase_capacity, dry_friction),
      jets_(finder_.shapes()),
      motion_(model),
      C_(index(model.n_bodies()) + 1) {
  double size = 0;
  const ContactShapes& shapes = finder_.shapes();
  for (int i = 0; i < shapes.size(); ++i)
    if (shapes[i].kind != ShapeKind::plane) size = std::max(size, shapes[i].convex.extent);
  constexpr double of_size = 1e-11, least = 1e-13;
  touching_ = std::max(of_size * size, least);
}

std::string ContactPhase::find(const Vector& q) {
  system_.poses(q.data(), C_.data());
  if (!finder_.find(C_, everywhere)) return "there are more points of contact than there is memory for";
  jets_.restart();
  return {};
}

const ContactPoint* ContactPhase::point(std::uint64_t key) const {
  const auto found = std::ranges::find(finder_.points(), key, &ContactPoint::key);
  return found == finder_.points().end() ? nullptr : &*found;
}

std::string ContactPhase::name_of(ContactLaw law, std::uint64_t key) const {
  if (law == ContactLaw::contact) return jets_.names(key);
  const int velocity =
      law == ContactLaw::stop ? system_.stops()[key].velocity : system_.dry_joints()[key].velocity;
  for (const Joint& joint : model_.joints())
    if (joint.nv == 1 && joint.iv == velocity) return joint.name;
  return {};
}

bool ContactPhase::is_closed(ContactLaw law, std::uint64_t key) const {
  return std::ranges::any_of(closed, [&](const auto& c) { return c.law == law && c.key == key; });
}

double ContactPhase::limit_of(const ClosedConstraint& c) const { return system_.dry_joints()[c.key].force; }

int ContactPhase::row_of(std::size_t k) const {
  const std::size_t n = contacts_.size();
  std::size_t block = k;  // contacts are the first entries of `closed`
  if (closed[k].law == ContactLaw::stop) block = n + closed[k].key;
  if (closed[k].law == ContactLaw::dry_friction) block = n + system_.stops().size() + closed[k].key;
  return system_.problem().blocks()[block].first;
}

std::string ContactPhase::make_rows(const Vector& q, double h) {
  points_change_ = false;
  if (std::string why = find(q); !why.empty()) return why;
  std::stable_partition(closed.begin(), closed.end(),
                        [](const auto& c) { return c.law == ContactLaw::contact; });
  contacts_.clear();
  const ContactShapes& shapes = finder_.shapes();
  for (const ClosedConstraint& c : closed) {
    if (c.law != ContactLaw::contact) break;
    const ContactPoint* at = point(c.key);
    points_change_ = !at;
    if (!at) return "the points at which " + jets_.names(c.key) + " touch change" + instead;
    contacts_.push_back({.a = shapes[at->a].body,
                         .b = shapes[at->b].body,
                         .point = at->point,
                         .normal = at->normal,
                         .gap = at->gap,
                         .surface = shapes.surface(at->a, at->b),
                         .key = at->key});
  }
  const Solvability verdict = system_.set(q.data(), contacts_, h);
  if (!verdict.ok()) return to_string(model_, verdict);
  const VelocityProblem& problem = system_.problem();
  Y_.setZero(model_.nv(), problem.rows());
  for (const VelocityProblem::Block& b : problem.blocks()) {
    const auto columns = problem.columns(b);
    const std::span<const int> at = problem.support(b);
    for (std::size_t i = 0; i < at.size(); ++i)
      Y_.row(at[i]).segment(b.first, b.rows) = columns.row(static_cast<Eigen::Index>(i));
  }
  c_ = problem.c;
  return {};
}

bool ContactPhase::has_friction(std::size_t k) const {
  if (closed[k].law != ContactLaw::contact) return closed[k].law == ContactLaw::dry_friction;
  const auto first = c_.begin() + row_of(k) + 1;
  return std::any_of(first, first + system_.contact_rows() - 1, [](double c) { return c > 0; });
}

std::array<double, LawBlock::most_rows - 1> ContactPhase::stored_direction(std::size_t k) const {
  const auto& [normal, t1, t2] = axes_of(k);
  const Vec3<>&along = closed[k].along, &about = closed[k].about;
  return {dot(along, t1), dot(along, t2), dot(about, normal), dot(about, t1), dot(about, t2)};
}

double ContactPhase::direction(std::size_t k, double* s) const {
  const int row = row_of(k), n = system_.contact_rows() - 1;
  const std::array<double, LawBlock::most_rows - 1> stored = stored_direction(k);
  double squares = 0, forward = 0, length = 0, across = 0, out = 0;
  for (int i = 0; i < n; ++i) {
    s[i] = c_[index(row + 1 + i)] * u_[row + 1 + i];
    squares += s[i] * s[i];
    forward += s[i] * stored[index(i)];
    length += stored[index(i)] * stored[index(i)];
  }
  const double speed = std::sqrt(squares);
  if (length == 0) {
    if (speed > 0)
      for (int i = 0; i < n; ++i) s[i] /= speed;
    return speed;
  }
  if (!(forward > 0)) {  // beyond the stop, where friction along -s would drive the contact aside
    std::copy_n(stored.begin(), n, s);
    return speed;
  }
  for (int i = 0; i < n; ++i) across += std::pow(s[i] - forward * stored[index(i)], 2);
  across = std::sqrt(across);
  const double turned = across > resolution ? 1 - resolution / across : 0;
  for (int i = 0; i < n; ++i) {
    const double along = forward * stored[index(i)];
    s[i] = along + turned * (s[i] - along);
    out += s[i] * s[i];
  }
  for (int i = 0; i < n; ++i) s[i] /= std::sqrt(out);
  return speed;
}

void ContactPhase::store_direction(std::size_t k, const double* s) {
  const auto& [normal, t1, t2] = axes_of(k);
  closed[k].along = s[0] * t1 + s[1] * t2;
  closed[k].about = {};
  if (system_.contact_rows() > 3) closed[k].about = s[2] * normal;
  if (system_.contact_rows() > 4) closed[k].about += s[3] * t1 + s[4] * t2;
}

std::string ContactPhase::set_motion(const Vector& q, const Vector& v, const Forces& forces) {
  if (std::string why = make_rows(q); !why.empty()) return why;
  const Eigen::Index nv = model_.nv(), rows = system_.problem().rows();
  u_.resize(rows);
  system_.times(v.data(), u_.data());
  w_.resize(nv);
  system_.momenta(v.data(), w_.data());
  speed_ = std::sqrt(std::max(0.0, w_.dot(v)));
  bias_.setZero(rows);
  system_.bias_forces(q.data(), v.data(), forces.loads, w_.data());
  if (!model_.loops().empty()) system_.loop_bias(bias_.data() + system_.first_loop_row());
  w_ = as_eigen(forces.tau) - w_;
  system_.pull(w_.data(), w_.data());
  if (contacts_.empty()) return {};
  motion_.run(q.data(), v.data(), v, Matrix::Zero(nv, 1));
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const ContactJet* jet = jets_.find(contacts_[k].key, C_, everywhere);
    points_change_ = !jet;
    if (!jet) return "contact of " + jets_.names(contacts_[k].key) + " has no closed form" + instead;
    const ContactChanges change = motion_.contact(*jet);
    std::array<double, LawBlock::most_rows> u{};
    bias_.segment(row_of(k), system_.contact_rows()) =
        motion_.row_velocities(*jet, change, axes_of(k), frame_changes(jet->normal, change.normal()),
                               system_.contact_rows(), u.data());
  }
  return {};
}

std::string ContactPhase::accelerate(const Vector& q, const Vector& v, const Forces& forces,
                                     std::span<double> a) {
  if (std::string why = set_motion(q, v, forces); !why.empty()) return why;
  const Eigen::Index nv = model_.nv(), rows = system_.problem().rows();
  active_.clear();
  constexpr double infinite = std::numeric_limits<double>::infinity();
  slips_.assign(closed.size(), infinite);
  speeds_.assign(closed.size(), infinite);
  lambda_.setZero(rows);
  Vector w = w_;
  const int n = system_.contact_rows() - 1;
  for (std::size_t k = 0; k < closed.size(); ++k) {
    const ClosedConstraint& c = closed[k];
    const int row = row_of(k);
    const bool slides = c.branch == LawBranch::slide;
    if (c.law == ContactLaw::dry_friction && slides) {
      slips_[k] = c.along.x * u_[row];
      speeds_[k] = std::abs(u_[row]);
      lambda_[row] = -c.along.x * limit_of(c);
      w += lambda_[row] * Y_.col(row);
      continue;
    }
    active_.push_back({k, row});
    if (c.law != ContactLaw::contact || !has_friction(k)) continue;
    if (slides) {
      std::array<double, LawBlock::most_rows - 1> s{};
      speeds_[k] = direction(k, s.data());
      const std::array<double, LawBlock::most_rows - 1> stored = stored_direction(k);
      slips_[k] = 0;
      for (int i = 0; i < n; ++i) {
        slips_[k] += c_[index(row + 1 + i)] * u_[row + 1 + i] * stored[index(i)];
        active_.back().friction[index(i)] = -c_[index(row + 1 + i)] * s[index(i)];
      }
    } else {
      for (int i = row + 1; i <= row + n; ++i)
        if (c_[index(i)] > 0) active_.push_back({k, i});
    }
  }
  for (int row = system_.first_loop_row(); row < rows; ++row) active_.push_back({closed.size(), row});
  constexpr double rounding = 1e-10;
  std::erase_if(active_, [&, least = rounding * largest_row()](const Active& it) {
    const int first = it.constraint < closed.size() ? row_of(it.constraint) : it.row;
    return !(Y_.col(it.row).norm() > least) || !(Y_.col(first).norm() > least);
  });

  const auto m = static_cast<Eigen::Index>(active_.size());
  Matrix R(nv, m), C(nv, m);
  Vector b(m);
  weights_.resize(m);
  for (Eigen::Index j = 0; j < m; ++j) {
    const Active& it = active_[index(j)];
    R.col(j) = C.col(j) = Y_.col(it.row);
    for (int i = 0; i < n; ++i)
      if (it.friction[index(i)] != 0) C.col(j) += it.friction[index(i)] * Y_.col(it.row + 1 + i);
    weights_[j] = R.col(j).norm();
    b[j] = -(R.col(j).dot(w) + bias_[it.row]) / weights_[j];
    R.col(j) /= weights_[j];
    C.col(j) /= weights_[j];
  }
  x_ = w;
  loads_.resize(m);
  free_loads_.resize(m, 0);
  loads_move_ = false;
  if (m > 0) {
    const Matrix G = R.transpose() * C;
    const Matrix inverse = least_squares(G, Matrix::Identity(m, m), rounding);
    Vector loads = inverse * b;
    loads += inverse * (b - G * loads);
    constexpr double consistent = 1e-6;
    if (!((b - G * loads).norm() <= consistent * (w.norm() + b.norm())))
      return "closed contacts, stops and loops hold each other in a way that no forces can" +
             std::string(instead);
    const Matrix left = Matrix::Identity(m, m) - inverse * G;
    const auto redundant = static_cast<Eigen::Index>(std::lround(left.trace()));
    if (redundant > 0) {
      const Matrix Q = Eigen::ColPivHouseholderQR<Matrix>(left).householderQ(), open = Q.leftCols(redundant);
      free_loads_ = weights_.cwiseInverse().asDiagonal() * open;
      loads_move_ = (C * open).norm() > consistent;
    }
    loads_ = loads.cwiseQuotient(weights_);
    if (loads_move_) share_loads();
    x_ += C * weights_.cwiseProduct(loads_);
  }
  system_.push(x_.data(), a.data());
  return {};
}

std::vector<LoadCondition> ContactPhase::load_conditions() const {
  std::vector<LoadCondition> conditions;
  for (Eigen::Index j = 0; j < loads_.size(); ++j) {
    const Active& it = active_[index(j)];
    if (it.constraint == closed.size()) continue;
    const ClosedConstraint& c = closed[it.constraint];
    const int first = row_of(it.constraint);
    if (it.row == first) {
      conditions.push_back(
          {.normal = static_cast<int>(j), .tangent = {}, .factors = {}, .weight = weights_[j]});
      if (c.law == ContactLaw::dry_friction) conditions.back().bound = limit_of(c);
      continue;
    }
    LoadCondition& cone = conditions.back();
    cone.tangent.push_back(static_cast<int>(j));
    cone.factors.conservativeResize(static_cast<Eigen::Index>(cone.tangent.size()));
    cone.factors[cone.factors.size() - 1] = 1 / c_[index(it.row)];
  }
  return conditions;
}

void ContactPhase::share_loads() {
  std::vector<Eigen::Index> normal;  // of contacts, among the loads
  for (Eigen::Index j = 0; j < loads_.size(); ++j)
    if (const Active& it = active_[index(j)];
        it.constraint < contacts_.size() && it.row == row_of(it.constraint))
      normal.push_back(j);
  Matrix R(Y_.rows(), std::ssize(normal));
  for (std::size_t k = 0; k < normal.size(); ++k)
    R.col(static_cast<Eigen::Index>(k)) = Y_.col(active_[index(normal[k])].row);
  Eigen::ColPivHouseholderQR<Matrix> rows(R.transpose());
  rows.setThreshold(1e-10);
  const Matrix Q = rows.householderQ();
  const auto unbalanced =
      Q.rightCols(R.cols() - rows.rank()).transpose();  // of loads that no compression has
  const Vector apart = unbalanced * loads_(normal);
  loads_ -= free_loads_ * least_squares(unbalanced * free_loads_(normal, Eigen::all), apart, 1e-10);
  const std::vector<LoadCondition> conditions = load_conditions();
  if (least_reserve(conditions, loads_) >= 0) return;
  Vector best = loads_;
  double low = 0, high = 1;  // parts of the way to the loads with the largest reserve, which is concave
  if (maximise_reserve(conditions, free_loads_, w_.norm(), best) > 0)
    for (int k = 0; k < std::numeric_limits<double>::digits; ++k) {
      const double part = (low + high) / 2;
      (least_reserve(conditions, loads_ + part * (best - loads_)) < 0 ? low : high) = part;
    }
  loads_ += high * (best - loads_);
}

double ContactPhase::reserve() {
  const double size = w_.norm() + x_.norm();
  Vector best = loads_;
  const double found = maximise_reserve(load_conditions(), free_loads_, size, best);
  if (!loads_move_) loads_ = best;
  for (Eigen::Index j = 0; j < loads_.size(); ++j) {
    const Active& it = active_[index(j)];
    lambda_[it.row] = loads_[j];
    for (int i = 0; i < system_.contact_rows() - 1; ++i)
      if (it.friction[index(i)] != 0) lambda_[it.row + 1 + i] = it.friction[index(i)] * loads_[j];
  }
  return size > 0 ? found / size : 0;
}

double ContactPhase::certificate() {
  set_directed_problem();
  const VelocityProblem& problem = system_.problem();
  std::vector<double> lambda(index(problem.rows())), scratch(2 * lambda.size() + index(problem.nv()));
  for (std::size_t k = 0; k < lambda.size(); ++k)
    lambda[k] = c_[k] > 0 ? lambda_[static_cast<Eigen::Index>(k)] / c_[k] : 0;
  return axode::certificate(problem, lambda.data(), scratch.data());
}

void ContactPhase::follow_directions(const Vector& v) {
  constexpr double certain = 1e3;  // times the resolution: a speed whose direction is known well
  u_.resize(system_.problem().rows());
  system_.times(v.data(), u_.data());
  for (std::size_t k = 0; k < closed.size(); ++k) {
    if (closed[k].law != ContactLaw::contact || closed[k].branch != LawBranch::slide || !has_friction(k))
      continue;
    std::array<double, LawBlock::most_rows - 1> s{};
    if (direction(k, s.data()) > certain * resolution) {
      closed[k].along = closed[k].about = {};
      direction(k, s.data());
    }
    store_direction(k, s.data());
  }
}

std::vector<ContactForce> ContactPhase::forces() {
  std::vector<ContactForce> all;
  const ContactShapes& shapes = finder_.shapes();
  for (const ContactPoint& at : finder_.points()) {
    const auto found = std::ranges::find_if(
        closed, [&](const ClosedConstraint& c) { return c.law == ContactLaw::contact && c.key == at.key; });
    if (found == closed.end() && !(at.gap < shapes.margin())) continue;
    const SurfacePair surface = shapes.surface(at.a, at.b);
    ContactForce& out = all.emplace_back(ContactForce{.a = at.a,
                                                      .b = at.b,
                                                      .body_a = shapes[at.a].body,
                                                      .body_b = shapes[at.b].body,
                                                      .point = at.point,
                                                      .normal = at.normal,
                                                      .gap = at.gap,
                                                      .friction = surface.friction,
                                                      .key = at.key});
    if (found == closed.end()) continue;
    const auto k = static_cast<std::size_t>(found - closed.begin());
    const double* f = lambda_.data() + row_of(k);
    const auto& [n, t1, t2] = axes_of(k);
    out.force = f[0] * n + f[1] * t1 + f[2] * t2;
    if (system_.contact_rows() > 3) out.moment = f[3] * n;
    if (system_.contact_rows() > 4) out.moment += f[4] * t1 + f[5] * t2;
    out.branch = found->branch;
  }
  return all;
}

std::string ContactPhase::gaps(const Vector& q, const Vector& v, const Vector& a, std::vector<Gap>& out) {
  if (std::string why = find(q); !why.empty()) return why;
  out.clear();
  const ContactShapes& shapes = finder_.shapes();
  if (!finder_.points().empty()) {
    motion_.run(q.data(), v.data(), v, a);
    system_.move_bodies(v.data());
  }
  for (const ContactPoint& at : finder_.points()) {
    if (is_closed(ContactLaw::contact, at.key)) continue;
    std::array<double, LawBlock::most_rows> u{};
    double ddg = std::numeric_limits<double>::quiet_NaN();
    if (const ContactJet* jet = jets_.find(at.key, C_, everywhere)) {
      const ContactChanges change = motion_.contact(*jet);
      ddg = motion_.row_velocities(*jet, change, contact_frame(jet->normal),
                                   frame_changes(jet->normal, change.normal()), 1, u.data())(0, 0);
    } else {
      const Contact contact{.a = shapes[at.a].body,
                            .b = shapes[at.b].body,
                            .point = at.point,
                            .normal = at.normal,
                            .gap = at.gap,
                            .surface = {}};
      system_.contact_velocity(contact, contact_frame(at.normal), u.data());
    }
    out.push_back({ContactLaw::contact, at.key, at.gap, u[0], ddg});
  }
  for (std::size_t k = 0; k < system_.stops().size(); ++k) {
    const JointStop& stop = system_.stops()[k];
    if (is_closed(ContactLaw::stop, k)) continue;
    out.push_back({ContactLaw::stop, k, stop.room(q.data()), stop.side * v[stop.velocity],
                   stop.side * a[stop.velocity]});
  }
  return {};
}

}  // namespace axode
