#include "axode/dynamics/springs.hpp"

#include <stdexcept>
#include <string>

#include "axode/dynamics/spring_elements.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

constexpr auto no_columns = [](std::size_t, int, int, const auto&) {};

/// Adds the generalised forces of one spring element of a model to τ.
template <class T> struct AddForces {
  const Tree<T>& tree;
  const ForceLaw& law;
  const T *q, *v;
  T* tau;

  void operator()(const Spring::Path& path) const noexcept {
    const SpringCoordinate<T> at = coordinate_of(path, tree, q, v);
    const T F = tension(law, at.x, at.dx).f;
    each_segment(path, tree, q, v, [&](const Segment<T>& segment) {
      for (std::size_t e = 0; e < 2; ++e) {
        const Vec3<T> pull = (e == 0 ? F : -F) * (transpose(segment.R[e]) * segment.u);
        each_body_fixed_column(
            tree, q, segment.place[e], [&](int, int c, const Screw<T>& X) { tau[c] += dot(pull, X.v); },
            segment.meeting);
      }
    });
  }
  void operator()(const Spring::JointSum& joints) const noexcept {
    const SpringCoordinate<T> at = coordinate_of(joints, tree, q, v);
    const T F = tension(law, at.x, at.dx).f;
    for (const Spring::JointSum::Term& term : joints.terms) tau[term.velocity] -= T(term.factor) * F;
  }
  template <class Geometry> void operator()(const Geometry& between) const noexcept {
    const RelativePose<T> at(between.ends, tree, q, v, no_columns);
    const Six<T> W = wrench_of(between, law, at, false).W;
    for (std::size_t e = 0; e < 2; ++e) {
      const Six<T> on_end = e == 0 ? reaction(at.D, W) : W;
      each_body_fixed_column(
          tree, q, at.place[e], [&](int, int c, const Screw<T>& X) { tau[c] += product(on_end, six(X)); },
          at.meeting);
    }
  }
};

template <class T, class Geometry>
SE3<T> pose_of(const Geometry& between, const Tree<T>& tree, const T* q) noexcept {
  return RelativePose<T>(between.ends, tree, q, nullptr, no_columns).D;
}

/// The coordinate of one spring element of a model; 0 for a bushing, which has none.
template <class T> struct Coordinate {
  const Tree<T>& tree;
  const T* q;

  T operator()(const Spring::Torsion& torsion) const noexcept {
    return TwistAngle<T>(pose_of(torsion, tree, q).R).angle;
  }
  T operator()(const Spring::Bushing&) const noexcept { return T(0); }
  template <class Geometry> T operator()(const Geometry& of_coordinate) const noexcept {
    return coordinate_of<T>(of_coordinate, tree, q, nullptr).x;
  }
};

/// The energy of one spring element of a model.
template <class T> struct Energy {
  const Tree<T>& tree;
  const ForceLaw& law;
  const T* q;

  T operator()(const Spring::Bushing& bushing) const noexcept {
    const Six<T> X = six(log(inverse(cast<T>(bushing.rest)) * pose_of(bushing, tree, q)));
    return T(0.5) * product(X, product(bushing.K, X));
  }
  template <class Geometry> T operator()(const Geometry& of_coordinate) const noexcept {
    return stored_energy(law, Coordinate<T>{tree, q}(of_coordinate));
  }
};

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
  for (const Spring& spring : model.springs().elements)
    std::visit(AddForces<T>{tree, spring.law, q.data(), v.data(), tau.data()}, spring.geometry);
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
  for (const Spring& spring : model.springs().elements)
    sum += std::visit(Energy<T>{tree, spring.law, q.data()}, spring.geometry);
  return sum;
}

template <class T>
T spring_coordinate(const Model& model, Workspace<T>& workspace, int k, Numbers<T> q,
                    std::type_identity_t<std::span<T>> gradient) {
  checked<"elastic_energy">(model, workspace, q);
  const std::vector<Spring>& springs = model.springs().elements;
  if (springs.empty()) throw std::invalid_argument("spring: model \"" + model.name() + "\" has no springs");
  if (k < 0 || k >= std::ssize(springs))
    throw std::invalid_argument("spring is " + std::to_string(k) + "; the model has springs 0 to " +
                                std::to_string(std::ssize(springs) - 1));
  const Spring& spring = springs[static_cast<std::size_t>(k)];
  if (std::holds_alternative<Spring::Bushing>(spring.geometry))
    throw std::invalid_argument("spring \"" + spring.name + "\" is a bushing, which has no coordinate");
  const Tree<T>& tree = model.tree<T>();
  if (!gradient.empty()) {
    check_size("gradient", gradient.size(), static_cast<std::size_t>(model.nv()), "nv");
    check_separate("gradient", gradient, "q", static_cast<std::span<const T>>(q));
    std::ranges::fill(gradient, T(0));
    // A spring with the constant tension -1 has the generalised force ∂x/∂q.
    const ForceLaw unit{.curve = PolynomialCurve{{-1}}};
    std::visit(AddForces<T>{tree, unit, q.data(), nullptr, gradient.data()}, spring.geometry);
  }
  return std::visit(Coordinate<T>{tree, q.data()}, spring.geometry);
}

template AXODE_ENTRY decltype(spring_forces<AXODE_T>) spring_forces<AXODE_T>;
template AXODE_ENTRY decltype(add_spring_forces<AXODE_T>) add_spring_forces<AXODE_T>;
template AXODE_ENTRY decltype(elastic_energy<AXODE_T>) elastic_energy<AXODE_T>;
template AXODE_ENTRY decltype(spring_coordinate<AXODE_T>) spring_coordinate<AXODE_T>;

}  // namespace axode
