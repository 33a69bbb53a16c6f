#pragma once
#include "axode/derivatives/displacement/first_order.hpp"
#include "axode/lie/six.hpp"

namespace axode {

/// Quantities of a body, or their sums over a subtree, from which the derivatives of the gradient of λ·τ
/// follow, with the forces τ of inverse dynamics and constant weights λ ((D1.21) and (D2.2) of
/// docs/derivations). Λ is the twist that the body would have if the joints moved with the velocities λ. A is
/// the momentum M Λ with the inertia M of the body.
///
/// The Coriolis inertia B of a body gives, for a twist X = (w; v), the wrench B X = 2 ∫ (r × (w × r'); w ×
/// r') dm, which causes the Coriolis acceleration 2 w × r' of mass elements dm with the positions r and
/// velocities r'. It has the form 2 [[D, 0], [-p~, 0]] with p = ∫ r' dm and p~ x = p × x. H is the moment of
/// the wrench Bᵀ Λ, whose force is 0. The member D is the block D of the Coriolis inertia that the body would
/// have with the twist Λ. The p of that Coriolis inertia is the linear part of A.
template <class T> struct VirtualMomentum {
  Wrench<Spatial, T> A;
  Vec3<T> H;
  Mat3<T> D;

  static constexpr int size = 18;  ///< number of numbers

  /// Reads all members from an array x of numbers.
  template <class Numbers> static constexpr VirtualMomentum from(const Numbers& x) {
    const auto vector = [&](int k) { return Vec3<T>{x[k], x[k + 1], x[k + 2]}; };
    return {{vector(0), vector(3)}, vector(6), {vector(9), vector(12), vector(15)}};
  }
  /// Writes all members to an array x of numbers.
  template <class Numbers> constexpr void to(Numbers& x) const {
    const auto set = [&](const Vec3<T>& a, int k) {
      x[k] = a.x;
      x[k + 1] = a.y;
      x[k + 2] = a.z;
    };
    set(A.m, 0);
    set(A.f, 3);
    set(H, 6);
    set(D.x, 9);
    set(D.y, 12);
    set(D.z, 15);
  }

  static constexpr VirtualMomentum of(const MovingInertia<T>& body, const Motion6<T>& Lambda) {
    const Momentum<Spatial, T> A = body.M * Lambda;
    return {{A.l, A.p}, body.B.transposed_times(Lambda), CoriolisInertia<T>::of(body.M, Lambda).D};
  }
  constexpr CoriolisInertia<T> B() const { return {D, A.f}; }
};

/// The screws and wrenches of a joint screw S that second derivatives of λ·τ need in addition to
/// ScrewEffects, which first derivatives need. τ are the forces of inverse dynamics, and λ constant weights.
/// The second derivatives are sums of powers of a wrench that belongs to one joint screw on a screw that
/// belongs to another ((D2.7) and (D2.8) of docs/derivations). `chi` is the bracket [Λ_p, S], and `psi_1` is
/// [V_p, S]. V_p is the twist of the predecessor, and Λ_p the twist that it would have if the joints moved
/// with the velocities λ.
template <class T> struct ScrewCurvature {
  Motion6<T> chi, psi_1;
  Wrench<Spatial, T> X, Y, Z;
  Wrench<Spatial, T> AS;  ///< hat(A) S = -ad_Sᵀ A

  static constexpr int size = 42;  ///< number of numbers of all members, and of a wrench Q due to loads

  /// Computes the screws and wrenches (D2.7) that belong to a joint screw S, for second derivatives of λ·τ
  /// with the forces τ of inverse dynamics and constant weights λ:
  ///   chi = [Λ_p, S],   psi_1 = [V_p, S],   AS = -ad_Sᵀ A,   Y = M chi + AS,   Z = 2 AS - B_Λ S,
  ///   X = Bᵀ chi - B_Λ psi_1 - ad_Sᵀ (H; 0) - 2 ad_psi_1ᵀ A.
  /// V_p is the twist of the predecessor. Λ_p (`Lambda_p`) is the twist that it would have if the joints
  /// moved with the velocities λ, and Λ the corresponding twist of a body. `moved` has the inertia M and the
  /// Coriolis inertia B of the subtree. `momentum` has sums over the bodies of the subtree, each with its own
  /// M, B and Λ: A of M Λ, H of the moments of Bᵀ Λ, and B_Λ of the Coriolis inertias that the bodies would
  /// have with the twists Λ.
  [[gnu::always_inline]] static constexpr ScrewCurvature of(const MovingInertia<T>& moved,
                                                            const VirtualMomentum<T>& momentum,
                                                            const Motion6<T>& S, const Motion6<T>& V_p,
                                                            const Motion6<T>& Lambda_p) {
    const Motion6<T> chi = ad(Lambda_p, S), psi_1 = ad(V_p, S);
    const Momentum<Spatial, T> M_chi = moved.M * chi;
    const Wrench<Spatial, T> AS = coad(S, momentum.A), BS = momentum.B() * S;
    const Wrench<Spatial, T> X = Wrench<Spatial, T>{moved.B.transposed_times(chi), {}} -
                                 momentum.B() * psi_1 + coad(S, Wrench<Spatial, T>{momentum.H, {}}) +
                                 T(2) * coad(psi_1, momentum.A);
    return {chi, psi_1, X, Wrench<Spatial, T>{M_chi.l, M_chi.p} + AS, T(2) * AS - BS, AS};
  }
};

/// Receives the second derivatives of a weighted sum of the forces of inverse dynamics by the pairs of
/// variables (q, q), (q, v), (v, v) and (a, q), or of the accelerations of forward dynamics by (q, q), (q,
/// v), (v, v) and, in `aq`, (τ, q). Each block has nv × nv numbers, [component of the first
/// variable][component of the second]. Entry [k][l] of qq is the derivative by ε_k and ε_l of the sum at q ⊕
/// ε_k e_k ⊕ ε_l e_l. It differs from entry [l][k] only if k and l belong to one joint with several
/// velocities.
template <class T> struct HessianBlocks { T *qq, *qv, *vv, *aq; };

/// Computes the second partial derivatives of λ·τ, the sum of the forces τ of inverse dynamics with constant
/// weights λ, by the pairs of variables (q, q), (q, v), (v, v) and (a, q); those by (v, a) and (a, a) are 0.
/// O(n d) for n bodies with d velocities on their paths to the ground: about 400 products and sums for a
/// hinge, and 114 for each pair of a joint and a joint before it on its path.
template <class T> struct SecondOrder {
  using L = Lanes<T>;
  using Number = typename L::Number;
  static constexpr int results = 7;

  FirstOrder<T> first;
  NumberRows<T, 8> Lambda;                          ///< Λ of each body: its angular and its linear part
  NumberRows<T, VirtualMomentum<T>::size> momenta;  ///< VirtualMomentum of each body, later of its subtree
  Arrays<T> curvature;                              ///< ScrewCurvature of each column
  Arrays<T> line;
  TwistToWrench<Spatial, T>* K;  ///< minus the second derivatives of the power of the loads on Λ

  explicit SecondOrder(Arena& arena)
      : first(arena),
        Lambda(arena, arena.topology().n + 1),
        momenta(arena, arena.topology().n + 1),
        curvature(arena, ScrewCurvature<T>::size, arena.topology().n_screws),
        line(arena, results, arena.topology().n_screws),
        K(arena.per_body<TwistToWrench<Spatial, T>>()) {}

  template <class Real>
  void run(const Tree<Real>& tree, const T* q, const T* v, const T* a, const T* lambda,
           const Loads<T>& loads) noexcept {
    const Topology& topology = *tree.operator->();
    first.screws.run(tree, q, v, a, cast<T>(tree.g));
    compute_adjoint_twists(topology, lambda);
    const bool loaded = !loads.wrenches.empty();
    if constexpr (std::same_as<Real, T>)
      if (loaded) {
        first.load(tree, q, loads.wrenches);
        add_load_hessian(tree, loads.wrenches);
      }
    first.compose(topology, loaded);
    compose(topology, loaded);
  }
  /// Writes the second derivatives of λ·τ that run() has prepared to the blocks of H, for a tree without
  /// couplings: the derivatives by the pairs of variables (q, q), (q, v), (v, v) and (a, q), see
  /// HessianBlocks. τ are the forces of inverse dynamics, and λ constant weights. The numbers equal those
  /// that add_to() adds to the last bit.
  void write(const Topology& topology, bool loaded, const HessianBlocks<T>& H) const noexcept {
    for (int c = last_block<T>(topology.nv); c >= 0; c -= L::width) write_columns(topology, c, loaded, H);
  }
  /// Adds the second derivatives of λ·τ that run() has prepared to the blocks of H: the derivatives by the
  /// pairs of variables (q, q), (q, v), (v, v) and (a, q), see HessianBlocks. τ are the forces of inverse
  /// dynamics, and λ constant weights. A block that is null is skipped.
  void add_to(const Topology& topology, bool loaded, const HessianBlocks<T>& H) noexcept {
    const std::ptrdiff_t nv = topology.nv;
    const auto add = [&](T* block, std::ptrdiff_t outer, std::ptrdiff_t inner, const T& x) {
      if (block) block[outer * nv + inner] += x;
    };
    for (int i = 1; i <= topology.n; ++i) {
      const int begin = topology.first_screw[i], next = topology.first_screw[i + 1],
                end = topology.first_screw[topology.subtree_end[i]];
      for (int l = begin; l < next; ++l) {
        multiply(l, begin, next, end, loaded);
        const std::ptrdiff_t v_l = topology.iv[i] + l - begin;
        for (int j = i; j < topology.subtree_end[i]; ++j)
          for (int k = topology.first_screw[j]; k < topology.first_screw[j + 1]; ++k) {
            const std::ptrdiff_t v_k = topology.iv[j] + k - topology.first_screw[j];
            add(H.qq, v_l, v_k, line.array(0)[k]);
            add(H.qv, v_l, v_k, line.array(1)[k]);
            add(H.aq, v_k, v_l, line.array(4)[k]);
            add(H.vv, v_l, v_k, j == i ? line.array(3)[k] - line.array(6)[k] : line.array(3)[k]);
            if (j == i) continue;
            add(H.qq, v_k, v_l, line.array(0)[k]);
            add(H.qv, v_k, v_l, line.array(2)[k]);
            add(H.vv, v_k, v_l, line.array(3)[k]);
            add(H.aq, v_l, v_k, line.array(5)[k]);
          }
      }
    }
  }

 private:
  using Part = typename FirstOrder<T>::Part;
  enum CurvaturePart { chi = 0, psi_1 = 6, X = 12, Y = 18, Z = 24, Q = 30, AS = 36 };

  /// Computes the adjoint twist Λ and the VirtualMomentum of each body.
  void compute_adjoint_twists(const Topology& topology, const T* lambda) noexcept {
    set_adjoint_twist(0, {});
    for (int i = 1; i <= topology.n; ++i) {
      Motion6<T> next = adjoint_twist(topology.parent[i]);
      for (int s = topology.first_screw[i]; s < topology.first_screw[i + 1]; ++s)
        next += lambda[topology.iv[i] + s - topology.first_screw[i]] * first.screws.screw(s);
      set_adjoint_twist(i, next);
    }
    for (int i = 1; i <= topology.n; i += L::width) {
      typename decltype(momenta)::Components numbers;
      VirtualMomentum<Number>::of(first.screws.bodies_from(i), adjoint_twists([i](int l) { return i + l; }))
          .to(numbers);
      momenta.store(numbers, i);
    }
  }
  Motion6<T> adjoint_twist(int i) const { return {Lambda.get3(i, 0), Lambda.get3(i, 4)}; }
  void set_adjoint_twist(int i, const Motion6<T>& twist) const {
    Lambda.set3(twist.w, i, 0);
    Lambda.set3(twist.v, i, 4);
  }
  /// Λ of the bodies i(0), i(1), ..., one body in each lane.
  template <class Row> [[gnu::always_inline]] Motion6<Number> adjoint_twists(const Row& i) const {
    typename NumberRows<T, 8>::Components x;
    Lambda.load(i, x);
    return {Lambda.vector(x, 0), Lambda.vector(x, 4)};
  }
  /// Computes for each body the matrix K that loads add to the second derivatives of λ·τ, with the forces τ
  /// of inverse dynamics and constant weights λ (D2.8). For two screws X and Y, the power of the wrench K Y
  /// on X is minus the sum of the powers of the wrenches L(Y) (L(X) W) on the twist Λ, over the loads W on
  /// the body. L(X) W is the change of W if the body is displaced along X, see load_change(). Λ is the twist
  /// that the body would have if the joints moved with the velocities λ.
  [[gnu::noinline]] void add_load_hessian(const Tree<T>& tree,
                                          std::span<const AppliedWrench<T>> wrenches) noexcept {
    for (int i = 0; i <= tree->n; ++i) K[i] = {};
    first.each_load(
        tree, wrenches, [&](const auto& given, int i, const Vec3<T>& r, const Vec3<T>& m, const Vec3<T>& f) {
          const Representation in = given.representation;
          const Motion6<T> Lambda_i = adjoint_twist(i);
          const Vec3<T> v = Lambda_i.v + cross(Lambda_i.w, r);  // the velocity of Λ at the point of the load
          const auto change_of = [&](const Vec3<T>& x, const Vec3<T>& y, const Vec3<T>& w) {
            return dot(x, y) * w - dot(y, w) * x;
          };
          K[i] += TwistToWrench<Spatial, T>::of([&](const Motion6<T>& D) -> Wrench<Spatial, T> {
            switch (in) {
              case Representation::body: break;
              case Representation::spatial:
                return coad(ad(Lambda_i, D), Wrench<Spatial, T>{m + cross(r, f), f});
              case Representation::hybrid: return {change_of(Lambda_i.w, m, D.w) + change_of(v, f, D.w), {}};
              case Representation::mixed: return {change_of(v, f, D.w), {}};
            }
            return {};
          });
        });
  }
  void compose(const Topology& topology, bool loaded) noexcept {
    momenta.sum_subtrees(topology);
    const MovingScrews<T>& screws = first.screws;
    for (int c = 0; c < topology.n_screws; c += L::width) {
      const auto body = [&](int l) { return screws.body_of[std::min(c + l, topology.n_screws - 1)]; };
      typename decltype(momenta)::Components Pi;
      momenta.load(body, Pi);
      const MovingColumn<Number> column = screws.columns_from(c);
      const auto x = ScrewCurvature<Number>::of(
          screws.subtrees_of_columns(c, topology.n_screws), VirtualMomentum<Number>::from(Pi), column.S,
          column.V_p, adjoint_twists([&](int l) { return topology.parent[body(l)]; }));
      store6(x.chi.w, x.chi.v, curvature, chi, c);
      store6(x.psi_1.w, x.psi_1.v, curvature, psi_1, c);
      store6(x.X.m, x.X.f, curvature, X, c);
      store6(x.Y.m, x.Y.f, curvature, Y, c);
      store6(x.Z.m, x.Z.f, curvature, Z, c);
      store6(x.AS.m, x.AS.f, curvature, AS, c);
    }
    if (!loaded) return;
    sum_subtrees(topology, K);
    for (int i = 1; i <= topology.n; ++i)
      for (int c = topology.first_screw[i]; c < topology.first_screw[i + 1]; ++c) {
        const Motion6<T> chi_c{curvature.get3(chi, c), curvature.get3(chi + 3, c)};
        const Wrench<Spatial, T> Q_c = first.N[i].transposed_times(chi_c) + K[i] * screws.screw(c);
        for (int k = 0; k < 6; ++k) curvature.array(Q + k)[c] = entry(Q_c, k);
      }
  }

  /// Returns the terms that must be subtracted from the second derivatives of λ·τ by two velocities of one
  /// joint (D2.8). τ are the forces of inverse dynamics, and λ constant weights. The formula for screws of
  /// two different joints contains these terms. Within one joint they do not occur, because the velocity
  /// along S_l does not change the twist of the predecessor of the joint. Lane j has the term for the screws
  /// S_l and S_c with c = k + j: the power of the wrench -ad_{S_c}ᵀ A on S_l. A is the sum of M Λ over the
  /// bodies of the subtree, where M is the inertia of a body and Λ the twist that it would have if the joints
  /// moved with the velocities λ.
  [[gnu::always_inline]] Number own_bracket(int l, int k) const {
    return product(first.effect, Part::S, l, curvature, AS, k);
  }
  /// Second derivatives of λ·τ by the pairs of variables (q, q), (q, v), (v, v) and (a, q), in one row and
  /// several columns of the matrix of each pair, one column in each lane. The row is the component of the
  /// first variable.
  struct Entries {
    Number qq, qv, vv, aq;
  };
  /// Writes the columns c, c + 1, ... of the matrices of second derivatives of λ·τ by (q, q), (q, v), (v, v)
  /// and (a, q), one column in each SIMD lane, for a tree without couplings. All later columns must have been
  /// written before, because lanes beyond the end of a row overwrite the first entries of the next row.
  void write_columns(const Topology& topology, int c, bool loaded, const HessianBlocks<T>& H) const noexcept {
    const int nv = topology.nv, next = std::min(c + L::width, nv);
    const auto end_of = [&](int k) { return topology.velocity_end[k]; };
    const auto joint_of = [&](int k) { return topology.first_screw[first.screws.body_of[k]]; };
    const auto joint_end = [&](int k) { return topology.first_screw[first.screws.body_of[k] + 1]; };
    Number column, joint, after, subtree;  // of each lane: its column, the first column of its joint, the end
                                           // of that joint, and the end of the columns that it moves
    int end = next;                        // of the rows that are not 0
    for (int l = 0; l < L::width; ++l) {
      const int k = std::min(c + l, nv - 1);
      column.x[l] = T(c + l);
      joint.x[l] = T(joint_of(k));
      after.x[l] = T(joint_end(k));
      subtree.x[l] = T(end_of(k));
      end = std::max(end, end_of(k));
    }
    const Number zero(T(0));
    const auto chosen = [](const auto& where, const Entries& x, const Entries& y) {
      return Entries{select(where, x.qq, y.qq), select(where, x.qv, y.qv), select(where, x.vv, y.vv),
                     select(where, x.aq, y.aq)};
    };
    const Entries zeros{zero, zero, zero, zero};
    const int first_row = joint_of(c), last_row = joint_end(next - 1);
    for (int r = 0; r < nv; ++r) {
      const Number row(static_cast<T>(r));
      Entries x = zeros;
      if (r < first_row) {
        if (end_of(r) > c) x = chosen(Number(T(end_of(r))) <= column, zeros, above(r, c, loaded));
      } else if (r < last_row) {
        const Entries a = above(r, c, loaded), b = below(r, c, loaded);
        const auto is_above = row < joint;
        x = chosen(row < after, a, b);
        x.vv = select(row < after && !is_above, a.vv - own_bracket(r, c), x.vv);
        x.aq = select(is_above, a.aq, b.aq);
        x = chosen(subtree <= row || (is_above && Number(T(end_of(r))) <= column), zeros, x);
      } else if (r < end) {
        x = chosen(subtree <= row, zeros, below(r, c, loaded));
      }
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(r) * nv + c;
      store_row<T>(x.qq, r, c, nv, H.qq + at);
      store_row<T>(x.qv, r, c, nv, H.qv + at);
      store_row<T>(x.vv, r, c, nv, H.vv + at);
      store_row<T>(x.aq, r, c, nv, H.aq + at);
    }
  }
  /// Returns the second derivatives (D2.8) of λ·τ by the pairs of variables (q, q), (q, v), (v, v) and (a,
  /// q), in row r and the columns c, c + 1, ... of the matrix of each pair, one column in each lane. Row r is
  /// component r of the first variable, and column c component c of the second. The results are valid if the
  /// joint of the row is before the joint of the column on a path from the ground. If both are the same
  /// joint, own_bracket() must be subtracted from those by (v, v), and those by (a, q) are valid in the
  /// result of below() instead.
  [[gnu::always_inline]] Entries above(int r, int c, bool loaded) const {
    const Arrays<T> e = first.effect, d = curvature;
    Number qq = product(d, chi, r, e, Part::P, c) + product(e, Part::psi_2, r, d, Y, c) +
                product(d, psi_1, r, d, X, c);
    if (loaded) qq = qq + product(e, Part::S, r, d, Q, c);
    return {qq, product(d, chi, r, e, Part::R, c) + product(d, psi_1, r, d, Z, c),
            product(e, Part::S, r, d, Z, c), product(e, Part::S, r, d, Y, c)};
  }
  /// Returns the second derivatives (D2.8) of λ·τ by the pairs of variables (q, q), (q, v), (v, v) and (a,
  /// q), in row r and the columns c, c + 1, ... of the matrix of each pair, one column in each lane. Row r is
  /// component r of the first variable, and column c component c of the second. The results are valid if the
  /// joint of the column is before the joint of the row on a path from the ground. If both are the same
  /// joint, only those by (a, q) are valid.
  [[gnu::always_inline]] Entries below(int r, int c, bool loaded) const {
    const Arrays<T> e = first.effect, d = curvature;
    Number qq = product(e, Part::P, r, d, chi, c) + product(d, Y, r, e, Part::psi_2, c) +
                product(d, X, r, d, psi_1, c);
    if (loaded) qq = qq + product(d, Q, r, e, Part::S, c);
    return {qq, product(d, Y, r, e, Part::sigma, c) + product(d, X, r, e, Part::S, c),
            product(d, Z, r, e, Part::S, c), product(e, Part::U, r, d, chi, c)};
  }
  /// The products of a six-vector of row r with the six-vectors of the columns from c on, one in each lane.
  [[gnu::always_inline]] static Number product(const Arrays<T>& of_row, int i, int r,
                                               const Arrays<T>& of_columns, int k, int c) {
    const T *x = of_row.array(i) + r, *y = of_columns.array(k) + c;
    Number sum = *x * L::load(y);
    for (int m = 1; m < 6; ++m) sum = sum + x[m * of_row.stride] * L::load(y + m * of_columns.stride);
    return sum;
  }
  /// Computes second derivatives (D2.8) of λ·τ, with the forces τ of inverse dynamics and constant weights λ,
  /// for the joint screw l and each joint screw c from `begin` to `end` - 1 in the subtree of its joint.
  /// Writes them to entry c of the arrays 0 to 5 of `line`: those by q_l and q_c, by q_l and v_c, by q_c and
  /// v_l, by v_l and v_c, by a_c and q_l, by a_l and q_c. If both screws belong to one joint (c < `next`),
  /// the arrays 2 and 5 are not valid, and the caller must subtract array 6 from array 3. Array 6 has the
  /// results of own_bracket(): terms of the formula for screws of different joints that do not occur within
  /// one joint.
  void multiply(int l, int begin, int next, int end, bool loaded) noexcept {
    const Arrays<T> e = first.effect, d = curvature,
                    out = line;  // local copies, so that the compiler knows that no result overwrites them
    for (int c = begin; c < end; c += L::width) {
      const Entries x = above(l, c, loaded);
      L::store(x.qq, out.array(0) + c);
      L::store(x.qv, out.array(1) + c);
      L::store(product(e, Part::sigma, l, d, Y, c) + product(e, Part::S, l, d, X, c), out.array(2) + c);
      L::store(x.vv, out.array(3) + c);
      L::store(product(d, chi, l, e, Part::U, c), out.array(4) + c);
      L::store(x.aq, out.array(5) + c);
    }
    for (int c = begin; c < next; c += L::width) L::store(own_bracket(l, c), out.array(6) + c);
  }
};

}  // namespace axode
