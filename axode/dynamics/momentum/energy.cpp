#include "axode/dynamics/momentum/energy.hpp"

#include "axode/dynamics/scratch.hpp"
#include "axode/kinematics/center_of_mass.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T> T kinetic_energy(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v) {
  Arena arena = checked<"kinetic_energy">(model, workspace, q, v);
  const Tree<T>& tree = model.tree<T>();
  const MovingMass<T> at(arena, tree, q.data(), v.data());
  T twice(0);
  for (int i = 1; i <= tree->n; ++i) twice += (at.spatial.M_body[i] * at.momenta.V[i]) | at.momenta.V[i];
  for (int c = 0; c < tree->nv; ++c) twice += tree.armature[c] * v[c] * v[c];
  return T(0.5) * twice;
}

template <class T> T potential_energy(const Model& model, Workspace<T>& workspace, Numbers<T> q) {
  Arena arena = checked<"potential_energy">(model, workspace, q);
  const Tree<T>& tree = model.tree<T>();
  const SpatialTree<T> s(arena, tree, q.data());
  T sum(0);
  each_root(model.topology(), [&](int i) { sum += dot(tree.g, s.M[i].h + s.M[i].m * s.origin[i]); });
  return -sum;
}

template <class T>
void load_powers(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                 const std::type_identity_t<Loads<T>>& loads, std::type_identity_t<std::span<T>> power) {
  Arena arena = checked<"load_powers">(model, workspace, q, v, loads, power);
  const Tree<T>& tree = model.tree<T>();
  const MovingMass<T> at(arena, tree, q.data(), v.data());
  for (std::size_t k = 0; k < power.size(); ++k) {
    const AppliedWrench<T>& load = loads.wrenches[k];
    const int i = tree->frame_body[load.frame];
    const SE3<T>& offset = tree.frame_offset[load.frame];
    const Twist<BodyFixed, T> V = change<BodyFixed>(at.spatial.link[i].C * offset, at.momenta.V[i]);
    power[k] = with_representation(load.representation, [&](auto rep) {
      return change<BodyFixed>(at.spatial.pose(i) * offset, Wrench<decltype(rep), T>{load.m, load.f}) | V;
    });
  }
}

template <class T> Inertia<T> centroidal_inertia(const Model& model, Workspace<T>& workspace, Numbers<T> q) {
  Arena arena = checked<"centroidal_inertia">(model, workspace, q);
  const SpatialTree<T> s(arena, model.tree<T>(), q.data());
  if (!(s.mass() > T(0))) throw no_mass(model);
  const Vec3<T> c = s.mass_center();
  Inertia<T> sum{};
  each_root(model.topology(), [&](int i) { sum += transform(s.origin[i] - c, s.M[i]); });
  return {sum.m, {}, sum.Theta};
}

template AXODE_ENTRY decltype(kinetic_energy<AXODE_T>) kinetic_energy<AXODE_T>;
template AXODE_ENTRY decltype(potential_energy<AXODE_T>) potential_energy<AXODE_T>;
template AXODE_ENTRY decltype(load_powers<AXODE_T>) load_powers<AXODE_T>;
template AXODE_ENTRY decltype(centroidal_inertia<AXODE_T>) centroidal_inertia<AXODE_T>;

}  // namespace axode
