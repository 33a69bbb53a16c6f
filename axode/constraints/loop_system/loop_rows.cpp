#include <algorithm>
#include <cmath>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/recursion/instantiate.hpp"

/// Computes the scaled loop equations Y = D^-½ L⁻ᵀ Aᵀ, their rank, and the multipliers λ that solve
/// Yᵀ Y λ = -b for a given b. A is the Jacobian of the loop equations, and LᵀD L the mass matrix of the
/// spanning tree. See "Redundant rows" of docs/derivations/loop-dynamics.md.
namespace axode {
namespace {

/// Bounds of the filter μ, a small number. The multipliers λ of the loops are computed from A M⁻¹ Aᵀ λ = -b,
/// with the Jacobian A of the loop equations, the mass matrix M and a given b. So that this is possible if
/// equations are redundant, each diagonal entry of A M⁻¹ Aᵀ is increased by μ times itself (D7.9). If the
/// loops are open by a residual r (rad and m), redundant equations seem to be independent, by an amount of
/// the order of |r|; hence μ is (1e4 |r|)², limited by these bounds. The lower bound is larger in
/// simulations, which determine the redundant equations once for each step.
template <class T> constexpr bool is_float = std::same_as<T, float>;
template <class T> constexpr T least_filter_in_motion = is_float<T> ? T(1e-4) : T(1e-9);
template <class T> constexpr T most_filter = is_float<T> ? T(1e-4) : T(1e-6);
/// The multipliers λ of the loop equations are computed from A M⁻¹ Aᵀ λ = -b by Cholesky factorisation. If a
/// pivot is not larger than this fraction of d², the diagonal entries of A M⁻¹ Aᵀ are increased by the filter
/// μ times themselves; otherwise they are not changed. For the equation of the pivot, d² is the diagonal
/// entry of A M⁻¹ Aᵀ, but not less than a limit. A is the Jacobian of the loop equations, and M the mass
/// matrix of the spanning tree.
template <class T> constexpr T sound_part = is_float<T> ? T(1e-2) : T(1e-3);
/// An equation of a loop joint counts as rounding errors, and is replaced by zeros so that its multiplier is
/// 0, if g is less than this fraction of its size d (D7.7). Here g² is the diagonal entry of A M⁻¹ Aᵀ for the
/// equation, with the Jacobian A of the loop equations and the mass matrix M. The size d is the largest of
/// four numbers: g; 0.1 times the largest g of the equations of the loop; 1e-6 times the largest g of all
/// equations; and 1e-4 times an estimate of the value that g would have if the terms of the equation did not
/// cancel.
template <class T> constexpr T vanishing_part = is_float<T> ? T(1e-4) : T(1e-9);
constexpr float size_of_a_row_of_zeros = 1e15f;
template <class T> constexpr T converged = is_float<T> ? T(1e-5) : T(1e-12);
constexpr int most_steps = 5;

}  // namespace

template <class T> void LoopSystem<T>::set_filter(const T* q, const RowRank& rank) noexcept {
  residual(q, rest_.data());
  const T open = rest_.head(size(ConstraintLevel::position)).squaredNorm();
  const T least = rank.redundant.empty() ? least_filter : least_filter_in_motion<T>;
  filter_ = std::clamp(T(1e8) * open, least, most_filter<T>);
}

/// Computes the column of Y = D^-½ L⁻ᵀ Aᵀ of one loop equation by the backward sweep of the articulated-body
/// algorithm, with the Jacobian A of the loop equations and the mass matrix LᵀD L of the spanning tree. The
/// sweep begins with the wrenches `first` and `second` of a unit multiplier on the two bodies of a loop
/// joint, or with the factors of a coupling of joints.
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

/// Computes the columns of Y = D^-½ L⁻ᵀ Aᵀ of n equations of a loop at once, if no joints of the tree are
/// coupled (D7.6). LᵀD L is the factorised mass matrix of the spanning tree and A the Jacobian of the loop
/// equations. The wrenches that unit multipliers exert on the two bodies of the loop are moved to the ground
/// by the backward sweep of the articulated-body algorithm. Each joint screw on the paths to the ground gives
/// one row of entries of Y.
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
      const auto u = dot(Wrenches::all(S.w), F.m) + dot(Wrenches::all(S.v), F.f);
      F.eliminate(u, root_[c], &Y_(c, first(path) + row), u * (root_[c] * root_[c]), U.m, U.f);
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
  // If the terms of a row cancel, for example because a loop repeats a joint of the tree, only rounding
  // errors remain. The size of a row is therefore at least a part of the size of its terms. The terms are
  // those of the wrench on either end alone, with moment and force apart, about the origin of the loop, and
  // those of the force on the mass between this end and the body where the paths meet, as if it were free.
  constexpr T least_part = T(1e-4);
  const Topology& topology = *tree().operator->();
  for (std::size_t k = 0; k < at_.size(); ++k) {
    const LoopPath& path = table_.paths[k];
    const auto& [a, b] = at_[k].frames;
    T by_moment(0), by_force(0);
    for (std::size_t e = 0; e < 2; ++e) {
      const Vec3<T> place = e == 0 ? a.r - at_[k].shift : b.r;
      const int end = path.ends[e].body;
      T mass(0);
      if (end > path.meeting)
        for (int i = end + 1; i < topology.subtree_end[end]; ++i) mass += tree().M[i].m;
      for (int i = end; i > 0; i = topology.parent[i]) {
        if (i > path.meeting) mass += tree().M[i].m;
        for (int s = topology.first_screw[i]; s < topology.first_screw[i + 1]; ++s) {
          const Twist<Spatial, T>& S = dynamics_->bodies.S[s];
          const T root = root_[topology.iv[i] + s - topology.first_screw[i]];
          const Vec3<T> v = S.v + cross(S.w, place);
          by_moment += root * root * dot(S.w, S.w);
          by_force += root * root * dot(v, v);
        }
      }
      if (mass > T(0)) by_force += T(1) / mass;
    }
    for (int r = 0; r < count(path); ++r) {
      const Wrench<Spatial, T>& W = at_[k].W[index(r)];
      const Vec3<T> m = W.m - cross(b.r, W.f);
      const int row = first(path) + r;
      T& scale = scale_[row];
      scale = std::max(scale, least_part * sqrt(dot(m, m) * by_moment + dot(W.f, W.f) * by_force));
      if (!(sqrt(G_(row, row)) < vanishing_part<T> * scale)) continue;
      Y_.col(row).setZero();
      G_.row(row).setZero();
      G_.col(row).setZero();
      scale = size_of_a_row_of_zeros;
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
        Eigen::Index from = Factor::block(ra);  // blocks left of the block of the diagonal are not used
        for (const Range& b : group.rows) {
          from = std::max(from, Factor::block(b.first));
          for (; from < b.first + b.count; from += Factor::width) {
            Eigen::Matrix<T, 1, Factor::width> sum = Factor::part(G_, ra, from);
            for (int c = group.first; c < group.first + group.count; ++c)
              sum += Y_(c, ra) * Factor::part(Y_, c, from);
            Factor::part(G_, ra, from) = sum;
          }
        }
      }
  const T largest = m > 0 ? sqrt(G_.diagonal().head(m).maxCoeff()) : T(0);
  for (const LoopPath& path : table_.paths) {
    if (count(path) == 0) continue;  // a belt has no row at the position level
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
  filter_ = least_filter;
  rank.redundant.assign(index(size(ConstraintLevel::velocity)), 1);
  left_ = Y_;
  Eigen::Index found = 0;
  // Rows with a residual are chosen before rows without one: if a row of a rolling contact depends on a row
  // with a residual, the latter is kept, because only it corrects positions.
  for (const bool with_residual : {true, false})
    for (; found < basis_.cols(); ++found) {
      // The row with the largest remainder is chosen next, because small remainders are ill-conditioned near
      // singular configurations.
      int best = -1;
      T most = part;
      for (const LoopPath& path : table_.paths)
        for (int r = 0; r < path.rows.count; ++r) {
          const int k = path.rows.first + r;
          if ((r < path.residuals.count) != with_residual || !rank.redundant[index(k)]) continue;
          const T rest = left_.col(k).norm() / scale_[k];
          if (!(rest > most)) continue;
          best = k;
          most = rest;
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
  for (int k = 0; k < m; ++k) {
    F(k, k) += filter * scale_[k] * scale_[k];
    F(k, m) = -b[k];
  }
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
  const auto is_sound = [&](Eigen::Index k, const T& D) { return D > sound_part<T> * scale_[k] * scale_[k]; };
  if (!factor_.factorize(m, is_sound)) return false;
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
  x = step;
  rest = given;
  for (int n = 1;; ++n) {
    moved_.setZero();
    for (int k = 0; k < m; ++k) moved_ += step_[k] * G_.row(k).transpose();
    rest += moved;  // now the residual G x + b
    const T change = step.dot(moved), whole = x.dot(rest - given);
    if (n == most_steps || !(change > converged<T> * converged<T> * whole)) break;
    step = -rest;
    each_redundant(rank, [&](int k) { step[k] = T(0); });
    factor_.solve(m, step_);
    x += step;
  }
}

// The members of LoopSystem are instantiated in loop_system.cpp, which is compiled in one unit with this
// file.

}  // namespace axode
