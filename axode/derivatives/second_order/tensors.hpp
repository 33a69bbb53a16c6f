#pragma once
#include "axode/derivatives/displacement/first_order.hpp"

namespace axode {

/// Receives the second partial derivatives of the nv forces τ of inverse dynamics, by the pairs of variables
/// (q, q), (q, v), (v, v) and (a, q). Each member has nv × nv × nv numbers, [component of τ][outer
/// derivative][inner derivative]. The outer derivative is by the first variable of the pair, and the inner
/// one by the second.
template <class T> struct SecondDerivatives { T *qq, *qv, *vv, *aq; };

/// Arrays of numbers in blocks, one for each component of the entries, of which a block has one entry in each
/// SIMD lane: component k of the entries c, c + 1, ... is a register, and the registers of a block adjoin, so
/// that they are at constant distances from each other. c must be a multiple of the number of lanes.
template <class T, int components> struct LaneBlocks {
  using L = Lanes<T>;
  using Number = typename L::Number;
  T* data;

  LaneBlocks(Arena& arena, int entries)
      : data(arena.lines<T>(static_cast<std::size_t>((entries + Arena::most_lanes - 1) / Arena::most_lanes) *
                            static_cast<std::size_t>(components * Arena::most_lanes))) {}

  T* block(int c) const { return data + static_cast<std::ptrdiff_t>(c / L::width) * components * L::width; }
  T* entry(int k) const { return block(k) + k % L::width; }
  Vec3<Number> load3(int k, int c) const {
    const T* const p = block(c) + k * L::width;
    return {L::load(p), L::load(p + L::width), L::load(p + 2 * L::width)};
  }
  void store3(const Vec3<Number>& a, int k, int c) const {
    T* const p = block(c) + k * L::width;
    L::store(a.x, p);
    L::store(a.y, p + L::width);
    L::store(a.z, p + 2 * L::width);
  }
  Motion6<Number> load6(int k, int c) const { return {load3(k, c), load3(k + 3, c)}; }
  Vec3<T> get3(int k, int c) const {
    const T* const p = entry(c) + k * L::width;
    return {p[0], p[L::width], p[2 * L::width]};
  }
};

/// Computes the second partial derivatives of all components of the forces τ of inverse dynamics by the pairs
/// of variables (q, q), (q, v), (v, v) and (a, q). Those of component i are the Hessian (D2.8) of
/// docs/derivations for the weights λ that are 1 for component i and 0 for the others. Its wrenches then need
/// no sums over bodies ((D2.10) to (D2.12)). An entry can differ from 0 only if its three joint screws are on
/// one path to the ground. O(n d²) for n bodies with d velocities on their paths to the ground, in addition
/// to the time to write the zeros. Numbers are computed where they are stored, row by row, with adjacent
/// columns in SIMD lanes.
template <class T> struct SecondOrderTensors {
  using L = Lanes<T>;
  using Number = typename L::Number;

  FirstOrder<T> first;
  LaneBlocks<T, 42> column;     ///< S, ψ', ψ'', σ, U, P and R of each column, a joint screw S
  LaneBlocks<T, 27> coriolis;   ///< t, B_S and B_ψ of each column
  LaneBlocks<T, 18> curvature;  ///< χ, Y, X and Z of each column for the component i at hand
  LaneBlocks<T, 2> extent;      ///< the index of each column, and its `end`, as numbers
  Arrays<T> line;               ///< a row of each of the four tensors, before couplings add its columns
  int *begin, *next;  ///< for each column: the columns of its joint are those from `begin` to `next` - 1
  int* end;           ///< for each column: the end of the columns that its joint moves
  int* last_end;      ///< for each block of columns: the largest entry of `end`
  int* live;          ///< for each block: whether a column of it is on one path with column i

  explicit SecondOrderTensors(Arena& arena)
      : first(arena),
        column(arena, arena.topology().n_screws),
        coriolis(arena, arena.topology().n_screws),
        curvature(arena, arena.topology().n_screws),
        extent(arena, arena.topology().n_screws),
        line(arena, 4, arena.topology().n_screws),
        begin(arena.per_screw<int>()),
        next(arena.per_screw<int>()),
        end(arena.per_screw<int>()),
        last_end(arena.per_screw<int>()),
        live(arena.per_screw<int>()) {}

  template <class Real>
  void run(const Tree<Real>& tree, const T* q, const T* v, const T* a,
           const SecondDerivatives<T>& out) noexcept {
    const Topology& topology = *tree.operator->();
    first.run(tree, q, v, a, Loads<T>{});
    const int n = topology.n_screws;
    find_ends(topology);
    for (int c = 0; c < n; c += L::width) take_columns(c, n);
    if (!topology.coupled_bodies.empty()) return add_couplings(topology, out);
    const std::ptrdiff_t matrix = static_cast<std::ptrdiff_t>(n) * n, numbers = matrix * n;
    for (int i = 0; i < n; ++i) {
      take_component(i, n);
      for (int k = 0, to = 0; k < n; k = to) {  // rows k to `to` - 1
        const bool zero = !on_one_path(i, k);
        for (to = k + 1; zero && to < n && !on_one_path(i, to);) ++to;
        const std::ptrdiff_t at = i * matrix + static_cast<std::ptrdiff_t>(k) * n;
        const Row row{out.qq + at, out.qv + at, out.vv + at, out.aq + at};
        if (zero)
          for (T* const tensor : {row.qq, row.qv, row.vv, row.aq})
            std::fill_n(tensor, static_cast<std::ptrdiff_t>(to - k) * n, T(0));
        else
          write_row(i, k, n, row, numbers - at);
      }
    }
  }

 private:
  enum ColumnPart { S = 0, psi_1 = 6, psi_2 = 12, sigma = 18, U = 24, P = 30, R = 36 };
  enum CoriolisPart { t = 0, B_S = 3, B_psi = 15 };
  enum CurvaturePart { chi = 0, Y = 6, X = 12, Z = 15 };

  void find_ends(const Topology& topology) noexcept {
    for (int b = 0; b * L::width < topology.n_screws; ++b) last_end[b] = 0;
    for (int i = 1; i <= topology.n; ++i)
      for (int c = topology.first_screw[i]; c < topology.first_screw[i + 1]; ++c) {
        begin[c] = topology.first_screw[i];
        next[c] = topology.first_screw[i + 1];
        end[c] = topology.first_screw[topology.subtree_end[i]];
        extent.entry(c)[0] = T(c);
        extent.entry(c)[L::width] = T(end[c]);
        last_end[c / L::width] = std::max(last_end[c / L::width], end[c]);
      }
  }
  /// Computes for the joint screws c, c + 1, ..., one in each SIMD lane, what all components of τ need: the
  /// ScrewEffects, and B_S and B_ψ of (D2.10).
  void take_columns(int c, int n_columns) noexcept {
    using Part = typename FirstOrder<T>::Part;
    const MovingInertia<Number> moved = first.screws.subtrees_of_columns(c, n_columns);
    const MovingColumn<Number> of = first.screws.columns_from(c);
    const Motion6<Number> psi = ad(of.V_p, of.S);
    const auto copy = [&](int from, int to) {
      column.store3(first.effect.load3(from, c), to, c);
      column.store3(first.effect.load3(from + 3, c), to + 3, c);
    };
    copy(Part::S, S);
    column.store3(psi.w, psi_1, c);
    column.store3(psi.v, psi_1 + 3, c);
    copy(Part::psi_2, psi_2);
    copy(Part::sigma, sigma);
    copy(Part::U, U);
    copy(Part::P, P);
    copy(Part::R, R);
    coriolis.store3(first.effect.load3(Part::t, c), t, c);
    const auto store = [&](const CoriolisInertia<Number>& B, int to) {
      coriolis.store3(B.D.x, to, c);
      coriolis.store3(B.D.y, to + 3, c);
      coriolis.store3(B.D.z, to + 6, c);
      coriolis.store3(B.p, to + 9, c);
    };
    store(CoriolisInertia<Number>::of(moved.M, of.S), B_S);
    CoriolisInertia<Number> of_psi = CoriolisInertia<Number>::of(moved.M, psi);
    of_psi += moved.B.along(of.S);
    store(of_psi, B_psi);
  }
  CoriolisInertia<Number> coriolis_inertia(int k, int c) const {
    return {{coriolis.load3(k, c), coriolis.load3(k + 3, c), coriolis.load3(k + 6, c)},
            coriolis.load3(k + 9, c)};
  }
  /// The indices of the columns c, c + 1, ... in SIMD lanes, and the ends of the columns that their joints
  /// move.
  Number columns_from(int c) const { return L::load(extent.block(c)); }
  Number ends_from(int c) const { return L::load(extent.block(c) + L::width); }

  /// Computes χ, Y, X and Z of the columns on one path with column i, for the Hessian of component i of τ:
  /// (D2.11) for columns after the joint of i, and (D2.12) for the others.
  void take_component(int i, int n) noexcept {
    const auto one = [&](const auto& x, int k) { return spread<Number, T>(x.get3(k, i)); };
    const Motion6<Number> S_i{one(column, S), one(column, S + 3)};
    const Wrench<Spatial, Number> U_i{one(column, U), one(column, U + 3)};
    const Vec3<Number> t_i = one(coriolis, t);
    const CoriolisInertia<Number> B_i{{one(coriolis, B_S), one(coriolis, B_S + 3), one(coriolis, B_S + 6)},
                                      one(coriolis, B_S + 9)};
    for (int c = 0; c < n; c += L::width) {
      const bool before = c < next[i] && last_end[c / L::width] > i,
                 after = c + L::width > next[i] && c < end[i];
      live[c / L::width] = before || after;
      if (before || after) store_component(c, i, before, after, S_i, U_i, t_i, B_i);
    }
  }
  void store_component(int c, int i, bool before, bool after, const Motion6<Number>& S_i,
                       const Wrench<Spatial, Number>& U_i, const Vec3<Number>& t_i,
                       const CoriolisInertia<Number>& B_i) noexcept {
    const Vec3<Number> none{Number(T(0)), Number(T(0)), Number(T(0))};
    Vec3<Number> x[6] = {none, none, none, none, none, none};
    const Number index = columns_from(c);
    const auto keep = [&](const auto& where, const Vec3<Number>(&y)[6]) {
      for (int k = 0; k < 6; ++k)
        x[k] = {select(where, y[k].x, x[k].x), select(where, y[k].y, x[k].y), select(where, y[k].z, x[k].z)};
    };
    if (before) {
      const Motion6<Number> S_c = column.load6(S, c), psi_c = column.load6(psi_1, c);
      const Wrench<Spatial, Number> US = coad(S_c, U_i);
      keep(index < Number(T(next[i])) && Number(T(i)) < ends_from(c),
           {none, none, US.m, US.f, cross(S_c.w, t_i) - B_i.transposed_times(psi_c),
            -B_i.transposed_times(S_c)});
    }
    if (after) {
      const Motion6<Number> chi_c = ad(S_i, column.load6(S, c));
      const Wrench<Spatial, Number> US =
          coad(S_i, Wrench<Spatial, Number>{column.load3(U, c), column.load3(U + 3, c)});
      const Vec3<Number> Z_c = coriolis_inertia(B_S, c).transposed_times(S_i);
      keep(index >= Number(T(next[i])) && index < Number(T(end[i])),
           {chi_c.w, chi_c.v, US.m + Z_c, US.f, coriolis_inertia(B_psi, c).transposed_times(S_i), Z_c});
    }
    for (int k = 0; k < 6; ++k) curvature.store3(x[k], 3 * k, c);
  }

  /// Entries of the four tensors in one row and adjacent columns, one column in each SIMD lane.
  struct Entries {
    Number qq, qv, vv, aq;
  };
  struct Row {
    T *qq, *qv, *vv, *aq;
  };
  /// Whether the joints of columns i and k are on one path to the ground.
  bool on_one_path(int i, int k) const { return k < next[i] ? end[k] > i : k < end[i]; }
  /// Writes row k of the four matrices of component i of τ, n numbers each, to `to`, for two columns on one
  /// path. Lanes beyond the end of the row overwrite what follows it, at most `room` numbers from `to` on.
  void write_row(int i, int k, int n, const Row& to, std::ptrdiff_t room) noexcept {
    const Number zero(T(0));
    for (int c = 0; c < n; c += L::width) {
      const Entries x = reaches(k, c) ? entries(i, k, c) : Entries{zero, zero, zero, zero};
      const int left = static_cast<int>(std::min<std::ptrdiff_t>(room - c, L::width));
      L::store(x.qq, to.qq + c, left);
      L::store(x.qv, to.qv + c, left);
      L::store(x.vv, to.vv + c, left);
      L::store(x.aq, to.aq + c, left);
    }
  }
  /// Whether an entry of row k in the columns c, c + 1, ... of a block can differ from 0.
  bool reaches(int k, int c) const {
    if (c >= next[k]) return c < end[k] && live[c / L::width];
    return c + L::width > begin[k] || last_end[c / L::width] > k;
  }
  /// The entries of row k in the columns c, c + 1, ..., 0 for columns that are not on one path with column k.
  [[gnu::always_inline]] Entries entries(int i, int k, int c) const {
    const bool after = k >= next[i];
    Entries x = c + L::width <= begin[k] ? below(k, c) : after ? above<true>(k, c) : above<false>(k, c);
    if (c < next[k] && c + L::width > begin[k]) take_joint(i, k, c, x);
    const Number zero(T(0));
    const auto outside = ends_from(c) <= Number(T(k)) || Number(T(end[k])) <= columns_from(c);
    return {select(outside, zero, x.qq), select(outside, zero, x.qv), select(outside, zero, x.vv),
            select(outside, zero, x.aq)};
  }
  /// Corrects the entries x of row k in the columns c, c + 1, ..., which above() has computed, for columns
  /// before the joint of the row and for those of this joint.
  [[gnu::always_inline]] void take_joint(int i, int k, int c, Entries& x) const {
    const Number index = columns_from(c), zero(T(0));
    const auto is_before = index < Number(T(begin[k])), is_after = Number(T(next[k])) <= index;
    if (k >= next[i] || c < begin[k]) {
      const Entries l = below(k, c);
      x = {select(is_before, l.qq, x.qq), select(is_before, l.qv, x.qv), select(is_before, l.vv, x.vv),
           select(is_after, x.aq, l.aq)};
    } else {  // no χ differs from 0 within the joint
      x.aq = select(is_after, x.aq, zero);
    }
    if (next[k] - begin[k] == 1) return;
    const Wrench<Spatial, T> of_joint = bracket(i, k);
    const Wrench<Spatial, Number> W{spread<Number, T>(of_joint.m), spread<Number, T>(of_joint.f)};
    x.vv = x.vv + select(is_before || is_after, zero, W | column.load6(S, c));
  }
  /// The entries (D2.8) in row k and the columns c, c + 1, ... for columns after the joint of the row. Those
  /// by (q, q), (q, v) and (v, v) hold for columns of the same joint as well, but for bracket(). `after` says
  /// whether k is after the joint of the component; if not, its χ is 0.
  template <bool after> [[gnu::always_inline]] Entries above(int k, int c) const {
    const T *s = column.entry(k), *d = curvature.block(c);
    Entries x{product<6>(s, psi_2, d, Y) + product<3>(s, psi_1, d, X), product<3>(s, psi_1, d, Z),
              product<3>(s, S, d, Z), product<6>(s, S, d, Y)};
    if constexpr (after) {
      const T *chi_k = curvature.entry(k), *e = column.block(c);
      x.qq = x.qq + product<6>(chi_k, chi, e, P);
      x.qv = x.qv + product<6>(chi_k, chi, e, R);
    }
    return x;
  }
  /// The entries (D2.8) in row k and the columns c, c + 1, ... for columns before the joint of the row. Those
  /// by (a, q) hold for columns of the same joint as well.
  [[gnu::always_inline]] Entries below(int k, int c) const {
    const T *e = column.entry(k), *y = curvature.entry(k), *s = column.block(c), *d = curvature.block(c);
    return {product<6>(e, P, d, chi) + product<6>(y, Y, s, psi_2) + product<3>(y, X, s, psi_1),
            product<6>(y, Y, s, sigma) + product<3>(y, X, s, S), product<3>(y, Z, s, S),
            product<6>(e, U, d, chi)};
  }
  /// The products of n numbers of one column, from component i on, with the components from j on of the
  /// columns of a block, one in each SIMD lane.
  template <int n> [[gnu::always_inline]] static Number product(const T* one, int i, const T* block, int j) {
    const auto of_block = [&](int m) { return L::load(block + (j + m) * L::width); };
    Number sum = one[i * L::width] * of_block(0);
    for (int m = 1; m < n; ++m) sum = sum + one[(i + m) * L::width] * of_block(m);
    return sum;
  }

  /// The wrench whose power on S_l is to be added to the derivative of component i of τ by the velocities
  /// of the screws S_k and S_l, if both are of one joint. The formula for screws of different joints has the
  /// term S_k|hat(A) S_l = -S_l|hat(A) S_k with the momentum A of (D2.7). This term does not occur within one
  /// joint, because the velocity of S_k does not move the predecessor of the joint.
  [[gnu::noinline]] Wrench<Spatial, T> bracket(int i, int k) const noexcept {
    const auto screw = [&](int c) { return Motion6<T>{column.get3(S, c), column.get3(S + 3, c)}; };
    if (k < next[i]) return coad(screw(k), Wrench<Spatial, T>{column.get3(U, i), column.get3(U + 3, i)});
    const Momentum<Spatial, T> A = first.screws.subtree_of_column(k).M * screw(i);
    return coad(screw(k), Wrench<Spatial, T>{A.l, A.p});
  }

  /// Adds the columns of joints that share a velocity.
  [[gnu::noinline]] void add_couplings(const Topology& topology, const SecondDerivatives<T>& out) noexcept {
    const std::ptrdiff_t nv = topology.nv;
    const int n = topology.n_screws;
    for (T* const tensor : {out.qq, out.qv, out.vv, out.aq}) std::fill_n(tensor, nv * nv * nv, T(0));
    const auto velocity = [&](int c) { return topology.iv[first.screws.body_of[c]] + c - begin[c]; };
    for (int i = 0; i < n; ++i) {
      take_component(i, n);
      for (int k = 0; k < n; ++k) {
        if (!on_one_path(i, k)) continue;
        write_row(i, k, n, {line.array(0), line.array(1), line.array(2), line.array(3)}, line.stride);
        const std::ptrdiff_t row = (velocity(i) * nv + velocity(k)) * nv;
        int to = 0;
        for (T* const tensor : {out.qq, out.qv, out.vv, out.aq}) {
          const T* const from = line.array(to++);
          for (int l = 0; l < n; ++l) tensor[row + velocity(l)] += from[l];
        }
      }
    }
  }
};

}  // namespace axode
