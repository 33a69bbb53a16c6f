#include "axode/kinematics/poses.hpp"

#include "axode/kinematics/checked.hpp"
#include "axode/kinematics/scratch.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
void poses(const Model& model, Workspace<T>& workspace, Numbers<T> q,
           std::type_identity_t<std::span<SE3<T>>> C) {
  Arena arena = checked<"poses">(model, workspace, q, C);
  const Tree<T>& tree = model.tree<T>();
  FramePoses<T> of(arena);
  of.run(tree, q.data());
  for (int f = 0; f < tree->n_frames(); ++f) store(of(tree->frame_body[f], tree.frame_offset[f]), &C[f]);
}

template <class T>
void poses(const Model& model, Workspace<T>& workspace, Numbers<T> q,
           std::type_identity_t<std::span<const Place<T>>> places,
           std::type_identity_t<std::span<SE3<T>>> C) {
  check_state(model, workspace, q);
  check_size("C", C.size(), places.size(), "as many as there are places");
  const Tree<T>& tree = model.tree<T>();
  Arena arena = workspace.arena(model.topology());
  FramePoses<T> of(arena);
  of.run(tree, q.data());
  for (std::size_t k = 0; k < places.size(); ++k) {
    const Place<T> place = found(model, places[k]);
    const int f = place.frame;
    C[k] = pose<T>(of(tree->frame_body[f], tree.frame_offset[f])) * place.offset;
  }
}

template AXODE_ENTRY void poses(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>, std::span<SE3<AXODE_T>>);
template AXODE_ENTRY void poses(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                std::span<const Place<AXODE_T>>, std::span<SE3<AXODE_T>>);

}  // namespace axode
