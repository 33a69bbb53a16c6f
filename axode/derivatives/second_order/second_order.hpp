#pragma once
#include "axode/derivatives/displacement/first_order.hpp"
#include "axode/lie/six.hpp"

namespace axode {

/// The wrench A = M Λ, the moment H of Bᵀ Λ, and the matrix D of the Coriolis inertia for the twist Λ, of a
/// body with the inertia M and the Coriolis inertia B. Λ is the twist that the body would have if the joints
/// moved with given weights λ as velocities. The derivatives of the gradient of λ·τ, with the forces τ of
/// inverse dynamics, follow from sums of these quantities over subtrees ((D1.21) and (D2.2) of
/// docs/derivations).
template <class T> struct VirtualMomentum {
  Wrench<Spatial, T> A;
  Vec3<T> H;
  Mat3<T> D;

  static constexpr std::size_t size = 18;
  using Entries = std::array<T, size>;

  static constexpr VirtualMomentum of(const MovingInertia<T>& body, const Motion6<T>& Lambda) {
    const Momentum<Spatial, T> A = body.M * Lambda;
    return {{A.l, A.p}, body.B.transposed_times(Lambda), CoriolisInertia<T>::of(body.M, Lambda).D};
  }
  constexpr CoriolisInertia<T> B() const { return {D, A.f}; }
};

/// The screws and wrenches of one joint screw from whose products with those of another joint screw all
/// second derivatives of λ·τ follow, for the forces τ of inverse dynamics and constant weights λ, in addition
/// to those that give the first derivatives ((D2.7) and (D2.8) of docs/derivations). `chi` is the bracket
/// [Λ_p, S] of the joint screw S with the twist Λ_p that the predecessor would have if the joints moved with
/// the weights λ as velocities, and `psi_1` is [V_p, S] with its twist V_p.
template <class T> struct ScrewCurvature {
  Motion6<T> chi, psi_1;
  Wrench<Spatial, T> X, Y, Z, Q;
  Wrench<Spatial, T> AS;  ///< hat(A) S = -ad_Sᵀ A

  static constexpr std::size_t size = 42;
  using Entries = std::array<T, size>;

  /// Computes all members for a joint screw S except the wrench Q, which is 0 without loads. `moved` and
  /// `momentum` have the inertias and momenta of the subtree of the joint. V_p is the twist of the
  /// predecessor, and Lambda_p the twist that it would have if the joints moved with the weights λ as
  /// velocities.
  static constexpr ScrewCurvature of(const MovingInertia<T>& moved, const VirtualMomentum<T>& momentum,
                                     const Motion6<T>& S, const Motion6<T>& V_p, const Motion6<T>& Lambda_p) {
    const Motion6<T> chi = ad(Lambda_p, S), psi_1 = ad(V_p, S);
    const Momentum<Spatial, T> M_chi = moved.M * chi;
    const Wrench<Spatial, T> AS = coad(S, momentum.A), BS = momentum.B() * S;
    const Wrench<Spatial, T> X = Wrench<Spatial, T>{moved.B.transposed_times(chi), {}} -
                                 momentum.B() * psi_1 + coad(S, Wrench<Spatial, T>{momentum.H, {}}) +
                                 T(2) * coad(psi_1, momentum.A);
    return {chi, psi_1, X, Wrench<Spatial, T>{M_chi.l, M_chi.p} + AS, T(2) * AS - BS, {}, AS};
  }
};

/// Receives second derivatives along the pairs of directions (q, q), (q, v), (v, v) and a fourth pair, which
/// is (a, q) for inverse and (τ, q) for forward dynamics: nv × nv numbers each, [outer derivative][inner
/// derivative]. qq is symmetric, except within joints of several velocities, where the outer displacement
/// comes first.
template <class T> struct HessianBlocks { T *qq, *qv, *vv, *aq; };

/// Computes the second partial derivatives of λ·τ, the sum of the forces τ of inverse dynamics with constant
/// weights λ, in O(n d) on paths of d velocities: about 400 products and sums for a hinge, and 114 for each
/// pair of a joint and a joint before it on its path.
template <class T> struct SecondOrder {
  using L = Lanes<T>;
  using Number = typename L::Number;
  static constexpr int results = 6;

  FirstOrder<T> first;
  Motion6<T>* Lambda;
  Arrays<T> Lambdas, momenta;               ///< for each body: Λ, and VirtualMomentum of the body, later of
                                            ///< its subtree
  Arrays<T> Lambda_p, momentum, curvature;  ///< for each column: Λ of the predecessor, VirtualMomentum of the
                                            ///< subtree, and ScrewCurvature
  Arrays<T> line;
  TwistToWrench<Spatial, T>* K;  ///< minus the second derivatives of the power of the loads on Λ

  explicit SecondOrder(Arena& arena)
      : first(arena),
        Lambda(arena.per_body<Motion6<T>>()),
        Lambdas(arena, 6, arena.topology().n + 1),
        momenta(arena, static_cast<int>(VirtualMomentum<T>::size), arena.topology().n + 1),
        Lambda_p(arena, 6, arena.topology().n_screws),
        momentum(arena, static_cast<int>(VirtualMomentum<T>::size), arena.topology().n_screws),
        curvature(arena, static_cast<int>(ScrewCurvature<T>::size), arena.topology().n_screws),
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
  /// Adds the second derivatives to the blocks of H, after run(). A block that is null is skipped.
  void add_to(const Topology& topology, bool loaded, const HessianBlocks<T>& H) noexcept {
    const std::ptrdiff_t nv = topology.nv;
    const auto add = [&](T* block, std::ptrdiff_t outer, std::ptrdiff_t inner, const T& x) {
      if (block) block[outer * nv + inner] += x;
    };
    for (int i = 1; i <= topology.n; ++i) {
      const int begin = topology.first_screw[i], next = topology.first_screw[i + 1],
                end = topology.first_screw[topology.subtree_end[i]];
      for (int l = begin; l < next; ++l) {
        multiply(l, begin, end, loaded);
        const std::ptrdiff_t v_l = topology.iv[i] + l - begin;
        for (int j = i; j < topology.subtree_end[i]; ++j)
          for (int k = topology.first_screw[j]; k < topology.first_screw[j + 1]; ++k) {
            const std::ptrdiff_t v_k = topology.iv[j] + k - topology.first_screw[j];
            add(H.qq, v_l, v_k, line.array(0)[k]);
            add(H.qv, v_l, v_k, line.array(1)[k]);
            add(H.aq, v_k, v_l, line.array(4)[k]);
            add(H.vv, v_l, v_k, j == i ? line.array(3)[k] - own_bracket(l, k) : line.array(3)[k]);
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
    Lambda[0] = {};
    set6(Lambdas, 0, Lambda[0]);
    for (int i = 1; i <= topology.n; ++i) {
      const Motion6<T> Lambda_before = Lambda[topology.parent[i]];
      Lambda[i] = Lambda_before;
      for (int s = topology.first_screw[i]; s < topology.first_screw[i + 1]; ++s) {
        set6(Lambda_p, s, Lambda_before);
        Lambda[i] += lambda[topology.iv[i] + s - topology.first_screw[i]] * first.screws.screw(s);
      }
      set6(Lambdas, i, Lambda[i]);
    }
    for (int i = 0; i <= topology.n; i += L::width) {
      const auto numbers = std::bit_cast<typename VirtualMomentum<Number>::Entries>(
          VirtualMomentum<Number>::of(first.screws.bodies(i), load6(Lambdas, i)));
      for (std::size_t k = 0; k < numbers.size(); ++k)
        L::store(numbers[k], momenta.array(static_cast<int>(k)) + i);
    }
  }
  /// Computes a matrix K for each body: minus the second derivatives, by displacements of the body, of the
  /// power of its loads along the twist Λ. Λ is the twist that the body would have if the joints moved with
  /// the weights λ of the forces τ as velocities.
  [[gnu::noinline]] void add_load_hessian(const Tree<T>& tree,
                                          std::span<const AppliedWrench<T>> wrenches) noexcept {
    for (int i = 0; i <= tree->n; ++i) K[i] = {};
    first.each_load(tree, wrenches,
                    [&](const auto& given, int i, const Vec3<T>& r, const Vec3<T>& m, const Vec3<T>& f) {
                      const Representation in = given.representation;
                      const Vec3<T> v =
                          Lambda[i].v + cross(Lambda[i].w, r);  // the velocity of Λ at the point of the load
                      const auto change_of = [&](const Vec3<T>& x, const Vec3<T>& y, const Vec3<T>& w) {
                        return dot(x, y) * w - dot(y, w) * x;
                      };
                      K[i] += TwistToWrench<Spatial, T>::of([&](const Motion6<T>& D) -> Wrench<Spatial, T> {
                        switch (in) {
                          case Representation::body: break;
                          case Representation::spatial:
                            return coad(ad(Lambda[i], D), Wrench<Spatial, T>{m + cross(r, f), f});
                          case Representation::hybrid:
                            return {change_of(Lambda[i].w, m, D.w) + change_of(v, f, D.w), {}};
                          case Representation::mixed: return {change_of(v, f, D.w), {}};
                        }
                        return {};
                      });
                    });
  }
  void compose(const Topology& topology, bool loaded) noexcept {
    sum_subtrees(topology, static_cast<int>(VirtualMomentum<T>::size), momenta, momentum);
    const MovingScrews<T>& screws = first.screws;
    for (int c = 0; c < topology.n_screws; c += L::width) {
      typename VirtualMomentum<Number>::Entries Pi;
      for (std::size_t k = 0; k < Pi.size(); ++k) Pi[k] = L::load(momentum.array(static_cast<int>(k)) + c);
      const auto numbers = std::bit_cast<typename ScrewCurvature<Number>::Entries>(
          ScrewCurvature<Number>::of(screws.subtree_of_columns(c), std::bit_cast<VirtualMomentum<Number>>(Pi),
                                     load6(screws.S, c), load6(screws.V_p, c), load6(Lambda_p, c)));
      for (std::size_t k = 0; k < numbers.size(); ++k)
        L::store(numbers[k], curvature.array(static_cast<int>(k)) + c);
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

  /// The number to subtract, for two screws l and k of one joint, from the second derivative by their
  /// velocities that the formula for screws of two different joints gives. Within one joint the velocity of
  /// one screw does not change the twist of the predecessor of the other, so that one bracket less occurs:
  /// S_l | -ad_{S_k}ᵀ A, where A is the sum over the subtree of M Λ, the inertia times the twist of a body
  /// for joint velocities equal to the weights λ.
  T own_bracket(int l, int k) const {
    T sum(0);
    for (int c = 0; c < 6; ++c) sum += curvature.array(AS + c)[k] * first.screws.S.array(c)[l];
    return sum;
  }
  /// Multiplies the screws and wrenches that belong to joint screw l (ScrewEffects and ScrewCurvature) with
  /// those of the joint screws from `begin` to `end` - 1, and writes the products to `line`, in six arrays.
  /// Second derivatives are sums of them.
  void multiply(int l, int begin, int end, bool loaded) noexcept {
    const Arrays<T> e = first.effect, d = curvature,
                    out = line;  // local copies, so that the compiler knows that no result overwrites them
    Number S[6], psi_2[6], sigma[6], chi_l[6], psi_l[6];
    for (int k = 0; k < 6; ++k) {
      S[k] = Number(e.array(Part::S + k)[l]);
      psi_2[k] = Number(e.array(Part::psi_2 + k)[l]);
      sigma[k] = Number(e.array(Part::sigma + k)[l]);
      chi_l[k] = Number(d.array(chi + k)[l]);
      psi_l[k] = Number(d.array(psi_1 + k)[l]);
    }
    const auto product = [](const Number(&mine)[6], const Arrays<T>& theirs, int part, int c) {
      return theirs.template product<6>(mine, part, c);
    };
    for (int c = begin; c < end; c += L::width) {
      const Number SY = product(S, d, Y, c), SX = product(S, d, X, c);
      Number qq = product(chi_l, e, Part::P, c) + product(psi_2, d, Y, c) + product(psi_l, d, X, c);
      if (loaded) qq = qq + product(S, d, Q, c);
      L::store(qq, out.array(0) + c);
      L::store(product(chi_l, e, Part::R, c) + product(psi_l, d, Z, c), out.array(1) + c);
      L::store(product(sigma, d, Y, c) + SX, out.array(2) + c);
      L::store(product(S, d, Z, c), out.array(3) + c);
      L::store(product(chi_l, e, Part::U, c), out.array(4) + c);
      L::store(SY, out.array(5) + c);
    }
  }
};

}  // namespace axode
