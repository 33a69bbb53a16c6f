#pragma once
#include "axode/derivatives/first_order.hpp"

namespace axode {

/// Where the second partial derivatives of nv results go: nv × nv × nv each, [component][outer derivative][inner derivative].
template <class T> struct SecondDerivatives { T *qq, *qv, *vv, *aq; };

/// The second partial derivatives of inverse dynamics. For a displacement of l and one of k behind it the rows behind k are
/// products of 18 numbers of the row, and those before it of the screw of the row and one wrench. O(n d²).
template <class T> struct SecondOrderTensors {
  using L = Lanes<T>;
  using Number = typename L::Number;
  using X6 = Motion6<T>;
  using W6 = Wrench<Spatial, T>;

  FirstOrder<T> first;
  Arrays<T> BS;    ///< CoriolisInertia of all behind a column with its screw in the place of V
  Arrays<T> line;  ///< a result in all rows

  explicit SecondOrderTensors(Arena& arena)
      : first(arena), BS(arena, 12, arena.topology().n_screws), line(arena, 1, arena.topology().n_screws) {}

  template <class Real>
  void run(const Tree<Real>& tree, const T* q, const T* v, const T* a,
           const SecondDerivatives<T>& out) noexcept {
    const Topology& topology = *tree.operator->();
    first.run(tree, q, v, a, Loads<T>{});
    for (int c = 0; c < topology.n_screws; c += L::width) {
      const auto B = std::bit_cast<std::array<Number, 12>>(
          CoriolisInertia<Number>::of(first.screws.behind_columns(c).M, load6(first.screws.S, c)));
      for (std::size_t k = 0; k < B.size(); ++k) L::store(B[k], BS.array(static_cast<int>(k)) + c);
    }
    const std::ptrdiff_t nv = topology.nv;
    for (T* const tensor : {out.qq, out.qv, out.vv, out.aq}) std::fill_n(tensor, nv * nv * nv, T(0));
    for (int b_k = 1; b_k <= topology.n; ++b_k)
      for (int k = topology.first_screw[b_k]; k < topology.first_screw[b_k + 1]; ++k)
        for (int b_l = b_k; b_l > 0; b_l = topology.parent[b_l])
          for (int l = topology.first_screw[b_l]; l < topology.first_screw[b_l + 1]; ++l)
            pair(topology, {l, b_l}, {k, b_k}, out);
  }

 private:
  struct Column {
    int c, body;
  };
  /// What a row is made of: behind k of x, b and (y, z), before k of these, W and, before l, Q.
  struct Terms {
    X6 x{}, b{}, y{}, z{};
    W6 W{}, Q{};
    bool bilinear = false;  ///< whether there are y and z
  };

  using Part = typename FirstOrder<T>::Part;
  X6 motion(int part, int c) const { return {first.effect.get3(part, c), first.effect.get3(part + 3, c)}; }
  W6 wrench(int part, int c) const { return {first.effect.get3(part, c), first.effect.get3(part + 3, c)}; }

  void pair(const Topology& t, Column l, Column k, const SecondDerivatives<T>& out) noexcept {
    const MovingScrews<T>& screws = first.screws;
    const auto psi = [&](int c) {
      return ad(X6{screws.V_p.get3(0, c), screws.V_p.get3(3, c)}, screws.screw(c));
    };
    const bool same = l.body == k.body;
    const X6 S_l = motion(Part::S, l.c), S_k = motion(Part::S, k.c), psi_l = psi(l.c), psi_k = psi(k.c),
             psi_2_l = motion(Part::psi_2, l.c), sigma_l = motion(Part::sigma, l.c), bracket = ad(S_l, S_k);
    const MovingInertia<T> moved = screws.behind_column(k.c);
    const auto M = [&](const X6& X) {
      const Momentum<Spatial, T> Pi = moved.M * X;
      return W6{Pi.l, Pi.p};
    };
    const auto& B = moved.B;
    put(t, l, k, moved,
        {ad(psi_2_l, S_k) + T(2) * ad(psi_l, psi_k), ad(psi_l, S_k), psi_l, psi_k, M(psi_2_l) + B * psi_l,
         wrench(Part::P, k.c), true},
        [&](std::ptrdiff_t o, std::ptrdiff_t i, const T& x) {
          out.qq[o] += x;
          if (!same) out.qq[i] += x;
        });
    put(t, l, k, moved, {T(2) * ad(psi_l, S_k), {}, psi_l, S_k, {}, wrench(Part::R, k.c), true},
        [&](std::ptrdiff_t o, std::ptrdiff_t, const T& x) { out.qv[o] += x; });
    put(t, l, k, moved, {same ? bracket : T(2) * bracket, {}, S_l, S_k, {}, {}, true},
        [&](std::ptrdiff_t o, std::ptrdiff_t i, const T& x) {
          out.vv[o] += x;
          if (!same) out.vv[i] += x;
        });
    put(t, l, k, moved, {{}, {}, {}, {}, {}, wrench(Part::U, k.c)},
        [&](std::ptrdiff_t, std::ptrdiff_t i, const T& x) { out.aq[i] += x; });
    if (same) return;
    put(t, l, k, moved,
        {ad(sigma_l, S_k) + T(2) * ad(S_l, psi_k), bracket, S_l, psi_k, M(sigma_l) + B * S_l, {}, true},
        [&](std::ptrdiff_t, std::ptrdiff_t i, const T& x) { out.qv[i] += x; });
    put(t, l, k, moved, {bracket, {}, {}, {}, M(S_l), {}},
        [&](std::ptrdiff_t o, std::ptrdiff_t, const T& x) { out.aq[o] += x; });
  }

  /// add(index of [row][l][k], index of [row][k][l], entry) for every row.
  template <class Add>
  void put(const Topology& t, Column l, Column k, const MovingInertia<T>& moved, const Terms& s,
           const Add& add) noexcept {
    const std::ptrdiff_t nv = t.nv, v_l = t.iv[l.body] + l.c - t.first_screw[l.body],
                         v_k = t.iv[k.body] + k.c - t.first_screw[k.body];
    const auto add_row = [&](std::ptrdiff_t row, const T& x) {
      add((row * nv + v_l) * nv + v_k, (row * nv + v_k) * nv + v_l, x);
    };
    const int begin = t.first_screw[k.body], end = t.first_screw[t.subtree_end[k.body]];
    rows_behind(begin, end, s);
    for (int j = k.body; j < t.subtree_end[k.body]; ++j)
      for (int c = t.first_screw[j]; c < t.first_screw[j + 1]; ++c)
        add_row(t.iv[j] + c - t.first_screw[j], line.array(0)[c]);
    const Momentum<Spatial, T> Mx = moved.M * s.x;
    W6 G = W6{Mx.l, Mx.p} + moved.B * s.b + coad(motion(Part::S, k.c), s.W);
    if (s.bilinear) G += CoriolisInertia<T>::of(moved.M, s.y) * s.z;
    const W6 also = coad(motion(Part::S, l.c), s.Q);
    bool before_l = false;
    for (int j = k.body; (j = t.parent[j]) > 0;) {
      if (!before_l && j < l.body) before_l = true, G += also;
      for (int c = t.first_screw[j]; c < t.first_screw[j + 1]; ++c)
        add_row(t.iv[j] + c - t.first_screw[j], G | motion(Part::S, c));
    }
  }
  /// U_i|x + T_i|b - y·B_i z of the rows from begin on.
  void rows_behind(int begin, int end, const Terms& s) noexcept {
    const Vec3<T> w = T(-2) * s.z.w, p = cross(s.y.v, w);  // -y·B z = D : (y w') + p'·(v_y × w')
    const T x[] = {s.x.w.x, s.x.w.y, s.x.w.z, s.x.v.x, s.x.v.y, s.x.v.z, s.b.w.x, s.b.w.y, s.b.w.z};
    const T y[] = {s.y.w.x * w.x, s.y.w.y * w.x, s.y.w.z * w.x, s.y.w.x * w.y, s.y.w.y * w.y, s.y.w.z * w.y,
                   s.y.w.x * w.z, s.y.w.y * w.z, s.y.w.z * w.z, p.x,           p.y,           p.z};
    for (int c = begin; c < end; c += L::width) {
      Number sum = Number(x[0]) * L::load(first.effect.array(Part::U) + c);
      for (int k = 1; k < 6; ++k) sum = sum + Number(x[k]) * L::load(first.effect.array(Part::U + k) + c);
      for (int k = 0; k < 3; ++k) sum = sum + Number(x[6 + k]) * L::load(first.effect.array(Part::t + k) + c);
      if (s.bilinear)
        for (int k = 0; k < 12; ++k) sum = sum + Number(y[k]) * L::load(BS.array(k) + c);
      L::store(sum, line.array(0) + c);
    }
  }
};

}  // namespace axode
