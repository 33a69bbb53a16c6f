#pragma once
#include <algorithm>

#include "axode/derivatives/displacement/load_stiffness.hpp"
#include "axode/derivatives/displacement/moving_screws.hpp"
#include "axode/fast/symmetric_blocks.hpp"
#include "axode/lie/six.hpp"
#include "axode/recursion/spatial_tree.hpp"

namespace axode {

/// Computes ∂τ/∂q, ∂τ/∂v and ∂τ/∂a of inverse dynamics by products of every joint screw with the joint
/// screws of its subtree ((D1.17) of docs/derivations). It takes 67 products and sums for each such pair,
/// or 78 in code with SIMD lanes, which computes ∂τ/∂a above and below its diagonal although it is
/// symmetric.
template <class T> struct FirstOrder {
  using L = Lanes<T>;
  using Number = typename L::Number;
  static constexpr int results = 5;

  MovingScrews<T> screws;
  Arrays<T> effect;  ///< the ScrewEffects of each column
  Arrays<T> line;    ///< products of one screw with the columns of its subtree
  BodyPoses<T> inertial;
  LoadStiffness<T>* N;  ///< load stiffness of each body; after compose() that of its subtree
  Arrays<T> NtS;        ///< Nᵀ S of each column
  T* own;

  explicit FirstOrder(Arena& arena)
      : screws(arena),
        effect(arena, ScrewEffects<T>::size, arena.topology().n_screws),
        line(arena, results, arena.topology().n_screws),
        inertial(arena),
        N(arena.per_body<LoadStiffness<T>>()),
        NtS(arena, 6, arena.topology().n_screws),
        own(arena.per_velocity<T>()) {}

  /// Computes the ScrewEffects of each joint screw S at a state (q, v) with the accelerations a. ScrewEffects
  /// are screws (S, and its rates as a screw that is fixed to the predecessor) and wrenches: the changes of
  /// the wrench that the joint transmits to its subtree, by a displacement, by a velocity and by an
  /// acceleration of the subtree along S. The entries of ∂τ/∂q, ∂τ/∂v and ∂τ/∂a are sums of powers of such
  /// wrenches on such screws.
  template <class Real>
  void run(const Tree<Real>& tree, const T* q, const T* v, const T* a, const Loads<T>& loads) noexcept {
    run(tree, q, v, a, loads, cast<T>(tree.g));
  }
  template <class Real>
  void run(const Tree<Real>& tree, const T* q, const T* v, const T* a, const Loads<T>& loads,
           const Vec3<T>& g) noexcept {
    screws.run(tree, q, v, a, g);
    if constexpr (std::same_as<Real, T>)
      if (!loads.wrenches.empty()) load(tree, q, loads.wrenches);
    compose(*tree.operator->(), !loads.wrenches.empty());
  }
  /// Computes the ScrewEffects of each joint screw S from the motions and inertias of the bodies in `screws`.
  /// ScrewEffects are screws (S, and its rates as a screw that is fixed to the predecessor) and wrenches: the
  /// changes of the wrench that the joint transmits to its subtree, by a displacement, by a velocity and by
  /// an acceleration of the subtree along S. The entries of ∂τ/∂q, ∂τ/∂v and ∂τ/∂a are sums of powers of such
  /// wrenches on such screws. `loaded` says whether there are loads (external wrenches).
  void compose(const Topology& topology, bool loaded) noexcept {
    screws.compose(topology);
    for (int c = 0; c < topology.n_screws; c += L::width) {
      const MovingColumn<Number> column = screws.columns_from(c);
      const auto x = ScrewEffects<Number>::of(screws.subtrees_of_columns(c, topology.n_screws), column.S,
                                              column.V_p, column.dV_p, column.V);
      store6(x.S.w, x.S.v, effect, S, c);
      store6(x.psi_2.w, x.psi_2.v, effect, psi_2, c);
      store6(x.sigma.w, x.sigma.v, effect, sigma, c);
      store6(x.U.m, x.U.f, effect, U, c);
      store6(x.P.m, x.P.f, effect, P, c);
      store6(x.R.m, x.R.f, effect, R, c);
      effect.store3(x.psi_1, psi_1, c);
      effect.store3(x.t, t, c);
    }
    if (loaded) stiffen(topology);
  }

  /// Computes the forces τ of inverse dynamics at the state of run(). `tau` may share the memory of v or a.
  template <class Real>
  void project(const Tree<Real>& tree, const T* v, const T* a, bool joint_losses, T* tau) const noexcept {
    joint_terms(tree, v, a, joint_losses, own);
    std::copy_n(own, tree->nv, tau);
    for (int i = 1; i <= tree->n; ++i) {
      const Wrench<Spatial, T> F = screws.transmitted(i);
      const int first = tree->first_screw[i];
      for (int c = first; c < tree->first_screw[i + 1]; ++c)
        tau[tree->iv[i] + c - first] += F | screws.screw(c);
    }
  }

  /// Writes the matrices ∂τ/∂q, ∂τ/∂v and ∂τ/∂a, nv × nv numbers each, [component, direction].
  template <class Real>
  void write(const Tree<Real>& tree, const Loads<T>& loads, T* dq, T* dv, T* da) noexcept {
    const std::ptrdiff_t nv = tree->nv;
    if (tree->coupled_bodies.empty()) [[likely]] {
      write_columns(tree, loads, nv, dq, dv, da);
    } else {
      for (T* const matrix : {dq, dv, da}) std::fill_n(matrix, nv * nv, T(0));
      const auto add_to = [nv](T* matrix) {
        return [matrix, nv](std::ptrdiff_t r, std::ptrdiff_t c, const T& x) { matrix[r * nv + c] += x; };
      };
      each_product(tree, loads, add_to(dq), add_to(dv), add_to(da));
      add_losses(tree, loads, nv, dv);
    }
    for (std::ptrdiff_t c = 0; c < nv; ++c) da[c * nv + c] += T(tree.armature[static_cast<std::size_t>(c)]);
  }
  /// Writes ∂τ/∂q and ∂τ/∂v for a tree without couplings. The rows of each matrix are `stride` numbers apart,
  /// a multiple of the number of lanes.
  template <class Real>
  void write(const Tree<Real>& tree, const Loads<T>& loads, std::ptrdiff_t stride, T* dq,
             T* dv) const noexcept {
    write_columns(tree, loads, stride, dq, dv, nullptr);
  }

  /// Calls by_q(component of τ, direction, part of the entry) for every entry of ∂τ/∂q that can differ from
  /// 0, and by_v with the same arguments for ∂τ/∂v. An entry of a velocity that several joints share comes in
  /// several parts, which add up.
  template <class Real, class ByQ, class ByV>
  void each_entry(const Tree<Real>& tree, const Loads<T>& loads, const ByQ& by_q, const ByV& by_v) noexcept {
    each_product(tree, loads, by_q, by_v, [](std::ptrdiff_t, std::ptrdiff_t, const T&) {});
    if (loads.joint_losses)
      for (std::ptrdiff_t c = 0; c < tree->nv; ++c) by_v(c, c, T(tree.damping[static_cast<std::size_t>(c)]));
  }

  /// Calls f(load, body, point, moment, force) for each load on a moving body: the load as it was given,
  /// its body, its point, the moment about this point, and the force. Vectors are in inertial axes, and
  /// the point is relative to the origin of the root body, which is the body of its branch that is joined
  /// to the ground.
  template <class F>
  void each_load(const Tree<T>& tree, std::span<const AppliedWrench<T>> wrenches, const F& f) const noexcept {
    for (const AppliedWrench<T>& given : wrenches) {
      const ResolvedLoad<T> on(tree, given, inertial.C);
      if (on.body == 0) continue;
      const auto W = change<Hybrid>(inertial[on.body] * on.offset, on.W);
      f(given, on.body, screws.pose(on.body) * on.offset.r, W.m, W.f);
    }
  }
  [[gnu::noinline]] void load(const Tree<T>& tree, const T* q,
                              std::span<const AppliedWrench<T>> wrenches) noexcept {
    inertial.run(tree, q);
    for (int i = 0; i <= tree->n; ++i) N[i] = {};
    each_load(tree, wrenches,
              [&](const auto& given, int i, const Vec3<T>& r, const Vec3<T>& m, const Vec3<T>& f) {
                screws.load(i, {m + cross(r, f), f});
                N[i] += LoadStiffness<T>::of(given.representation, r, m, f);
              });
  }

  /// Offsets of the members of ScrewEffects in its array of numbers.
  enum Part { S = 0, psi_2 = 6, sigma = 12, U = 18, P = 24, R = 30, psi_1 = 36, t = 39 };

 private:
  /// Writes to `line`, for joint screw l and each joint screw k from `begin` to `end` - 1, the five numbers
  ///   S_l|P_k,   S_l|R_k,   S_l|U_k,   U_k|ψ''_l + t_k·ω(ψ'_l),   U_k|σ_l + t_k·ω(S_l)
  /// of which ∂τ/∂q, ∂τ/∂v and ∂τ/∂a consist (D1.17). If joint k is in the subtree of joint l, the first
  /// three belong to row l and column k of these matrices, and the last two to row k and column l of ∂τ/∂q
  /// and ∂τ/∂v. A bar means the power of a wrench on a screw, and ω(X) is the angular part of a screw X. For
  /// a joint screw S these quantities are
  ///   ψ' = [V_p, S],   ψ'' = [V'_p, S] + [V_p, ψ'],   σ = ψ' + [V, S],
  ///   U = M S,   P = M ψ'' + B ψ' - ad_Sᵀ F + N S,   R = M σ + B S,   and t, the moment of Bᵀ S.
  /// V_p and V'_p are the twist of the predecessor and its rate, and V is the twist of the body that the
  /// joint moves. M, F, B and N belong to the subtree: the inertia M, the wrench F that the joint transmits,
  /// the Coriolis inertia B and the load stiffness N. For a twist X = (w; v), B X is the wrench that gives
  /// mass elements with velocities r' the Coriolis acceleration 2 w × r'. If the subtree is displaced along
  /// X, the wrench that balances its loads changes by N X, as seen in a frame that is displaced with it. If
  /// there are loads, the fourth number also contains (Nᵀ S)_k|S_l.
  void multiply(int l, int begin, int end, bool loaded) noexcept {
    const Arrays<T> e = effect, n = NtS, out = line;  // local copies, so that the compiler knows that no
                                                      // result overwrites them
    Number x[psi_1 + 3];
    for (int k = 0; k < 18; ++k) x[k] = Number(e.array(k)[l]);
    for (int k = psi_1; k < psi_1 + 3; ++k) x[k] = Number(e.array(k)[l]);
    for (int c = begin; c < end; c += L::width) {
      L::store(e.template product<6>(x + S, P, c), out.array(0) + c);
      L::store(e.template product<6>(x + S, R, c), out.array(1) + c);
      L::store(e.template product<6>(x + S, U, c), out.array(2) + c);
      Number dq = e.template product<6>(x + psi_2, U, c) + e.template product<3>(x + psi_1, t, c);
      if (loaded) dq = dq + n.template product<6>(x + S, 0, c);
      L::store(dq, out.array(3) + c);
      L::store(e.template product<6>(x + sigma, U, c) + e.template product<3>(x + S, t, c), out.array(4) + c);
    }
  }

  /// Calls by_q, by_v and by_a with (component of τ, direction, part of the entry) for the entries of
  /// ∂τ/∂q, ∂τ/∂v and ∂τ/∂a that can differ from 0, without armatures and damping. If several joints share
  /// a velocity, an entry comes in several parts, which add up.
  template <class Real, class ByQ, class ByV, class ByA>
  void each_product(const Tree<Real>& tree, const Loads<T>& loads, const ByQ& by_q, const ByV& by_v,
                    const ByA& by_a) noexcept {
    for (int i = 1; i <= tree->n; ++i) {
      const int begin = tree->first_screw[i], next = tree->first_screw[i + 1],
                end = tree->first_screw[tree->subtree_end[i]];
      for (int l = begin; l < next; ++l) {
        multiply(l, begin, end, !loads.wrenches.empty());
        const std::ptrdiff_t v_l = tree->iv[i] + l - begin;
        for (int j = i; j < tree->subtree_end[i]; ++j)
          for (int k = tree->first_screw[j]; k < tree->first_screw[j + 1]; ++k) {
            const std::ptrdiff_t v_k = tree->iv[j] + k - tree->first_screw[j];
            if (j > i) {
              by_q(v_l, v_k, line.array(0)[k]);
              by_v(v_l, v_k, line.array(1)[k]);
              by_a(v_l, v_k, line.array(2)[k]);
            }
            by_q(v_k, v_l, line.array(3)[k]);
            by_v(v_k, v_l, line.array(4)[k]);
            by_a(v_k, v_l, line.array(2)[k]);
          }
      }
    }
  }

  /// Entries of ∂τ/∂q, ∂τ/∂v and ∂τ/∂a in one row and several columns, one column in each lane.
  struct Entries {
    Number q, v, a;
  };
  /// Computes entries of ∂τ/∂q, ∂τ/∂v and ∂τ/∂a in one row r and in adjacent columns c, one column in each
  /// SIMD lane, for a tree without couplings (D1.17). S_r and S_c are the joint screws of the row and the
  /// column. A bar means the power of a wrench on a screw, and ω(X) is the angular part of a screw X.
  ///
  /// If the joint of row r is before that of column c on a path from the ground, above() returns S_r|P_c,
  /// S_r|R_c and S_r|U_c. P_c, R_c and U_c are the changes of the wrench that the joint of column c
  /// transmits, for a unit of displacement, velocity and acceleration along S_c.
  ///
  /// If the joint of row r is that of column c or in its subtree, below() returns U_r|ψ''_c + t_r·ω(ψ'_c),
  /// U_r|σ_c + t_r·ω(S_c) and U_r|S_c. With the inertia M and the Coriolis inertia B of the subtree of joint
  /// r, U_r is the wrench M S_r, and t_r is the moment of the wrench Bᵀ S_r, whose force is 0. If the twists
  /// V of the bodies of this subtree change by X, and their rates by Y - [V, X], the force of joint r changes
  /// by U_r|Y + t_r·ω(X). For a unit of displacement along S_c, seen in a frame that is displaced with the
  /// subtree, X and Y are ψ'_c and ψ''_c, the first two time derivatives of S_c as a screw that is fixed to
  /// the predecessor of joint c. For a unit of velocity they are S_c and σ_c = ψ'_c + [V_c, S_c], where V_c
  /// is the twist of the body that joint c moves, and for a unit of acceleration 0 and S_c. If there are
  /// loads, the first number also contains (Nᵀ S_r)|S_c, where N is the load stiffness of the subtree of
  /// joint r.
  struct Columns {
    Arrays<T> effect, NtS;  // copies, so that the compiler knows that no result overwrites them
    Number screws[psi_2 + 12], psi_1_of[3], wrenches[18];

    Columns(const FirstOrder& of, int c) : effect(of.effect), NtS(of.NtS) {
      for (int k = 0; k < 18; ++k) screws[k] = L::load(effect.array(S + k) + c);
      for (int k = 0; k < 18; ++k) wrenches[k] = L::load(effect.array(U + k) + c);
      for (int k = 0; k < 3; ++k) psi_1_of[k] = L::load(effect.array(psi_1 + k) + c);
    }
    Entries above(int r) const {
      return {product<6>(effect, S, r, wrenches + (P - U)), product<6>(effect, S, r, wrenches + (R - U)),
              product<6>(effect, S, r, wrenches)};
    }
    Entries below(int r, bool loaded) const {
      Number q = product<6>(effect, U, r, screws + psi_2) + product<3>(effect, t, r, psi_1_of);
      if (loaded) q = q + product<6>(NtS, 0, r, screws);
      return {q, product<6>(effect, U, r, screws + sigma) + product<3>(effect, t, r, screws),
              product<6>(effect, U, r, screws)};
    }

   private:
    /// The sum of component k + m of row r times several[m] over m = 0 to n - 1.
    template <int n> static Number product(const Arrays<T>& rows, int k, int r, const Number* several) {
      const T* const x = rows.array(k) + r;
      Number sum = x[0] * several[0];
      for (int m = 1; m < n; ++m) sum = sum + x[m * rows.stride] * several[m];
      return sum;
    }
  };

  template <class Real>
  static void add_losses(const Tree<Real>& tree, const Loads<T>& loads, std::ptrdiff_t stride,
                         T* dv) noexcept {
    if (!loads.joint_losses) return;
    for (std::ptrdiff_t c = 0; c < tree->nv; ++c)
      dv[c * stride + c] += T(tree.damping[static_cast<std::size_t>(c)]);
  }
  /// Writes ∂τ/∂q, ∂τ/∂v and ∂τ/∂a, without armatures, to dq, dv and da for a tree without couplings. The
  /// rows of each matrix are `stride` numbers apart. If da is null, ∂τ/∂a is not computed.
  template <class Real>
  void write_columns(const Tree<Real>& tree, const Loads<T>& loads, std::ptrdiff_t stride, T* dq, T* dv,
                     T* da) const noexcept {
    const Topology& topology = *tree.operator->();
    const bool loaded = !loads.wrenches.empty();
    for (int c = last_block<T>(tree->nv); c >= 0; c -= L::width) {
      if (da)
        write_columns<true>(topology, c, loaded, stride, dq, dv, da);
      else
        write_columns<false>(topology, c, loaded, stride, dq, dv, da);
    }
    add_losses(tree, loads, stride, dv);
  }
  /// Writes the columns c, c + 1, ... of ∂τ/∂q, ∂τ/∂v and ∂τ/∂a, one in each SIMD lane. All later columns
  /// must have been written before. The reasons are that lanes beyond the end of a row overwrite the first
  /// entries of the next row, and that code with one lane copies entries of the symmetric matrix ∂τ/∂a
  /// from later columns.
  template <bool with_a>
  void write_columns(const Topology& topology, int c, bool loaded, std::ptrdiff_t stride, T* dq, T* dv,
                     T* da) const noexcept {
    const int nv = topology.nv, next = std::min(c + L::width, nv);
    const auto end_of = [&](int k) { return topology.velocity_end[k]; };
    const auto joint_of = [&](int k) { return topology.first_screw[screws.body_of[k]]; };
    int end = next;  // of the rows that are not 0
    for (int k = c; k < next; ++k) end = std::max(end, end_of(k));
    const auto put = [&](int r, const Entries& x) {
      const std::ptrdiff_t at = r * stride + c;
      const int room = static_cast<int>(nv * stride - at);
      L::store(x.q, dq + at, room);
      L::store(x.v, dv + at, room);
      if constexpr (with_a) L::store(x.a, da + at, room);
    };
    const Number zero(T(0));
    const Entries zeros{zero, zero, zero};
    const Columns columns(*this, c);
    if constexpr (L::width == 1) {
      for (int r = 0; r < joint_of(c); ++r) put(r, end_of(r) > c ? columns.above(r) : zeros);
      for (int r = joint_of(c); r <= c; ++r) put(r, columns.below(r, loaded));
      for (int r = c + 1; r < end; ++r) {
        const Entries x = columns.below(r, loaded);
        if constexpr (with_a)
          put(r, {x.q, x.v, da[c * stride + r]});
        else
          put(r, x);
      }
    } else {
      Number column, joint, subtree;  // of each lane: its column, the first column of its joint, and the end
                                      // of the columns that this joint moves
      for (int l = 0; l < L::width; ++l) {
        const int k = std::min(c + l, nv - 1);
        column.x[l] = T(c + l);
        joint.x[l] = T(joint_of(k));
        subtree.x[l] = T(end_of(k));
      }
      const auto clear = [&](const auto& where, const Entries& x) {
        return Entries{select(where, zero, x.q), select(where, zero, x.v), select(where, zero, x.a)};
      };
      for (int r = 0; r < joint_of(c); ++r) {
        if (end_of(r) <= c)
          put(r, zeros);
        else if (end_of(r) < next)
          put(r, clear(Number(T(end_of(r))) <= column, columns.above(r)));
        else
          put(r, columns.above(r));
      }
      for (int r = joint_of(c); r < next; ++r) {
        const Number row(static_cast<T>(r));
        const auto is_above = row < joint;
        const Entries a = columns.above(r), b = columns.below(r, loaded);
        put(r, clear(subtree <= row || (is_above && Number(T(end_of(r))) <= column),
                     {select(is_above, a.q, b.q), select(is_above, a.v, b.v), select(is_above, a.a, b.a)}));
      }
      for (int r = next; r < end; ++r)
        put(r, clear(subtree <= Number(static_cast<T>(r)), columns.below(r, loaded)));
    }
    for (int r = end; r < nv; ++r) put(r, zeros);
  }

  [[gnu::noinline]] void stiffen(const Topology& topology) noexcept {
    sum_subtrees(topology, N);
    for (int i = 1; i <= topology.n; ++i)
      for (int c = topology.first_screw[i]; c < topology.first_screw[i + 1]; ++c) {
        const Wrench<Spatial, T> NS = N[i] * screws.screw(c), NtS_c = N[i].transposed_times(screws.screw(c));
        NtS.set3(NtS_c.m, 0, c);
        NtS.set3(NtS_c.f, 3, c);
        for (int k = 0; k < 6; ++k) effect.array(P + k)[c] += entry(NS, k);
      }
  }
};

}  // namespace axode
