#include "axode/constraints/loop_system.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>

#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

/// Steps of the proximal iteration filter: what has less than μ d² in Yᵀ Y is rounding, or rows that agree only where the
/// loops are closed. A residual r makes such rows |r| d large, and a part of r² / μ of them would be obeyed in a step: so
/// μ = (1e4 |r|)². Where branches of a motion meet, 1 / σ times what is open would become motion, and in a motion loops are closed to
/// no less than rounding: so μ has a larger bound there.
template <class T> constexpr bool is_float = std::same_as<T, float>;
template <class T> constexpr T least_filter = is_float<T> ? T(1e-5) : T(1e-12);
template <class T> constexpr T least_filter_in_motion = is_float<T> ? T(1e-4) : T(1e-9);
template <class T> constexpr T most_filter = is_float<T> ? T(1e-4) : T(1e-6);
/// Rows of which the others leave this part of what they are need no filter.
template <class T> constexpr T sound_part = is_float<T> ? T(1e-2) : T(1e-3);
template <class T> constexpr T settled = is_float<T> ? T(1e-5) : T(1e-12);
constexpr int most_steps = 5;

}  // namespace

template <class T>
LoopSystem<T>::LoopSystem(const Model& of)
    : model_(of),
      dynamics_(of.topology()),
      fast_(of.topology()),
      table_(of),
      at_(of.loops().joints.size()),
      filter_(least_filter<T>),
      entries_(of.loops().all.size()) {
  const int m = of.loops().rows, nv = of.nv();
  for (std::size_t k = 0; k < entries_.size(); ++k)
    for (const LoopColumn& column : table_.paths[k].columns)  // what is constant of them, of couplings all
      entries_[k].resize(entries_[k].size() + index(table_.paths[k].rows.count), T(column.factor));
  const Eigen::Index room = RowCholesky<T>::room(m);
  Y_.setZero(nv, room), G_.setZero(m, room), factor_.resize(m);
  left_.setZero(nv, room), along_.setZero(room), basis_.resize(nv, std::min(nv, m));
  scale_.resize(m), b_.resize(m), lambda_.resize(m), rest_.resize(m), step_.setZero(room),
      moved_.resize(room);
  zero_.setZero(nv), forces_.resize(nv), w_.resize(nv), root_.resize(nv);
}

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
  times(v, b_.data());
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
  link_ = links.link, origin_ = links.origin;
  place_loops();
}

template <class T> void LoopSystem<T>::update_kinematics(const SE3<T>* C, const Vec3<T>& origin) noexcept {
  const Topology& topology = *tree().operator->();
  auto& links = dynamics_->bodies.links;
  link_ = links.link, origin_ = links.origin;
  link_[0] = Link<Spatial, T>::root();
  each_root(topology, [&](int root) {
    origin_[root] = origin + C[root].r;
    for (int i = root; i < topology.subtree_end[root]; ++i) link_[i] = {{C[i].R, C[i].r - C[root].r}};
  });
  place_loops();
}

template <class T>
void LoopSystem<T>::force(const T* q, const T* v, const T* a, const Loads<T>& loads, T* tau) noexcept {
  auto& recursion = dynamics_->recursion;
  recursion.run(tree(), q, v, a, loads);
  recursion.project(tree(), v, a, loads.joint_losses, tau);
  link_ = recursion.motion.bodies.link, origin_ = recursion.origin;
  dynamics_->bodies.links.link = link_;
  place_loops();
}

template <class T> void LoopSystem<T>::place_loops() noexcept {
  joint_columns(tree(), link_, dynamics_->bodies.S);
  place_ends();
}

template <class T> void LoopSystem<T>::place_ends() noexcept {
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

template <class T> void LoopSystem<T>::set_filter(const T* q, const RowRank& rank) noexcept {
  residual(q, rest_.data());
  const T open = rest_.head(size(ConstraintLevel::position)).squaredNorm();
  const T least = rank.redundant.empty() ? least_filter<T> : least_filter_in_motion<T>;
  filter_ = std::clamp(T(1e8) * open, least, most_filter<T>);
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
}

template <class T> void LoopSystem<T>::make_rows(ConstraintLevel level) noexcept {
  make_wrenches(level);
  make_entries();
}

template <class T> void LoopSystem<T>::make_wrenches(ConstraintLevel level) noexcept {
  if (level != level_) Y_.setZero();  // its columns are now those of others
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
    T* entry = entries_[k].data();
    const std::size_t rows = index(count(path));
    loops::LoopWrenches<T> first;
    for (std::size_t r = 0; r < rows; ++r) first[r] = on_first(at_[k], at_[k].W[r]);
    for (const LoopColumn& column : path.columns)
      for (std::size_t r = 0; r < rows; ++r) {
        const Twist<Spatial, T>& J = dynamics_->bodies.S[column.screw];
        *entry++ = column.side > 0 ? at_[k].W[r] | J : -(first[r] | J);
      }
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
    const Wrench<Spatial, T> closing = wrench(k, lambda);
    W[second.body] += closing, W[first.body] -= on_first(at_[k], closing);
  }
  for (int i = n; i > 0; --i) {
    if (const int p = tree()->parent[i]; p > 0) W[p] += W[i];  // the loops' wrenches on the whole subtree
    W[i] = dynamics_->recursion.W[i] - W[i];
  }
}

template <class T> Solvability LoopSystem<T>::factorize(const T* q, const RowRank& rank) noexcept {
  update_kinematics(q);
  return prepare(ConstraintLevel::velocity, q, rank);
}

template <class T> Solvability LoopSystem<T>::factorize_with_armature(const T* armature) noexcept {
  auto& bodies = dynamics_->bodies;
  const bool quick = tree()->coupled_bodies.empty() && bodies.factorize_quickly(tree(), armature);
  const Solvability verdict = quick ? Solvability{} : bodies.factorize(tree(), armature);
  const auto put = [&](int c, const T&, const T& D) { root_[c] = T(1) / sqrt(D); };
  for (int i = 0; i <= tree()->n; ++i) bodies.each_pivot(tree(), i, put);
  return verdict;
}

/// A row as what the joints feel, on its way to the ground: of its unit wrench on the bodies of a loop joint,
/// or of the factors of a coupling.
template <class T>
void LoopSystem<T>::pull_row(const LoopPath& path, int row, const Wrench<Spatial, T>& first,
                             const Wrench<Spatial, T>& second) noexcept {
  auto& bodies = dynamics_->bodies;
  const Topology::Ties& ties = tree()->ties;
  const auto at_rest = [&](int i) {
    bodies.W[i] = {};
    for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t) bodies.u_tie[t] = T(0);
  };
  at_rest(0);
  for (const int i : path.bodies) at_rest(i);
  bodies.W[path.ends[0].body] += first;
  bodies.W[path.ends[1].body] -= second;
  for (const LoopColumn& column : path.columns) zero_[column.velocity] += T(column.factor);
  for (const int i : path.bodies) bodies.backward_step(tree(), i, zero_.data());
  bodies.backward_step_at_ground(tree(), zero_.data());
  for (const LoopColumn& column : path.columns) zero_[column.velocity] = T(0);
  const auto put = [&](int c, const T& u, const T&) { Y_(c, row) = root_[c] * u; };
  for (const int i : path.bodies) bodies.each_pivot(tree(), i, put);
  bodies.each_pivot(tree(), 0, put);
}

/// Several rows of a loop at once, where no velocity is shared: Y_c = Sᵀ F / √D and F -= U Sᵀ F / D for the wrenches F.
template <class T>
template <int n>
void LoopSystem<T>::pull_rows(const LoopPath& path, const State& at, int row) noexcept {
  const auto& bodies = dynamics_->bodies;
  const Topology& topology = *tree().operator->();
  using Wrenches = RowsInLanes<T, n>;
  Wrenches F_i = -Wrenches(at.W, row), F_j(at.W, row);
  F_i.move(-at.shift);
  propagate_to_root(path, F_i, F_j, [&](int i, Wrenches& F) {
    for (int s = topology.first_screw[i + 1] - 1; s >= topology.first_screw[i]; --s) {
      const int c = topology.iv[i] + s - topology.first_screw[i];
      const Twist<Spatial, T>& S = bodies.S[s];
      const Wrench<Spatial, T>& U = bodies.U[s];
      const auto felt = dot(Wrenches::all(S.w), F.m) + dot(Wrenches::all(S.v), F.f);
      F.eliminate(felt, root_[c], &Y_(c, first(path) + row), felt * (root_[c] * root_[c]), U.m, U.f);
    }
  });
}

template <class T> void LoopSystem<T>::pull_loop(const LoopPath& path, const State& at) noexcept {
  if (!tree()->coupled_bodies.empty()) {
    for (int r = 0; r < count(path); ++r) {
      const Wrench<Spatial, T>& W = at.W[index(r)];
      pull_row(path, first(path) + r, on_first(at, W), W);
    }
    return;
  }
  each_register_of_rows<T>(count(path), [&](int row, auto n) { pull_rows<n()>(path, at, row); });
}

template <class T> void LoopSystem<T>::factorize_rows() noexcept {
  for (std::size_t k = 0; k < at_.size(); ++k) pull_loop(table_.paths[k], at_[k]);
  for (const LoopPath& path : table_.of_couplings()) pull_row(path, first(path), {}, {});
  multiply_rows();
  // A row whose terms cancel, as where a loop restates a joint of the tree, is rounding. It is measured by its terms: those
  // of the wrench on either end alone, moment and force apart, about the place of the loop.
  constexpr T least_part = T(1e-4);
  const Topology& topology = *tree().operator->();
  for (std::size_t k = 0; k < at_.size(); ++k) {
    const LoopPath& path = table_.paths[k];
    const auto& [a, b] = at_[k].frames;
    T by_moment(0), by_force(0);
    for (std::size_t e = 0; e < 2; ++e) {
      const Vec3<T> place = e == 0 ? a.r - at_[k].shift : b.r;
      for (int i = path.ends[e].body; i > 0; i = topology.parent[i])
        for (int s = topology.first_screw[i]; s < topology.first_screw[i + 1]; ++s) {
          const Twist<Spatial, T>& S = dynamics_->bodies.S[s];
          const T root = root_[topology.iv[i] + s - topology.first_screw[i]];
          const Vec3<T> v = S.v + cross(S.w, place);
          by_moment += root * root * dot(S.w, S.w), by_force += root * root * dot(v, v);
        }
    }
    for (int r = 0; r < count(path); ++r) {
      const Wrench<Spatial, T>& W = at_[k].W[index(r)];
      const Vec3<T> m = W.m - cross(b.r, W.f);
      T& scale = scale_[first(path) + r];
      scale = std::max(scale, least_part * sqrt(dot(m, m) * by_moment + dot(W.f, W.f) * by_force));
    }
  }
}

template <class T> void LoopSystem<T>::multiply_rows() noexcept {
  const int m = size(level_);
  using Factor = RowCholesky<T>;
  G_.setZero();
  for (const LoopTable::VelocityBlock& group : blocks())
    for (const Range& a : group.rows)
      for (int ra = a.first; ra < a.first + a.count; ++ra) {
        Eigen::Index from = Factor::block(ra);  // what is left of the diagonal is not needed
        for (const Range& b : group.rows)
          for (from = std::max(from, Factor::block(b.first)); from < b.first + b.count;
               from += Factor::width) {
            Eigen::Matrix<T, 1, Factor::width> sum = Factor::part(G_, ra, from);
            for (int c = group.first; c < group.first + group.count; ++c)
              sum += Y_(c, ra) * Factor::part(Y_, c, from);
            Factor::part(G_, ra, from) = sum;
          }
      }
  const T largest = m > 0 ? sqrt(G_.diagonal().head(m).maxCoeff()) : T(0);
  for (const LoopPath& path : table_.paths) {
    const auto own = G_.diagonal().segment(first(path), count(path));
    const T floor = std::max(T(0.1) * sqrt(own.maxCoeff()), T(1e-6) * largest);
    scale_.segment(first(path), count(path)) = own.cwiseSqrt().cwiseMax(floor > T(0) ? floor : T(1));
  }
}

template <class T> Solvability LoopSystem<T>::determine_rank(const T* q, RowRank& rank) noexcept {
  const Solvability verdict = factorize(q, rank);
  if (!verdict.ok()) return verdict;
  determine_rank(rank);
  set_filter(q, rank);
  return verdict;
}

template <class T> void LoopSystem<T>::determine_rank(RowRank& rank) noexcept {
  const T part = is_float<T> ? T(1e-4) : T(1e-10);
  filter_ = least_filter<T>;
  rank.redundant.assign(index(size(ConstraintLevel::velocity)), 1);
  left_ = Y_;
  Eigen::Index found = 0;
  // Where what rolls repeats a row with a place, that one is kept: nothing else brings the place back.
  for (const bool placed : {true, false})
    for (; found < basis_.cols(); ++found) {
      int best = -1;
      T most = part;
      for (const LoopPath& path : table_.paths)
        for (int r = 0; r < path.rows.count; ++r) {
          const int k = path.rows.first + r;
          if ((r < path.residuals.count) != placed || !rank.redundant[index(k)]) continue;
          // that of which the others leave most: near singular places what is left is ill-conditioned
          if (const T rest = left_.col(k).norm() / scale_[k]; rest > most) best = k, most = rest;
        }
      if (best < 0) break;
      rank.redundant[index(best)] = 0;
      auto q = basis_.col(found);
      q = left_.col(best);
      for (Eigen::Index j = 0; j < found; ++j) q -= basis_.col(j).dot(q) * basis_.col(j);
      q.normalize();
      along_.noalias() = q.transpose() * left_;
      left_.noalias() -= q * along_;
    }
}

template <class T>
template <class F>
void LoopSystem<T>::each_redundant(const RowRank& rank, const F& f) const {
  if (rank.redundant.empty()) return;
  for (const LoopPath& path : table_.paths)
    for (int r = 0; r < count(path); ++r)
      if (rank.redundant[index(path.rows.first + r)]) f(first(path) + r);
}

template <class T> void LoopSystem<T>::solve_rows(const T* b, T* lambda, const RowRank& rank) noexcept {
  if (!solve_sound_rows(b, lambda, rank)) solve_filtered_rows(b, lambda, rank);
}

template <class T> void LoopSystem<T>::set_rows(const T* b, const T& filter, const RowRank& rank) noexcept {
  const int m = size(level_);
  auto& F = factor_.matrix();
  F = G_;
  for (int k = 0; k < m; ++k) F(k, k) += filter * scale_[k] * scale_[k], F(k, m) = -b[k];
  each_redundant(rank, [&](int k) {
    F.row(k).setZero();
    F.col(k).setZero();
    F(k, k) = scale_[k] * scale_[k];
  });
}

template <class T> bool LoopSystem<T>::solve_sound_rows(const T* b, T* lambda, const RowRank& rank) noexcept {
  const int m = size(level_);
  weakest_row_ = T(1);
  set_rows(b, T(0), rank);
  if (!factor_.factorize(
          m, [&](Eigen::Index k, const T& D) { return D > sound_part<T> * scale_[k] * scale_[k]; }))
    return false;
  factor_.solve_right_side(m, step_);
  std::copy_n(step_.data(), m, lambda);
  return true;
}

template <class T>
void LoopSystem<T>::solve_filtered_rows(const T* b, T* lambda, const RowRank& rank) noexcept {
  const int m = size(level_);
  for (int k = 0; k < m; ++k)
    for (int j = 0; j < k; ++j) G_(k, j) = G_(j, k);
  set_rows(b, filter_, rank);
  factor_.factorize(m, [&](Eigen::Index k, const T& D) {
    weakest_row_ = std::min(weakest_row_, D / (scale_[k] * scale_[k]) - filter_);
    return true;
  });
  factor_.solve_right_side(m, step_);
  Eigen::Map<Vector> x(lambda, m);
  const Eigen::Map<const Vector> given(b, m);
  auto step = step_.head(m), rest = rest_.head(m), moved = moved_.head(m);
  x = step, rest = given;
  for (int n = 1;; ++n) {
    moved_.setZero();
    for (int k = 0; k < m; ++k) moved_ += step_[k] * G_.row(k).transpose();
    rest += moved;  // G x + b
    const T change = step.dot(moved), whole = x.dot(rest - given);
    if (n == most_steps || !(change > settled<T> * settled<T> * whole)) break;
    step = -rest;
    each_redundant(rank, [&](int k) { step[k] = T(0); });
    factor_.solve(m, step_);
    x += step;
  }
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
