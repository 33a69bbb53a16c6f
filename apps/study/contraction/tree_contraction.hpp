#pragma once
#include <span>

#include "apps/study/contraction/contraction_plan.hpp"
#include "apps/study/matrix6.hpp"
#include "apps/study/screws_once.hpp"
#include "axode/recursion/forward_kinematics.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode::command {

/// Runs the steps of a tree contraction one after the other, on one processor. A tree contraction computes
/// forward dynamics in steps that join bodies to longer and longer chains, until all are joined to the
/// ground. LongestPath has the same functions, and counts the operations on the critical path of steps that
/// run in parallel.
struct OneByOne {
  template <class F> void at(int, const F& f) { f(); }
  template <class F> void join(int, int, const F& f) { f(); }
  template <class F> void sum(int, int, const F& f) { f(); }
  template <class F> void pass_on(int, int, bool, const F& f) { f(); }
  void meet() {}
};

/// Forward dynamics in spatial twists by contraction of the tree, in O(log n) rounds on n processors. Each
/// step joins a node of the tree to the node above it, until all are joined to the ground. A node is a
/// segment, a chain from a first body to a last one, which can be the same body. A body becomes part of a
/// longer segment only when all its branches but one have been joined to it, so that a longer segment has at
/// most one node below it.
///
/// The algorithm is the divide and conquer of Featherstone (A divide-and-conquer articulated-body algorithm
/// for parallel O(log(n)) calculation of rigid-body dynamics, Int. J. Robotics Research 18(9), 1999, pp.
/// 867-892) with other inputs: instead of the wrenches at both ends of a segment, the acceleration a of its
/// first body and the wrench f that its last body passes on to the node below, 0 if there is none. The
/// outputs are
///   wrench on the first body = K a + Eᵀ f + κ,  acceleration of the last body: b = E a - N f + α.   (1)
/// The coefficients K, E, κ, N and α belong to the segment. For one body, K is its inertia, κ its bias
/// wrench, E = I, and N and α are 0; nothing is inverted, so that massless bodies are allowed. The joint
/// above a segment, with the screws S, the acceleration x, the drive force τ and the bias c, is eliminated by
/// a = a_p + c + S x, where a_p is the acceleration of the predecessor. With U = K S, G = E S, D =
/// Sᵀ U + armature and u = τ - Sᵀ κ this gives
///   x = (u - Uᵀ (a_p + c) - Gᵀ f) / D,  K -= U Uᵀ / D,  E -= G Uᵀ / D,  N += G Gᵀ / D,               (2)
///   κ += U u / D + K c,  α += G u / D + E c.
/// A step joins a lower segment, with the coefficients K', E', N', κ', α' after (2), to the upper segment
/// above it, with K, E, N, κ, α. If no node is below the lower segment and the upper one is a single body,
/// the step adds K' and κ' to K and κ, as in the articulated-body algorithm. Otherwise let K' = L Lᵀ,
/// R Rᵀ = I + Lᵀ N L, B = N L R⁻ᵀ, X = R⁻¹ Lᵀ E, P = E - B X, Q = N - B Bᵀ and h = α - B R⁻¹ Lᵀ α. If the
/// lower segment passes on the wrench f, the acceleration of the upper segment's last body is
///   b = P a + h - Q (E'ᵀ f + κ'),                                                                    (3)
/// and the joined segment has, with π = h - Q κ', in place of K, E, N, κ and α
///   K + Xᵀ X,  E' P,  N' + E' Q E'ᵀ,  κ + Eᵀ (K' π + κ'),  α' + E' π.                                (4)
/// The tree must have no coupled joints. Only gravity and the drive forces act.
template <class T> class TreeContraction {
 public:
  explicit TreeContraction(const Tree<double>& tree, ContractionPlan plan)
      : plan_(std::move(plan)),
        screws_(static_cast<std::size_t>(tree->n_screws)),
        nodes_(static_cast<std::size_t>(tree->n + 1)) {}

  const ContractionPlan& plan() const { return plan_; }

  /// Writes the accelerations (nv) to `a`. Returns false if a pivot of the elimination is so small that the
  /// mass matrix, or the inertia of a part of the tree, may be singular.
  template <class Schedule = OneByOne>
  bool run(const Tree<T>& tree, const T* q, const T* v, const T* tau, T* a, Schedule&& schedule = {},
           SpatialOrigin origin = SpatialOrigin::of_roots) {
    schedule.meet();
    for (int i = 1; i <= tree->n; ++i)
      schedule.at(i, [&] {
        Node& node = nodes_[i];
        with_joint(tree, i, [&](const auto& joint) { node.C_pi = joint.pose(tree.B[i], q + tree->iq[i]); });
        if (tree->parent[i] == 0 && origin == SpatialOrigin::of_roots) node.C_pi.r = {};
        node.along = node.C_pi;
      });
    put_poses(schedule);
    for (int i = 1; i <= tree->n; ++i) schedule.at(i, [&] { put_body(tree, i, v); });
    put_twists(schedule);
    for (int i = 1; i <= tree->n; ++i)
      schedule.at(i, [&] {
        Node& node = nodes_[i];
        node.c = six(ad(node.V, node.Sv));
        node.kappa = six(velocity_wrench(node.M, node.V));
      });
    schedule.meet();
    for (const Step& step : plan_.steps)
      if (!join(tree, step, tau, schedule)) return false;
    schedule.meet();
    nodes_[0].a = {T(0), T(0), T(0), -tree.g.x, -tree.g.y, -tree.g.z};
    for (std::size_t k = plan_.steps.size(); k-- > 0;) {
      const Step& step = plan_.steps[k];
      schedule.pass_on(step.upper, step.lower, !step.upper_single, [&] { accelerate(tree, step, a); });
    }
    return true;
  }

 private:
  using Step = ContractionPlan::Step;
  struct Eliminated {
    Six<T> S, U, G;  ///< G only in nodes with children
    T D, u;
  };
  struct Node {
    SE3<T> C_pi, C, base;  ///< pose in the predecessor's frame, pose, and pose of the predecessor
    SE3<T> along, above;   ///< poses along this segment, and along the upper segment when it is joined
    Inertia<T> M;
    Twist<Spatial, T> Sv, V, V_base, V_along, V_above;
    Six<T> c, kappa, alpha, a, f, h, size;  ///< size: the diagonal of K before the joint was eliminated
    Matrix6<T> K, E, N, P, Q;
  };

  /// The poses by prefix products: of segments towards the ground, of bodies towards the leaves.
  template <class Schedule> void put_poses(Schedule& schedule) {
    schedule.meet();
    for (const Step& step : plan_.steps) {
      nodes_[step.lower].above = nodes_[step.upper].along;
      if (!step.rake)
        schedule.join(step.upper, step.lower, [&] {
          nodes_[step.upper].along = nodes_[step.upper].along * nodes_[step.lower].along;
        });
    }
    schedule.meet();
    for (std::size_t k = plan_.steps.size(); k-- > 0;) {
      const Step& step = plan_.steps[k];
      schedule.pass_on(step.upper, step.lower, false, [&] {
        Node &lower = nodes_[step.lower], &upper = nodes_[step.upper];
        lower.base = step.upper_single ? upper.C : upper.base * lower.above;
        lower.C = step.upper == 0 ? lower.C_pi : lower.base * lower.C_pi;
      });
    }
  }
  /// Inertia, screws and the twist of the joint of body i.
  void put_body(const Tree<T>& tree, int i, const T* v) {
    Node& node = nodes_[i];
    node.M = transform(node.C, tree.M[i]);
    put_matrix(node);
    node.Sv = {};
    with_joint(tree, i, [&](const auto& joint) {
      for (int k = 0; k < joint.nv; ++k) {
        const Screw<T> J = Ad(node.C, joint.column(k));
        const Twist<Spatial, T> S{J.w, J.v}, Sv = v[tree->iv[i] + k] * S;
        node.Sv = k == 0 ? Sv : node.Sv + Sv;
        screws_[tree->first_screw[i] + k].S = six(S);
      }
    });
    node.V_along = node.Sv;
  }
  static void put_matrix(Node& node) {
    const auto& [m, h, A] = node.M;
    const T o(0);
    node.K = {{{A.xx, A.xy, A.xz, o, -h.z, h.y},
               {A.xy, A.yy, A.yz, h.z, o, -h.x},
               {A.xz, A.yz, A.zz, -h.y, h.x, o},
               {o, h.z, -h.y, m, o, o},
               {-h.z, o, h.x, o, m, o},
               {h.y, -h.x, o, o, o, m}}};
  }
  /// The twists by prefix sums.
  template <class Schedule> void put_twists(Schedule& schedule) {
    schedule.meet();
    for (const Step& step : plan_.steps) {
      nodes_[step.lower].V_above = nodes_[step.upper].V_along;
      if (!step.rake)
        schedule.join(step.upper, step.lower,
                      [&] { nodes_[step.upper].V_along += nodes_[step.lower].V_along; });
    }
    schedule.meet();
    nodes_[0].V = {};
    for (std::size_t k = plan_.steps.size(); k-- > 0;) {
      const Step& step = plan_.steps[k];
      schedule.pass_on(step.upper, step.lower, false, [&] {
        Node &lower = nodes_[step.lower], &upper = nodes_[step.upper];
        lower.V_base = step.upper_single ? upper.V : upper.V_base + lower.V_above;
        lower.V = step.upper == 0 ? lower.Sv : lower.V_base + lower.Sv;
      });
    }
  }

  /// Joins the two nodes of a step. Returns false if a pivot is too small.
  template <class Schedule>
  bool join(const Tree<T>& tree, const Step& step, const T* tau, Schedule& schedule) {
    Node &upper = nodes_[step.upper], &lower = nodes_[step.lower];
    bool regular = true;
    schedule.at(step.lower, [&] { regular = eliminate_joint(tree, step, tau); });
    if (!regular) return false;
    const auto add = [&] {
      upper.K = symmetric_sum<1>(upper.K, lower.K);
      upper.kappa = upper.kappa + lower.kappa;
    };
    if (!step.upper_single) {
      schedule.join(step.upper, step.lower, [&] { join_segments(upper, lower, step.rake); });
    } else if (step.rake) {
      schedule.sum(step.upper, step.lower, add);
    } else {
      schedule.join(step.upper, step.lower, add);
      upper.E = lower.E;
      upper.N = lower.N;
      upper.alpha = lower.alpha;
    }
    return true;
  }
  /// Eliminates the joint above the lower node by (2). Returns false if a pivot is too small.
  bool eliminate_joint(const Tree<T>& tree, const Step& step, const T* tau) {
    const int i = step.lower, first = tree->first_screw[i], end = tree->first_screw[i + 1];
    Node& node = nodes_[i];
    if (!step.rake && step.lower_single) {
      node.E = identity6<T>();
      node.N = {};
      node.alpha = {};
    }
    node.size = diagonal(node.K);
    for (int s = end; s-- > first;) {
      auto& [S, U, G, D, u] = screws_[s];
      const int c = tree->iv[i] + s - first;
      U = times(node.K, S);
      D = dot(U, S) + tree.armature[c];
      if (!(D > T(plan_.least_pivot[s]))) return false;
      u = tau[c] - dot(S, node.kappa);
      const T d = T(1) / D;
      add_square(node.K, -d, U);
      node.kappa = node.kappa + (u * d) * U;
      if (step.rake) continue;
      G = step.lower_single && s == end - 1 ? S : times(node.E, S);
      add_outer(node.E, -d * G, U);
      add_square(node.N, d, G);
      node.alpha = node.alpha + (u * d) * G;
    }
    node.kappa = node.kappa + times(node.K, node.c);
    if (!step.rake) node.alpha = node.alpha + times(node.E, node.c);
    return true;
  }
  /// Puts a node whose joint is eliminated below a segment, by (4).
  static void join_segments(Node& upper, Node& lower, bool rake) {
    const Lower6<T> L(lower.K, lower.size);
    Matrix6<T> Lt_N, Xt, B, middle = identity6<T>();
    for (std::size_t i = 0; i < 6; ++i) Lt_N[i] = L.transposed_times(upper.N[i]);  // the rows of N L
    const Matrix6<T> columns = transposed(Lt_N);
    for (std::size_t k = 0; k < 6; ++k) {
      const Six<T> column = L.transposed_times(columns[k]);
      for (std::size_t i = 0; i <= k; ++i) middle[k][i] += column[i];
    }
    const Lower6<T> R(middle, diagonal(middle));
    const Matrix6<T> Et = transposed(upper.E);
    for (std::size_t i = 0; i < 6; ++i) {
      B[i] = R.solve(Lt_N[i]);
      Xt[i] = R.solve(L.transposed_times(Et[i]));
    }
    lower.P = difference(upper.E, times_transposed(B, Xt));
    lower.Q = symmetric_sum<-1>(upper.N, symmetric_times_transposed(B, B));
    lower.h = upper.alpha - times(B, R.solve(L.transposed_times(upper.alpha)));
    const Six<T> pi = lower.h - times(lower.Q, lower.kappa);
    upper.K = symmetric_sum<1>(upper.K, symmetric_times_transposed(Xt, Xt));
    upper.kappa = upper.kappa + times(Et, times(lower.K, pi) + lower.kappa);
    if (rake) return;
    upper.E = times(lower.E, lower.P);
    upper.N = symmetric_sum<1>(lower.N, symmetric_times_transposed(times(lower.E, lower.Q), lower.E));
    upper.alpha = lower.alpha + times(lower.E, pi);
  }
  /// Computes the accelerations of the joint that a step eliminated, and the inputs of its lower node.
  void accelerate(const Tree<T>& tree, const Step& step, T* out) {
    Node &upper = nodes_[step.upper], &lower = nodes_[step.lower];
    const int first = tree->first_screw[step.lower];
    Six<T> b = upper.a;
    if (!step.upper_single) {
      const Six<T> w = step.rake ? lower.kappa : times(transposed(lower.E), upper.f) + lower.kappa;
      b = times(lower.P, upper.a) + (lower.h - times(lower.Q, w));  // eq. (3)
      lower.f = upper.f;
      upper.f = times(lower.K, b) + w;
    } else {
      lower.f = upper.f;
    }
    lower.a = b + lower.c;
    for (int s = first; s < tree->first_screw[step.lower + 1]; ++s) {
      const auto& [S, U, G, D, u] = screws_[s];
      T rest = u - dot(U, lower.a);
      if (!step.rake) rest -= dot(G, lower.f);
      const T x = rest / D;
      out[tree->iv[step.lower] + s - first] = x;
      lower.a = lower.a + x * S;
    }
  }

  ContractionPlan plan_;
  std::vector<Eliminated> screws_;
  std::vector<Node> nodes_;
};

}  // namespace axode::command
