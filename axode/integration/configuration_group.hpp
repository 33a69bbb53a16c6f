#pragma once
#include <array>
#include <utility>

#include "axode/integration/local_coordinates.hpp"
#include "axode/lie/cayley.hpp"
#include "axode/lie/twist.hpp"
#include "axode/model/tree.hpp"

namespace axode {

/// The configurations of a tree as a Lie group, the product of the subgroups of the joints. Elements x, y of
/// its Lie algebra have nv numbers of the type T along the left-trivialised directions of the joints; for
/// joints of one velocity brackets vanish and ⊕ is +. The numbers of the tree have the type S. Arguments are
/// vectors or pointers to their first numbers; results may share the memory of arguments. O(n).
///
/// q ⊕ x is q exp x or, with LocalCoordinates::cayley, q cay x with Cayley's map. velocity(), acceleration()
/// and rate() follow by differentiation of ⊕, (D8.1), (D8.3) and (D14.9): they convert between rates of x and
/// the velocity or acceleration of q ⊕ x. The transposed maps act on momenta. The members' comments write all
/// these maps for exp.
template <class T, class S = T> class ConfigurationGroup {
 public:
  /// The first number of an argument or of a result, which is a vector or a pointer.
  template <class Number> struct First {
    First(Number* x) : first(x) {}
    template <class V, class = decltype(std::declval<V&>().data())> First(V&& x) : first(x.data()) {}
    Number* first;
  };
  using Argument = First<const T>;
  using Result = First<T>;

  explicit ConfigurationGroup(const Tree<S>& tree,
                              LocalCoordinates coordinates = LocalCoordinates::exponential)
      : tree_(&tree), by_exp_(coordinates == LocalCoordinates::exponential) {
    for (int i = 1; i <= tree->n; ++i)
      if (tree->first_screw[i + 1] - tree->first_screw[i] > 1) commutes_ = false;
  }
  /// Whether all joints have one velocity, so that the group is commutative.
  bool commutes() const { return commutes_; }

  /// Computes q ⊕ x. The norm of its quaternions is corrected to second order.
  void move(Argument q, Argument x, Result out) const noexcept;
  /// Computes the x with q0 ⊕ x = q1. Rotations take the shorter way round.
  void difference(Argument q0, Argument q1, Result out) const noexcept;
  /// Computes out = q ⊕ x ⊕ x, which is q ⊕ 2x in exponential coordinates. The contents of x are lost.
  void move_twice(Argument q, Result x, Result out) const noexcept;
  /// Computes x with its entries for joints of one velocity replaced by 0.
  void noncommuting(Argument x, Result out) const noexcept;
  /// Computes the bracket [x, y].
  void bracket(Argument x, Argument y, Result out) const noexcept;
  /// Computes dexp_{-x} y, which is the velocity of q ⊕ x if x' = y.
  void velocity(Argument x, Argument y, Result out) const noexcept;
  /// Computes dexp_{-x} z + (D_{-y} dexp)_{-x} y, which is the acceleration of q ⊕ x if x' = y and y' = z.
  void acceleration(Argument x, Argument y, Argument z, Result out) const noexcept;
  /// Computes dexp⁻¹_{-x} y, which is the rate x' for which q ⊕ x has the velocity y.
  void rate(Argument x, Argument y, Result out) const noexcept;

  // The maps ad_transpose(), Ad_transpose() and dexp_transpose() are transposed: they act on momenta p.
  /// Computes ad_xᵀ p.
  void ad_transpose(Argument x, Argument p, Result out) const noexcept;
  /// Computes Ad_{exp x}ᵀ p, which is the momentum p at q, expressed at q ⊕ x.
  void Ad_transpose(Argument x, Argument p, Result out) const noexcept;
  /// Computes dexp_xᵀ p.
  void dexp_transpose(Argument x, Argument p, Result out) const noexcept;

 private:
  const Tree<S>& tree() const { return *tree_; }
  template <class F> void each_own_joint(const F& f) const noexcept {
    for (const JointGroup& group : tree()->joint_groups)
      if (!group.coupled)
        with_subgroup(group.kind, T(0), [&](const auto& joint) {  // no map depends on the pitch
          for (int k = group.begin; k < group.end; ++k) f(joint, tree()->by_kind[k]);
        });
  }
  /// Computes the screw S x of a joint from its velocities x and their unit screws S. put() is the inverse.
  template <class Joint> static Screw<T> screw(const Joint& joint, const T* x) noexcept {
    const Twist<BodyFixed, T> X = joint.twist(x);
    return {X.w, X.v};
  }
  template <class Joint> static void put(const Joint& joint, const Screw<T>& X, T* out) noexcept {
    const auto x = joint.project(Wrench<BodyFixed, T>{X.w, X.v});
    for (int k = 0; k < joint.nv; ++k) out[k] = x[static_cast<std::size_t>(k)];
  }
  /// Applies a map f of screws joint by joint. For every joint of several velocities, let S be its unit
  /// screws and x, y the entries for its velocities: `out` receives the z with S z = f(S x, S y). For a joint
  /// of one velocity `out` receives the entry of `plain`, or 0 if `plain` is null.
  template <class F>
  void each_block(const T* x, const T* y, T* out, const F& f, const T* plain = nullptr) const noexcept {
    each_own_joint([&]<class Joint>(const Joint& joint, int i) {
      const int c = tree()->iv[i];
      if constexpr (Joint::nv == 1) {
        out[c] = plain ? plain[c] : T(0);
      } else {
        put(joint, f(screw(joint, x + c), screw(joint, y + c)), out + c);
      }
    });
  }
  /// Applies a map f of momenta joint by joint. For every joint of several velocities, let S be its unit
  /// screws, and x and p the entries of the arguments for its velocities. `out` receives Sᵀ E f(S x, E S p),
  /// where E exchanges the angular and the linear part of six numbers. With exchanged parts, the transpose of
  /// Ad_{exp X}, ad_X or dexp_X is the same map of screws with -X instead of X. For a joint of one velocity
  /// `out` receives the entry of the array `plain`, or 0 if `plain` is null.
  template <class F>
  void each_dual_block(const T* x, const T* p, T* out, const F& f, const T* plain = nullptr) const noexcept {
    each_block(
        x, p, out,
        [&](const Screw<T>& X, const Screw<T>& P) {
          const Screw<T> Z = f(X, Screw<T>{P.v, P.w});
          return Screw<T>{Z.v, Z.w};
        },
        plain);
  }

  const Tree<S>* tree_;
  bool by_exp_, commutes_ = true;
};

template <class T, class S>
void ConfigurationGroup<T, S>::move(Argument q, Argument x, Result out) const noexcept {
  each_own_joint([&]<class Joint>(const Joint& joint, int i) {
    T* const to = out.first + tree()->iq[i];
    const T* by = x.first + tree()->iv[i];
    std::array<T, Joint::nv> canonical;
    if constexpr (Joint::nv > 1)
      if (!by_exp_) {
        put(joint, log_cay(screw(joint, by)), canonical.data());
        by = canonical.data();
      }
    joint.integrate(q.first + tree()->iq[i], by, to);
    if constexpr (Joint::nq > Joint::nv) {
      const T scale = T(0.5) * (T(3) - (to[0] * to[0] + to[1] * to[1] + to[2] * to[2] + to[3] * to[3]));
      for (int k = 0; k < 4; ++k) to[k] = scale * to[k];
    }
  });
}

template <class T, class S>
void ConfigurationGroup<T, S>::difference(Argument q0, Argument q1, Result out) const noexcept {
  each_own_joint([&](const auto& joint, int i) {
    joint.difference(q0.first + tree()->iq[i], q1.first + tree()->iq[i], out.first + tree()->iv[i]);
  });
}

template <class T, class S>
void ConfigurationGroup<T, S>::move_twice(Argument q, Result x, Result out) const noexcept {
  if (by_exp_) {
    for (int c = 0; c < tree()->nv; ++c) x.first[c] *= T(2);
    move(q, x.first, out);
  } else {
    move(q, x.first, out);
    move(out.first, x.first, out);
  }
}

template <class T, class S>
void ConfigurationGroup<T, S>::noncommuting(Argument x, Result out) const noexcept {
  each_block(x.first, x.first, out.first, [](const Screw<T>& X, const Screw<T>&) { return X; });
}

template <class T, class S>
void ConfigurationGroup<T, S>::bracket(Argument x, Argument y, Result out) const noexcept {
  each_block(x.first, y.first, out.first, [](const Screw<T>& X, const Screw<T>& Y) { return ad(X, Y); });
}

template <class T, class S>
void ConfigurationGroup<T, S>::velocity(Argument x, Argument y, Result out) const noexcept {
  each_block(
      x.first, y.first, out.first,
      [this](const Screw<T>& X, const Screw<T>& Y) { return by_exp_ ? dexp(-X, Y) : dcay(-X, Y); }, y.first);
}

template <class T, class S>
void ConfigurationGroup<T, S>::acceleration(Argument x, Argument y, Argument z, Result out) const noexcept {
  each_own_joint([&]<class Joint>(const Joint& joint, int i) {
    const int c = tree()->iv[i];
    if constexpr (Joint::nv == 1) {
      out.first[c] = z.first[c];
    } else {
      const Screw<T> X = screw(joint, x.first + c), Y = screw(joint, y.first + c),
                     Z = screw(joint, z.first + c);
      put(joint, by_exp_ ? dexp(-X, Z) + ddexp(-X, -Y, Y) : dcay(-X, Z) + ddcay(-X, -Y, Y), out.first + c);
    }
  });
}

template <class T, class S>
void ConfigurationGroup<T, S>::rate(Argument x, Argument y, Result out) const noexcept {
  each_block(
      x.first, y.first, out.first,
      [this](const Screw<T>& X, const Screw<T>& Y) { return by_exp_ ? dexp_inv(-X, Y) : dcay_inv(-X, Y); },
      y.first);
}

template <class T, class S>
void ConfigurationGroup<T, S>::ad_transpose(Argument x, Argument p, Result out) const noexcept {
  each_dual_block(x.first, p.first, out.first,
                  [](const Screw<T>& X, const Screw<T>& P) { return ad(-X, P); });
}

template <class T, class S>
void ConfigurationGroup<T, S>::Ad_transpose(Argument x, Argument p, Result out) const noexcept {
  each_dual_block(
      x.first, p.first, out.first,
      [this](const Screw<T>& X, const Screw<T>& P) { return Ad(by_exp_ ? exp(-X) : cay(-X), P); }, p.first);
}

template <class T, class S>
void ConfigurationGroup<T, S>::dexp_transpose(Argument x, Argument p, Result out) const noexcept {
  if (by_exp_) {
    each_dual_block(
        x.first, p.first, out.first, [](const Screw<T>& X, const Screw<T>& P) { return dexp(-X, P); },
        p.first);
  } else {
    each_block(
        x.first, p.first, out.first,
        [](const Screw<T>& X, const Screw<T>& P) { return dcay_transpose(X, P); }, p.first);
  }
}

extern template class ConfigurationGroup<double>;

}  // namespace axode
