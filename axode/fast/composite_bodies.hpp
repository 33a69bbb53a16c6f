#pragma once
#include <algorithm>

#include "axode/fast/poses.hpp"
#include "axode/fast/symmetric_blocks.hpp"

namespace axode {

/// The composite-body algorithm for the mass matrix M of trees without coupled joints. Composite inertias are
/// about the origins of the bodies in inertial axes. The joint screws S and the impulses F, which give the
/// subtrees of the joints the twists S, are then written about the origin of the root body, where M_ij = S_i
/// | F_j, the product of a screw and an impulse. As the velocities of a subtree are consecutive, a row of M
/// is a product of one screw and consecutive entries of F.
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

  /// Computes screws and impulses of all joints at q about the origin of their root body.
  template <class Real> void run(const Tree<Real>& tree, const T* q) noexcept {
    poses.template run<FastPoses<T>::From::root>(tree, q, [&](int i, const auto& at) {
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
        set_columns(tree, i);
        ++i;
      }
    }
  }

  /// Writes the mass matrix M, nv × nv, armatures included. For i <= j, M_ij = S_i | F_j if velocity i moves
  /// the joint of velocity j, and 0 otherwise, with the joint screws S and the impulse F_j that gives the
  /// subtree of joint j the twist S_j. The entries below the diagonal are equal to those above.
  template <class Real> void write(const Tree<Real>& tree, T* out) const noexcept {
    const std::ptrdiff_t nv = tree->nv;
    if constexpr (L::width == 1) {
      const Arrays<T> several = F;
      for (int i = 0; i < tree->nv; ++i) {
        const Six one(S, i);
        const int end = tree->velocity_end[i];
        T* const row = out + i * nv;
        T* const column = out + i;
        for (int j = i; j < end; ++j) row[j] = column[j * nv] = product(several, j, one);
        for (int j = end; j < tree->nv; ++j) row[j] = column[j * nv] = T(0);
      }
    } else {
      const int last = last_block<T>(tree->nv);
      for (int i = last; i >= 0; i -= L::width)
        for (int j = last; j >= i; j -= L::width) write_block(tree, i, j, out);
    }
    for (int i = 0; i < tree->nv; ++i) out[i * nv + i] += T(tree.armature[i]);
  }

  /// Writes only the entries M_ij of the mass matrix for which j = i, or for which velocity j moves the joint
  /// of velocity i. Armatures are included.
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
  /// Writes the block of the mass matrix with rows i, i + 1, ... and columns j, j + 1, ... (j >= i), and its
  /// mirror image below the diagonal. The blocks in later rows, and in later columns of these rows, must be
  /// written before, because SIMD lanes beyond the end of a row spill into the next row.
  template <class Real> void write_block(const Tree<Real>& tree, int i, int j, T* out) const noexcept {
    const Arrays<T> one = S;
    const int nv = tree->nv;
    int least = nv, most = 0;  // range of the ends of the subtrees that these rows move
    for (int m = 0; m < L::width; ++m) {
      const int end = tree->velocity_end[std::min(i + m, nv - 1)];
      least = std::min(least, end);
      most = std::max(most, end);
    }
    if (j >= most) {
      const SquareBlock<T> nothing{};
      store(nothing, i, j, nv, out);
      store(nothing, j, i, nv, out);
      return;
    }
    Number several[6];
    for (int k = 0; k < 6; ++k) several[k] = L::load(F.array(k) + j);
    SquareBlock<T> block;
    unrolled<L::width>([&](auto m) { block[m] = product(one, i + m, several); });
    if (least < std::min(j + L::width, nv))
      unrolled<L::width>([&](auto m) {
        const Number end(T(tree->velocity_end[std::min(i + m, nv - 1)] - j));
        block[m] = select(lane() < end, block[m], Number(T(0)));
      });
    const SquareBlock<T> mirrored = transposed<T>(block);
    if (i == j)
      unrolled<L::width>([&](auto m) { block[m] = select(lane() < Number(T(m)), mirrored[m], block[m]); });
    store(block, i, j, nv, out);
    if (i < j) store(mirrored, j, i, nv, out);
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
  /// Computes the screws and impulses of joint i, which may be of any kind.
  template <class Real> [[gnu::noinline]] void set_columns(const Tree<Real>& tree, int i) noexcept {
    const SO3<T> R{C.get3(0, i), C.get3(3, i), C.get3(6, i)};
    const Vec3<T> r = C.get3(9, i);
    const Inertia<T> M_i = get(i);
    with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
      for (int k = 0; k < joint.nv; ++k) {
        const Screw<T> X = Ad(R, joint.column(k));
        const Momentum<Hybrid, T> Pi = M_i * Twist<Hybrid, T>{X.w, X.v};
        const int c = tree->iv[i] + k;
        S.set3(X.w, 0, c);
        S.set3(X.v + cross(r, X.w), 3, c);
        F.set3(Pi.l + cross(r, Pi.p), 0, c);
        F.set3(Pi.p, 3, c);
      }
    });
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
