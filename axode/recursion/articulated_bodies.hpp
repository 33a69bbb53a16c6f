#pragma once
#include "axode/recursion/forward_kinematics.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The articulated-body algorithm, which solves M x = b for the mass matrix M in O(n) (Featherstone; (D4.2)
/// to (D4.11) of docs/derivations).
///
/// From the leaves to the roots each screw S of a joint is eliminated from the articulated inertia M^A, which
/// is the inertia of the body with the joints of its subtree free:
///   U = M^A S,  D = Sᵀ U + armature,  M^A -= U Uᵀ / D.
/// After the last screw of a joint, M^A is moved to the predecessor and added to the inertia there. The
/// rounding errors of a pivot D are estimated from the magnitudes F of the numbers of which it is the
/// difference.
///
/// A velocity that coupled joints share is eliminated at the body where the paths from these joints to the
/// ground meet. Each body on these paths has an additional column of its inertia for this velocity, called a
/// tie (Topology::Ties).
template <class Rep, class T> struct ArticulatedBodies {
  BodyLinks<Rep, T> links;
  Inertia<T>* M_body;  ///< rigid inertia of each body, as Link::inertia() returns it
  ArticulatedInertia<Rep, T>* M;
  ArticulatedInertia<Rep, T>* F;  ///< magnitude of the numbers from which M is computed
  Twist<Rep, T>* S;
  Wrench<Rep, T>* U;
  T* D;
  // The following members are for ties, the columns of velocities that coupled joints share.
  Wrench<Rep, T>* U_tie;
  T* D_tie;      ///< k × k for each group of k ties
  T* scale_tie;  ///< magnitude of the numbers from which the diagonal of D_tie is computed
  T* D_screw;    ///< D between each screw and the ties of its body; body i begins at ties.of_screws[i]
  // The following members are for the solution of M x = b.
  Wrench<Rep, T>* W;
  Twist<Rep, T>* X;
  T *u, *u_tie;

  explicit ArticulatedBodies(Arena& arena)
      : links(arena),
        M_body(arena.per_body<Inertia<T>>()),
        M(arena.per_body<ArticulatedInertia<Rep, T>>()),
        F(arena.per_body<ArticulatedInertia<Rep, T>>()),
        S(arena.per_screw<Twist<Rep, T>>()),
        U(arena.per_screw<Wrench<Rep, T>>()),
        D(arena.per_screw<T>()),
        U_tie(arena.per_tie<Wrench<Rep, T>>()),
        D_tie(arena.per_pair_of_ties<T>()),
        scale_tie(arena.per_tie<T>()),
        D_screw(arena.per_tie_and_screw<T>()),
        W(arena.per_body<Wrench<Rep, T>>()),
        X(arena.per_body<Twist<Rep, T>>()),
        u(arena.per_screw<T>()),
        u_tie(arena.per_tie<T>()) {}

  /// Factorises the mass matrix at q. `armature` has one entry for each velocity. O(n).
  template <TreeOf<T> AnyTree>
  Solvability factorize(const AnyTree& tree, const T* q, const T* armature) noexcept {
    links.run(tree, q);
    return factorize(tree, armature);
  }
  /// Factorises the mass matrix at the configuration for which `links` were computed.
  template <TreeOf<T> AnyTree> Solvability factorize(const AnyTree& tree, const T* armature) noexcept {
    put_screws_and_inertias(tree);
    return eliminate_joints(tree, armature);
  }
  /// Factorises the mass matrix at the configuration for which `links` was computed. Calls check.add(c, D,
  /// scale) for each velocity c with its pivot D, the inertia that remains when it is eliminated; scale()
  /// returns the magnitude of the numbers from which D was computed.
  template <TreeOf<T> AnyTree, class Check>
  void factorize(const AnyTree& tree, const T* armature, Check& check) noexcept {
    put_screws_and_inertias(tree);
    eliminate_joints(tree, armature, check);
  }
  /// Computes the joint screws S and the rigid inertias `M_body` at the present configuration (in `links`).
  template <TreeOf<T> AnyTree> void put_screws_and_inertias(const AnyTree& tree) noexcept {
    joint_columns(tree, links.link, S);
    put_inertias(tree);
  }
  /// Computes only the rigid inertias `M_body`.
  template <TreeOf<T> AnyTree> void put_inertias(const AnyTree& tree) noexcept {
    for (int i = 1; i <= tree->n; ++i) M_body[i] = links.link[i].inertia(tree.M[i]);
  }
  /// Factorises the mass matrix from the joint screws S and the rigid inertias `M_body`. Rounding errors of
  /// pivots (the inertias that remain when velocities are eliminated) are estimated only if a pivot is small
  /// or the tree has coupled joints.
  template <TreeOf<T> AnyTree> Solvability eliminate_joints(const AnyTree& tree, const T* armature) noexcept {
    if (tree->coupled_bodies.empty() && eliminate_fast(tree, armature)) return {};
    PivotCheck<T> check;
    eliminate_joints(tree, armature, check);
    return check.verdict(*tree.operator->());
  }
  /// Factorises the mass matrix from the joint screws S and the rigid inertias `M_body`, and estimates the
  /// rounding error of every pivot. Calls check.add(c, D, scale) for each velocity c with its pivot D, the
  /// inertia that remains when it is eliminated; scale() returns the magnitude of the numbers from which D
  /// was computed.
  template <TreeOf<T> AnyTree, class Check>
  void eliminate_joints(const AnyTree& tree, const T* armature, Check& check) noexcept {
    const Topology::Ties& ties = tree->ties;
    for (int t = 0; t < ties.begin[tree->n + 1]; ++t) {
      U_tie[t] = {};
      scale_tie[t] = T(0);
    }
    for (std::size_t k = 0; k < ties.n_pairs; ++k) D_tie[k] = T(0);
    M[0] = {};
    F[0] = {};
    for (int i = 1; i <= tree->n; ++i) {
      M[i] = articulated(links.link[i], M_body[i]);
      F[i] = size_of<Rep>(M_body[i]);
    }
    for (int i = tree->n; i > 0; --i) {
      for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t)
        if (turn(ties, i, t) == before) eliminate_tie(tree, i, t, armature, check);
      const int first = tree->first_screw[i];
      for (int s = tree->first_screw[i + 1] - 1; s >= first; --s) {
        if (ties.own[i] >= 0) {
          enter(tree, i, s);
        } else {
          const T I = armature[tree->iv[i] + s - first];
          U[s] = M[i] * S[s];
          D[s] = (U[s] | S[s]) + I;
          const Wrench<Rep, T> G = F[i] * S[s];
          const T size = (G | S[s]) + I;
          check.add(tree->iv[i] + s - first, D[s], [&] { return size; });
          eliminate_screw(tree, i, s, G, size);
        }
      }
      if (own_tie_ends(ties, i)) eliminate_tie(tree, i, ties.own[i], armature, check);
      const int p = tree->parent[i];
      M[p] += links.link[i].up(M[i]);
      F[p] += links.link[i].up(F[i]);
      pass_ties_to_parent(tree, i);
    }
    for (int t = ties.begin[0]; t < ties.begin[1]; ++t) eliminate_tie(tree, 0, t, armature, check);
  }

  /// Replaces x by M⁻¹ x, after factorize(). O(n).
  template <TreeOf<T> AnyTree> void solve(const AnyTree& tree, T* x) noexcept {
    backward_sweep(tree, x);
    forward_sweep(tree, x);
  }
  /// Replaces the drive forces x by the joint accelerations a, once the mass matrix has been factorised. W[i]
  /// must be the wrench that body i needs to keep its twist, minus the applied wrenches. bias[i] is the part
  /// of the twist rate of body i, relative to its predecessor, that does not depend on a, and bias[0] is the
  /// twist rate of the ground. A null `bias` means that all are 0. O(n).
  template <TreeOf<T> AnyTree>
  void accelerate(const AnyTree& tree, const TwistRate<Rep, T>* bias, T* x) noexcept {
    W[0] = {};
    clear_ties(tree);
    for (int i = tree->n; i > 0; --i) backward_step(tree, i, x, bias);
    backward_step_at_ground(tree, x);
    forward_sweep(tree, x, bias);
  }

  /// The backward sweep, from the leaves to the roots, of the solution of equations with the mass matrix M =
  /// Lᵀ D L. It computes u = L⁻ᵀ x from the vector x of the right sides, which has one entry for each
  /// velocity.
  template <TreeOf<T> AnyTree> void backward_sweep(const AnyTree& tree, const T* x) noexcept {
    for (int i = 0; i <= tree->n; ++i) W[i] = {};
    clear_ties(tree);
    for (int i = tree->n; i > 0; --i) backward_step(tree, i, x);
    backward_step_at_ground(tree, x);
  }
  /// The step at body i of the backward sweep, the first half of the solution of equations with the mass
  /// matrix for the right sides x, one for each velocity. It must follow the steps of all other bodies in the
  /// subtree. If joint accelerations are computed, bias[i] is the twist rate of body i, relative to its
  /// predecessor, for zero joint accelerations; a null `bias` means that all are 0.
  template <TreeOf<T> AnyTree>
  void backward_step(const AnyTree& tree, int i, const T* x,
                     const TwistRate<Rep, T>* bias = nullptr) noexcept {
    const Topology::Ties& ties = tree->ties;
    for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t)
      if (turn(ties, i, t) == before) backward_step_of_tie(tree, i, t, x);
    const int first = tree->first_screw[i];
    for (int s = tree->first_screw[i + 1] - 1; s >= first; --s) {
      if (ties.own[i] >= 0) {
        u_tie[ties.own[i]] += W[i] | S[s];
      } else {
        u[s] = x[tree->iv[i] + s - first] - (W[i] | S[s]);
        const T k = u[s] / D[s];
        W[i] += k * U[s];
        const T* const D_s = of_screw(tree, i, s);
        for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t)
          if (ties.up[t] >= 0) u_tie[t] += k * D_s[t];
      }
    }
    if (own_tie_ends(ties, i)) backward_step_of_tie(tree, i, ties.own[i], x);
    if (bias != nullptr) {
      const Twist<Rep, T> of_bias{bias[i].w, bias[i].v};
      W[i] += M[i] * of_bias;
      for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t)
        if (ties.up[t] >= 0) u_tie[t] += U_tie[t] | of_bias;
    }
    for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t)
      if (ties.up[t] >= 0) u_tie[ties.up[t]] += u_tie[t];
    W[tree->parent[i]] += links.link[i].up(W[i]);
  }
  /// The backward sweep at the ground, for velocities of coupled joints on paths that meet only there.
  template <TreeOf<T> AnyTree> void backward_step_at_ground(const AnyTree& tree, const T* x) noexcept {
    for (int t = tree->ties.begin[0]; t < tree->ties.begin[1]; ++t) backward_step_of_tie(tree, 0, t, x);
  }
  /// Calls f(c, u_c, D_c) for each velocity c that is eliminated at body i (0 is the ground). These are the
  /// velocities of joint i, unless other, coupled joints share them, and the shared velocities for which the
  /// paths from the coupled joints to the ground meet at body i. D_c is the pivot of the velocity in the mass
  /// matrix Lᵀ D L, and u_c is the entry of u = L⁻ᵀ x that the backward sweep has computed from the right
  /// sides x.
  template <TreeOf<T> AnyTree, class F> void each_pivot(const AnyTree& tree, int i, F&& f) const {
    const Topology::Ties& ties = tree->ties;
    if (i > 0 && ties.own[i] < 0)
      for (int s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s)
        f(tree->iv[i] + s - tree->first_screw[i], u[s], D[s]);
    for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t)
      if (ties.up[t] < 0) f(ties.velocity[t], u_tie[t], row(ties, t)[t]);
  }

  /// The forward sweep, from the roots to the leaves, of the solution of equations with the mass matrix M =
  /// Lᵀ D L. It computes x = L⁻¹ D⁻¹ u from the result u of the backward sweep. If x are joint accelerations,
  /// bias[i] is the twist rate of body i, relative to its predecessor, for x = 0, and bias[0] is the twist
  /// rate of the ground; a null `bias` means that all are 0. The backward sweep must have received the same
  /// `bias`.
  template <TreeOf<T> AnyTree>
  void forward_sweep(const AnyTree& tree, T* x, const TwistRate<Rep, T>* bias = nullptr) noexcept {
    const Topology::Ties& ties = tree->ties;
    const auto of_bias = [&](int i) { return Twist<Rep, T>{bias[i].w, bias[i].v}; };
    X[0] = bias != nullptr ? of_bias(0) : Twist<Rep, T>{};
    for (int t = ties.begin[1]; t-- > ties.begin[0];) forward_step_of_tie(tree, 0, t, x);
    for (int i = 1; i <= tree->n; ++i) {
      X[i] = links.link[i].down(X[tree->parent[i]]);
      if (bias != nullptr) X[i] += of_bias(i);
      if (own_tie_ends(ties, i)) forward_step_of_tie(tree, i, ties.own[i], x);
      const int first = tree->first_screw[i];
      for (int s = first; s < tree->first_screw[i + 1]; ++s) {
        T& x_s = x[tree->iv[i] + s - first];
        if (ties.own[i] < 0) {
          T rest = u[s] - (U[s] | X[i]);
          const T* const D_s = of_screw(tree, i, s);
          for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t)
            if (ties.up[t] >= 0) rest -= D_s[t] * x[ties.velocity[t]];
          x_s = rest / D[s];
        }
        X[i] += x_s * S[s];
      }
      for (int t = ties.begin[i + 1]; t-- > ties.begin[i];)
        if (turn(ties, i, t) == before) forward_step_of_tie(tree, i, t, x);
    }
  }

 private:
  /// Factorises the mass matrix of a tree without coupled joints, without estimates of rounding errors.
  /// Returns false if a pivot is so small that the mass matrix may be singular; the factors are then
  /// incomplete.
  template <TreeOf<T> AnyTree> bool eliminate_fast(const AnyTree& tree, const T* armature) noexcept {
    for (int i = 0; i <= tree->n; ++i) M[i] = {};
    for (auto k = tree->by_depth.rbegin(); k != tree->by_depth.rend(); ++k) {
      const int i = *k;
      ArticulatedInertia<Rep, T> left = articulated(links.link[i], M_body[i]);
      left += M[i];  // those of the bodies that joints connect to body i
      const int first = tree->first_screw[i];
      for (int s = tree->first_screw[i + 1] - 1; s >= first; --s) {
        U[s] = left * S[s];
        D[s] = (U[s] | S[s]) + armature[tree->iv[i] + s - first];
        if (!(D[s] > T(pivot_threshold<T>) * tree.inertia_scale[s])) return false;
        eliminate(left, U[s], D[s]);
      }
      M[i] = left;
      M[tree->parent[i]] += links.link[i].up(left);
    }
    return true;
  }
  /// Sets the forces u_tie on the velocities that coupled joints share (ties) to 0 before a backward sweep.
  template <class AnyTree> void clear_ties(const AnyTree& tree) noexcept {
    for (int t = 0; t < tree->ties.begin[tree->n + 1]; ++t) u_tie[t] = T(0);
  }
  /// The time at which a velocity that coupled joints share (a tie) is eliminated, as seen from body i.
  /// `before`: at body i, before the screws of joint i, which does not share the velocity. `after`: at body
  /// i, after the screws of joint i, which shares the velocity. `later`: not at body i but at a body nearer
  /// to the ground, where the paths of the coupled joints meet.
  enum Turn { before, after, later };
  static Turn turn(const Topology::Ties& ties, int i, int t) {
    return ties.up[t] >= 0 ? later : t == ties.own[i] ? after : before;
  }
  /// Whether the joint of body i shares its velocity with others and this velocity is eliminated at body i.
  static bool own_tie_ends(const Topology::Ties& ties, int i) {
    return ties.own[i] >= 0 && ties.up[ties.own[i]] < 0;
  }
  /// Whether tie o is eliminated after tie t, both ties of body i. A tie of body i is a velocity that coupled
  /// joints share, some of them in the subtree of body i, and that is eliminated at body i or nearer to the
  /// ground. For each tie the articulated inertia (6 × 6) of the body has an additional column, the wrench on
  /// the body for a unit rate of the velocity.
  static bool waits(const Topology::Ties& ties, int i, int o, int t) {
    const Turn of_o = turn(ties, i, o), of_t = turn(ties, i, t);
    return of_o > of_t || (of_o == of_t && o > t);
  }
  /// Returns the inertias that couple joint screw s of body i with the ties of body i when the velocity of
  /// the screw is eliminated; entry t belongs to tie t, and ties are numbered through all bodies. A tie of
  /// body i is a velocity that coupled joints share, some of them in the subtree of body i, and that is
  /// eliminated at body i or nearer to the ground.
  template <class AnyTree> T* of_screw(const AnyTree& tree, int i, int s) const noexcept {
    const Topology::Ties& ties = tree->ties;
    return D_screw + ties.of_screws[i] + (s - tree->first_screw[i]) * (ties.begin[i + 1] - ties.begin[i]) -
           ties.begin[i];
  }
  /// Returns the inertias that couple tie t of a body with the ties of this body, itself included, after the
  /// elimination of the velocities in the subtree that precede that of tie t in a sweep from the leaves to
  /// the ground; entry o belongs to tie o, and ties are numbered through all bodies. A tie of a body is a
  /// velocity that coupled joints share, some of them in the subtree of the body, and that is eliminated at
  /// this body or nearer to the ground. There are entries only for ties in the group of t: Topology::Ties
  /// divides the ties of a body into groups that the elimination does not couple with each other.
  T* row(const Topology::Ties& ties, int t) const noexcept {
    return D_tie + ties.row[t] - ties.group_begin[t];
  }

  /// Adds joint screw S = S[s] of body i to the tie of the velocity that its joint shares with other, coupled
  /// joints. S is the screw for a unit rate of this velocity, and M the articulated inertia of body i. A tie
  /// t is an additional column U_t (U_tie) of M for a shared velocity: the wrench on the body for a unit
  /// rate. D_to (D_tie) is the inertia that couples the ties t and o of the body. Velocities are eliminated
  /// from M one after the other, and their ties are then no longer updated. By (D4.11) of docs/derivations,
  /// for the tie t of this velocity and every other tie o of the body that is not eliminated yet,
  ///   D_tt += 2 U_t·S + Sᵀ M S,  D_to += U_o·S,  then  U_t += M S.
  template <class AnyTree> void enter(const AnyTree& tree, int i, int s) noexcept {
    const Topology::Ties& ties = tree->ties;
    const int own = ties.own[i];
    const Wrench<Rep, T> MS = M[i] * S[s];
    for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t) {
      if (turn(ties, i, t) == before) continue;
      const T D_ts = U_tie[t] | S[s];
      if (t == own) {
        row(ties, t)[t] += D_ts + D_ts + (MS | S[s]);
      } else {
        row(ties, t)[own] += D_ts;
        row(ties, own)[t] += D_ts;
      }
    }
    U_tie[own] += MS;
    scale_tie[own] += F[i] * S[s] | S[s];
  }
  /// Eliminates the velocity of screw S = S[s] of body i from the articulated inertia M of the body and from
  /// its ties. A tie is an additional column of M for a velocity that several coupled joints share and that
  /// is eliminated nearer to the ground. U[s] = M S and the pivot D[s] = Sᵀ M S + armature must have been
  /// computed. F = F[i] has the magnitudes of the numbers from which M was computed. The arguments G = F S
  /// and `size` = Sᵀ F S + armature are magnitudes of the same kind, for U[s] and D[s]; from them the
  /// function updates F, which serves to estimate rounding errors.
  template <class AnyTree>
  void eliminate_screw(const AnyTree& tree, int i, int s, const Wrench<Rep, T>& G, const T& size) noexcept {
    const Topology::Ties& ties = tree->ties;
    eliminate(M[i], U[s], D[s]);
    update_scale(F[i], G, size, U[s], D[s]);
    if (ties.begin[i] == ties.begin[i + 1]) return;
    T* const D_s = of_screw(tree, i, s);
    for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t)
      if (ties.up[t] >= 0) D_s[t] = U_tie[t] | S[s];
    for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t) {
      if (ties.up[t] < 0) continue;
      const T k = D_s[t] / D[s];
      U_tie[t] -= k * U[s];
      scale_tie[t] += k * k * size;
      for (int o = ties.group_begin[t]; o < ties.group_end[t]; ++o)
        if (ties.up[o] >= 0) row(ties, t)[o] -= k * D_s[o];
    }
  }
  /// Eliminates tie t, a velocity that several coupled joints share, at body i, where the paths of these
  /// joints to the ground meet.
  template <class AnyTree, class Check>
  void eliminate_tie(const AnyTree& tree, int i, int t, const T* armature, Check& check) noexcept {
    const Topology::Ties& ties = tree->ties;
    T* const D_t = row(ties, t);
    const T I = armature[ties.velocity[t]];
    D_t[t] += I;
    const T size = scale_tie[t] + I;
    check.add(ties.velocity[t], D_t[t], [&] { return size; });
    eliminate(M[i], U_tie[t], D_t[t]);
    update_scale(F[i], {}, size, U_tie[t], D_t[t]);
    for (int r = ties.group_begin[t]; r < ties.group_end[t]; ++r) {
      if (!waits(ties, i, r, t)) continue;
      const T k = D_t[r] / D_t[t];
      U_tie[r] -= k * U_tie[t];
      scale_tie[r] += k * k * size;
      for (int o = ties.group_begin[t]; o < ties.group_end[t]; ++o)
        if (waits(ties, i, o, t)) row(ties, r)[o] -= k * D_t[o];
    }
  }
  /// Adds the ties of body i to those of its predecessor, except for velocities that are eliminated at body
  /// i. A tie is an additional column of the articulated inertia of a body, for a velocity that several
  /// coupled joints share. It has the wrench on the body for a unit rate of this velocity, and the forces
  /// that couple the velocity with the other ties of the body.
  template <class AnyTree> void pass_ties_to_parent(const AnyTree& tree, int i) noexcept {
    const Topology::Ties& ties = tree->ties;
    for (int t = ties.begin[i]; t < ties.begin[i + 1]; ++t) {
      if (ties.up[t] < 0) continue;
      U_tie[ties.up[t]] += links.link[i].up(U_tie[t]);
      scale_tie[ties.up[t]] += scale_tie[t];
      for (int o = ties.group_begin[t]; o < ties.group_end[t]; ++o)
        if (ties.up[o] >= 0) row(ties, ties.up[t])[ties.up[o]] += row(ties, t)[o];
    }
  }

  /// The backward step for a velocity that coupled joints share. It is eliminated at body i (0 is the
  /// ground), where the paths from these joints to the ground meet. t is the index of the tie of body i for
  /// this velocity: an additional column of the articulated inertia, with the wrench U_tie[t] on the body for
  /// a unit rate of the velocity. Computes u_tie[t], the entry for this velocity of u = L⁻ᵀ x, with the mass
  /// matrix Lᵀ D L and the right sides x, and adds its contributions to the wrench W[i] and to the entries of
  /// velocities that are eliminated later.
  template <class AnyTree> void backward_step_of_tie(const AnyTree& tree, int i, int t, const T* x) noexcept {
    const Topology::Ties& ties = tree->ties;
    const T* const D_t = row(ties, t);
    u_tie[t] = x[ties.velocity[t]] - u_tie[t];
    const T k = u_tie[t] / D_t[t];
    W[i] += k * U_tie[t];
    for (int o = ties.group_begin[t]; o < ties.group_end[t]; ++o)
      if (waits(ties, i, o, t)) u_tie[o] += k * D_t[o];
  }
  /// The forward step, in the solution of equations with the mass matrix, for a velocity that coupled joints
  /// share. It is eliminated at body i (0 is the ground), where the paths from these joints to the ground
  /// meet. t is the index of the tie of body i for this velocity: an additional column of the articulated
  /// inertia, with the wrench U_tie[t] on the body for a unit rate of the velocity. Computes the entry of the
  /// solution x for this velocity. X[i] must be the motion of body i, a twist or its rate, that follows from
  /// the entries of x computed before. If joint i is one of the coupled joints, X[i] does not contain the
  /// motion of this joint yet.
  template <class AnyTree> void forward_step_of_tie(const AnyTree& tree, int i, int t, T* x) noexcept {
    const Topology::Ties& ties = tree->ties;
    const T* const D_t = row(ties, t);
    T rest = u_tie[t] - (U_tie[t] | X[i]);
    for (int o = ties.group_begin[t]; o < ties.group_end[t]; ++o)
      if (waits(ties, i, o, t)) rest -= D_t[o] * x[ties.velocity[o]];
    x[ties.velocity[t]] = rest / D_t[t];
  }
};

}  // namespace axode
