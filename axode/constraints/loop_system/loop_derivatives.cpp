#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/recursion/instantiate.hpp"

/// Derivatives of the loop equations by q and v: each loop joint is evaluated on dual numbers (numbers with
/// their derivatives), for the motion of its two bodies along a direction of q or v (D6.10).
namespace axode {
namespace {

template <class T> using Lifted = Dual<T, 1>;
template <class T> Twist<Spatial, T> twist(const Screw<T>& X) { return {X.w, X.v}; }

}  // namespace

template <class T>
void LoopSystem<T>::differentiate(const T* lambda, T* by_q, T* by_v, T* constraint_forces_by_q) noexcept {
  const auto& V = dynamics_->recursion.motion.bodies.V;
  const auto& dV = dynamics_->recursion.motion.bodies.dV;
  const auto nv = static_cast<std::ptrdiff_t>(model_.nv());
  table_.each([&](std::size_t k, const auto& joint) {  // rows of couplings are constant
    const LoopPath& path = table_.paths[k];
    const State& at = at_[k];
    const Wrench<Spatial, T> F = wrench(k, lambda);
    // Moves a screw to origin(k). Screws on the path to the first body may be about another origin.
    const auto about_O = [&](const auto& x, int body, int side) {
      const Vec3<T> from = side < 0 && body > 0 ? at.shift : Vec3<T>{};
      return Screw<T>{x.w, x.v - cross(x.w, from)};
    };
    const loops::EndMotion<T> ends = motion_of_ends(k, V, dV);
    const std::array<Screw<T>, 2> V_end{ends.V_i, ends.V_j}, dV_end{ends.dV_i, ends.dV_j};
    for (const LoopColumn& c : path.columns) {
      const int p = tree()->parent[c.body];
      const std::size_t e = c.side > 0 ? 1 : 0;
      const Screw<T> J = about_O(dynamics_->bodies.S[c.screw], c.body, c.side);
      const Screw<T> V_p = about_O(V[p], p, c.side), V_b = about_O(V[c.body], c.body, c.side);
      const Screw<T> relative = V_end[e] - V_p, V_q = ad(J, relative);
      const Screw<T> dV_q = ad(J, dV_end[e] - about_O(dV[p], p, c.side)) + ad(ad(V_p, J), relative);
      const Screw<T> dV_v = V_q + ad(V_b, J), none{};
      const auto of = [&](std::size_t end, const Screw<T>& X) { return end == e ? X : none; };

      // The changes of W and of A a + γ if the bodies move along X, their twists change by dX, and the rates
      // of their twists by ddX.
      const auto along = [&](const Screw<T>& X, const Screw<T>& dX, const Screw<T>& ddX,
                             loops::LoopWrenches<Lifted<T>>& W) {
        const loops::LoopFrames<Lifted<T>> frames{loops::lift(at.frames.a, of(0, X)),
                                                  loops::lift(at.frames.b, of(1, X))};
        const loops::EndMotion<Lifted<T>> motion{
            loops::lift(V_end[0], of(0, dX)), loops::lift(V_end[1], of(1, dX)),
            loops::lift(dV_end[0], of(0, ddX)), loops::lift(dV_end[1], of(1, ddX))};
        Six<Lifted<T>> rates{};
        joint.wrenches(frames, W.data());
        loops::bias(joint, frames, W.data(), motion, rates.data());
        return rates;
      };
      loops::LoopWrenches<Lifted<T>> still, moved;
      const Six<Lifted<T>> along_v = along(none, J, dV_v, still), along_q = along(J, V_q, dV_q, moved);
      Wrench<Spatial, T> dF{};
      for (int r = 0; r < path.rows.count; ++r) {
        const std::ptrdiff_t entry = (path.rows.first + r) * nv + c.velocity;
        by_q[entry] += along_q[index(r)].dx[0];
        by_v[entry] += along_v[index(r)].dx[0];
        dF += lambda[path.rows.first + r] * loops::rate_of(moved[index(r)]);
      }
      for (const LoopColumn& of_k : path.columns) {
        const Screw<T> J_k = about_O(dynamics_->bodies.S[of_k.screw], of_k.body, of_k.side);
        T change = dF | twist(J_k);
        if (of_k.side == c.side && c.body <= of_k.body)
          change += F | twist(ad(J, J_k));  // the screw J_k is displaced too
        constraint_forces_by_q[of_k.velocity * nv + c.velocity] += of_k.side > 0 ? change : -change;
      }
    }
  });
}

template <class T> void LoopSystem<T>::differentiate_residuals(const T* lambda, T* rate) noexcept {
  const auto& V = dynamics_->recursion.motion.bodies.V;
  std::fill_n(rate, model_.nv(), T(0));
  table_.each([&](std::size_t k, const auto& joint) {
    const LoopPath& path = table_.paths[k];
    const State& at = at_[k];
    const auto about_O = [&](const auto& x, int body, int side) {
      const Vec3<T> from = side < 0 && body > 0 ? at.shift : Vec3<T>{};
      return Screw<T>{x.w, x.v - cross(x.w, from)};
    };
    const int a = path.ends[0].body, b = path.ends[1].body;
    const loops::LoopFrames<Lifted<T>> moving{loops::lift(at.frames.a, about_O(V[a], a, -1)),
                                              loops::lift(at.frames.b, about_O(V[b], b, 1))};
    loops::LoopWrenches<Lifted<T>> R;
    loops::residual_wrenches(joint, moving, R.data());
    Wrench<Spatial, T> F{}, dF{};
    for (int r = 0; r < path.residuals.count; ++r) {
      const T& factor = lambda[path.residuals.first + r];
      F += factor * loops::value_of(R[index(r)]);
      dF += factor * loops::rate_of(R[index(r)]);
    }
    for (const LoopColumn& c : path.columns) {
      const Screw<T> J = about_O(dynamics_->bodies.S[c.screw], c.body, c.side);
      const Screw<T> dJ = ad(about_O(V[c.body], c.body, c.side), J);
      const T change = (dF | twist(J)) + (F | twist(dJ));
      rate[c.velocity] += c.side > 0 ? change : -change;
    }
  });
}

template AXODE_ENTRY void LoopSystem<AXODE_T>::differentiate_residuals(const AXODE_T*, AXODE_T*) noexcept;
template AXODE_ENTRY void LoopSystem<AXODE_T>::differentiate(const AXODE_T*, AXODE_T*, AXODE_T*,
                                                             AXODE_T*) noexcept;

}  // namespace axode
