#pragma once
#include "axode/derivatives/displacement/accelerations.hpp"
#include "axode/derivatives/displacement/first_order.hpp"

namespace axode {

/// The screws S, ψ and η and the wrenches U, D and A that belong to one joint screw S. The derivatives of the
/// generalised momenta p, and of their rates p', are sums of powers of a wrench of one joint screw on a screw
/// of another ((D5.3) and (D5.4) of docs/derivations):
///   ψ = [V_p, S],   η = [V, S],   U = M S,   D = M ψ - ad_Sᵀ Π,   A = M η - ad_Sᵀ Π.
/// V_p and V are the twists of the predecessor and of the body that the joint moves, and M and Π are the
/// inertia and the momentum of the subtree of this body.
template <class T> struct MomentumEffects {
  Motion6<T> S, psi,
      eta;  ///< ψ = [V_p, S] with the twist of the predecessor, η = [V, S] with that of the body
  Wrench<Spatial, T> U, D, A;

  static constexpr int size = 36;  ///< number of numbers

  /// Computes, for a joint screw S, the screws and wrenches
  ///   ψ = [V_p, S],   η = [V, S],   U = M S,   D = M ψ - ad_Sᵀ Π,   A = M η - ad_Sᵀ Π.
  /// M and Π are the inertia and the momentum of the subtree that the joint moves, V_p is the twist of the
  /// predecessor, and V is the twist of the body.
  static constexpr MomentumEffects of(const Inertia<T>& M, const Wrench<Spatial, T>& Pi, const Motion6<T>& S,
                                      const Motion6<T>& V_p, const Motion6<T>& V) {
    const auto times_M = [&](const Motion6<T>& X) {
      const Momentum<Spatial, T> p = M * X;
      return Wrench<Spatial, T>{p.l, p.p};
    };
    const Motion6<T> psi = ad(V_p, S), eta = ad(V, S);
    const Wrench<Spatial, T> carried = coad(S, Pi);
    return {S, psi, eta, times_M(S), times_M(psi) + carried, times_M(eta) + carried};
  }
};

/// Computes the derivatives of the velocities v = M⁻¹ p, and of the rates p' of the momenta p = M v, with
/// respect to q and p, with the mass matrix M. They follow from the derivatives of M v and p' as functions of
/// (q, v) ((D5.5) of docs/derivations).
template <class T> struct MomentumFirstOrder {
  using L = Lanes<T>;
  using Number = typename L::Number;

  AccelerationsAndColumns<T> forward;
  FirstOrder<T> terms;  ///< first the derivatives of gravity and loads at rest, then the tree with the
                        ///< accelerations v and no velocities
  Arrays<T> effect, line;
  T *v, *zero;

  explicit MomentumFirstOrder(Arena& arena)
      : forward(arena),
        terms(arena),
        effect(arena, MomentumEffects<T>::size, arena.topology().n_screws),
        line(arena, 6, arena.topology().n_screws),
        v(arena.per_velocity<T>()),
        zero(arena.per_velocity<T>()) {}

  /// Writes the matrices ∂v/∂q, ∂v/∂p, ∂p'/∂q and ∂p'/∂p, nv × nv numbers each, [component, direction].
  Solvability run(const Tree<T>& tree, const T* q, const T* p, const Loads<T>& loads, T* v_q, T* v_p, T* dp_q,
                  T* dp_p) noexcept {
    const std::ptrdiff_t nv = tree->nv, entries = nv * nv;
    std::fill_n(zero, nv, T(0));
    Solvability verdict = forward.run(tree, q, zero, zero, {});
    if (verdict.ok()) {
      std::copy_n(p, nv, v);
      forward.solve_one(tree, v);
      verdict = solved(verdict, nv, v);
    }
    if (!verdict.ok()) {
      for (T* const matrix : {v_q, v_p, dp_q, dp_p}) verdict = solved(verdict, entries, matrix);
      return verdict;
    }

    for (T* const matrix : {v_q, dp_q, dp_p}) std::fill_n(matrix, entries, T(0));
    const auto add_to = [nv](T* matrix) {
      return [=](std::ptrdiff_t r, std::ptrdiff_t direction, const T& x) { matrix[direction * nv + r] += x; };
    };
    const auto subtract_from = [nv](T* matrix) {
      return [=](std::ptrdiff_t r, std::ptrdiff_t direction, const T& x) { matrix[direction * nv + r] -= x; };
    };
    // Intermediate results are transposed, with one row for each direction: F_v is in the memory of p'_p, and
    // -(Mv)_q in that of v_q.
    terms.run(tree, q, zero, zero, loads);
    terms.each_entry(tree, loads, subtract_from(dp_q), subtract_from(dp_p));
    move(tree, q);
    each_entry(tree, subtract_from(v_q), add_to(dp_q), add_to(dp_p));
    forward.solve(tree, dp_p);
    for (std::ptrdiff_t l = 0; l < nv; ++l)
      for (std::ptrdiff_t k = 0; k < nv; ++k)
        if (const T x = v_q[l * nv + k]; x != T(0))  // k and l are on one path
          for (std::ptrdiff_t c = 0; c < nv; ++c) dp_q[l * nv + c] += x * dp_p[k * nv + c];
    for (T* const matrix : {v_q, dp_q, dp_p}) transpose(matrix, nv);
    forward.solve(tree, v_q);
    forward.inverse(tree, v_p);
    return verdict;
  }

  /// Computes the matrices Mv_q = ∂(M v)/∂q and, if they are given, F_q = ∂F/∂q and F_v = ∂F/∂v, nv × nv
  /// numbers each, [component, direction]. M v and F are functions of (q, v), and M is the mass matrix
  /// without armatures. F = ∂T/∂q + ad_vᵀ M v is the rate of M v without drive forces, gravity, loads and
  /// losses, where T is the kinetic energy. ad_v is the Lie bracket of the configuration group; it is 0 for
  /// joints with one velocity (D5.2).
  template <class... Rates>
  void kinetic(const Tree<T>& tree, const T* q, const T* v_given, T* Mv_q, Rates*... F_q_and_F_v) noexcept {
    const std::ptrdiff_t nv = tree->nv;
    std::fill_n(zero, nv, T(0));
    std::copy_n(v_given, nv, v);
    for (T* const matrix : {Mv_q, F_q_and_F_v...}) std::fill_n(matrix, nv * nv, T(0));
    const auto add_to = [nv](T* matrix) {
      return [=](std::ptrdiff_t r, std::ptrdiff_t direction, const T& x) { matrix[direction * nv + r] += x; };
    };
    move(tree, q);
    each_entry(tree, add_to(Mv_q), add_to(F_q_and_F_v)...);
  }

 private:
  static void transpose(T* matrix, std::ptrdiff_t n) noexcept {
    for (std::ptrdiff_t r = 0; r < n; ++r)
      for (std::ptrdiff_t c = 0; c < r; ++c) std::swap(matrix[r * n + c], matrix[c * n + r]);
  }

  /// Computes, for each joint screw S, the screws and wrenches of MomentumEffects:
  ///   ψ = [V_p, S],   η = [V, S],   U = M S,   D = M ψ - ad_Sᵀ Π,   A = M η - ad_Sᵀ Π.
  /// V_p and V are the twists of the predecessor and of the body that the joint moves, and M and Π are the
  /// inertia and the momentum of the subtree of this body. The twists and momenta are computed as the twist
  /// rates and wrenches of a motion without gravity with the velocities 0 and the accelerations v.
  void move(const Tree<T>& tree, const T* q) noexcept {
    MovingScrews<T>& screws = terms.screws;
    screws.run(tree, q, zero, v, {});
    screws.compose(*tree.topology());
    for (int c = 0; c < tree->n_screws; c += L::width) {
      const MovingInertia<Number> moved = screws.subtrees_of_columns(c, tree->n_screws);
      const MovingColumn<Number> column = screws.columns_from(c);
      const auto x = MomentumEffects<Number>::of(moved.M, moved.F, column.S, column.dV_p,
                                                 screws.twist_rates_of_columns(c, tree->n_screws));
      store6(x.S.w, x.S.v, effect, S, c);
      store6(x.psi.w, x.psi.v, effect, psi, c);
      store6(x.eta.w, x.eta.v, effect, eta, c);
      store6(x.U.m, x.U.f, effect, U, c);
      store6(x.D.m, x.D.f, effect, D, c);
      store6(x.A.m, x.A.f, effect, A, c);
    }
  }

  /// Offsets of the members of MomentumEffects in its array of numbers.
  enum Part { S = 0, psi = 6, eta = 12, U = 18, D = 24, A = 30 };

  /// Writes to `line`, for joint screw l and each joint screw k from `begin` to `end` - 1, the six powers
  ///   S_l|D_k,   η_l|D_k,   η_l|U_k,   ψ_l|U_k,   ψ_l|A_k,   S_l|A_k
  /// of which the derivatives of the generalised momenta and of their rates consist (D5.4). A bar means the
  /// power of a wrench on a screw. For a joint screw S
  ///   ψ = [V_p, S],   η = [V, S],   U = M S,   D = M ψ - ad_Sᵀ Π,   A = M η - ad_Sᵀ Π.
  /// V_p and V are the twists of the predecessor and of the body that the joint moves, and M and Π are the
  /// inertia and the momentum of the subtree of this body. With step = 3, only the first and the fourth power
  /// are computed, which are those for the momenta.
  template <int step> void multiply(int l, int begin, int end) noexcept {
    Number x[U];
    for (int k = 0; k < U; ++k) x[k] = Number(effect.array(k)[l]);
    static constexpr int pairs[][2] = {{S, D}, {eta, D}, {eta, U}, {psi, U}, {psi, A}, {S, A}};
    for (int c = begin; c < end; c += L::width)
      for (int n = 0; n < 6; n += step) {
        Number sum(T(0));
        for (int k = 0; k < 6; ++k)
          sum = sum + x[pairs[n][0] + k] * L::load(effect.array(pairs[n][1] + k) + c);
        L::store(sum, line.array(n) + c);
      }
  }

  /// Calls Mv_by_q, by_q and by_v as f(component, direction, part of the entry) for the entries of three
  /// matrices: the derivative of the momenta M v by q, and, if they are given, those of their rates p' by q
  /// and by v. If several joints share a velocity, its entries come in several parts, which add up.
  template <class MvByQ, class... ByQAndByV>
  void each_entry(const Tree<T>& tree, const MvByQ& Mv_by_q, const ByQAndByV&... rates_by) noexcept {
    for (int i = 1; i <= tree->n; ++i)
      for (int l = tree->first_screw[i]; l < tree->first_screw[i + 1]; ++l) {
        multiply<sizeof...(rates_by) == 0 ? 3 : 1>(l, tree->first_screw[i],
                                                   tree->first_screw[tree->subtree_end[i]]);
        const std::ptrdiff_t v_l = tree->iv[i] + l - tree->first_screw[i];
        for (int j = i; j < tree->subtree_end[i]; ++j)
          for (int k = tree->first_screw[j]; k < tree->first_screw[j + 1]; ++k) {
            const std::ptrdiff_t v_k = tree->iv[j] + k - tree->first_screw[j];
            const auto at = [&](int n) { return line.array(n)[k]; };
            const auto put = [&](std::ptrdiff_t row, std::ptrdiff_t column, int n) {
              Mv_by_q(row, column, at(n));
              (rates_by(row, column, at(++n)), ...);
            };
            if (j > i) put(v_l, v_k, 0);
            put(v_k, v_l, 3);
          }
      }
  }
};

}  // namespace axode
