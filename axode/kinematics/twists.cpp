#include "axode/kinematics/twists.hpp"

#include "axode/kinematics/check_arguments.hpp"
#include "axode/kinematics/scratch.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

/// Runs the recursion and hands every frame to f(frame, V, V').
template <class Rep, class T, class F>
void each_frame(const Tree<T>& tree, Arena arena, const T* q, const T* v, const T* a, F f) noexcept {
  const TreeMotion<Rep, T> motion(arena);
  motion.run(tree, q, v, a);
  for (int k = 0; k < tree->n_frames(); ++k) {
    const int i = tree->frame_body[k];
    const Link<Rep, T> frame = motion.bodies.link[i].child(tree.frame_offset[k]);
    const Twist<Rep, T> V_i = motion.bodies.V[i], V = frame.down(V_i);
    f(k, V, frame.down(motion.bodies.dV[i]) + frame.bias(V_i, V, Twist<Rep, T>{}));
  }
}

}  // namespace

template <RecursionRepresentation Rep, class T>
void twists(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
            std::type_identity_t<std::span<Twist<Rep, T>>> V) {
  check_state(model, workspace, q, v);
  check_size("V", V.size(), static_cast<std::size_t>(model.n_frames()), "n_frames");
  each_frame<Rep>(model.tree<T>(), workspace.arena(model.topology()), q.data(), v.data(), v.data(),
                  [&](int k, const Twist<Rep, T>& V_k, const TwistRate<Rep, T>&) { V[k] = V_k; });
}

template <RecursionRepresentation Rep, class T>
void accelerations(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                   std::type_identity_t<std::span<TwistRate<Rep, T>>> dV) {
  check_state(model, workspace, q, v, a);
  check_size("dV", dV.size(), static_cast<std::size_t>(model.n_frames()), "n_frames");
  each_frame<Rep>(model.tree<T>(), workspace.arena(model.topology()), q.data(), v.data(), a.data(),
                  [&](int k, const Twist<Rep, T>&, const TwistRate<Rep, T>& dV_k) { dV[k] = dV_k; });
}

template void twists<AXODE_REP>(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>,
                                std::span<Twist<AXODE_REP, AXODE_T>>);
template void accelerations<AXODE_REP>(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>,
                                       Numbers<AXODE_T>, std::span<TwistRate<AXODE_REP, AXODE_T>>);

}  // namespace axode
