#include "axode/codegen/recording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/codegen/traced_tree.hpp"
#include "axode/dynamics/articulated_bodies.hpp"
#include "axode/dynamics/composite_bodies.hpp"
#include "axode/dynamics/fast_inverse_dynamics.hpp"
#include "axode/dynamics/fast_inverse_mass_matrix.hpp"
#include "axode/dynamics/sparse_factor.hpp"
#include "axode/kinematics/path.hpp"

namespace axode::codegen {
namespace {

using T = Trace;
using Numbers = std::vector<T>;
using Arena = Workspace<T>::Arena;

Numbers zeros(int n) { return Numbers(static_cast<std::size_t>(n)); }

/// The arguments of a function, which become inputs of the tape, and what its kernels read.
struct Traced {
  const Tree<double>& tree;
  Tree<T> constants = cast<T>(tree);
  Workspace<T> workspace{tree};
  Tape tape;
  Recording recording;

  Traced(const Tree<double>& traced, std::string result) : tree(traced) {
    recording.result = std::move(result);
  }
  Numbers argument(const char* name, int n) {
    Numbers x;
    for (int k = 0; k < n; ++k) x.push_back(tape.input(static_cast<int>(recording.arguments.size()), k));
    recording.arguments.emplace_back(name);
    return x;
  }
  Recording with(Numbers results) {
    recording.results = std::move(results);
    recording.nodes = tape.nodes();
    return std::move(recording);
  }
};

/// Without what the armatures take.
Numbers forces(Traced& traced, const Numbers& q, const Numbers& v, const Numbers& a) {
  Arena arena(traced.workspace);
  FastInverseDynamics<Plain<T>, T> recursion(arena);
  Numbers tau = zeros(traced.tree.nv);
  recursion.forward(traced.tree, q.data(), v.data(), a.data(), cast<T>(traced.tree.g));
  recursion.backward(traced.tree, tau.data());
  return tau;
}

/// Body-fixed, where joint screws are constant and sparse.
Numbers composite(Traced& traced, const Numbers& q) {
  Arena arena(traced.workspace);
  Link<BodyFixed, T>* links = body_links<BodyFixed>(traced.constants, arena, q.data());
  Numbers M = zeros(traced.tree.nv * traced.tree.nv);
  CompositeBodies<BodyFixed, T>(arena, links)
      .run(traced.constants, traced.constants.armature.data(), M.data());
  return M;
}

Recording inverse_dynamics(const Tree<double>& tree) {
  Traced traced(tree, "tau");
  const Numbers q = traced.argument("q", tree.nq), v = traced.argument("v", tree.nv),
                a = traced.argument("a", tree.nv);
  Numbers tau = forces(traced, q, v, a);
  for (std::size_t c = 0; c < tau.size(); ++c) tau[c] += T(tree.armature[c]) * a[c];
  return traced.with(std::move(tau));
}

Recording mass_matrix(const Tree<double>& tree) {
  Traced traced(tree, "M");
  return traced.with(composite(traced, traced.argument("q", tree.nq)));
}

/// How accelerations are found from what the forces leave over, x := M⁻¹ x, and what makes it doubtful.
using Solver = Trace::Condition (*)(Traced&, const Numbers& q, Numbers& x, double coarser);

/// The articulated-body algorithm.
Trace::Condition solve_articulated(Traced& traced, const Numbers& q, Numbers& x, double coarser) {
  Arena arena(traced.workspace);
  Link<BodyFixed, T>* links = body_links<BodyFixed>(traced.constants, arena, q.data());
  ArticulatedBodies<BodyFixed, T> bodies(arena, links);
  Trace::Condition doubt;
  bodies.factorize(traced.constants, traced.constants.armature.data(), [&](int, int c, const T& D, const T&) {
    doubt = doubt || !(D > T(coarser * traced.tree.pivot_floor[static_cast<std::size_t>(c)]));
  });
  bodies.solve(traced.constants, x.data());
  return doubt;
}

/// The mass matrix and its sparse factors.
Trace::Condition solve_factorized(Traced& traced, const Numbers& q, Numbers& x, double coarser) {
  constexpr double small = 1e-8;  // where joints are coupled, whose screws share their pivots
  const Tree<double>& tree = traced.tree;
  const bool coupled = !tree.coupled_bodies.empty();
  Numbers H = composite(traced, q);
  Trace::Condition doubt;
  factorize(traced.constants, H.data(), [&](int c, const T& pivot, const T& M_cc) {
    const T floor = coupled ? T(small) * M_cc : T(tree.pivot_floor[static_cast<std::size_t>(c)]);
    doubt = doubt || !(pivot > T(coarser) * floor);
  });
  solve(traced.constants, H.data(), x.data());
  return doubt;
}

Recording forward_dynamics(const Tree<double>& tree, Solver solver, double coarser) {
  Traced traced(tree, "a");
  const Numbers q = traced.argument("q", tree.nq), v = traced.argument("v", tree.nv);
  Numbers x = traced.argument("tau", tree.nv);
  const Numbers bias = forces(traced, q, v, zeros(tree.nv));
  for (std::size_t c = 0; c < x.size(); ++c) x[c] -= bias[c];
  traced.recording.returns_doubt = true;
  const Trace::Condition doubt = traced.recording.doubt = solver(traced, q, x, coarser);
  if (doubt.is_constant() && doubt.constant())  // a joint moves no mass wherever it is
    std::fill(x.begin(), x.end(), T(std::numeric_limits<double>::quiet_NaN()));
  return traced.with(std::move(x));
}

/// The twist of a frame for a unit of each velocity. In the axes of the frame the joint screws are found on
/// the way from it to the ground, in inertial axes from the poses of the bodies.
template <class Rep> std::vector<Twist<Rep, T>> columns(Traced& traced, const Numbers& q, int frame) {
  const Tree<T>& tree = traced.constants;
  std::vector<Twist<Rep, T>> J(static_cast<std::size_t>(tree.nv));
  const auto add = [&](int c, const Screw<T>& X) { J[c] += Twist<Rep, T>{X.w, X.v}; };
  if constexpr (std::same_as<Rep, BodyFixed>) {
    each_body_fixed_column(tree, q.data(), Place<T>(frame),
                           [&](int, int c, const Screw<T>& X) { add(c, X); });
  } else {
    Arena arena(traced.workspace);
    SE3<T>* C_pi = arena.per_body<SE3<T>>();
    SE3<T>* C = arena.per_body<SE3<T>>();
    joint_poses(tree, q.data(), C_pi);
    body_poses(tree, C_pi, C);
    const int body = tree.frame_body[frame];
    const SE3<T> place = C[body] * tree.frame_offset[frame];
    const Vec3<T> origin = std::same_as<Rep, Spatial> ? Vec3<T>{} : place.r;
    for (int i = body; i > 0; i = tree.parent[i]) each_screw(tree, i, {C[i].R, C[i].r - origin}, add);
    if constexpr (std::same_as<Rep, Mixed>)
      for (auto& [w, v] : J) w = transpose(place.R) * w;
  }
  return J;
}

Recording jacobian(const Tree<double>& tree, int frame, Representation representation) {
  Traced traced(tree, "J");
  const Numbers q = traced.argument("q", tree.nq);
  const std::size_t nv = static_cast<std::size_t>(tree.nv);
  Numbers rows(6 * nv);
  with_representation(representation, [&](auto rep) {
    const auto J = columns<decltype(rep)>(traced, q, frame);
    for (std::size_t c = 0; c < nv; ++c) {
      const Vec3<T>&w = J[c].w, &v = J[c].v;
      std::size_t r = 0;
      for (const T& x : {w.x, w.y, w.z, v.x, v.y, v.z}) rows[r++ * nv + c] = x;
    }
  });
  return traced.with(std::move(rows));
}

}  // namespace

Recording record(const Model& model, const Function& function, bool single_precision) {
  const Tree<double> tree = traced_tree(model.tree<double>());
  switch (function.quantity) {
    case Quantity::inverse_dynamics: return inverse_dynamics(tree);
    case Quantity::mass_matrix: return mass_matrix(tree);
    case Quantity::jacobian: return jacobian(tree, function.frame, function.representation);
    case Quantity::forward_dynamics: break;
  }
  const double coarser = single_precision ? 1e5 : 1;  // fewer digits
  if (!tree.coupled_bodies.empty()) return forward_dynamics(tree, solve_factorized, coarser);
  Recording by_bodies = forward_dynamics(tree, solve_articulated, coarser);
  if (tree.depth > FastInverseMassMatrix<double>::longest_path) return by_bodies;  // factors lose digits
  Recording by_factors = forward_dynamics(tree, solve_factorized, coarser);
  return operations(by_bodies).total() < operations(by_factors).total() ? by_bodies : by_factors;
}

std::array<int, 3> operands(const Tape::Node& node) {
  using enum Tape::Operation;
  switch (node.operation) {
    case one:
    case input: return {};
    case scale:
    case reciprocal:
    case root:
    case sine:
    case cosine:
    case negation: return {node.a};
    default: return {node.a, node.b, node.condition};
  }
}

std::vector<char> needed(const Recording& recording) {
  std::vector<char> need(recording.nodes.size());
  for (const T& x : recording.results) need[static_cast<std::size_t>(x.node())] = 1;
  need[static_cast<std::size_t>(recording.doubt.node())] = 1;
  for (std::size_t k = need.size(); k-- > 0;)
    if (need[k])
      for (const int from : operands(recording.nodes[k])) need[static_cast<std::size_t>(from)] = 1;
  return need;
}

Operations operations(const Recording& recording) {
  using enum Tape::Operation;
  const std::vector<char> need = needed(recording);
  const auto is_factor = [](double x) { return std::abs(x) != 1; };
  Operations count;
  for (const T& x : recording.results) count.products += !x.is_constant() && is_factor(x.factor());
  for (std::size_t k = 0; k < need.size(); ++k) {
    if (!need[k]) continue;
    const Tape::Node& node = recording.nodes[k];
    switch (node.operation) {
      case scale: count.products += node.a != 0 && is_factor(node.factor); break;
      case sum: ++count.sums, count.products += node.b != 0 && is_factor(node.factor); break;
      case product: ++count.products; break;
      case reciprocal: ++count.divisions; break;
      case root: ++count.roots; break;
      case sine:
      case cosine:
      case angle: ++count.angles; break;
      default: break;
    }
  }
  return count;
}

}  // namespace axode::codegen
