#pragma once
#include "axode/derivatives/displacement/accelerations.hpp"
#include "axode/derivatives/displacement/first_order.hpp"
#include "axode/derivatives/displacement/geometric_parameters.hpp"

namespace axode {

/// Computes the derivatives ∂τ/∂π of the joint forces τ of inverse dynamics by geometric parameters π. The
/// six parameters of a body displace its joint and its subtree, relative to the predecessor, along the six
/// unit screws of the frame that the body has while its joint is at zero. See (D1.18) of docs/derivations.
template <class T> struct GeometryDerivatives {
  using L = Lanes<T>;
  using Number = typename L::Number;

  FirstOrder<T> state;
  Arrays<T> line;  ///< derivatives of the forces of all columns in the subtree by one parameter

  explicit GeometryDerivatives(Arena& arena) : state(arena), line(arena, 1, arena.topology().n_screws) {}

  /// Writes ∂τ/∂π, nv × n × 6 numbers for n bodies, [component, body - 1, unit screw].
  void run(const Tree<T>& tree, const T* q, const T* v, const T* a, const Loads<T>& loads, T* out) noexcept {
    const bool loaded = !loads.wrenches.empty();
    state.run(tree, q, v, a, loads);
    const MovingScrews<T>& screws = state.screws;
    std::fill_n(out, static_cast<std::ptrdiff_t>(tree->nv) * tree->n * 6, T(0));
    for (int i = 1; i <= tree->n; ++i) {
      const int first = tree->first_screw[i], end = tree->first_screw[tree->subtree_end[i]];
      const Motion6<T> V_p = screws.six(first, MovingScrews<T>::OfColumn::V_p),
                       dV_p = screws.six(first, MovingScrews<T>::OfColumn::dV_p);
      const MovingInertia<T> subtree = screws.subtree_of_column(first);
      each_unit_screw(screws.pose(i) * frame_at_zero(tree, i, q), [&](int u, const Screw<T>& unit) {
        const Motion6<T> J{unit.w, unit.v};
        T* const column = out + (i - 1) * 6 + u;
        const auto add = [&](int j, int c, const T& x) {
          column[static_cast<std::ptrdiff_t>(tree->iv[j] + c - tree->first_screw[j]) * tree->n * 6] += x;
        };
        const CarriedScrew<T> psi(V_p, dV_p, J);
        multiply(psi, J, first, end, loaded);
        for (int j = i; j < tree->subtree_end[i]; ++j)
          for (int c = tree->first_screw[j]; c < tree->first_screw[j + 1]; ++c) add(j, c, line.array(0)[c]);
        const Momentum<Spatial, T> Pi = subtree.M * psi.second;
        Wrench<Spatial, T> P = Wrench<Spatial, T>{Pi.l, Pi.p} + subtree.B * psi.first + coad(J, subtree.F);
        if (loaded) P += state.N[i] * J;
        for (int j = tree->parent[i]; j > 0; j = tree->parent[j])
          for (int c = tree->first_screw[j]; c < tree->first_screw[j + 1]; ++c)
            add(j, c, P | screws.screw(c));
      });
    }
  }

 private:
  /// Computes the derivatives of the joint forces for a displacement of a subtree along a screw J (D1.18),
  /// and writes them to `line`: one for each of the joint screws from `begin` to `end` - 1, whose joints must
  /// be in the subtree. psi has the time derivatives of J as a screw that is fixed to the body before the
  /// subtree. `loaded` says whether there are loads.
  void multiply(const CarriedScrew<T>& psi, const Motion6<T>& J, int begin, int end, bool loaded) noexcept {
    using Part = typename FirstOrder<T>::Part;
    for (int c = begin; c < end; c += L::width) {
      const auto several = [&](int k) { return L::load(state.effect.array(k) + c); };
      Number sum(T(0));
      for (int k = 0; k < 6; ++k) sum = sum + Number(entry(psi.second, k)) * several(Part::U + k);
      sum = sum + Number(psi.first.w.x) * several(Part::t) + Number(psi.first.w.y) * several(Part::t + 1) +
            Number(psi.first.w.z) * several(Part::t + 2);
      if (loaded)
        for (int k = 0; k < 6; ++k) sum = sum + Number(entry(J, k)) * L::load(state.NtS.array(k) + c);
      L::store(sum, line.array(0) + c);
    }
  }
};

/// Computes ∂a/∂π of forward dynamics with respect to the geometric parameters π, each of which displaces a
/// subtree along a unit screw: -M⁻¹ ∂τ/∂π, with the mass matrix M and ∂τ/∂π of inverse dynamics at the
/// accelerations a.
template <class T> struct ForwardGeometryDerivatives {
  AccelerationsAndColumns<T> forward;
  GeometryDerivatives<T> inverse;
  T* x;

  explicit ForwardGeometryDerivatives(Arena& arena)
      : forward(arena), inverse(arena), x(arena.per_velocity<T>()) {}

  Solvability run(const Tree<T>& tree, const T* q, const T* v, const T* tau, const Loads<T>& loads,
                  T* out) noexcept {
    const std::ptrdiff_t columns = static_cast<std::ptrdiff_t>(tree->n) * 6;
    const Solvability verdict = forward.run(tree, q, v, tau, loads);
    if (!verdict.ok()) return verdict;
    inverse.run(tree, q, v, forward.a, loads, out);
    for (std::ptrdiff_t k = 0; k < columns; ++k) {
      for (std::ptrdiff_t c = 0; c < tree->nv; ++c) x[c] = -out[c * columns + k];
      forward.solve_one(tree, x);
      for (std::ptrdiff_t c = 0; c < tree->nv; ++c) out[c * columns + k] = x[c];
    }
    return verdict;
  }
};

}  // namespace axode
