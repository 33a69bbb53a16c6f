#include "axode/dynamics/momentum/momentum.hpp"

#include "axode/dynamics/scratch.hpp"
#include "axode/kinematics/center_of_mass.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
void momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
             std::type_identity_t<std::span<T>> p) {
  Arena arena = checked<"momenta">(model, workspace, q, v, p);
  const Tree<T>& tree = model.tree<T>();
  const MovingMass<T> at(arena, tree, q.data(), v.data());
  T* const own = at.own;
  for (int c = 0; c < tree->nv; ++c) own[c] = tree.armature[c] * v[c];
  for (int i = 1; i <= tree->n; ++i)
    at.spatial.each_screw(i, [&](int c, const Twist<Spatial, T>& J) { own[c] += at.momenta.Pi[i] | J; });
  for (int c = 0; c < tree->nv; ++c) p[c] = own[c];
}

template <class T>
Solvability from_momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                         std::type_identity_t<std::span<T>> v) {
  Arena arena = checked<"from_momenta">(model, workspace, q, p, v);
  const Tree<T>& tree = model.tree<T>();
  FrameResponse<Hybrid, T> at(arena);
  const Solvability verdict = at.bodies.factorize(tree, q.data(), tree.armature.data());
  for (int c = 0; c < tree->nv; ++c) at.x[c] = p[c];
  if (verdict.ok()) at.bodies.solve(tree, at.x);
  for (int c = 0; c < tree->nv; ++c) v[c] = at.x[c];
  return solved(verdict, tree->nv, v.data());
}

template <class T>
Momentum<Spatial, T> spatial_momentum(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                      Numbers<T> v) {
  Arena arena = checked<"spatial_momentum">(model, workspace, q, v);
  const MovingMass<T> at(arena, model.tree<T>(), q.data(), v.data());
  return at.momenta.whole(at.spatial);
}

template <class T>
Momentum<Hybrid, T> centroidal_momentum(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                        Numbers<T> v) {
  Arena arena = checked<"centroidal_momentum">(model, workspace, q, v);
  const MovingMass<T> at(arena, model.tree<T>(), q.data(), v.data());
  if (!(at.spatial.mass() > T(0))) throw no_mass(model);
  const Vec3<T> c = at.spatial.mass_center();
  Momentum<Hybrid, T> sum{};
  each_root(model.topology(), [&](int i) {
    const Momentum<Spatial, T>& Pi = at.momenta.Pi[i];
    sum += Momentum<Hybrid, T>{Pi.l + cross(at.spatial.origin[i] - c, Pi.p), Pi.p};
  });
  return sum;
}

template AXODE_ENTRY decltype(momenta<AXODE_T>) momenta<AXODE_T>;
template AXODE_ENTRY decltype(from_momenta<AXODE_T>) from_momenta<AXODE_T>;
template AXODE_ENTRY decltype(spatial_momentum<AXODE_T>) spatial_momentum<AXODE_T>;
template AXODE_ENTRY decltype(centroidal_momentum<AXODE_T>) centroidal_momentum<AXODE_T>;

}  // namespace axode
