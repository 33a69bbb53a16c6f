#include "axode/codegen/recording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/codegen/traced_tree.hpp"
#include "axode/derivatives/first_order.hpp"
#include "axode/derivatives/forward_second_order.hpp"
#include "axode/derivatives/inverse_dynamics_products.hpp"
#include "axode/fast/inverse_dynamics.hpp"
#include "axode/fast/inverse_mass_matrix.hpp"
#include "axode/kinematics/path.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/articulated_bodies.hpp"
#include "axode/recursion/composite_bodies.hpp"
#include "axode/recursion/sparse_factor.hpp"

namespace axode::codegen {
namespace {

using T = Trace;
using Numbers = std::vector<T>;

Numbers zeros(int n) { return Numbers(static_cast<std::size_t>(n)); }

template <class Kernel> using OnTape = WithScratch<T, Kernel>;

/// Doubts a solution where a pivot is small against what feeds the velocity with every joint at zero.
class Doubt {
 public:
  Doubt(const Tree<double>& tree, double small) : fed_(static_cast<std::size_t>(tree->nv)), small_(small) {
    for (int i = 1; i <= tree->n; ++i)
      for (int s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s)
        fed_[static_cast<std::size_t>(tree->iv[i] + s - tree->first_screw[i])] +=
            tree.fed[static_cast<std::size_t>(s)];
  }
  template <class Fed> void see(int c, const T& pivot, const Fed&) {
    doubt_ = doubt_ || !(pivot > T(small_ * fed_[static_cast<std::size_t>(c)]));
  }
  const Trace::Condition& verdict() const { return doubt_; }

 private:
  std::vector<double> fed_;
  double small_;
  Trace::Condition doubt_;
};

/// The arguments of a function, which become inputs of the tape, and what its kernels read.
struct Traced {
  const Tree<double>& tree;
  Tree<T> constants = cast<T>(tree);
  Tape tape;
  Recording recording;

  Traced(const Tree<double>& traced, std::string result) : tree(traced) {
    recording.result = std::move(result);
  }
  Numbers argument(const char* name, int n) {
    Numbers x;
    for (int k = 0; k < n; ++k) x.push_back(tape.input(static_cast<int>(recording.arguments.size()), k));
    recording.arguments.emplace_back(name);
    recording.lengths.push_back(n);
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
  OnTape<FastInverseDynamics<Plain<T>, T>> recursion(*traced.tree.topology());
  Numbers tau = zeros(traced.tree->nv);
  recursion->forward(traced.tree, q.data(), v.data(), a.data(), cast<T>(traced.tree.g));
  recursion->backward(traced.tree, tau.data());
  return tau;
}

/// Body-fixed, where joint screws are constant and sparse.
Numbers composite(Traced& traced, const Numbers& q) {
  OnTape<CompositeBodies<BodyFixed, T>> bodies(*traced.tree.topology());
  Numbers M = zeros(traced.tree->nv * traced.tree->nv);
  bodies->run(traced.constants, q.data(), traced.constants.armature.data(), M.data());
  return M;
}

Recording inverse_dynamics(const Tree<double>& tree) {
  Traced traced(tree, "tau");
  const Numbers q = traced.argument("q", tree->nq), v = traced.argument("v", tree->nv),
                a = traced.argument("a", tree->nv);
  Numbers tau = forces(traced, q, v, a);
  for (std::size_t c = 0; c < tau.size(); ++c) tau[c] += T(tree.armature[c]) * a[c];
  return traced.with(std::move(tau));
}

Recording mass_matrix(const Tree<double>& tree) {
  Traced traced(tree, "M");
  return traced.with(composite(traced, traced.argument("q", tree->nq)));
}

/// How accelerations are found from what the forces leave over, x := M⁻¹ x for several x, and what makes it doubtful.
using Solver = Trace::Condition (*)(Traced&, const Numbers& q, std::span<Numbers> columns, double small);

/// The articulated-body algorithm.
Trace::Condition solve_articulated(Traced& traced, const Numbers& q, std::span<Numbers> columns,
                                   double small) {
  OnTape<ArticulatedBodies<BodyFixed, T>> bodies(*traced.tree.topology());
  Doubt doubt(traced.tree, small);
  bodies->links.run(traced.constants, q.data());
  bodies->factorize(traced.constants, traced.constants.armature.data(), doubt);
  for (Numbers& x : columns) bodies->solve(traced.constants, x.data());
  return doubt.verdict();
}

/// The mass matrix and its sparse factors.
Trace::Condition solve_factorized(Traced& traced, const Numbers& q, std::span<Numbers> columns,
                                  double small) {
  Numbers H = composite(traced, q);
  const Numbers fed = zeros(traced.tree->nv);  // not asked for
  Doubt doubt(traced.tree, small);
  factorize(traced.constants, fed.data(), H.data(), doubt);
  for (Numbers& x : columns) solve(traced.constants, H.data(), x.data());
  return doubt.verdict();
}

/// What is above the diagonal to below it: of a solution for a unit vector, the part that is found before it reaches
/// the leaves.
void mirror(T* matrix, std::size_t n) {
  for (std::size_t r = 0; r < n; ++r)
    for (std::size_t c = 0; c < r; ++c) matrix[r * n + c] = matrix[c * n + r];
}

/// On long paths the factors of the mass matrix lose digits.
bool factors_are_exact(const Tree<double>& tree) {
  return tree->depth <= FastInverseMassMatrix<double>::longest_path;
}

/// The arguments of forward dynamics and the accelerations.
struct Accelerated {
  Traced& traced;
  Solver solver;
  double small;
  Numbers q, v, tau, a;

  /// Without forces, for what needs the mass matrix alone.
  Accelerated(Traced& on, Solver by, double doubtful, Numbers at)
      : traced(on), solver(by), small(doubtful), q(std::move(at)), a(zeros(on.tree->nv)) {}
  Accelerated(Traced& on, Solver by, double doubtful)
      : traced(on),
        solver(by),
        small(doubtful),
        q(on.argument("q", on.tree->nq)),
        v(on.argument("v", on.tree->nv)),
        tau(on.argument("tau", on.tree->nv)),
        a(tau) {
    const Numbers bias = forces(traced, q, v, zeros(on.tree->nv));
    for (std::size_t c = 0; c < a.size(); ++c) a[c] -= bias[c];
    solve({&a, 1});
  }
  void solve(std::span<Numbers> columns) { traced.recording.doubt = solver(traced, q, columns, small); }
  /// The same for a matrix of nv columns, row by row.
  void solve(T* matrix) {
    const std::size_t nv = a.size();
    std::vector<Numbers> columns(nv, zeros(traced.tree->nv));
    for (std::size_t k = 0; k < nv * nv; ++k) columns[k % nv][k / nv] = matrix[k];
    solve(columns);
    for (std::size_t k = 0; k < nv * nv; ++k) matrix[k] = columns[k % nv][k / nv];
  }
  Recording with(Numbers results) {
    traced.recording.returns_doubt = true;
    const Trace::Condition doubt = traced.recording.doubt;
    if (doubt.is_constant() && doubt.constant())  // a joint moves no mass wherever it is
      std::fill(results.begin(), results.end(), T(std::numeric_limits<double>::quiet_NaN()));
    return traced.with(std::move(results));
  }
};

/// M⁻¹ = (a row of solutions for each unit vector), of which the half is taken that takes less.
Recording inverse_mass_matrix(const Tree<double>& tree, Solver solver, double small) {
  Traced traced(tree, "M_inverse");
  Accelerated at(traced, solver, small, traced.argument("q", tree->nq));
  const std::size_t nv = static_cast<std::size_t>(tree->nv);
  Numbers out = zeros(tree->nv * tree->nv);
  for (std::size_t c = 0; c < nv; ++c) out[c * nv + c] = T(1);
  at.solve(out.data());
  mirror(out.data(), nv);
  return at.with(std::move(out));
}

Recording solution(const Tree<double>& tree, Solver solver, double small) {
  Traced traced(tree, "x");
  Accelerated at(traced, solver, small, traced.argument("q", tree->nq));
  Numbers x = traced.argument("tau", tree->nv);
  at.solve({&x, 1});
  return at.with(std::move(x));
}

Recording forward_dynamics(const Tree<double>& tree, Solver solver, double small) {
  Traced traced(tree, "a");
  Accelerated at(traced, solver, small);
  return at.with(at.a);
}

/// By q, v and a, one behind the other.
Numbers matrices(Traced& traced, const Numbers& q, const Numbers& v, const Numbers& a) {
  OnTape<FirstOrder<T>> first_order(*traced.tree.topology());
  const int entries = traced.tree->nv * traced.tree->nv;
  Numbers out = zeros(3 * entries);
  first_order->run(traced.tree, q.data(), v.data(), a.data(), {});
  first_order->write(traced.tree, {}, out.data(), out.data() + entries, out.data() + 2 * entries);
  return out;
}
Numbers product(Traced& traced, const Numbers& q, const Numbers& v, const Numbers& a, const Numbers& dq,
                const Numbers& dv, const Numbers& da) {
  OnTape<InverseDynamicsJvp<T>> jvp(*traced.tree.topology());
  Numbers out = zeros(traced.tree->nv);
  jvp->run(traced.tree, q.data(), v.data(), a.data(), dq.data(), dv.data(), da.data(), {}, out.data());
  return out;
}
Numbers gradients(Traced& traced, const Numbers& q, const Numbers& v, const Numbers& a, const Numbers& w) {
  OnTape<InverseDynamicsVjp<T>> vjp(*traced.tree.topology());
  vjp->run(traced.tree, q.data(), v.data(), a.data(), w.data(), {});
  Numbers out;
  for (const T* const part : {vjp->by_q, vjp->by_v, vjp->by_a})
    out.insert(out.end(), part, part + traced.tree->nv);
  return out;
}

/// Where the blocks of a Hessian go that lie one behind the other.
HessianBlocks<T> blocks(Numbers& out) {
  T* const first = out.data();
  const std::ptrdiff_t entries = std::ssize(out) / 4;
  return {first, first + entries, first + 2 * entries, first + 3 * entries};
}
Numbers hessian(Traced& traced, const Numbers& q, const Numbers& v, const Numbers& a, const Numbers& w) {
  OnTape<SecondOrder<T>> second(*traced.tree.topology());
  Numbers out = zeros(4 * traced.tree->nv * traced.tree->nv);
  second->run(traced.tree, q.data(), v.data(), a.data(), w.data(), {});
  second->add_to(*traced.tree.topology(), false, blocks(out));
  return out;
}

Recording inverse_dynamics_derivatives(const Tree<double>& tree, Quantity quantity) {
  const bool jvp = quantity == Quantity::inverse_dynamics_jvp,
             vjp = quantity == Quantity::inverse_dynamics_vjp,
             curved = quantity == Quantity::inverse_dynamics_hessian;
  Traced traced(tree, vjp ? "gradient" : curved ? "hessian" : "dtau");
  const Numbers q = traced.argument("q", tree->nq), v = traced.argument("v", tree->nv),
                a = traced.argument("a", tree->nv);
  if (vjp) return traced.with(gradients(traced, q, v, a, traced.argument("w", tree->nv)));
  if (curved) return traced.with(hessian(traced, q, v, a, traced.argument("w", tree->nv)));
  if (!jvp) return traced.with(matrices(traced, q, v, a));
  const Numbers dq = traced.argument("dq", tree->nv), dv = traced.argument("dv", tree->nv),
                da = traced.argument("da", tree->nv);
  return traced.with(product(traced, q, v, a, dq, dv, da));
}

Recording forward_dynamics_derivatives(const Tree<double>& tree, Solver solver, double small) {
  Traced traced(tree, "da");
  Accelerated at(traced, solver, small);
  const std::size_t nv = at.a.size(), entries = nv * nv;
  Numbers out = matrices(traced, at.q, at.v, at.a);
  for (std::size_t k = 0; k < entries; ++k) {
    out[k] = -out[k], out[entries + k] = -out[entries + k];
    out[2 * entries + k] = T(k % (nv + 1) == 0);
  }
  for (const std::size_t matrix : {0, 1, 2}) at.solve(out.data() + matrix * entries);
  mirror(out.data() + 2 * entries, nv);
  return at.with(std::move(out));
}
Recording forward_dynamics_jvp(const Tree<double>& tree, Solver solver, double small) {
  Traced traced(tree, "da");
  Accelerated at(traced, solver, small);
  const Numbers dq = traced.argument("dq", tree->nv), dv = traced.argument("dv", tree->nv);
  Numbers x = traced.argument("dtau", tree->nv);
  const Numbers along = product(traced, at.q, at.v, at.a, dq, dv, zeros(tree->nv));
  for (std::size_t c = 0; c < x.size(); ++c) x[c] -= along[c];
  at.solve({&x, 1});
  return at.with(std::move(x));
}
Recording forward_dynamics_vjp(const Tree<double>& tree, Solver solver, double small) {
  Traced traced(tree, "gradient");
  Accelerated at(traced, solver, small);
  Numbers mu = traced.argument("w", tree->nv);
  at.solve({&mu, 1});
  Numbers out = gradients(traced, at.q, at.v, at.a, mu);
  const std::size_t nv = mu.size();
  for (std::size_t c = 0; c < nv; ++c) out[c] = -out[c], out[nv + c] = -out[nv + c], out[2 * nv + c] = mu[c];
  return at.with(std::move(out));
}

Recording forward_dynamics_hessian(const Tree<double>& tree, Solver solver, double small) {
  Traced traced(tree, "hessian");
  Accelerated at(traced, solver, small);
  Numbers mu = traced.argument("w", tree->nv);
  for (T& x : mu) x = -x;
  at.solve({&mu, 1});
  OnTape<SecondOrder<T>> second(*tree.topology());
  Numbers out = zeros(4 * tree->nv * tree->nv);
  second->run(tree, at.q.data(), at.v.data(), at.a.data(), mu.data(), {});
  accelerations_from(*second, tree, {}, blocks(out), [&](T* matrix) { at.solve(matrix); });
  return at.with(std::move(out));
}

/// The twist of a frame for a unit of each velocity. In the axes of the frame the joint screws are found on
/// the way from it to the ground, in inertial axes from the poses of the bodies.
template <class Rep> std::vector<Twist<Rep, T>> columns(Traced& traced, const Numbers& q, int frame) {
  const Tree<T>& tree = traced.constants;
  std::vector<Twist<Rep, T>> J(static_cast<std::size_t>(tree->nv));
  const auto add = [&](int c, const Screw<T>& X) { J[c] += Twist<Rep, T>{X.w, X.v}; };
  if constexpr (std::same_as<Rep, BodyFixed>) {
    each_body_fixed_column(tree, q.data(), Place<T>(frame),
                           [&](int, int c, const Screw<T>& X) { add(c, X); });
  } else {
    OnTape<BodyPoses<T>> poses(*tree.topology());
    poses->run(tree, q.data());
    const SE3<T>* C = poses->C;
    const int body = tree->frame_body[frame];
    const SE3<T> place = C[body] * tree.frame_offset[frame];
    const Vec3<T> origin = std::same_as<Rep, Spatial> ? Vec3<T>{} : place.r;
    for (int i = body; i > 0; i = tree->parent[i]) each_screw(tree, i, {C[i].R, C[i].r - origin}, add);
    if constexpr (std::same_as<Rep, Mixed>)
      for (auto& [w, v] : J) w = transpose(place.R) * w;
  }
  return J;
}

Recording jacobian(const Tree<double>& tree, int frame, Representation representation) {
  Traced traced(tree, "J");
  const Numbers q = traced.argument("q", tree->nq);
  const std::size_t nv = static_cast<std::size_t>(tree->nv);
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

/// Frame by frame: the columns of R, then r.
Recording poses(const Tree<double>& tree, int first, int last) {
  Traced traced(tree, "C");
  const Numbers q = traced.argument("q", tree->nq);
  OnTape<BodyPoses<T>> bodies(*tree.topology());
  bodies->run(traced.constants, q.data());
  Numbers out;
  for (int f = first; f <= last; ++f) {
    const SE3<T> C = bodies->C[tree->frame_body[f]] * traced.constants.frame_offset[f];
    for (const Vec3<T>& x : {C.R.x, C.R.y, C.R.z, C.r}) out.insert(out.end(), {x.x, x.y, x.z});
  }
  return traced.with(std::move(out));
}

}  // namespace

std::vector<Recording> record_solutions(const Model& model) {
  const Tree<double> tree = traced_tree(model.tree<double>());
  std::vector<Recording> solutions{solution(tree, solve_articulated, doubtful_part<double>)};
  if (factors_are_exact(tree)) solutions.push_back(solution(tree, solve_factorized, doubtful_part<double>));
  return solutions;
}

Recording record(const Model& model, const Function& function, bool single_precision) {
  const Tree<double> tree = traced_tree(model.tree<double>());
  switch (function.quantity) {
    case Quantity::inverse_dynamics: return inverse_dynamics(tree);
    case Quantity::mass_matrix: return mass_matrix(tree);
    case Quantity::poses: return poses(tree, 0, tree->n_frames() - 1);
    case Quantity::pose: return poses(tree, function.frame, function.frame);
    case Quantity::jacobian: return jacobian(tree, function.frame, function.representation);
    case Quantity::inverse_dynamics_derivatives:
    case Quantity::inverse_dynamics_jvp:
    case Quantity::inverse_dynamics_vjp:
    case Quantity::inverse_dynamics_hessian: return inverse_dynamics_derivatives(tree, function.quantity);
    default: break;
  }
  const auto by = [&](Solver solver) {
    const double small = single_precision ? doubtful_part<float> : doubtful_part<double>;
    switch (function.quantity) {
      case Quantity::inverse_mass_matrix: return inverse_mass_matrix(tree, solver, small);
      case Quantity::forward_dynamics_derivatives: return forward_dynamics_derivatives(tree, solver, small);
      case Quantity::forward_dynamics_jvp: return forward_dynamics_jvp(tree, solver, small);
      case Quantity::forward_dynamics_vjp: return forward_dynamics_vjp(tree, solver, small);
      case Quantity::forward_dynamics_hessian: return forward_dynamics_hessian(tree, solver, small);
      default: return forward_dynamics(tree, solver, small);
    }
  };
  Recording by_bodies = by(solve_articulated);
  if (!factors_are_exact(tree)) return by_bodies;
  Recording by_factors = by(solve_factorized);
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
