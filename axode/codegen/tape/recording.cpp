#include "axode/codegen/tape/recording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "axode/codegen/tape/differentiation.hpp"
#include "axode/codegen/tape/traced_tree.hpp"
#include "axode/derivatives/products/row_kernels.hpp"
#include "axode/fast/inverse_mass_matrix.hpp"
#include "axode/kinematics/path.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/articulated_bodies.hpp"
#include "axode/recursion/composite_bodies.hpp"
#include "axode/recursion/sparse_factor.hpp"

namespace axode::codegen {
namespace {

using T = Trace;
using Traces = Composition::Traces;

template <class Kernel> using OnTape = WithScratch<T, Kernel>;

/// Determines whether the mass matrix may be singular. It may be if the pivot of a velocity in its
/// factorisation is small compared with the inertia that this velocity moves at q = 0. In float, each pivot
/// is also compared with the rounding errors of the numbers from which it is computed.
class SingularityTest {
 public:
  SingularityTest(const Tree<double>& tree, bool single_precision)
      : inertia_scale(tree->nv), single_precision_(single_precision) {
    for (int i = 1; i <= tree->n; ++i)
      for (int s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s)
        inertia_scale[static_cast<std::size_t>(tree->iv[i] + s - tree->first_screw[i])] +=
            T(tree.inertia_scale[s]);
  }
  template <class Scale> void add(int c, const T& pivot, const Scale& scale) {
    const double small = single_precision_ ? pivot_threshold<float> : pivot_threshold<double>;
    has_small_ = has_small_ || !(pivot > T(small) * inertia_scale[c]);
    if (single_precision_) has_rounding_ = has_rounding_ || !(pivot > T(16 * unit_roundoff<float>) * scale());
  }
  Trace::Condition verdict() const { return single_precision_ ? has_small_ && has_rounding_ : has_small_; }

  Traces inertia_scale;  ///< of each velocity

 private:
  bool single_precision_;
  Trace::Condition has_small_, has_rounding_;
};

/// A function of a tree that is being recorded: its tape (list of operations) and the constants of the tree.
struct Traced {
  Composition on;
  Tree<T> constants;
  std::string result;

  Traced(const Tree<double>& tree, std::string_view name) : constants(cast<T>(tree)), result(name) {}
  Traces argument(std::string_view name, int n) { return on.argument(std::string(name), n); }
  Recording with(Traces results) { return on.with(result, std::move(results)); }
  /// The recording of these results, which are wrong if `maybe_singular` is true.
  Recording with(Traces results, const Trace::Condition& maybe_singular) {
    if (maybe_singular.is_constant() && maybe_singular.constant())  // a joint moves no mass in any
                                                                    // configuration
      std::ranges::fill(results, T(std::numeric_limits<double>::quiet_NaN()));
    Recording recording = with(std::move(results));
    recording.returns_singularity = true;
    recording.maybe_singular = maybe_singular;
    return recording;
  }
};

/// Records the operations that solve the equations of motion, either by articulated bodies or by sparse
/// factors of the mass matrix. They are in body axes, in which joint screws are constant and sparse.
template <bool factors> struct Solver {
  using T = Trace;
  using Bodies = std::conditional_t<factors, CompositeBodies<BodyFixed, T>, ArticulatedBodies<BodyFixed, T>>;
  FastInverseDynamics<Plain<T>, T> bias;
  Bodies bodies;
  T *zero, *H;
  bool single_precision = false;
  std::optional<Tree<T>> constants;
  Trace::Condition maybe_singular;

  explicit Solver(Arena& arena)
      : bias(arena),
        bodies(arena),
        zero(arena.per_velocity<T>()),
        H(arena.array<T>(arena.topology().nv * arena.topology().nv)) {}

  void prepare(const Tree<double>& tree, const T* q) {
    constants.emplace(cast<T>(tree));
    SingularityTest check(tree, single_precision);
    std::fill_n(zero, tree->nv, T(0));
    if constexpr (factors) {
      std::fill_n(H, tree->nv * tree->nv, T(0));
      bodies.run(*constants, q, constants->armature.data(), H);
      axode::factorize(*constants, check.inertia_scale.data(), H, check);
    } else {
      bodies.links.run(*constants, q);
      bodies.factorize(*constants, constants->armature.data(), check);
    }
    maybe_singular = check.verdict();
  }
  void accelerate(const Tree<double>& tree, const T* q, const T* v, const T* tau, T* a) {
    std::fill_n(zero, tree->nv, T(0));
    std::fill_n(a, tree->nv, T(0));
    bias.forward(tree, q, v, zero, cast<T>(tree.g));
    bias.backward(tree, a);
    for (int c = 0; c < tree->nv; ++c) a[c] = tau[c] - a[c];
    prepare(tree, q);
    solve_one(tree, a);
  }
  void solve_one(const Tree<double>&, T* x) {
    if constexpr (factors)
      axode::solve(*constants, H, x);
    else
      bodies.solve(*constants, x);
  }
  void solve(const Tree<double>& tree, T* matrix) {
    const std::size_t nv = tree->nv;
    Traces x(nv);
    for (std::size_t c = 0; c < nv; ++c) {
      for (std::size_t r = 0; r < nv; ++r) x[r] = matrix[r * nv + c];
      solve_one(tree, x.data());
      for (std::size_t r = 0; r < nv; ++r) matrix[r * nv + c] = x[r];
    }
  }
  /// Computes the inverse of the mass matrix, by solving for all unit vectors. One half of the matrix is
  /// copied from the other, because it is symmetric, so that fewer operations are recorded.
  void inverse(const Tree<double>& tree, T* matrix) {
    const std::size_t nv = tree->nv;
    for (std::size_t k = 0; k < nv * nv; ++k) matrix[k] = T(k % (nv + 1) == 0);
    solve(tree, matrix);
    for (std::size_t r = 0; r < nv; ++r)
      for (std::size_t c = 0; c < r; ++c) matrix[r * nv + c] = matrix[c * nv + r];
  }
};

/// Whether the factors of the mass matrix are exact to rounding, unlike on long paths, where digits are lost.
bool factors_are_exact(const Tree<double>& tree) {
  return tree->depth <= FastInverseMassMatrix<double>::longest_path;
}

/// Records a function of a state by running its kernel. Each result has nv or nv² numbers.
template <catalog::Id id, class By>
Recording record_row(const Tree<double>& tree, const Function&, bool single_precision) {
  constexpr const catalog::Words& row = id.words();
  Traced traced(tree, row.together);
  catalog::Read<T> given;
  std::vector<Traces> arguments;
  for (const catalog::Input input : row.numbers()) {
    arguments.push_back(traced.argument(to_string(input), input == catalog::Input::q ? tree->nq : tree->nv));
    given[input] = arguments.back().data();
  }
  Traces out(row.symbols.size() * static_cast<std::size_t>(std::pow(tree->nv, row.shape.size())));
  OnTape<catalog::RowKernel<id, By>> kernel(*tree.topology());
  if constexpr (row.may_fail) {
    kernel->by.single_precision = single_precision;
    kernel->run(tree, given, out.data());
    return traced.with(std::move(out), kernel->by.maybe_singular);
  } else {
    kernel->run(tree, given, out.data());
    return traced.with(std::move(out));
  }
}

/// Records the mass matrix in the body-fixed representation, in which joint screws are constant and sparse.
Recording mass_matrix(const Tree<double>& tree, const Function&, bool) {
  Traced traced(tree, "M");
  const Traces q = traced.argument("q", tree->nq);
  OnTape<CompositeBodies<BodyFixed, T>> bodies(*tree.topology());
  Traces M(tree->nv * tree->nv);
  bodies->run(traced.constants, q.data(), traced.constants.armature.data(), M.data());
  return traced.with(std::move(M));
}
template <class By>
Recording inverse_mass_matrix(const Tree<double>& tree, const Function&, bool single_precision) {
  Traced traced(tree, "M_inverse");
  const Traces q = traced.argument("q", tree->nq);
  OnTape<By> by(*tree.topology());
  by->single_precision = single_precision;
  by->prepare(tree, q.data());
  Traces out(tree->nv * tree->nv);
  by->inverse(tree, out.data());
  return traced.with(std::move(out), by->maybe_singular);
}
template <class By> Recording solution(const Tree<double>& tree) {
  Traced traced(tree, "x");
  const Traces q = traced.argument("q", tree->nq);
  Traces x = traced.argument("tau", tree->nv);
  OnTape<By> by(*tree.topology());
  by->prepare(tree, q.data());
  by->solve_one(tree, x.data());
  return traced.with(std::move(x), by->maybe_singular);
}

/// The Jacobian of a frame in representation Rep, one column for each velocity.
template <class Rep> std::vector<Twist<Rep, T>> columns(Traced& traced, const Traces& q, int frame) {
  const Tree<T>& tree = traced.constants;
  std::vector<Twist<Rep, T>> J(tree->nv);
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

Recording jacobian(const Tree<double>& tree, const Function& function, bool) {
  Traced traced(tree, "J");
  const Traces q = traced.argument("q", tree->nq);
  const std::size_t nv = tree->nv;
  Traces rows(6 * nv);
  with_representation(function.representation, [&](auto rep) {
    const auto J = columns<decltype(rep)>(traced, q, function.frame);
    for (std::size_t c = 0; c < nv; ++c) {
      const Vec3<T>&w = J[c].w, &v = J[c].v;
      std::size_t r = 0;
      for (const T& x : {w.x, w.y, w.z, v.x, v.y, v.z}) rows[r++ * nv + c] = x;
    }
  });
  return traced.with(std::move(rows));
}

/// Records the poses of the frames `first` to `last`, 12 numbers for each: the columns of R, then r.
Recording poses_between(const Tree<double>& tree, int first, int last) {
  Traced traced(tree, "C");
  const Traces q = traced.argument("q", tree->nq);
  OnTape<BodyPoses<T>> bodies(*tree.topology());
  bodies->run(traced.constants, q.data());
  Traces out;
  for (int f = first; f <= last; ++f) {
    const SE3<T> C = bodies->C[tree->frame_body[f]] * traced.constants.frame_offset[f];
    for (const Vec3<T>& x : {C.R.x, C.R.y, C.R.z, C.r}) out.insert(out.end(), {x.x, x.y, x.z});
  }
  return traced.with(std::move(out));
}
Recording poses(const Tree<double>& tree, const Function&, bool) {
  return poses_between(tree, 0, tree->n_frames() - 1);
}
Recording pose(const Tree<double>& tree, const Function& function, bool) {
  return poses_between(tree, function.frame, function.frame);
}

using Articulated = Solver<false>;
using Factorized = Solver<true>;

/// The functions that record one function of the model. `by_bodies` solves with the mass matrix by
/// articulated bodies, and `by_factors` by factors of the mass matrix; `by_factors` is null for a function
/// that does not solve with the mass matrix.
struct Recorder {
  using Of = Recording (*)(const Tree<double>&, const Function&, bool single_precision);
  Of by_bodies = nullptr, by_factors = nullptr;
};
template <catalog::Id id> constexpr Recorder recorder() {
  if constexpr (!id.words().tape) {
    return {};
  } else if constexpr (id == "mass_matrix") {
    return {mass_matrix};
  } else if constexpr (id == "poses") {
    return {poses};
  } else if constexpr (id == "pose") {
    return {pose};
  } else if constexpr (id == "jacobian") {
    return {jacobian};
  } else if constexpr (id == "inverse_mass_matrix") {
    return {inverse_mass_matrix<Articulated>, inverse_mass_matrix<Factorized>};
  } else {
    static_assert(catalog::HasRowKernel<id, Articulated>, "a row with .tape = true needs a RowKernel");
    return {record_row<id, Articulated>, id.words().may_fail ? record_row<id, Factorized> : nullptr};
  }
}
constexpr auto recorders = [] {
  std::array<Recorder, catalog::functions_of_state.size()> all{};
  catalog::each_row([&]<catalog::Id id> { all[id.index] = recorder<id>(); });
  return all;
}();

}  // namespace

std::vector<Recording> record_solutions(const Model& model) {
  const Tree<double> tree = traced_tree(model.tree<double>());
  std::vector<Recording> solutions{solution<Articulated>(tree)};
  if (factors_are_exact(tree)) solutions.push_back(solution<Factorized>(tree));
  return solutions;
}

Recording record(const Model& model, const Function& function, bool single_precision) {
  const Tree<double> tree = traced_tree(model.tree<double>());
  const Recorder& recorder = recorders[function.row.index];
  Recording by_bodies = recorder.by_bodies(tree, function, single_precision);
  if (recorder.by_factors == nullptr || !factors_are_exact(tree)) return by_bodies;
  Recording by_factors = recorder.by_factors(tree, function, single_precision);
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
  for (const T& x : recording.results) need[x.node()] = 1;
  need[recording.maybe_singular.node()] = 1;
  for (std::size_t k = need.size(); k-- > 0;)
    if (need[k])
      for (const int from : operands(recording.nodes[k])) need[from] = 1;
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
      case sum:
        ++count.sums;
        count.products += node.b != 0 && is_factor(node.factor);
        break;
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
