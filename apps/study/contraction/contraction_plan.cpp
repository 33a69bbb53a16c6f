#include "apps/study/contraction/contraction_plan.hpp"

#include "axode/recursion/articulated_inertia.hpp"
#include "axode/recursion/link.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode::command {
namespace {

struct Node {
  int above = 0, children = 0;
  bool alive = true, single = true;
  int joined_in = 0;  ///< the last round in which it was compressed
  /// A lower bound, at q = 0, of the articulated inertia that its first body has in the segment.
  ArticulatedInertia<BodyFixed, double> M;
};

/// The magnitude of the inertia that velocity c of a body with the inertia M moves by the screw X.
double inertia_moved(const Tree<double>& tree, const ArticulatedInertia<BodyFixed, double>& M, int c,
                     const Screw<double>& X) {
  const auto trace_of = [](const Sym3<double>& A) { return A.xx + A.yy + A.zz; };
  return dot(X.w, X.w) * trace_of(M.A) + dot(X.v, X.v) * trace_of(M.L) + tree.armature[c];
}
/// Replaces the inertia M of body i by the inertia that remains after the elimination of the body's joint. If
/// a pivot is so small, relative to the inertia that the joint moves, that digits would be lost, sets M to 0
/// and returns false.
bool eliminate_joint(const Tree<double>& tree, int i, ArticulatedInertia<BodyFixed, double>& M) {
  constexpr double well_conditioned = 1e-3;
  const auto before = M;
  return with_joint(tree, i, [&](const auto& joint) {
    for (int k = joint.nv; k-- > 0;) {
      const Screw<double> X = joint.column(k);
      const Twist<BodyFixed> S{X.w, X.v};
      const Wrench<BodyFixed> U = M * S;
      const int c = tree->iv[i] + k;
      const double D = (U | S) + tree.armature[c];
      if (!(D > well_conditioned * inertia_moved(tree, before, c, X))) {
        M = {};
        return false;
      }
      eliminate(M, U, D);
    }
    return true;
  });
}

}  // namespace

ContractionPlan::ContractionPlan(const Tree<double>& tree, int most_rounds)
    : least_pivot(static_cast<std::size_t>(tree->n_screws)) {
  const int n = tree->n;
  std::vector<Node> nodes(static_cast<std::size_t>(n + 1));
  const auto at = [&](int i) -> Node& { return nodes[static_cast<std::size_t>(i)]; };
  for (int i = 1; i <= n; ++i) {
    at(i).above = tree->parent[i];
    at(i).M = articulated(Link<BodyFixed, double>{}, tree.M[i]);
    ++at(tree->parent[i]).children;
  }
  /// Joins a node with the node above; if it does not rake, only where the joint is determined.
  const auto join = [&](int lower, bool rake) {
    Node& upper = at(at(lower).above);
    auto M = at(lower).M;
    if (!eliminate_joint(tree, lower, M) && !rake) return false;
    with_joint(tree, lower, [&](const auto& joint) {
      for (int k = 0, s = tree->first_screw[lower]; k < joint.nv; ++k, ++s)
        least_pivot[s] = pivot_threshold<double> *
                         (rake ? tree.inertia_scale[s]
                               : inertia_moved(tree, at(lower).M, tree->iv[lower] + k, joint.column(k)));
    });
    if (upper.single) upper.M += Link<BodyFixed, double>{tree.B[lower]}.up(M);
    steps.push_back({at(lower).above, lower, upper.single, at(lower).single, rake});
    at(lower).alive = false;
    return true;
  };
  for (int left = n; left > 0;) {
    ++rounds;
    std::vector<int> leaves, inner;
    for (int i = 1; i <= n; ++i)
      if (at(i).alive) (at(i).children == 0 ? leaves : inner).push_back(i);
    for (const int i : leaves) {
      join(i, true);
      --at(at(i).above).children;
      --left;
    }
    if (rounds > most_rounds) continue;
    for (const int i : inner) {  // the nodes above come first
      Node &lower = at(i), &upper = at(lower.above);
      if (lower.above == 0 || lower.children != 1 || upper.children != 1 || lower.joined_in == rounds ||
          upper.joined_in == rounds || !join(i, false))
        continue;
      ++compressions;
      --left;
      upper.single = false;
      upper.joined_in = lower.joined_in = rounds;
      for (const int below : inner)
        if (at(below).above == i) at(below).above = lower.above;
    }
  }
}

}  // namespace axode::command
