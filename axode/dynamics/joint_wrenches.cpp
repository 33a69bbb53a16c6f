#include "axode/dynamics/joint_wrenches.hpp"

#include "axode/dynamics/wrench_frame.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode {

template <RecursionRepresentation Rep, class T>
void joint_wrenches(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                    std::type_identity_t<std::span<Wrench<Rep, T>>> W,
                    const std::type_identity_t<Loads<T>>& loads, WrenchPoint at) {
  Arena arena = checked<"joint_wrenches">(model, workspace, q, v, a, loads, W);
  const Tree<T>& tree = model.tree<T>();
  InverseDynamicsRecursion<Rep, T> recursion{arena};
  recursion.run(tree, q.data(), v.data(), a.data(), loads);
  for (int i = 1; i <= tree->n; ++i) {  // treat the internal frame as a body that is fixed to the frame of
                                        // the result
    const SE3<T> offset = wrench_frame<T>(model, i, at);
    const Link<Rep, T> user = recursion.motion.bodies.link[i].child(offset);
    W[i - 1] = user.child(inverse(offset)).up(recursion.W[i]);
  }
  if constexpr (std::same_as<Rep, Spatial>)
    each_root(model.topology(), [&](int root) {
      for (int i = root; i < tree->subtree_end[root]; ++i)
        W[i - 1].m += cross(recursion.origin[root], W[i - 1].f);
    });
}

template decltype(joint_wrenches<AXODE_REP, AXODE_T>) joint_wrenches<AXODE_REP, AXODE_T>;

}  // namespace axode
