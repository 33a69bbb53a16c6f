#include "axode/constraints/loop_system/loop_system.hpp"

#include <algorithm>
#include <limits>

#include "axode/recursion/instantiate.hpp"

namespace axode {
template <class T>
LoopSystem<T>::LoopSystem(const Model& of)
    : model_(of),
      dynamics_(of.topology()),
      fast_(std::make_unique<WithScratch<T, FastKernel>>(of.topology())),
      table_(of),
      at_(of.loops().joints.size()),
      entries_(of.loops().all.size()),
      drives_(of, table_),
      driven_(index(of.nv())) {
  const int m = of.loops().rows, nv = of.nv();
  for (std::size_t k = 0; k < entries_.size(); ++k)
    for (const LoopColumn& column : table_.paths[k].columns)  // entries of couplings are constant and set
                                                              // here; all others are set by make_entries()
      entries_[k].resize(entries_[k].size() + index(table_.paths[k].rows.count), T(column.factor));
  const Eigen::Index room = RowCholesky<T>::room(m);
  Y_.setZero(nv, room);
  G_.setZero(m, room);
  factor_.resize(m);
  left_.setZero(nv, room);
  along_.setZero(room);
  basis_.resize(nv, std::min(nv, m));
  for (Vector* const x : {&scale_, &b_, &lambda_, &rest_}) x->resize(m);
  for (Vector* const x : {&forces_, &w_, &root_}) x->resize(nv);
  step_.setZero(room);
  moved_.resize(room);
  zero_.setZero(nv);
}

template <class T> LoopSystem<T>::~LoopSystem() = default;

template <class T>
Solvability LoopSystem<T>::accelerate(const T* q, const T* v, const T* tau, const Loads<T>& loads, T* a,
                                      T* lambda, const RowRank& rank) noexcept {
  const int nv = model_.nv();
  if (accelerate_fast(q, v, tau, loads, a, lambda, rank)) return solved({}, nv, a);
  move(q, v, loads, forces_.data());
  for (int c = 0; c < nv; ++c) forces_[c] = tau[c] - forces_[c];
  const Solvability verdict = prepare(ConstraintLevel::velocity, q, rank);
  if (verdict.ok()) {
    bias(b_.data());
    add_response(forces_.data(), b_.data());
    solve_rows(b_.data(), lambda, rank);
    push(lambda, forces_.data());
  } else {
    std::fill_n(lambda, size(ConstraintLevel::velocity), std::numeric_limits<T>::quiet_NaN());
  }
  std::copy_n(forces_.data(), nv, a);
  return solved(verdict, nv, a);
}

template <class T>
Solvability LoopSystem<T>::impact(const T* q, const T* v, const T& e, T* v_after, T* impulses) noexcept {
  const Solvability verdict = factorize(q);
  if (verdict.ok()) return impact(v, e, v_after, impulses);
  std::fill_n(impulses, size(ConstraintLevel::velocity), std::numeric_limits<T>::quiet_NaN());
  return solved(verdict, model_.nv(), v_after);
}

template <class T>
Solvability LoopSystem<T>::impact(const T* v, const T& e, T* v_after, T* impulses,
                                  const RowRank& rank) noexcept {
  const int nv = model_.nv();
  make_entries();
  velocity_residual(v, b_.data());
  b_ *= T(1) + e;
  solve_rows(b_.data(), impulses, rank);
  w_.setZero();
  push(impulses, forces_.data());
  for (int c = 0; c < nv; ++c) v_after[c] = v[c] + forces_[c];
  return solved({}, nv, v_after);
}

template <class T>
Solvability LoopSystem<T>::projection_step(const T* q, T* x, const RowRank& rank) noexcept {
  update_kinematics(q);
  const Solvability verdict = prepare(ConstraintLevel::position, q, rank);
  if (verdict.ok()) {
    residual(q, b_.data());
    solve_rows(b_.data(), lambda_.data(), rank);
    w_.setZero();
    push(lambda_.data(), x);
  }
  return solved(verdict, model_.nv(), x);
}

template <class T>
Solvability LoopSystem<T>::prepare(ConstraintLevel level, const T* q, const RowRank& rank) noexcept {
  const Solvability verdict = factorize();
  if (verdict.ok()) {
    set_filter(q, rank);
    make_wrenches(level);
    factorize_rows();
  }
  return verdict;
}

template <class T> void LoopSystem<T>::update_kinematics(const T* q) noexcept {
  auto& links = dynamics_->bodies.links;
  links.run(tree(), q);
  link_ = links.link;
  origin_ = links.origin;
  update_loops();
}

template <class T> void LoopSystem<T>::update_kinematics(const SE3<T>* C, const Vec3<T>& origin) noexcept {
  const Topology& topology = *tree().operator->();
  auto& links = dynamics_->bodies.links;
  link_ = links.link;
  origin_ = links.origin;
  link_[0] = Link<Spatial, T>::root();
  each_root(topology, [&](int root) {
    origin_[root] = origin + C[root].r;
    for (int i = root; i < topology.subtree_end[root]; ++i) link_[i] = {{C[i].R, C[i].r - C[root].r}};
  });
  update_loops();
}

template <class T>
void LoopSystem<T>::force(const T* q, const T* v, const T* a, const Loads<T>& loads, T* tau) noexcept {
  auto& recursion = dynamics_->recursion;
  recursion.run(tree(), q, v, a, loads);
  recursion.project(tree(), v, a, loads.joint_losses, tau);
  link_ = recursion.motion.bodies.link;
  origin_ = recursion.origin;
  dynamics_->bodies.links.link = link_;
  update_loops();
}

template <class T> std::span<const T> LoopSystem<T>::acceleration_residual(const T* a) noexcept {
  const auto* const V = dynamics_->recursion.motion.bodies.V;
  const auto* const dV = dynamics_->recursion.motion.bodies.dV;
  table_.each([&](std::size_t k, const auto& joint) {
    loops::bias(joint, at_[k].frames, at_[k].W.data(), motion_of_ends(k, V, dV),
                rest_.data() + table_.paths[k].rows.first);
  });
  for (const LoopPath& path : table_.of_couplings()) {
    T& row = rest_[path.rows.first];
    row = T(0);
    for (const LoopColumn& column : path.columns) row += T(column.factor) * a[column.velocity];
  }
  for (const PrescribedRow<T>& it : prescribed_) rest_[it.row] -= it.dds;
  return {rest_.data(), index(model_.loops().rows)};
}

template <class T>
bool LoopSystem<T>::drive_forces(std::span<const int> drives, const T* f, T* tau, T* lambda) noexcept {
  const T least = considerable_entry();
  if (drives.empty()) return drives_.solve(entries_, least, model_.loops().driven.data(), f, tau, lambda);
  std::ranges::fill(driven_, 0);
  for (const int c : drives) driven_[index(c)] = 1;
  return drives_.solve(entries_, least, driven_.data(), f, tau, lambda);
}

template <class T> T LoopSystem<T>::considerable_entry() const noexcept {
  T square(0);
  for (const State& at : at_)
    square = std::max({square, dot(at.frames.a.r, at.frames.a.r), dot(at.frames.b.r, at.frames.b.r)});
  constexpr T shortest = T(1e-6);  // shorter levers count as 0
  const T lever = sqrt(square);
  return T(0.1) * (lever > shortest ? std::min(T(1), lever) : T(1));
}

template <class T> void LoopSystem<T>::update_loops() noexcept {
  joint_columns(tree(), link_, dynamics_->bodies.S);
  update_loop_ends();
}

template <class T> void LoopSystem<T>::update_loop_ends() noexcept {
  for (std::size_t k = 0; k < at_.size(); ++k) {
    const LoopPath& path = table_.paths[k];
    const Vec3<T> O = origin(k);
    at_[k].frames = {pose(path.ends[0], path.root[0], O), pose(path.ends[1], path.root[1], O)};
    at_[k].shift = path.root[0] > 0 ? origin_[path.root[0]] - O : Vec3<T>{};
  }
}

template <class T> Vec3<T> LoopSystem<T>::origin(std::size_t k) const noexcept {
  const auto& [i, j] = table_.paths[k].root;
  return i + j == 0 ? Vec3<T>{} : origin_[j > 0 ? j : i];
}

template <class T>
SE3<T> LoopSystem<T>::pose(const Loop::End& end, int root, const Vec3<T>& O) const noexcept {
  const SE3<T> F = cast<T>(end.F);
  if (root == 0) return {F.R, F.r - O};
  const SE3<T> C = link_[end.body].C * F;
  return {C.R, C.r + (origin_[root] - O)};
}

template <class T> void LoopSystem<T>::residual(const T* q, T* r) const noexcept {
  table_.each([&](std::size_t k, const auto& joint) {
    joint.residual(at_[k].frames, r + table_.paths[k].residuals.first);
  });
  for (const LoopCoupling& coupling : model_.loops().couplings) {
    T& out = r[coupling.first_residual];
    out = T(-coupling.offset);
    for (const LoopCoupling::Term& term : coupling.terms) out += T(term.factor) * q[term.coordinate];
  }
  for (const PrescribedRow<T>& it : prescribed_) r[it.residual] -= it.s;
}

template <class T> void LoopSystem<T>::velocity_residual(const T* v, T* out) const noexcept {
  times(v, out);
  for (const PrescribedRow<T>& it : prescribed_) out[it.row] -= it.ds;
}

template <class T> void LoopSystem<T>::make_rows(ConstraintLevel level) noexcept {
  make_wrenches(level);
  make_entries();
}

template <class T> void LoopSystem<T>::make_wrenches(ConstraintLevel level) noexcept {
  if (level != level_) Y_.setZero();  // the columns of Y now belong to other rows
  level_ = level;
  if (level == ConstraintLevel::velocity) {
    table_.each([&](std::size_t k, const auto& joint) { joint.wrenches(at_[k].frames, at_[k].W.data()); });
  } else {
    table_.each([&](std::size_t k, const auto& joint) {
      loops::residual_wrenches(joint, at_[k].frames, at_[k].W.data());
    });
  }
}

template <class T> void LoopSystem<T>::make_entries() noexcept {
  for (std::size_t k = 0; k < at_.size(); ++k) {
    const LoopPath& path = table_.paths[k];
    each_register_of_rows<T>(count(path), [&](int row, auto n) {
      using Wrenches = RowsInLanes<T, n()>;
      const Wrenches second(at_[k].W, row);
      Wrenches first = -second;
      first.move(-at_[k].shift);
      T* entry = entries_[k].data() + row;
      for (const LoopColumn& column : path.columns) {
        const Twist<Spatial, T>& J = dynamics_->bodies.S[column.screw];
        const Wrenches& F = column.side > 0 ? second : first;
        const auto rates = dot(Wrenches::all(J.w), F.m) + dot(Wrenches::all(J.v), F.f);
        for (std::size_t r = 0; r < n(); ++r) entry[r] = rates[r];
        entry += count(path);
      }
    });
  }
}

template <class T> void LoopSystem<T>::write(T* A) const noexcept {
  std::fill_n(A, static_cast<std::ptrdiff_t>(size(level_)) * model_.nv(), T(0));
  each_entry([&](int row, int c, const T& entry) {
    A[static_cast<std::ptrdiff_t>(row) * model_.nv() + c] += entry;
  });
}

template <class T> void LoopSystem<T>::times(const T* x, T* out) const noexcept {
  std::fill_n(out, size(level_), T(0));
  each_entry([&](int row, int c, const T& entry) { out[row] += entry * x[c]; });
}

template <class T> void LoopSystem<T>::add_transposed_times(const T* lambda, T* out) const noexcept {
  each_entry([&](int row, int c, const T& entry) { out[c] += entry * lambda[row]; });
}

template <class T>
void LoopSystem<T>::bias(const Twist<Spatial, T>* V, const TwistRate<Spatial, T>* dV,
                         T* gamma) const noexcept {
  for (const LoopPath& path : table_.of_couplings()) gamma[path.rows.first] = T(0);
  table_.each([&](std::size_t k, const auto& joint) {
    const loops::LoopFrames<T>& frames = at_[k].frames;
    loops::LoopWrenches<T> W;
    joint.wrenches(frames, W.data());
    loops::bias(joint, frames, W.data(), motion_of_ends(k, V, dV), gamma + table_.paths[k].rows.first);
  });
  for (const PrescribedRow<T>& it : prescribed_) gamma[it.row] -= it.dds;
}

template <class T>
loops::EndMotion<T> LoopSystem<T>::motion_of_ends(std::size_t k, const Twist<Spatial, T>* V,
                                                  const TwistRate<Spatial, T>* dV) const noexcept {
  const auto& [first, second] = table_.paths[k].ends;
  const int i = first.body, j = second.body;
  const Vec3<T>& shift = at_[k].shift;
  return {{V[i].w, V[i].v - cross(V[i].w, shift)},
          {V[j].w, V[j].v},
          {dV[i].w, dV[i].v - cross(dV[i].w, shift)},
          {dV[j].w, dV[j].v}};
}

template <class T> void LoopSystem<T>::rates(const Twist<Spatial, T>* X, const T* x, T* out) const noexcept {
  for (std::size_t k = 0; k < at_.size(); ++k) {
    const LoopPath& path = table_.paths[k];
    T* const rows = out + first(path);
    for (int r = 0; r < count(path); ++r) {
      const Wrench<Spatial, T>& W = at_[k].W[index(r)];
      rows[r] = (W | X[path.ends[1].body]) - (on_first(at_[k], W) | X[path.ends[0].body]);
    }
  }
  for (const LoopPath& path : table_.of_couplings()) {
    T& row = out[first(path)];
    row = T(0);
    for (const LoopColumn& column : path.columns) row += T(column.factor) * x[column.velocity];
  }
}

template <class T>
void LoopSystem<T>::add_wrenches(const T* lambda, Wrench<Spatial, T>* on, T* tau) const noexcept {
  for (std::size_t k = 0; k < at_.size(); ++k) {
    const LoopPath& path = table_.paths[k];
    const Wrench<Spatial, T> W = wrench(k, lambda);
    on[path.ends[1].body] += W;
    on[path.ends[0].body] -= on_first(at_[k], W);
  }
  for (const LoopPath& path : table_.of_couplings())
    for (const LoopColumn& column : path.columns)
      tau[column.velocity] += T(column.factor) * lambda[first(path)];
}

template <class T> void LoopSystem<T>::joint_wrenches(const T* lambda, Wrench<Spatial, T>* W) noexcept {
  const int n = tree()->n;
  std::fill_n(W, n + 1, Wrench<Spatial, T>{});
  for (std::size_t k = 0; k < at_.size(); ++k) {
    const auto& [first, second] = table_.paths[k].ends;
    const Wrench<Spatial, T> by_loop = wrench(k, lambda);
    W[second.body] += by_loop;
    W[first.body] -= on_first(at_[k], by_loop);
  }
  for (int i = n; i > 0; --i) {
    const int p = tree()->parent[i];
    if (p > 0) W[p] += W[i];  // W[i] now is the sum of the loop wrenches on the subtree of body i
    W[i] = dynamics_->recursion.W[i] - W[i];
  }
}

template <class T> Solvability LoopSystem<T>::factorize(const T* q, const RowRank& rank) noexcept {
  update_kinematics(q);
  return prepare(ConstraintLevel::velocity, q, rank);
}

template <class T> Solvability LoopSystem<T>::factorize_with_armature(const T* armature) noexcept {
  auto& bodies = dynamics_->bodies;
  bodies.put_inertias(tree());
  const Solvability verdict = bodies.eliminate_joints(tree(), armature);
  const auto put = [&](int c, const T&, const T& D) { root_[c] = T(1) / sqrt(D); };
  for (int i = 0; i <= tree()->n; ++i) bodies.each_pivot(tree(), i, put);
  return verdict;
}

template <class T> void LoopSystem<T>::pull(const T* x) noexcept {
  auto& bodies = dynamics_->bodies;
  bodies.backward_sweep(tree(), x);
  const auto put = [&](int c, const T& u, const T&) { w_[c] = root_[c] * u; };
  for (int i = 0; i <= tree()->n; ++i) bodies.each_pivot(tree(), i, put);
}

template <class T> void LoopSystem<T>::add_response(const T* x, T* b) noexcept {
  pull(x);
  add_to_rows(b);
}

template <class T> void LoopSystem<T>::force_response(const T* tau, T* a) noexcept {
  b_.setZero();
  add_response(tau, b_.data());
  solve_rows(b_.data(), lambda_.data());
  push(lambda_.data(), a);
}

template <class T> void LoopSystem<T>::add_to_rows(T* b) const noexcept {
  for (const LoopTable::VelocityBlock& group : blocks())
    for (int c = group.first; c < group.first + group.count; ++c)
      for (const Range& rows : group.rows)
        for (int r = rows.first; r < rows.first + rows.count; ++r) b[r] += w_[c] * Y_(c, r);
}

template <class T> void LoopSystem<T>::add_to_velocities(const T* lambda) noexcept {
  for (const LoopTable::VelocityBlock& group : blocks())
    for (int c = group.first; c < group.first + group.count; ++c)
      for (const Range& rows : group.rows)
        for (int r = rows.first; r < rows.first + rows.count; ++r) w_[c] += Y_(c, r) * lambda[r];
}

template <class T> void LoopSystem<T>::push(const T* lambda, T* x) noexcept {
  auto& bodies = dynamics_->bodies;
  add_to_velocities(lambda);
  const auto put = [&](int c, T& u, const T& D) { u = root_[c] * D * w_[c]; };
  for (int i = 0; i <= tree()->n; ++i) bodies.each_pivot(tree(), i, put);
  bodies.forward_sweep(tree(), x);
}

template <class T> Wrench<Spatial, T> LoopSystem<T>::wrench(std::size_t k, const T* lambda) const noexcept {
  Wrench<Spatial, T> sum{};
  const LoopPath& path = table_.paths[k];
  for (int r = 0; r < count(path); ++r) sum += lambda[first(path) + r] * at_[k].W[index(r)];
  return sum;
}

template class LoopSystem<AXODE_T>;

}  // namespace axode
