#include "axode/constraints/loop_system.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/scalar/dual.hpp"

/// Derivatives of the rows of loops. What a direction does to the two bodies of a loop is written out; what that does to
/// the rows comes from the rows themselves, run on dual numbers, whatever the kind of the loop.
namespace axode {
namespace {

template <class T> using Lifted = Dual<T, 1>;

template <class T> Lifted<T> lift(const T& x, const T& dx) { return {x, {dx}}; }
template <class T> Vec3<Lifted<T>> lift(const Vec3<T>& x, const Vec3<T>& dx) {
  return {lift(x.x, dx.x), lift(x.y, dx.y), lift(x.z, dx.z)};
}
/// A quantity that changes by another one.
template <template <class, class> class Kind, class T>
Kind<Spatial, Lifted<T>> lift(const Kind<Spatial, T>& x, const Screw<T>& dx) {
  return {lift(x.w, dx.w), lift(x.v, dx.v)};
}
/// A pose that moves along a screw.
template <class T> SE3<Lifted<T>> lift(const SE3<T>& C, const Screw<T>& X) {
  const auto axis = [&](const Vec3<T>& e) { return lift(e, cross(X.w, e)); };
  return {{axis(C.R.x), axis(C.R.y), axis(C.R.z)}, lift(C.r, X.v + cross(X.w, C.r))};
}

template <class Kind> auto screw(const Kind& x) {
  return Screw<std::remove_cvref_t<decltype(x.w.x)>>{x.w, x.v};
}

}  // namespace

template <class T>
void LoopSystem<T>::differentiate(const T* lambda, T* by_q, T* by_v, T* closing_by_q) noexcept {
  const auto& [link, V, dV] = dynamics_->recursion.motion.bodies;
  const auto nv = static_cast<std::ptrdiff_t>(model_.nv());
  for (std::size_t k = 0; k < at_.size(); ++k) {
    const LoopPath& path = paths_[k];
    const Loop& loop = *path.loop;
    if (loop.kind == LoopKind::coupling) continue;  // its row is constant
    const State& at = at_[k];
    const Wrench<Spatial, T> F = wrench(k, lambda);
    // About origin(k): what belongs to the first body, or to one on the path to it, is seen from another origin.
    const auto about_O = [&](const auto& x, int body, int side) {
      const Vec3<T> from = side < 0 && body > 0 ? at.shift : Vec3<T>{};
      return Screw<T>{x.w, x.v - cross(x.w, from)};
    };
    const auto twist = [&](const Screw<T>& X) { return Twist<Spatial, T>{X.w, X.v}; };
    const auto rate = [&](const Screw<T>& X) { return TwistRate<Spatial, T>{X.w, X.v}; };
    const std::array<Screw<T>, 2> V_end{about_O(V[loop.ends[0].body], loop.ends[0].body, -1),
                                        about_O(V[loop.ends[1].body], loop.ends[1].body, 1)};
    const std::array<Screw<T>, 2> dV_end{about_O(dV[loop.ends[0].body], loop.ends[0].body, -1),
                                         about_O(dV[loop.ends[1].body], loop.ends[1].body, 1)};
    for (const LoopColumn& c : path.columns) {
      const int p = tree()->parent[c.body];
      const std::size_t e = c.side > 0 ? 1 : 0;
      const Screw<T> J = about_O(dynamics_->bodies.S[c.screw], c.body, c.side);
      const Screw<T> V_p = about_O(V[p], p, c.side), V_b = about_O(V[c.body], c.body, c.side);
      const Screw<T> seen = V_end[e] - V_p, V_q = ad(J, seen);
      const Screw<T> dV_q = ad(J, dV_end[e] - about_O(dV[p], p, c.side)) + ad(ad(V_p, J), seen);
      const Screw<T> dV_v = V_q + ad(V_b, J), none{};
      const auto of = [&](std::size_t end, const Screw<T>& X) { return end == e ? X : none; };

      const LoopAt<Lifted<T>> moved(loop, lift(at.C_a, of(0, J)), lift(at.C_b, of(1, J)));
      const LoopAt<Lifted<T>> still(loop, lift(at.C_a, none), lift(at.C_b, none));
      const auto wrenches = moved.wrenches();
      const Six<Lifted<T>> along_q =
          moved.bias(wrenches, lift(twist(V_end[0]), of(0, V_q)), lift(twist(V_end[1]), of(1, V_q)),
                     lift(rate(dV_end[0]), of(0, dV_q)), lift(rate(dV_end[1]), of(1, dV_q)));
      const Six<Lifted<T>> along_v =
          still.bias(still.wrenches(), lift(twist(V_end[0]), of(0, J)), lift(twist(V_end[1]), of(1, J)),
                     lift(rate(dV_end[0]), of(0, dV_v)), lift(rate(dV_end[1]), of(1, dV_v)));
      Wrench<Spatial, T> dF{};
      for (int r = 0; r < path.rows.count; ++r) {
        const std::ptrdiff_t entry = (path.rows.first + r) * nv + c.velocity;
        by_q[entry] += along_q[index(r)].dx[0];
        by_v[entry] += along_v[index(r)].dx[0];
        const auto& [m, f] = wrenches[index(r)];
        dF += lambda[path.rows.first + r] *
              Wrench<Spatial, T>{{m.x.dx[0], m.y.dx[0], m.z.dx[0]}, {f.x.dx[0], f.y.dx[0], f.z.dx[0]}};
      }
      for (const LoopColumn& of_k : path.columns) {
        const Screw<T> J_k = about_O(dynamics_->bodies.S[of_k.screw], of_k.body, of_k.side);
        T change = dF | twist(J_k);
        if (of_k.side == c.side && c.body <= of_k.body) change += F | twist(ad(J, J_k));  // it moves along
        closing_by_q[of_k.velocity * nv + c.velocity] += of_k.side > 0 ? change : -change;
      }
    }
  }
}

template <class T> void LoopSystem<T>::differentiate_residuals(const T* lambda, T* rate) noexcept {
  const auto& V = dynamics_->recursion.motion.bodies.V;
  std::fill_n(rate, model_.nv(), T(0));
  for (std::size_t k = 0; k < at_.size(); ++k) {
    const LoopPath& path = paths_[k];
    if (path.loop->kind == LoopKind::coupling) continue;  // its row is constant
    const State& at = at_[k];
    const auto about_O = [&](const auto& x, int body, int side) {
      const Vec3<T> from = side < 0 && body > 0 ? at.shift : Vec3<T>{};
      return Screw<T>{x.w, x.v - cross(x.w, from)};
    };
    const int a = path.loop->ends[0].body, b = path.loop->ends[1].body;
    const auto R =
        LoopAt<Lifted<T>>(*path.loop, lift(at.C_a, about_O(V[a], a, -1)), lift(at.C_b, about_O(V[b], b, 1)))
            .residual_wrenches();
    Wrench<Spatial, T> F{}, dF{};
    for (int r = 0; r < path.residuals.count; ++r) {
      const T& factor = lambda[path.residuals.first + r];
      const auto& [m, f] = R[index(r)];
      F += factor * Wrench<Spatial, T>{{m.x.x, m.y.x, m.z.x}, {f.x.x, f.y.x, f.z.x}};
      dF += factor * Wrench<Spatial, T>{{m.x.dx[0], m.y.dx[0], m.z.dx[0]}, {f.x.dx[0], f.y.dx[0], f.z.dx[0]}};
    }
    for (const LoopColumn& c : path.columns) {
      const Screw<T> J = about_O(dynamics_->bodies.S[c.screw], c.body, c.side);
      const Screw<T> dJ = ad(about_O(V[c.body], c.body, c.side), J);
      const T change = (dF | Twist<Spatial, T>{J.w, J.v}) + (F | Twist<Spatial, T>{dJ.w, dJ.v});
      rate[c.velocity] += c.side > 0 ? change : -change;
    }
  }
}

template void LoopSystem<AXODE_T>::differentiate_residuals(const AXODE_T*, AXODE_T*) noexcept;
template void LoopSystem<AXODE_T>::differentiate(const AXODE_T*, AXODE_T*, AXODE_T*, AXODE_T*) noexcept;

}  // namespace axode
