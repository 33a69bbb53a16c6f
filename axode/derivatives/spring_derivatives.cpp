#include "axode/derivatives/spring_derivatives.hpp"

#include "axode/derivatives/displacement/scratch.hpp"
#include "axode/dynamics/spring_elements.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

/// Computes the derivatives of the generalised forces of the springs in the joint of body i. Calls
/// add(component, direction, derivative by q, derivative by v) for each entry.
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

/// Computes the derivatives of the generalised forces of one spring. Calls add(component, direction,
/// derivative by q, derivative by v) for each entry.
template <class T, class Add> class DifferentiateSpring {
 public:
  DifferentiateSpring(const Tree<T>& tree, const ForceLaw& law, const T* q, const T* v,
                      SpringColumns<T>& columns, const Add& add)
      : tree_(tree), law_(law), q_(q), v_(v), columns_(columns), add_(add) {}

  /// A spring along a path of points, with the tension F and the length x. Its generalised force at velocity
  /// k is τ_k = -F ∂x/∂q_k. Second derivatives of x are sums over the segments of the path (D16.6).
  void operator()(const Spring::Path& path) const noexcept {
    columns_.clear();
    T x(0), dx(0);
    const std::size_t segments = path.points.size() - 1;
    for (std::size_t k = 0; k < segments; ++k) {
      const Segment<T> segment = with_columns(path, k);
      x += segment.length;
      dx += segment.rate;
      add_gradient(segment);
    }
    const Tension<T> F = tension(law_, x, dx);
    // If the two points of a line coincide, F/x has a limit if F is 0 there.
    const T slope = segments == 1 && F.f == T(0) ? F.by_x : T(0);
    for (std::size_t k = 0; k < segments; ++k)
      add_curvature(
          segments == 1 ? Segment<T>(path.points.data(), tree_, q_, v_, nothing) : with_columns(path, k), F.f,
          slope);
    add_by_coordinate(F);
  }
  void operator()(const Spring::JointSum& joints) const noexcept {
    columns_.clear();
    for (const Spring::JointSum::Term& term : joints.terms) columns_.add(term.velocity, T(term.factor), T(0));
    const SpringCoordinate<T> at = coordinate_of(joints, tree_, q_, v_);
    add_by_coordinate(tension(law_, at.x, at.dx));
  }
  /// A spring whose wrench depends on the relative pose of its ends. Its generalised force at velocity k is
  /// τ_k = W·ξ_k, where W is this wrench and ξ_k is column k of the relative twist, which is its part for a
  /// unit of velocity k. The columns depend on the configuration as well (D16.12).
  template <class Geometry> void operator()(const Geometry& between) const noexcept {
    columns_.clear();
    const RelativePose<T> at(between.ends, tree_, q_, v_, [&](std::size_t e, int i, int c, const auto& X) {
      columns_.column[columns_.count++] = {static_cast<int>(e), i, c, X};
    });
    for (int k = 0; k < columns_.count; ++k)
      if (Column& each = columns_.column[k]; each.end == 0) each.X = -Ad_inv(at.D, each.X);
    const SpringWrench<T> W = wrench_of(between, law_, at, true);
    for (const Column& j : columns_.all()) {
      Screw<T> dV{};
      for (const Column& k : columns_.all()) dV = dV + v_[k.c] * turned(j, k);
      const Six<T> xi_j = six(j.X), by_eta = product(W.K, xi_j), by_V = product(W.C, six(dV)),
                   by_v = product(W.C, xi_j);
      for (const Column& k : columns_.all()) {
        const Six<T> xi_k = six(k.X);
        add_(k.c, j.c, product(W.W, six(turned(j, k))) - product(xi_k, by_eta) - product(xi_k, by_V),
             -product(xi_k, by_v));
      }
    }
  }

 private:
  using Column = typename SpringColumns<T>::Column;
  static constexpr auto nothing = [](std::size_t, int, int, const auto&) {};

  /// Returns segment k of the path of a spring, the straight line from point k to the next point, and stores
  /// its columns. There is one column for each end of the segment and each velocity that moves this end. For
  /// a unit of this velocity, the column has the rate of the vector between the ends and the angular velocity
  /// of the body at the moved end, both relative to the body where the paths from the two ends to the ground
  /// meet.
  Segment<T> with_columns(const Spring::Path& path, std::size_t k) const noexcept {
    columns_.count = 0;
    Segment<T> segment(&path.points[k], tree_, q_, v_, [&](std::size_t e, int i, int c, const Screw<T>& X) {
      columns_.column[columns_.count++] = {static_cast<int>(e), i, c, X};
    });
    for (int n = 0; n < columns_.count; ++n) {
      Column& each = columns_.column[n];
      const SO3<T>& R = segment.R[static_cast<std::size_t>(each.end)];
      each.X = {R * each.X.w, each.end == 0 ? -(R * each.X.v) : R * each.X.v};
    }
    return segment;
  }
  /// The derivative of column k along the direction of column j, for a straight segment of a spring. Each
  /// column belongs to one velocity of a joint that moves only one end of the segment; joints that move both
  /// ends have none. Column k is the vector r_k by which a unit of this velocity changes the vector between
  /// the ends, and w_k is the angular velocity that it gives to the body at the moved end. If the joints of j
  /// and k move the same end, the derivative is w_j × r_k or, if the joint of j is farther from the ground
  /// than that of k, w_k × r_j; otherwise it is 0.
  static Vec3<T> bent(const Column& j, const Column& k) {
    if (j.end != k.end) return {};
    return j.body <= k.body ? cross(j.X.w, k.X.v) : cross(k.X.w, j.X.v);
  }
  /// The derivative of column ξ_k of the relative twist along direction j: [ξ_k, ξ_j] or 0 (D16.12).
  static Screw<T> turned(const Column& j, const Column& k) {
    const bool moves = k.end == 1 ? j.end == 1 && k.body < j.body : j.end == 1 || k.body >= j.body;
    return moves ? ad(k.X, j.X) : Screw<T>{};
  }

  /// Adds the contributions of one segment to ∂x/∂q and ∂x'/∂q of the spring coordinate x, in columns_.
  void add_gradient(const Segment<T>& at) const noexcept {
    const T inverse = at.length == T(0) ? T(0) : T(1) / at.length;
    for (const Column& j : columns_.all()) {
      const T l_j = dot(at.u, j.X.v);
      Vec3<T> turn{};
      for (const Column& k : columns_.all()) turn += v_[k.c] * bent(j, k);
      columns_.add(j.c, l_j, dot(at.u, turn) + inverse * (dot(at.dr, j.X.v) - at.rate * l_j));
    }
  }
  /// Adds -F ∂²x/∂q² of one straight segment of a spring to the derivatives of the generalised forces; x is
  /// its length and F the tension. `slope` is the limit of F/x for a segment without length.
  void add_curvature(const Segment<T>& at, const T& F, const T& slope) const noexcept {
    const T string = at.length == T(0) ? slope : F / at.length;
    for (const Column& j : columns_.all()) {
      const T l_j = dot(at.u, j.X.v);
      for (const Column& k : columns_.all())
        add_(k.c, j.c, -(string * (dot(j.X.v, k.X.v) - l_j * dot(at.u, k.X.v)) + F * dot(at.u, bent(j, k))),
             T(0));
    }
  }
  /// Adds the matrices -(∂x/∂q)ᵀ ∂F/∂q and -(∂x/∂q)ᵀ ∂F/∂v, outer products of rows with nv entries, to the
  /// derivatives of the generalised forces -F (∂x/∂q)ᵀ by q and v. x is the coordinate of a spring, and F its
  /// tension. add_curvature() adds the remaining term, with ∂²x/∂q².
  void add_by_coordinate(const Tension<T>& F) const noexcept {
    for (int m = 0; m < columns_.n_velocities; ++m) {
      const int j = columns_.velocities[m];
      const T by_q = F.by_x * columns_.by_q[j] + F.by_dx * columns_.rate_by_q[j],
              by_v = F.by_dx * columns_.by_q[j];
      for (int n = 0; n < columns_.n_velocities; ++n) {
        const int k = columns_.velocities[n];
        add_(k, j, -by_q * columns_.by_q[k], -by_v * columns_.by_q[k]);
      }
    }
  }

  const Tree<T>& tree_;
  const ForceLaw& law_;
  const T *q_, *v_;
  SpringColumns<T>& columns_;
  const Add& add_;
};

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
  for (const Spring& spring : model.springs().elements)
    std::visit(DifferentiateSpring(model.tree<T>(), spring.law, q.data(), v.data(), columns, add),
               spring.geometry);
}

template AXODE_ENTRY decltype(spring_force_derivatives<AXODE_T>) spring_force_derivatives<AXODE_T>;

}  // namespace axode
