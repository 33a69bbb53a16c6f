#pragma once
#include <algorithm>

#include "axode/derivatives/displacement/load_stiffness.hpp"
#include "axode/derivatives/displacement/moving_screws.hpp"
#include "axode/lie/six.hpp"
#include "axode/recursion/spatial_tree.hpp"

namespace axode {

/// Computes ∂τ/∂q, ∂τ/∂v and ∂τ/∂a of inverse dynamics by products of every joint screw with the joint screws
/// of its subtree ((D1.17) of docs/derivations). It takes 67 products and sums for each such pair.
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
        effect(arena, static_cast<int>(ScrewEffects<T>::size), arena.topology().n_screws),
        line(arena, results, arena.topology().n_screws),
        inertial(arena),
        N(arena.per_body<LoadStiffness<T>>()),
        NtS(arena, 6, arena.topology().n_screws),
        own(arena.per_velocity<T>()) {}

  /// Computes the ScrewEffects of all columns at a state.
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
  /// Computes, for each joint screw, the screws and wrenches from whose products the derivatives follow
  /// (ScrewEffects), from the motion of the bodies in `screws`. `loaded` says whether there are loads.
  void compose(const Topology& topology, bool loaded) noexcept {
    screws.compose(topology);
    for (int c = 0; c < topology.n_screws; c += L::width) {
      const auto numbers = std::bit_cast<typename ScrewEffects<Number>::Entries>(screws.effects(c));
      for (std::size_t k = 0; k < numbers.size(); ++k)
        L::store(numbers[k], effect.array(static_cast<int>(k)) + c);
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
    for (T* const matrix : {dq, dv, da}) std::fill_n(matrix, nv * nv, T(0));
    const bool loaded = !loads.wrenches.empty();
    for (int i = 1; i <= tree->n; ++i) {
      const int begin = tree->first_screw[i], next = tree->first_screw[i + 1],
                end = tree->first_screw[tree->subtree_end[i]];
      for (int l = begin; l < next; ++l) {
        multiply(l, begin, end, loaded);
        if (tree->coupled_bodies.empty()) [[likely]] {
          for (int k = next; k < end; ++k) {
            dq[l * nv + k] = line.array(0)[k];
            dv[l * nv + k] = line.array(1)[k];
            da[l * nv + k] = line.array(2)[k];
          }
          for (int k = begin; k < end; ++k) {
            dq[k * nv + l] = line.array(3)[k];
            dv[k * nv + l] = line.array(4)[k];
            da[k * nv + l] = line.array(2)[k];
          }
        } else {
          const auto add = [&](T* matrix) {
            return [matrix, nv](std::ptrdiff_t r, std::ptrdiff_t c, const T& x) { matrix[r * nv + c] += x; };
          };
          each_entry_of(tree, l, i, add(dq), add(dv), add(da));
        }
      }
    }
    for (std::ptrdiff_t c = 0; c < nv; ++c) {
      da[c * nv + c] += T(tree.armature[static_cast<std::size_t>(c)]);
      if (loads.joint_losses) dv[c * nv + c] += T(tree.damping[static_cast<std::size_t>(c)]);
    }
  }

  /// Calls by_q(component of τ, direction, part of the entry) for every entry of ∂τ/∂q that can differ from
  /// 0, and by_v with the same arguments for ∂τ/∂v. An entry of a velocity that several joints share comes in
  /// several parts, which add up.
  template <class Real, class ByQ, class ByV>
  void each_entry(const Tree<Real>& tree, const Loads<T>& loads, const ByQ& by_q, const ByV& by_v) noexcept {
    for (int i = 1; i <= tree->n; ++i)
      for (int l = tree->first_screw[i]; l < tree->first_screw[i + 1]; ++l) {
        multiply(l, tree->first_screw[i], tree->first_screw[tree->subtree_end[i]], !loads.wrenches.empty());
        each_entry_of(tree, l, i, by_q, by_v, [](std::ptrdiff_t, std::ptrdiff_t, const T&) {});
      }
    if (loads.joint_losses)
      for (std::ptrdiff_t c = 0; c < tree->nv; ++c) by_v(c, c, T(tree.damping[static_cast<std::size_t>(c)]));
  }

  /// Calls f(load, body, point, moment, force) for each load on a moving body: the load as it was given, its
  /// body, its point, and the moment and the force. Vectors are in inertial axes, and the point is relative
  /// to the origin of the root of the body.
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
  /// Multiplies the screws and wrenches that belong to joint screw l (ScrewEffects) with those of the joint
  /// screws from `begin` to `end` - 1. Writes five products for each pair to `line`; the derivatives are sums
  /// of such products.
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

  /// Calls by_q, by_v and by_a as f(component of τ, direction, part of the entry) for the entries of ∂τ/∂q,
  /// ∂τ/∂v and ∂τ/∂a that belong to joint screw l of body i and a screw of its subtree. The products for l
  /// must have been computed by multiply().
  template <class Real, class ByQ, class ByV, class ByA>
  void each_entry_of(const Tree<Real>& tree, int l, int i, const ByQ& by_q, const ByV& by_v,
                     const ByA& by_a) const noexcept {
    const std::ptrdiff_t v_l = tree->iv[i] + l - tree->first_screw[i];
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
