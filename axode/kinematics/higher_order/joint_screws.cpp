#include "axode/kinematics/higher_order/joint_screws.hpp"

#include "axode/fast/poses.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
void joint_screws(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                  std::type_identity_t<std::span<Twist<Spatial, T>>> J) {
  Arena arena = checked<"joint_screws">(model, workspace, q, J);
  const Tree<T>& tree = model.tree<T>();
  FastPoses<T> poses(arena);
  poses.run(tree, q.data(), [&](int i, const auto& at) {
    Twist<Spatial, T>* J_i = J.data() + tree->first_screw[i];
    if (is_hinge(tree, i)) [[likely]] {
      using Factor = typename FastGeometry<T>::type::Factor;
      J_i[0] = {at.R.z, cross(Factor(at.r), Factor(at.R.z))};
    } else {
      with_joint(tree, i, [&](const auto& joint) {
        const SE3<T> C = pose<T>(at);
        for (int k = 0; k < joint.nv; ++k) J_i[k] = twist<Spatial>(joint.column(C, k));
      });
    }
  });
}

template AXODE_ENTRY decltype(joint_screws<AXODE_T>) joint_screws<AXODE_T>;

}  // namespace axode
