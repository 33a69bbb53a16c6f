#include "axode/contact/law/contact_system.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/constraints/loop_system/rows_in_lanes.hpp"
#include "axode/scalar/index.hpp"

namespace axode {

ContactFrame contact_frame(const Vec3<>& n) noexcept {
  const double s = n.z >= 0 ? 1 : -1, c = -1 / (s + n.z), b = n.x * n.y * c;
  return {n, {1 + s * n.x * n.x * c, s * b, -s * n.x}, {b, s + n.y * n.y * c, -n.y}};
}

ContactFrame turned(const ContactFrame& axes, const Vec3<>& n) noexcept {
  const Vec3<> across = axes.t1 - dot(n, axes.t1) * n;
  const double length = norm(across);
  constexpr double parallel = 0.1;  // below: the old tangent is nearly the new normal
  if (!(length > parallel)) return contact_frame(n);
  const Vec3<> t1 = (1 / length) * across;
  return {n, t1, cross(n, t1)};
}

ContactSystem::ContactSystem(const Model& model, int contact_rows, std::size_t capacity, bool dry_friction)
    : model_(model),
      contact_rows_(contact_rows),
      loops_(model),
      problem_(model.nv()),
      armature_(tree().armature) {
  const Topology& topology = *tree().operator->();
  const std::size_t nv = index(model.nv()), bodies = index(model.n_bodies()) + 1;
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Joint& joint = model.joint(i);
    if (joint.leader || joint.nv != 1) continue;
    const Dof& dof = joint.dof[0];
    for (const auto& [limit, side] : {std::pair{dof.lower, 1.0}, std::pair{dof.upper, -1.0}})
      if (dof.hard_stops && std::isfinite(limit))
        stops_.push_back({joint.iq, joint.iv, limit, side, dof.restitution});
    if (dry_friction && dof.friction > 0) dry_.push_back({joint.iv, dof.friction});
  }
  root_body_.resize(bodies);
  for (int i = 1; i <= model.n_bodies(); ++i)
    root_body_[index(i)] = topology.parent[i] == 0 ? i : root_body_[index(topology.parent[i])];
  eliminated_at_.resize(nv);
  for (int i = 0; i <= model.n_bodies(); ++i)
    loops_.bodies().each_pivot(tree(), i,
                               [&](int c, const double&, const double&) { eliminated_at_[index(c)] = i; });
  const std::size_t loop_rows = index(model.loops().rows);
  const std::size_t blocks = capacity + stops_.size() + dry_.size() + loop_rows;
  problem_.reserve(blocks);
  J_.reserve(blocks * LawBlock::most_rows * nv);
  unit_.resize(nv);
  A_.resize(loop_rows * nv);
  residual_.resize(index(model.loops().residuals));
  for (const LoopPath& path : loops_.table().paths)
    for (int k = 0; k < path.rows.count; ++k) residual_rows_.push_back(k < path.residuals.count ? 1 : 0);
  room_.reserve(capacity + stops_.size() + loop_rows);
  active_.reserve(stops_.size());
  V_.resize(bodies);
  Pi_.resize(bodies);
  q_.assign(index(model.nq()), std::numeric_limits<double>::quiet_NaN());
  path_.reserve(bodies);
  support_.reserve(nv + 1);
  place_.resize(nv);
}

void ContactSystem::place(const double* q) noexcept {
  if (!q_.empty() && std::equal(q_.begin(), q_.end(), q)) return;
  std::copy_n(q, q_.size(), q_.begin());
  loops_.update_kinematics(q);
}

void ContactSystem::bias_forces(const double* q, const double* v, const Loads<>& loads, double* h) noexcept {
  std::ranges::fill(q_, std::numeric_limits<double>::quiet_NaN());
  loops_.move(q, v, loads, h);
}

void ContactSystem::poses(const double* q, SE3<>* C) noexcept {
  place(q);
  C[0] = {};
  for (int i = 1; i <= model_.n_bodies(); ++i) {
    const SE3<>& link = loops_.link(i).C;
    C[i] = {link.R, loops_.root_origins()[root_body_[index(i)]] + link.r};
  }
}

Solvability ContactSystem::set(const double* q, std::span<const Contact> contacts, double h,
                               double stop_margin, const double* resistance) {
  const auto follows = [](const Contact& contact) {
    return contact.surface.compliance && !contact.normal_impulse;
  };
  problem_.clear(static_cast<int>(std::ranges::count_if(contacts, follows)));
  J_.clear();
  room_.clear();
  active_.clear();
  ends_of_path_ = {-1, -1};
  place(q);
  armature_ = tree().armature;
  if (resistance)
    for (std::size_t c = 0; c < armature_.size(); ++c) armature_[c] += resistance[c];
  const Solvability verdict = loops_.factorize_with_armature(armature_.data());
  if (!verdict.ok()) return verdict;
  int compliance = model_.nv();
  for (const Contact& contact : contacts) {
    add_contact(contact, compliance);
    room_.push_back(contact.gap);
  }
  for (std::size_t k = 0; k < stops_.size(); ++k) {
    const JointStop& stop = stops_[k];
    const double room = stop.room(q);
    if (!(room < stop_margin)) continue;
    add_unit_row(ContactLaw::stop, stop.velocity, stop.side, 0);
    room_.push_back(room);
    active_.push_back(static_cast<int>(k));
  }
  for (const DryJoint& dry : dry_) add_unit_row(ContactLaw::dry_friction, dry.velocity, 1, h * dry.force);
  first_loop_row_ = problem_.rows();
  if (!model_.loops().empty()) add_loops(q);
  return verdict;
}

void ContactSystem::find_path(int a, int b) {
  if (ends_of_path_ == std::array{a, b}) return;
  ends_of_path_ = {a, b};
  const Topology& topology = *tree().operator->();
  path_.clear();
  for (int i = a, j = b; i > 0 || j > 0;) {
    const int k = std::max(i, j);
    path_.push_back({k, (j == k ? 1 : 0) - (i == k ? 1 : 0)});
    if (i == k) i = topology.parent[k];
    if (j == k) j = topology.parent[k];
  }
  support_.clear();
  const auto add = [&](int c, const double&, const double&) { support_.push_back(c); };
  for (auto on_path = path_.rbegin(); on_path != path_.rend(); ++on_path)
    loops_.bodies().each_pivot(tree(), on_path->body, add);
  loops_.bodies().each_pivot(tree(), 0, add);
  if (is_coupled()) std::ranges::sort(support_);
  for (std::size_t k = 0; k < support_.size(); ++k) place_[index(support_[k])] = static_cast<int>(k);
}

void ContactSystem::pull_row(int a, int b, const Wrench<Spatial>& on_a, const Wrench<Spatial>& on_b,
                             const double* x, double* Y) noexcept {
  auto& bodies = loops_.bodies();
  const Topology::Ties& ties = tree()->ties;
  const auto at_rest = [&](int i) {
    bodies.W[i] = {};
    for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t) bodies.u_tie[t] = 0;
  };
  at_rest(0);
  for (const PathBody& on_path : path_) at_rest(on_path.body);
  bodies.W[a] -= on_a;
  bodies.W[b] -= on_b;
  for (const PathBody& on_path : path_) bodies.backward_step(tree(), on_path.body, x);
  bodies.backward_step_at_ground(tree(), x);
  const auto put = [&](int c, const double& u, const double&) { Y[place_[index(c)]] = root(c) * u; };
  for (const PathBody& on_path : path_) bodies.each_pivot(tree(), on_path.body, put);
  bodies.each_pivot(tree(), 0, put);
}

double* ContactSystem::add_block(ContactLaw law, int rows, double bound, double*& Y, bool compliant) {
  const std::size_t size = support_.size() * index(rows), first = J_.size();
  J_.resize(first + size, 0.0);
  Y = problem_.add(law, rows, support_, bound, compliant);
  return J_.data() + first;
}

Wrench<Spatial> ContactSystem::at_root(int body, const Vec3<>& point,
                                       const Wrench<Spatial>& W) const noexcept {
  const Vec3<> O = body > 0 ? loops_.root_origins()[root_body_[index(body)]] : Vec3<>{};
  return {W.m + cross(point - O, W.f), W.f};
}

void ContactSystem::add_contact(const Contact& contact, int& compliance) {
  find_path(contact.a, contact.b);
  double* Y = nullptr;
  const bool pressed = contact.normal_impulse.has_value();
  const bool compliant = contact.surface.compliance && !pressed;
  if (compliant) support_.push_back(compliance++);
  double* J = add_block(pressed ? ContactLaw::pressed : ContactLaw::contact, contact_rows_,
                        contact.normal_impulse.value_or(0), Y, compliant);
  const SurfacePair& surface = contact.surface;
  const std::array<double, LawBlock::most_rows> factors{1,
                                                        surface.friction,
                                                        surface.friction,
                                                        surface.spin_friction,
                                                        surface.rolling_friction,
                                                        surface.rolling_friction};
  std::copy_n(factors.begin(), contact_rows_, problem_.c.end() - contact_rows_);
  add_rows(contact, J, Y);
  if (compliant) support_.pop_back();
}

void ContactSystem::add_rows(const Contact& contact, double* J, double* Y) noexcept {
  const std::size_t width = support_.size(), rows = index(contact_rows_);
  const ContactFrame frame = contact_frame(contact.normal);
  const std::array axes{frame.n, frame.t1, frame.t2};
  WrenchesOfRows on_a{}, on_b{};
  for (std::size_t k = 0; k < rows; ++k) {
    const Wrench<Spatial> force{{}, axes[k % 3]}, moment{axes[k % 3], {}};
    on_a[k] = at_root(contact.a, contact.point, k < 3 ? -force : -moment);
    on_b[k] = at_root(contact.b, contact.point, k < 3 ? force : moment);
  }
  if (is_coupled()) {
    const auto& bodies = loops_.bodies();
    for (const auto& [i, side] : path_) {
      if (side == 0) continue;
      const auto& on_body = side > 0 ? on_b : on_a;
      each_screw(i, [&](int c, int s) {
        double* entry = J + place_[index(c)];
        for (std::size_t k = 0; k < rows; ++k, entry += width) *entry += on_body[k] | bodies.S[s];
      });
    }
    for (std::size_t k = 0; k < rows; ++k, Y += width)
      pull_row(contact.a, contact.b, on_a[k], on_b[k], unit_.data(), Y);
    return;
  }
  each_register_of_rows<double>(contact_rows_, [&](int first, auto n) {
    const std::size_t at = index(first) * width;
    add_rows_in_lanes<n()>(on_a, on_b, first, J + at, Y + at);
  });
}

template <int n>
void ContactSystem::add_rows_in_lanes(const WrenchesOfRows& on_a, const WrenchesOfRows& on_b, int first,
                                      double* J, double* Y) noexcept {
  using Lanes = RowsInLanes<double, n>;
  const std::size_t width = support_.size();
  const auto& bodies = loops_.bodies();
  const Lanes of_a(on_a, first), of_b(on_b, first);
  Lanes left_of_a = of_a, left_of_b = of_b;  // what remains of them adds up where the paths meet
  bool met = false;
  for (const auto& [i, side] : path_) {
    if (side == 0 && !met) {
      left_of_b.m += left_of_a.m;
      left_of_b.f += left_of_a.f;
      met = true;
    }
    const Lanes& of = side < 0 ? of_a : of_b;
    Lanes& left = side < 0 ? left_of_a : left_of_b;
    each_screw_backwards(i, [&, side = side](int c, int s) {
      const auto w = Lanes::all(bodies.S[s].w), v = Lanes::all(bodies.S[s].v);
      const std::size_t at = index(place_[index(c)]);
      const double scale = root(c);
      if (side != 0) {
        const auto entry = dot(of.m, w) + dot(of.f, v);
        for (std::size_t k = 0; k < n; ++k) J[at + k * width] = entry[k];
      }
      const auto u = dot(left.m, w) + dot(left.f, v);
      std::array<double, n> y;
      left.eliminate(u, scale, y.data(), scale * (scale * u), bodies.U[s].m, bodies.U[s].f);
      for (std::size_t k = 0; k < n; ++k) Y[at + k * width] = y[k];
    });
  }
}

void ContactSystem::add_unit_row(ContactLaw law, int velocity, double side, double bound) {
  find_path(0, eliminated_at_[index(velocity)]);
  double* Y = nullptr;
  add_block(law, 1, bound, Y)[place_[index(velocity)]] = side;
  unit_[index(velocity)] = side;
  pull_row(0, 0, {}, {}, unit_.data(), Y);
  unit_[index(velocity)] = 0;
}

void ContactSystem::add_loops(const double* q) {
  loops_.make_rows(ConstraintLevel::velocity);
  loops_.factorize_rows();
  loops_.write(A_.data());
  const std::size_t first = room_.size();
  room_.resize(first + index(model_.loops().rows));
  loop_openings(q, room_.data() + first);
  ends_of_path_ = {-1, -1};
  for (const LoopPath& path : loops_.table().paths)
    for (int k = 0; k < path.rows.count; ++k) {
      const int row = path.rows.first + k;
      support_ = path.velocities;
      double* Y = nullptr;
      double* J = add_block(ContactLaw::loop, 1, 0, Y);
      for (const int c : support_) {
        *J++ = A_[index(row) * index(model_.nv()) + index(c)];
        *Y++ = loops_.Y()(c, row);
      }
    }
}

void ContactSystem::pull(const double* p, double* x) noexcept {
  auto& bodies = loops_.bodies();
  if (is_coupled()) {
    bodies.backward_sweep(tree(), p);
    const auto put = [&](int c, const double& u, const double&) { x[c] = root(c) * u; };
    for (int i = 0; i <= tree()->n; ++i) bodies.each_pivot(tree(), i, put);
    return;
  }
  Wrench<Spatial>* const W = bodies.W;
  for (int i = 0; i <= tree()->n; ++i) W[i] = {};
  for (int i = tree()->n; i > 0; --i) {
    each_screw_backwards(i, [&](int c, int s) {
      const double u = p[c] - (W[i] | bodies.S[s]);
      x[c] = root(c) * u;
      W[i] += (root(c) * x[c]) * bodies.U[s];
    });
    W[tree()->parent[i]] += W[i];
  }
}

void ContactSystem::push(const double* x, double* v) noexcept {
  auto& bodies = loops_.bodies();
  if (is_coupled()) {
    const auto put = [&](int c, double& u, const double& D) { u = root(c) * D * x[c]; };
    for (int i = 0; i <= tree()->n; ++i) bodies.each_pivot(tree(), i, put);
    bodies.forward_sweep(tree(), v);
    return;
  }
  Twist<Spatial>* const X = bodies.X;
  X[0] = {};
  for (int i = 1; i <= tree()->n; ++i) {
    X[i] = X[tree()->parent[i]];
    each_screw(i, [&](int c, int s) {
      v[c] = root(c) * (x[c] - root(c) * (bodies.U[s] | X[i]));
      X[i] += v[c] * bodies.S[s];
    });
  }
}

void ContactSystem::pull_velocities(const double* v, double* x) noexcept {
  if (is_coupled()) {
    momenta(v, x);
    pull(x, x);
    return;
  }
  auto& bodies = loops_.bodies();
  Twist<Spatial>* const X = bodies.X;
  X[0] = {};
  for (int i = 1; i <= tree()->n; ++i) {
    X[i] = X[tree()->parent[i]];
    each_screw(i, [&](int c, int s) {
      const double v_c = v[c];
      x[c] = root(c) * (bodies.D[s] * v_c + (bodies.U[s] | X[i]));
      X[i] += v_c * bodies.S[s];
    });
  }
}

void ContactSystem::times(const double* v, double* u) const noexcept {
  for (const VelocityProblem::Block& b : problem_.blocks()) {
    const double* J = J_.data() + b.columns;
    const std::span<const int> at = problem_.joint_support(b);
    for (int k = 0; k < b.rows; ++k, J += b.compliances) {
      double sum = 0;
      for (const int c : at) sum += *J++ * v[c];
      u[b.first + k] = sum;
    }
  }
}

void ContactSystem::add_transposed_times(const double* lambda, double* p) const noexcept {
  for (const VelocityProblem::Block& b : problem_.blocks()) {
    const double* J = J_.data() + b.columns;
    const std::span<const int> at = problem_.joint_support(b);
    for (int k = 0; k < b.rows; ++k, J += b.compliances)
      for (const int c : at) p[c] += *J++ * lambda[b.first + k];
  }
}

void ContactSystem::write(double* J) const noexcept {
  const std::size_t nv = index(model_.nv());
  std::fill_n(J, index(problem_.rows()) * nv, 0.0);
  for (const VelocityProblem::Block& b : problem_.blocks()) {
    const double* entry = J_.data() + b.columns;
    for (int k = 0; k < b.rows; ++k, entry += b.compliances)
      for (const int c : problem_.joint_support(b)) J[index(b.first + k) * nv + index(c)] = *entry++;
  }
}

void ContactSystem::momenta(const double* v, double* p, const Vec3<>& ground) noexcept {
  const auto& bodies = loops_.bodies();
  move_bodies(v, ground);
  for (int i = 1; i <= tree()->n; ++i) Pi_[index(i)] = bodies.M_body[i] * V_[index(i)];
  sum_subtrees(*tree().operator->(), Pi_.data());
  for (int c = 0; c < tree()->nv; ++c) p[c] = tree().armature[index(c)] * v[c];
  for (int i = 1; i <= tree()->n; ++i)
    each_screw(i, [&](int c, int s) { p[c] += Pi_[index(i)] | bodies.S[s]; });
}

void ContactSystem::move_bodies(const double* v, const Vec3<>& ground) noexcept {
  V_[0] = {{}, ground};
  for (int i = 1; i <= tree()->n; ++i) {
    Twist<Spatial>& V = V_[index(i)];
    V = V_[index(tree()->parent[i])];
    each_screw(i, [&](int c, int s) { V += v[c] * loops_.bodies().S[s]; });
  }
}

void ContactSystem::contact_velocity(const Contact& contact, const ContactFrame& axes,
                                     double* u) const noexcept {
  const auto velocity = [&](int body) {
    const Vec3<> O = body > 0 ? loops_.root_origins()[root_body_[index(body)]] : Vec3<>{};
    return V_[index(body)].v + cross(V_[index(body)].w, contact.point - O);
  };
  const Vec3<> at_point = velocity(contact.b) - velocity(contact.a);
  const Vec3<> turning = V_[index(contact.b)].w - V_[index(contact.a)].w;
  const auto& [n, t1, t2] = axes;
  const std::array<double, LawBlock::most_rows> rows{dot(n, at_point), dot(t1, at_point), dot(t2, at_point),
                                                     dot(n, turning),  dot(t1, turning),  dot(t2, turning)};
  std::copy_n(rows.begin(), contact_rows_, u);
}

double ContactSystem::speed(int body, double distance) const noexcept {
  if (body == 0) return 0;
  const Twist<Spatial>& V = V_[index(body)];
  return norm(V.v + cross(V.w, loops_.link(body).C.r)) + distance * norm(V.w);
}

void ContactSystem::loop_openings(const double* q, double* openings) noexcept {
  loops_.residual(q, residual_.data());
  for (const LoopPath& path : loops_.table().paths)
    for (int k = 0; k < path.rows.count; ++k)
      openings[path.rows.first + k] =
          k < path.residuals.count ? residual_[index(path.residuals.first + k)] : 0;
}

Wrench<Spatial> ContactSystem::on_ground(std::span<const Contact> contacts,
                                         const double* lambda) const noexcept {
  Wrench<Spatial> sum{};
  for (const Contact& contact : contacts) {
    const auto& [n, t1, t2] = contact_frame(contact.normal);
    const Vec3<> f = lambda[0] * n + lambda[1] * t1 + lambda[2] * t2;
    Vec3<> m;
    if (contact_rows_ > 3) m += lambda[3] * n;
    if (contact_rows_ > 4) m += lambda[4] * t1 + lambda[5] * t2;
    const Wrench<Spatial> W{m + cross(contact.point, f), f};
    if (contact.b == 0) sum += W;
    if (contact.a == 0) sum -= W;
    lambda += contact_rows_;
  }
  return sum;
}

}  // namespace axode
