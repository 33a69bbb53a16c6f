#include "axode/kinematics.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/kinematics/fast_poses.hpp"
#include "axode/kinematics/forward_recursion.hpp"
#include "axode/kinematics/mass_center.hpp"

namespace axode {
namespace {

template <class T> const SE3<T>* internal_poses(const Model& model, Workspace<T>& workspace, Numbers<T> q) {
  check_state(model, workspace, q);
  typename Workspace<T>::Arena arena(workspace);
  SE3<T>* C_pi = arena.template per_body<SE3<T>>();
  SE3<T>* C = arena.template per_body<SE3<T>>();
  joint_poses(model.tree<T>(), q.data(), C_pi);
  body_poses(model.tree<T>(), C_pi, C);
  return C;
}

}  // namespace

template <class T>
void poses(const Model& model, Workspace<T>& workspace, Numbers<T> q,
           std::type_identity_t<std::span<SE3<T>>> C) {
  check_size("C", C.size(), static_cast<std::size_t>(model.n_frames()), "n_frames");
  check_state(model, workspace, q);
  const Tree<T>& tree = model.tree<T>();
  typename Workspace<T>::Arena arena(workspace);
  SE3<T>* C_body = arena.template per_body<SE3<T>>();
  C_body[0] = {};
  FastPoses<T>(arena).run(tree, q.data(), [&](int i, const auto& at) { C_body[i] = pose<T>(at); });
  for (int k = 0; k < tree.n_frames(); ++k) C[k] = C_body[tree.frame_body[k]] * tree.frame_offset[k];
}

template <class T> Vec3<T> center_of_mass(const Model& model, Workspace<T>& workspace, Numbers<T> q) {
  return mass_center(model, model.tree<T>(), internal_poses(model, workspace, q));
}

template void poses(const Model&, Workspace<double>&, Numbers<double>, std::span<SE3<double>>);
template void poses(const Model&, Workspace<float>&, Numbers<float>, std::span<SE3<float>>);
template Vec3<double> center_of_mass(const Model&, Workspace<double>&, Numbers<double>);
template Vec3<float> center_of_mass(const Model&, Workspace<float>&, Numbers<float>);

}  // namespace axode
