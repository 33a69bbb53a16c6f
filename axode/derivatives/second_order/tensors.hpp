#pragma once
#include "axode/derivatives/displacement/first_order.hpp"

namespace axode {

/// Receives the second partial derivatives of the nv forces τ of inverse dynamics, by the pairs of variables
/// (q, q), (q, v), (v, v) and (a, q). Each member has nv × nv × nv numbers, [component of τ][outer
/// derivative][inner derivative]. The outer derivative is by the first variable of the pair, and the inner
/// one by the second.
template <class T> struct SecondDerivatives { T *qq, *qv, *vv, *aq; };

/// Computes the second partial derivatives of all components of the forces τ of inverse dynamics by the pairs
/// of variables (q, q), (q, v), (v, v) and (a, q), by (D2.10) to (D2.15) of docs/derivations. An entry can
/// differ from 0 only if its three joint screws are on one path to the ground. It is then a sum of powers of
/// wrenches on screws, where the wrenches depend on the inertia and the motion of the subtree of the joint
/// that is farthest from the ground. O(n d²) for n bodies with d velocities on their paths to the ground, in
/// addition to the time to write the zeros.
template <class T> struct SecondOrderTensors {
  using L = Lanes<T>;
  using Number = typename L::Number;

  FirstOrder<T> first;
  Arrays<T> psi_1, B_S, B_psi;                         ///< ψ', B_S and B_ψ of each column
  int* begin;                                          ///< for each body: the index on its path at which its
                                                       ///< columns begin
  int* velocity;                                       ///< velocities of the columns on the path of a body
  Arrays<T> path_S, path_psi, path_psi_2, path_sigma;  ///< S, ψ', ψ'' and σ of the columns on the path of a
                                                       ///< body
  Arrays<T> wrench;                                    ///< the products of column d with the columns of its
                                                       ///< path, see Wrenches
  Arrays<T> line;                                      ///< the products of the wrenches with one column of
                                                       ///< the path, see Products

  explicit SecondOrderTensors(Arena& arena)
      : first(arena),
        psi_1(arena, 6, arena.topology().n_screws),
        B_S(arena, 12, arena.topology().n_screws),
        B_psi(arena, 12, arena.topology().n_screws),
        begin(arena.per_body<int>()),
        velocity(arena.per_screw<int>()),
        path_S(arena, 6, arena.topology().n_screws),
        path_psi(arena, 6, arena.topology().n_screws),
        path_psi_2(arena, 6, arena.topology().n_screws),
        path_sigma(arena, 6, arena.topology().n_screws),
        wrench(arena, 6 * wrenches, arena.topology().n_screws),
        line(arena, products, arena.topology().n_screws) {}

  template <class Real>
  void run(const Tree<Real>& tree, const T* q, const T* v, const T* a,
           const SecondDerivatives<T>& out) noexcept {
    const Topology& topology = *tree.operator->();
    first.run(tree, q, v, a, Loads<T>{});
    for (int c = 0; c < topology.n_screws; c += L::width) find_twins(c, topology.n_screws);
    const std::ptrdiff_t nv = topology.nv;
    for (T* const tensor : {out.qq, out.qv, out.vv, out.aq}) std::fill_n(tensor, nv * nv * nv, T(0));
    for (int i = 1; i <= topology.n; ++i) {
      const int first_column = topology.first_screw[i], end = extend_path(topology, i);
      for (int e = begin[i]; e < end; ++e) {
        const Last d{first_column + e - begin[i], velocity[e], begin[i], end};
        compute_wrenches(d);
        for (int p = i; p > 0; p = topology.parent[p]) {
          const int begin_p = begin[p],
                    end_p = begin_p + topology.first_screw[p + 1] - topology.first_screw[p];
          for (int j = begin_p; j < end_p; ++j) {
            multiply(j, d, begin_p, end_p);
            if (topology.coupled_bodies.empty())
              put<false>(nv, j, d, begin_p, end_p, out);
            else
              put<true>(nv, j, d, begin_p, end_p, out);
          }
        }
        if (end - begin[i] > 1) put_brackets(nv, d, out.vv);
      }
    }
  }

 private:
  using Part = typename FirstOrder<T>::Part;
  /// The joint screw, of three on one path to the ground, whose joint is the farthest from the ground. c is
  /// its index among all joint screws, and v the index of its velocity. The screws of its joint have the
  /// indices `begin` to `end` - 1 on the path.
  struct Last {
    int c;
    std::ptrdiff_t v;
    int begin, end;
  };
  enum Wrenches { US, BS, Bpsi, RS, PS, for_g, for_G, for_h, for_H, wrenches };
  enum Products { u, b, f, also_f, g, G, h, H, products };

  void find_twins(int c, int n_columns) noexcept {
    const MovingScrews<T>& screws = first.screws;
    const MovingInertia<Number> moved = screws.subtrees_of_columns(c, n_columns);
    const MovingColumn<Number> column = screws.columns_from(c);
    const Motion6<Number>&S = column.S, psi = ad(column.V_p, S);
    CoriolisInertia<Number> of_psi = CoriolisInertia<Number>::of(moved.M, psi);
    of_psi += moved.B.along(S);
    psi_1.store3(psi.w, 0, c);
    psi_1.store3(psi.v, 3, c);
    const auto store = [&](const CoriolisInertia<Number>& B, const Arrays<T>& to) {
      to.store3(B.D.x, 0, c);
      to.store3(B.D.y, 3, c);
      to.store3(B.D.z, 6, c);
      to.store3(B.p, 9, c);
    };
    store(CoriolisInertia<Number>::of(moved.M, S), B_S);
    store(of_psi, B_psi);
  }
  /// Appends the joint screws (columns) of body i to those of its path, and returns the index after the last.
  int extend_path(const Topology& topology, int i) noexcept {
    const int p = topology.parent[i];
    int e = begin[i] = p == 0 ? 0 : begin[p] + topology.first_screw[p + 1] - topology.first_screw[p];
    for (int c = topology.first_screw[i]; c < topology.first_screw[i + 1]; ++c, ++e) {
      velocity[e] = topology.iv[i] + e - begin[i];
      for (int k = 0; k < 6; ++k) {
        path_S.array(k)[e] = first.effect.array(Part::S + k)[c];
        path_psi.array(k)[e] = psi_1.array(k)[c];
        path_psi_2.array(k)[e] = first.effect.array(Part::psi_2 + k)[c];
        path_sigma.array(k)[e] = first.effect.array(Part::sigma + k)[c];
      }
    }
    return e;
  }

  void compute_wrenches(const Last& d) noexcept {
    const auto spread = [&](const Arrays<T>& x, int k) {
      const Vec3<T> a = x.get3(k, d.c);
      return Vec3<Number>{Number(a.x), Number(a.y), Number(a.z)};
    };
    const auto effect = [&](int part) {
      return Wrench<Spatial, Number>{spread(first.effect, part), spread(first.effect, part + 3)};
    };
    const auto twin = [&](const Arrays<T>& B) {
      return CoriolisInertia<Number>{{spread(B, 0), spread(B, 3), spread(B, 6)}, spread(B, 9)};
    };
    const CoriolisInertia<Number> S_twin = twin(B_S), psi_twin = twin(B_psi);
    const Wrench<Spatial, Number> U = effect(Part::U), P = effect(Part::P), R = effect(Part::R);
    const Vec3<Number> t = spread(first.effect, Part::t);
    for (int c = 0; c < d.end; c += L::width) {
      const auto store = [&](const Wrench<Spatial, Number>& W, int to) {
        wrench.store3(W.m, 6 * to, c);
        wrench.store3(W.f, 6 * to + 3, c);
      };
      const Motion6<Number> S = load6(path_S, c), psi = load6(path_psi, c), psi_2 = load6(path_psi_2, c),
                            sigma = load6(path_sigma, c);
      store(-coad(S, U), US);
      store(S_twin * S, BS);
      store(S_twin * psi, Bpsi);
      store(coad(S, R), RS);
      store(coad(S, P), PS);
      const Wrench<Spatial, Number> U_sigma = coad(sigma, U), U_psi = coad(psi_2, U);
      store(S_twin * sigma - U_sigma + psi_twin * S, for_g);
      store(S_twin * psi_2 - U_psi + psi_twin * psi, for_G);
      store(-U_sigma - Wrench<Spatial, Number>{cross(S.w, t), {}}, for_h);
      store(-U_psi - Wrench<Spatial, Number>{cross(psi.w, t), {}}, for_H);
    }
  }
  /// Computes the products (D2.11) of which the second derivatives of inverse dynamics consist, for three
  /// joint screws on one path to the ground: S_d, whose joint is the farthest from the ground, S_j, and each
  /// screw S_c of the path in turn. A product is the power of a wrench on S_j, or on ψ'_j = [V_p, S_j] with
  /// the twist V_p of the predecessor of the joint of S_j. The wrenches are functions of S_c, of S_d,
  /// and of the inertia and the motion of the subtree that S_d moves. compute_wrenches() must have stored
  /// them in `wrench` before the call.
  ///
  /// Writes the products to entry c of the arrays of `line`, in the order of the enumeration Products. The
  /// joint of S_j has the screws from begin_j to end_j - 1 of the path. The products h and H, which occur
  /// only in derivatives of the force at the velocity of S_d, are computed only for c < end_j.
  void multiply(int j, const Last& d, int begin_j, int end_j) noexcept {
    Number S[6], psi[6];
    for (int k = 0; k < 6; ++k) {
      S[k] = Number(path_S.array(k)[j]);
      psi[k] = Number(path_psi.array(k)[j]);
    }
    const Arrays<T> W = wrench, out = line;  // local copies, so that the compiler knows that no result
                                             // overwrites them
    const auto product = [W](const Number(&mine)[6], int with, int c) {
      return W.template product<6>(mine, 6 * with, c);
    };
    const auto store = [out](const Number& x, int to, int c) { L::store(x, out.array(to) + c); };
    for (int c = 0; c < d.end; c += L::width) {
      const Number f_c = product(S, Bpsi, c);
      store(product(S, US, c), u, c);
      store(product(S, BS, c), b, c);
      store(f_c, f, c);
      store(f_c, also_f, c);
      store(product(S, for_g, c), g, c);
      store(product(S, for_G, c), G, c);
      if (c >= end_j) continue;
      store(product(S, for_h, c) - product(psi, BS, c), h, c);
      store(product(S, for_H, c) - product(psi, Bpsi, c), H, c);
    }
    if (begin_j < d.begin)
      for (int c = end_j; c < d.end; c += L::width) {
        store(L::load(out.array(also_f) + c) + product(S, RS, c), also_f, c);
        store(L::load(out.array(G) + c) + product(S, PS, c), G, c);
      }
  }
  /// Writes the products (D2.11), which are powers of wrenches on screws, to the second derivatives of the
  /// forces τ by (q, q), (q, v), (v, v) and (a, q). multiply() has written the products of two joint screws d
  /// and j with each joint screw l of the path from the ground to the joint of d, which also contains j, to
  /// the arrays of `line`. They are parts of the derivatives of the force at the velocity of screw d along
  /// the directions of screws j and l. If the joint of screw j is nearer to the ground than that of d, they
  /// are also parts of the derivatives of the force at the velocity of screw j along the directions of screws
  /// d and l. If `coupled` is set, the parts are added, because several joints may share a velocity; without
  /// couplings each entry has one part.
  template <bool coupled>
  [[gnu::noinline]] void put(std::ptrdiff_t nv, int j, const Last& d, int begin_j, int end_j,
                             const SecondDerivatives<T>& out) noexcept {
    const std::ptrdiff_t v_j = velocity[j];
    const auto at = [nv](std::ptrdiff_t row, std::ptrdiff_t outer, std::ptrdiff_t inner) {
      return (row * nv + outer) * nv + inner;
    };
    const auto give = [](T& entry, const T& part) {
      if constexpr (coupled)
        entry += part;
      else
        entry = part;
    };
    const auto x = [&](Products of, int l) { return line.array(of)[l]; };
    for (int l = 0; l < end_j; ++l) {
      const std::ptrdiff_t v_l = velocity[l], lj = at(d.v, v_l, v_j), jl = at(d.v, v_j, v_l);
      give(out.qq[lj], x(H, l));
      give(out.qv[lj], -x(f, l));
      if (l < begin_j) {
        give(out.qq[jl], x(H, l));
        give(out.qv[jl], x(h, l));
        give(out.vv[lj], -x(b, l));
        give(out.vv[jl], -x(b, l));
        give(out.aq[lj], x(u, l));
      } else {
        give(out.vv[lj], -(x(b, l) + x(u, l)));
      }
    }
    if (begin_j == d.begin) return;
    for (int l = 0; l < d.end; ++l) {
      const std::ptrdiff_t v_l = velocity[l], ld = at(v_j, v_l, d.v), dl = at(v_j, d.v, v_l);
      give(out.qq[ld], x(G, l));
      give(out.qv[ld], x(also_f, l));
      give(out.vv[ld], x(b, l));
      if (l >= end_j) give(out.aq[dl], -x(u, l));
      if (l >= d.begin) continue;
      give(out.qq[dl], x(G, l));
      give(out.qv[dl], x(g, l));
      give(out.vv[dl], x(b, l));
      give(out.aq[ld], x(b, l) + x(u, l));
    }
  }
  /// The joint screw of column l of the path.
  Motion6<T> screw(int l) const { return {path_S.get3(0, l), path_S.get3(3, l)}; }
  /// Corrects the second derivatives of τ by the velocities of two screws S_l and S_d of one joint. The
  /// formula for screws of different joints has a term with their bracket [S_l, S_d] that does not occur
  /// within one joint, because the velocity of S_l does not move the predecessor of the joint. This term is
  /// subtracted.
  void put_brackets(std::ptrdiff_t nv, const Last& d, T* vv) noexcept {
    const Inertia<T> M = first.screws.subtree_of_column(d.c).M;
    for (int l = d.begin; l < d.end; ++l) {
      const Momentum<Spatial, T> Pi = M * ad(screw(l), first.screws.screw(d.c));
      for (int j = 0; j < d.begin; ++j) vv[(velocity[j] * nv + velocity[l]) * nv + d.v] -= Pi | screw(j);
    }
  }
};

}  // namespace axode
