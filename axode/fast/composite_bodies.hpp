#pragma once
#include <algorithm>

#include "axode/fast/poses.hpp"
#include "axode/fast/symmetric_blocks.hpp"

namespace axode {

/// The composite-body algorithm for the mass matrix M of trees without coupled joints. Everything is in the
/// axes of the root body, the first body on the path from the ground, on whose pose M does not depend.
/// Composite inertias are about the origins of the bodies. Joint screws S are about the origin of the root
/// body, and so are the impulses F that give the subtrees of the joints, with all other joints locked, the
/// twists S. If joint j is in the subtree of joint i, M_ij = S_iᵀ F_j without armatures. As the velocities
/// of a subtree are consecutive, a row of M is the product of one screw and consecutive entries of F. If the
/// root body is on a free joint, its screws are the unit vectors.
template <class T> struct FastCompositeBodies {
  using L = Lanes<T>;
  using Number = typename L::Number;
  FastPoses<T> poses;
  Arrays<T> C;     ///< columns of R (0 to 8), vector from the root body to the body (9 to 11)
  Arrays<T> M;     ///< h (0 to 2), Theta (3 to 8), m (9)
  Arrays<T> S, F;  ///< joint screws and impulses about the origin of the root body

  explicit FastCompositeBodies(Arena& arena)
      : poses(arena),
        C(arena, 12, arena.topology().n + 1),
        M(arena, 10, arena.topology().n + 1),
        S(arena, 6, arena.topology().n_screws),
        F(arena, 6, arena.topology().n_screws) {}

  /// Computes screws and impulses of all joints at q.
  template <class Real> void run(const Tree<Real>& tree, const T* q) noexcept {
    poses.template run<FastPoses<T>::From::root_axes>(tree, q, [&](int i, const auto& at) {
      C.set3(at.R.x, 0, i);
      C.set3(at.R.y, 3, i);
      C.set3(at.R.z, 6, i);
      C.set3(at.r, 9, i);
    });
    for (int i = 0; i <= tree->n; i += L::width) {
      const SO3<Number> R{C.load3(0, i), C.load3(3, i), C.load3(6, i)};
      const Inertia<Number> M_i = transform(R, inertias_in_lanes<T>(tree, i));
      const Sym3<Number>& Theta = M_i.Theta;
      M.store3(M_i.h, 0, i);
      M.store3({Theta.xx, Theta.yy, Theta.zz}, 3, i);
      M.store3({Theta.xy, Theta.xz, Theta.yz}, 6, i);
      L::store(M_i.m, M.array(9) + i);
    }
    compose(tree);
    for (int i = 1; i <= tree->n;) {
      if (is_hinge(tree, i)) [[likely]] {
        set_hinges(i, tree->iv[i]);
        i += std::max(1, std::min(L::width, tree->hinges[i]));
      } else {
        if (tree->kind[i] == Subgroup::prismatic)
          set_prismatic(tree, i);
        else if (tree->kind[i] == Subgroup::free && tree->parent[i] == 0)
          set_free_root(i, tree->iv[i]);
        else
          set_columns(tree, i);
        ++i;
      }
    }
  }

  /// Writes the mass matrix M, nv × nv, armatures included. For i <= j, M_ij is the product S_iᵀ F_j if the
  /// velocities i and j belong to one joint, or if the joint of i is on the path from the ground to the joint
  /// of j; otherwise M_ij is 0. S are the joint screws, and F_j is the impulse that gives the subtree of
  /// joint j the twist S_j. The entries below the diagonal are equal to those above.
  template <class Real> void write(const Tree<Real>& tree, T* out) const noexcept {
    const std::ptrdiff_t nv = tree->nv;
    if constexpr (L::width == 1) {
      const Arrays<T> several = F;
      for (int i = 0; i < tree->nv; ++i) {
        const int end = tree->velocity_end[i];
        T* const row = out + i * nv;
        T* const column = out + i;
        if (i < unit_screws(*tree.operator->())) {
          for (int j = i; j < end; ++j) row[j] = column[j * nv] = F.array(i)[j];
        } else {
          const Six one(S, i);
          for (int j = i; j < end; ++j) row[j] = column[j * nv] = product(several, j, one);
        }
        for (int j = end; j < tree->nv; ++j) row[j] = column[j * nv] = T(0);
      }
    } else {
      if (unit_screws(*tree.operator->()) > 0) copy_rows(tree->nv, tree->velocity_end[0], out);
      const int rest = tree->nv % L::width, tail = tree->nv > L::width && rest <= widest_tail ? rest : 0,
                end = tree->nv - tail;
      for (int c = last_block<T>(end); c >= 0; c -= L::width) write_columns(*tree.operator->(), c, out);
      if (tail > 0) write_tail(*tree.operator->(), end, out);
    }
    for (int i = 0; i < tree->nv; ++i) out[i * nv + i] += T(tree.armature[i]);
  }

  /// Writes only entries M_ij of the mass matrix with j <= i: those for which the velocities i and j belong
  /// to one joint, or the joint of j is on the path from the ground to the joint of i. Armatures are
  /// included.
  template <class Real> void write_paths(const Tree<Real>& tree, T* out) const noexcept {
    static_assert(L::width == 1);
    const Arrays<T> several = S;
    for (int i = 0; i < tree->nv; ++i) {
      const Six one(F, i);
      T* row = out + static_cast<std::ptrdiff_t>(i) * tree->nv;
      for (int j = i; j >= 0; j = tree->velocity_parent[j]) row[j] = product(several, j, one);
      row[i] += T(tree.armature[i]);
    }
  }

 private:
  /// The number of the first screws that are the unit vectors: 6 if the first body is free.
  static int unit_screws(const Topology& topology) {
    return topology.n > 0 && topology.kind[1] == Subgroup::free ? 6 : 0;
  }
  /// The columns of the mass matrix are computed in blocks as wide as a SIMD register. If at most this number
  /// of columns remains after the full blocks, they are computed one number after the other instead.
  static constexpr int widest_tail = 2;
  /// Writes the first six rows of the mass matrix M if body 1 is on a free joint. Its subtree has the columns
  /// before `end`; the later columns are 0.
  void copy_rows(int nv, int end, T* out) const noexcept {
    const Arrays<T> from = F;
    const Number zero(T(0));
    for (int k = 0; k < 6; ++k) {
      T* const row = out + static_cast<std::ptrdiff_t>(k) * nv;
      for (int c = 0; c < end; c += L::width) store_row<T>(L::load(from.array(k) + c), k, c, nv, row + c);
      for (int c = end; c < nv; c += L::width) store_row<T>(zero, k, c, nv, row + c);
    }
  }
  /// Writes the columns c to nv - 1 of the mass matrix M without SIMD registers, one number after the other.
  /// An entry (k, r) of these columns with k < c is copied from the entry (r, k), because M is symmetric.
  /// Hence the columns before c must have been written.
  void write_tail(const Topology& topology, int c, T* out) const noexcept {
    const std::ptrdiff_t nv = topology.nv;
    for (std::ptrdiff_t r = c; r < nv; ++r) {
      const T* const row = out + r * nv;
      for (std::ptrdiff_t k = 0; k < c; ++k) out[k * nv + r] = row[k];
      for (std::ptrdiff_t k = c; k <= r; ++k) {
        T sum(0);
        if (topology.velocity_end[static_cast<std::size_t>(k)] > r)
          for (int m = 0; m < 6; ++m) sum += S.array(m)[k] * F.array(m)[r];
        out[k * nv + r] = out[r * nv + k] = sum;
      }
    }
  }
  /// Writes the columns c, c + 1, ... of the mass matrix M, one in each SIMD lane. Blocks of columns must be
  /// written from the last to the first: lanes beyond the end of a row overwrite the first entries of the
  /// next row, which must be written later.
  void write_columns(const Topology& topology, int c, T* out) const noexcept {
    const Arrays<T> screw = S, impulse = F;  // local copies, which no store can change
    const int nv = topology.nv, next = std::min(c + L::width, nv);
    const auto end_of = [&](int k) { return topology.velocity_end[k]; };
    int end = next;  // of the rows that are not 0
    for (int k = c; k < next; ++k) end = std::max(end, end_of(k));
    const Number zero(T(0));
    Number screws[6], impulses[6];
    for (int k = 0; k < 6; ++k) {
      screws[k] = L::load(screw.array(k) + c);
      impulses[k] = L::load(impulse.array(k) + c);
    }
    const auto put = [&](int r, const Number& x) {
      store_row<T>(x, r, c, nv, out + r * static_cast<std::ptrdiff_t>(nv) + c);
    };
    for (int r = unit_screws(topology); r < c; ++r) {  // rows before these are written by copy_rows()
      if (end_of(r) <= c)
        put(r, zero);
      else if (end_of(r) < next)
        put(r, select(lane() < Number(T(end_of(r) - c)), product(screw, r, impulses), zero));
      else
        put(r, product(screw, r, impulses));
    }
    SquareBlock<T> block;
    unrolled<L::width>([&](auto m) {
      block[m] = product(screw, c + m, impulses);
      const int end_m = end_of(std::min(c + m, nv - 1));
      if (end_m < next) block[m] = select(lane() < Number(T(end_m - c)), block[m], zero);
    });
    const SquareBlock<T> mirrored = transposed<T>(block);
    unrolled<L::width>([&](auto m) { put(c + m, select(lane() < Number(T(m)), mirrored[m], block[m])); });
    if (end > next) {
      Number subtree;
      for (int l = 0; l < L::width; ++l) subtree.x[l] = T(end_of(c + l));
      for (int r = next; r < end; ++r)
        put(r, select(Number(static_cast<T>(r)) < subtree, product(impulse, r, screws), zero));
    }
    for (int r = end; r < nv; ++r) put(r, zero);
  }

  static Number lane() { return L::load(count.data()); }
  static constexpr std::array<T, L::width> count = [] {
    std::array<T, L::width> numbers{};
    for (int l = 0; l < L::width; ++l) numbers[l] = T(l);
    return numbers;
  }();

  /// Computes the composite inertias M_i of all subtrees. From the leaves to the roots, M_i of body i is
  /// moved to the origin of its predecessor p and added to M_p.
  template <class Real> void compose(const Tree<Real>& tree) noexcept {
    Inertia<T> carried{};
    for (int i = tree->n; i > 0; --i) {
      const int p = tree->parent[i];
      const Inertia<T> M_i = get(i) + carried;
      put(i, M_i);
      if (p > 0) carried = transform(C.get3(9, i) - C.get3(9, p), M_i);
      if (p > 0 && p != i - 1) put(p, get(p) + carried);
      if (p == 0 || p != i - 1) carried = {};
    }
  }
  Inertia<T> get(int i) const {
    return {M.array(9)[i],
            M.get3(0, i),
            {M.array(3)[i], M.array(4)[i], M.array(5)[i], M.array(6)[i], M.array(7)[i], M.array(8)[i]}};
  }
  void put(int i, const Inertia<T>& M_i) const {
    const Sym3<T>& A = M_i.Theta;
    M.array(9)[i] = M_i.m;
    M.set3(M_i.h, 0, i);
    M.set3({A.xx, A.yy, A.zz}, 3, i);
    M.set3({A.xy, A.xz, A.yz}, 6, i);
  }

  /// Computes the screws and impulses of one register of consecutive hinges, from body i and velocity c on.
  void set_hinges(int i, int c) noexcept {
    const Vec3<Number> n = C.load3(6, i), r = C.load3(9, i), h = M.load3(0, i);
    const Vec3<Number> d = M.load3(3, i), o = M.load3(6, i);
    const Vec3<Number> f = cross(n, h), m = Sym3<Number>{d.x, d.y, d.z, o.x, o.y, o.z} * n + cross(r, f);
    S.store3(n, 0, c);
    S.store3(cross(r, n), 3, c);
    F.store3(m, 0, c);
    F.store3(f, 3, c);
  }
  /// Computes the screw and the impulse of joint i, which is prismatic.
  template <class Real> void set_prismatic(const Tree<Real>& tree, int i) noexcept {
    const Vec3<T> n = C.get3(6, i);
    const T m = M.array(9)[i];
    const int c = tree->iv[i];
    S.set3({}, 0, c);
    S.set3(n, 3, c);
    F.set3(cross(M.get3(0, i) + m * C.get3(9, i), n), 0, c);
    F.set3(m * n, 3, c);
  }
  /// Computes the screws and impulses of a free joint i on the ground, whose velocities begin with c.
  void set_free_root(int i, int c) noexcept {
    const Inertia<T> M_i = get(i);
    const auto& [m, h, A] = M_i;
    const T o(0);
    const T columns[6][6]{{A.xx, A.xy, A.xz, o, -h.z, h.y}, {A.xy, A.yy, A.yz, h.z, o, -h.x},
                          {A.xz, A.yz, A.zz, -h.y, h.x, o}, {o, h.z, -h.y, m, o, o},
                          {-h.z, o, h.x, o, m, o},          {h.y, -h.x, o, o, o, m}};
    for (int k = 0; k < 6; ++k) {
      for (int l = 0; l < 6; ++l) {
        S.array(l)[c + k] = T(k == l);
        F.array(l)[c + k] = columns[k][l];
      }
    }
  }
  /// Computes the screws and impulses of joint i, which may be of any kind, with one screw in each lane.
  template <class Real> [[gnu::noinline]] void set_columns(const Tree<Real>& tree, int i) noexcept {
    const SO3<T> R{C.get3(0, i), C.get3(3, i), C.get3(6, i)};
    const int first = tree->iv[i];
    with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
      for (int k = 0; k < joint.nv; ++k) {
        const Screw<T> X = Ad(R, joint.column(k));
        S.set3(X.w, 0, first + k);
        S.set3(X.v, 3, first + k);
      }
    });
    const auto all = [](const Vec3<T>& a) { return Vec3<Number>{Number(a.x), Number(a.y), Number(a.z)}; };
    const Inertia<T> M_i = get(i);
    const Vec3<Number> d = all({M_i.Theta.xx, M_i.Theta.yy, M_i.Theta.zz});
    const Vec3<Number> o = all({M_i.Theta.xy, M_i.Theta.xz, M_i.Theta.yz});
    const Vec3<Number> r = all(C.get3(9, i));
    const Inertia<Number> in_all_lanes{Number(M_i.m), all(M_i.h), {d.x, d.y, d.z, o.x, o.y, o.z}};
    for (int c = first; c < tree->first_screw[i + 1]; c += L::width) {  // later joints overwrite lanes beyond
      const Twist<Hybrid, Number> X{S.load3(0, c), S.load3(3, c)};
      const Momentum<Hybrid, Number> Pi = in_all_lanes * X;
      S.store3(X.v + cross(r, X.w), 3, c);
      F.store3(Pi.l + cross(r, Pi.p), 0, c);
      F.store3(Pi.p, 3, c);
    }
  }
  /// The six components of entry r of the arrays `from`, each repeated in all lanes.
  struct Six {
    Number x[6];
    Six(const Arrays<T>& from, int r) {
      for (int k = 0; k < 6; ++k) x[k] = Number(from.array(k)[r]);
    }
  };
  static Number product(const Arrays<T>& several, int c, const Six& one) noexcept {
    const auto term = [&](int k) { return L::load(several.array(k) + c) * one.x[k]; };
    return ((term(0) + term(1)) + term(2)) + ((term(3) + term(4)) + term(5));
  }
  static Number product(const Arrays<T>& one, int r, const Number* several) noexcept {
    const auto term = [&](int k) { return one.array(k)[r] * several[k]; };
    return ((term(0) + term(1)) + term(2)) + ((term(3) + term(4)) + term(5));
  }
};

}  // namespace axode
