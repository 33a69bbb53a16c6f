#include "axode/dynamics/springs.hpp"

#include "axode/dynamics/spring_elements.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

constexpr auto no_columns = [](std::size_t, int, int, const auto&) {};

}  // namespace

template <class T>
void spring_forces(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                   std::type_identity_t<std::span<T>> tau) {
  checked<"spring_forces">(model, workspace, q, v, tau);
  std::ranges::fill(tau, T(0));
  add_spring_forces(model, workspace, q, v, tau);
}

template <class T>
void add_spring_forces(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                       std::type_identity_t<std::span<T>> tau) {
  checked<"spring_forces">(model, workspace, q, v, tau);
  const Tree<T>& tree = model.tree<T>();
  for (const int i : model.springs().joints)
    with_joint(tree, i, [&]<class Joint>(const Joint& joint) {
      const std::vector<Dof>& dof = model.joint(i).dof;
      const T *q_i = &q[tree->iq[i]], *v_i = &v[tree->iv[i]];
      T* const tau_i = &tau[tree->iv[i]];
      if constexpr (Joint::nv == 1) {
        const T& k = tree.ratio[i];
        *tau_i += k * elastic_force(dof[0], k * *q_i + tree.offset[i], k * *v_i).f;
      } else {
        const ElasticLogarithm<Joint, T> spring(joint, dof, q_i);
        for (int k = 0; k < joint.nv; ++k) tau_i[k] += spring.force(k);
      }
    });
  for (const Springs::Line& spring : model.springs().lines) {
    const SpringLine<T> line(spring, tree, q.data(), v.data(), no_columns);
    for (std::size_t e = 0; e < 2; ++e) {
      const Vec3<T> F = (e == 0 ? line.f : -line.f) * (transpose(line.R[e]) * line.u);
      each_body_fixed_column(
          tree, q.data(), line.place[e], [&](int, int c, const Screw<T>& X) { tau[c] += dot(F, X.v); },
          line.meeting);
    }
  }
}

template <class T> T elastic_energy(const Model& model, Workspace<T>& workspace, Numbers<T> q) {
  checked<"elastic_energy">(model, workspace, q);
  const Tree<T>& tree = model.tree<T>();
  T sum(0);
  for (const int i : model.springs().joints)
    with_joint(tree, i, [&]<class Joint>(const Joint& joint) {
      const std::vector<Dof>& dof = model.joint(i).dof;
      const T* q_i = &q[tree->iq[i]];
      if constexpr (Joint::nv == 1) {
        sum += elastic_force(dof[0], tree.ratio[i] * *q_i + tree.offset[i], T(0)).energy;
      } else {
        sum += ElasticLogarithm<Joint, T>(joint, dof, q_i).energy();
      }
    });
  for (const Springs::Line& spring : model.springs().lines)
    sum += SpringLine<T>::energy(spring, SpringLine<T>(spring, tree, q.data(), nullptr, no_columns).length);
  return sum;
}

template void spring_forces(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>,
                            std::span<AXODE_T>);
template void add_spring_forces(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>,
                                std::span<AXODE_T>);
template AXODE_T elastic_energy(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>);

}  // namespace axode
