#include "axode/derivatives/spring_derivatives.hpp"

#include "axode/derivatives/displacement/scratch.hpp"
#include "axode/dynamics/spring_elements.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

/// Adds the derivatives of the forces of the springs in one joint, by calls of add(component, direction, by
/// q, by v).
template <class T, class Add>
void differentiate_joint(const Model& model, int i, const T* q, const T* v, const Add& add) noexcept {
  const Tree<T>& tree = model.tree<T>();
  const std::vector<Dof>& dof = model.joint(i).dof;
  const int c = tree->iv[i];
  with_joint(tree, i, [&]<class Joint>(const Joint& joint) {
    const T* q_i = q + tree->iq[i];
    if constexpr (Joint::nv == 1) {
      const T& k = tree.ratio[i];
      const ElasticForce<T> at = elastic_force(dof[0], k * *q_i + tree.offset[i], k * v[c]);
      add(c, c, k * k * at.by_p, k * k * at.by_dp);
    } else {
      const ElasticLogarithm<Joint, T> spring(joint, dof, q_i);
      for (int k = 0; k < joint.nv; ++k)
        for (int j = 0; j < joint.nv; ++j) add(c + k, c + j, spring.by_q(dof, k, j), T(0));
    }
  });
}

/// Adds the derivatives of the forces of a spring along a line between two points. With the tension f, the
/// unit vector u of the line, and the columns r_k of the distance vector r and w_k of the rotations, τ_k = -f
/// u·r_k; along direction j of the same end r_k changes by w_j × r_k or, if j is farther from the ground, by
/// w_k × r_j.
template <class T, class Add>
void differentiate_line(const Springs::Line& spring, const Tree<T>& tree, const T* q, const T* v,
                        SpringColumns<T>& columns, const Add& add) noexcept {
  columns.count = 0;
  const SpringLine<T> line(spring, tree, q, v, [&](std::size_t e, int i, int c, const Screw<T>& X) {
    columns.column[columns.count++] = {static_cast<int>(e), i, c, X};
  });
  const std::span all(columns.column, static_cast<std::size_t>(columns.count));
  for (auto& [e, i, c, X] : all) {
    const SO3<T>& R = line.R[static_cast<std::size_t>(e)];
    X = {R * X.w, e == 0 ? -(R * X.v) : R * X.v};
  }
  using Column = typename SpringColumns<T>::Column;
  const auto turned = [](const Column& j, const Column& k) {
    if (j.end != k.end) return Vec3<T>{};
    return j.body <= k.body ? cross(j.X.w, k.X.v) : cross(k.X.w, j.X.v);
  };
  const T stiffness = T(spring.stiffness), damping = T(spring.damping);
  const bool there = !(line.length == T(0));
  const T inverse = there ? T(1) / line.length : T(0);
  const T string = there ? line.f * inverse : spring.rest == 0 ? stiffness : T(0);  // f/l, and its limit
  for (const Column& j : all) {
    const T l_j = dot(line.u, j.X.v);
    Vec3<T> turn{};
    for (const Column& k : all) turn += v[k.c] * turned(j, k);
    const T rate_j = dot(line.u, turn) + inverse * (dot(line.dr, j.X.v) - line.rate * l_j);
    const T f_q = stiffness * l_j + damping * rate_j, f_v = damping * l_j;
    for (const Column& k : all) {
      const T l_k = dot(line.u, k.X.v);
      const T direction = string * (dot(j.X.v, k.X.v) - l_j * l_k) + line.f * dot(line.u, turned(j, k));
      add(k.c, j.c, -(f_q * l_k + direction), -f_v * l_k);
    }
  }
}

}  // namespace

template <class T>
void spring_force_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                              const std::type_identity_t<StateDerivatives<T>>& d) {
  Arena arena = checked<"spring_force_derivatives">(model, workspace, q, v, d.q, d.v);
  for (const std::span<T> matrix : {d.q, d.v}) std::ranges::fill(matrix, T(0));
  const std::ptrdiff_t nv = model.nv();
  const auto add = [&](std::ptrdiff_t component, std::ptrdiff_t direction, const T& by_q, const T& by_v) {
    d.q[static_cast<std::size_t>(component * nv + direction)] += by_q;
    d.v[static_cast<std::size_t>(component * nv + direction)] += by_v;
  };
  for (const int i : model.springs().joints) differentiate_joint(model, i, q.data(), v.data(), add);
  SpringColumns<T> columns(arena);
  for (const Springs::Line& spring : model.springs().lines)
    differentiate_line(spring, model.tree<T>(), q.data(), v.data(), columns, add);
}

template void spring_force_derivatives(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>,
                                       const StateDerivatives<AXODE_T>&);

}  // namespace axode
