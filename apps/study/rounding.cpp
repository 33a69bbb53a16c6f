#include "apps/study/rounding.hpp"

#include <Eigen/Eigenvalues>

#include "apps/files/state.hpp"
#include "apps/study/contraction/tree_contraction.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/composite_bodies.hpp"
#include "axode/recursion/forward_dynamics.hpp"

namespace axode {
namespace command {
namespace {

/// A number with the digits of long double, for which no kernel has packed code.
class Exact {
 public:
  Exact() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number> Exact(Number x)
        : x_(x) {}  // NOLINT(google-explicit-constructor): a constant
    explicit operator double() const { return static_cast<double>(x_); }

    friend Exact operator+(const Exact& a, const Exact& b) { return a.x_ + b.x_; }
    friend Exact operator-(const Exact& a, const Exact& b) { return a.x_ - b.x_; }
    friend Exact operator-(const Exact& a) { return -a.x_; }
    friend Exact operator*(const Exact& a, const Exact& b) { return a.x_ * b.x_; }
    friend Exact operator/(const Exact& a, const Exact& b) { return a.x_ / b.x_; }
    Exact& operator+=(const Exact& b) { return *this = *this + b; }
    Exact& operator-=(const Exact& b) { return *this = *this - b; }
    friend Exact sqrt(const Exact& a) { return std::sqrt(a.x_); }
    friend Exact sin(const Exact& a) { return std::sin(a.x_); }
    friend Exact cos(const Exact& a) { return std::cos(a.x_); }
    friend Exact abs(const Exact& a) { return std::abs(a.x_); }
    friend bool operator<(const Exact& a, const Exact& b) { return a.x_ < b.x_; }
    friend bool operator>(const Exact& a, const Exact& b) { return a.x_ > b.x_; }
    friend Exact select(bool condition, const Exact& a, const Exact& b) { return condition ? a : b; }

   private:
    long double x_ = 0;
};

}  // namespace
}  // namespace command
template <>
inline constexpr double unit_roundoff<command::Exact> = std::numeric_limits<long double>::epsilon();
}  // namespace axode

namespace axode::command {
namespace {

/// A state in a scalar.
template <class T> struct Numbers { std::vector<T> q, v, a; };
template <class T> std::vector<T> cast_all(const std::vector<double>& x) { return {x.begin(), x.end()}; }

template <class Rep, class T>
std::vector<T> forces(const Tree<T>& tree, const Numbers<T>& x, SpatialOrigin origin) {
  Workspace<T> workspace(*tree.topology(), footprint<ScrewsOnce<Rep, T>>(*tree.topology()));
  Arena arena = workspace.arena(*tree.topology());
  std::vector<T> tau(x.v.size());
  ScrewsOnce<Rep, T>(arena).run(tree, x.q.data(), x.v.data(), x.a.data(), tau.data(), origin);
  return tau;
}
/// Accelerations by articulated bodies in spatial twists.
template <class T>
std::vector<T> spatial_accelerations(const Tree<double>& of, const Tree<T>& tree, const Numbers<T>& x,
                                     const std::vector<T>& tau, SpatialOrigin origin) {
  std::vector<T> a(x.v.size());
  TreeContraction<T> contraction(of, ContractionPlan(of, 0));
  if (!contraction.run(tree, x.q.data(), x.v.data(), tau.data(), a.data(), OneByOne{}, origin))
    std::ranges::fill(a, T(std::numeric_limits<double>::quiet_NaN()));
  return a;
}
template <class Rep>
std::vector<double> accelerations(const Tree<double>& tree, const Numbers<double>& x,
                                  const std::vector<double>& tau) {
  Workspace<> workspace(*tree.topology(), footprint<ForwardDynamicsRecursion<Rep, double>>(*tree.topology()));
  Arena arena = workspace.arena(*tree.topology());
  std::vector<double> a(x.v.size());
  static_cast<void>(ForwardDynamicsRecursion<Rep, double>(arena).run(tree, x.q.data(), x.v.data(), tau.data(),
                                                                     {}, a.data()));
  return a;
}
double condition(const Tree<double>& tree, const Numbers<double>& x) {
  Workspace<> workspace(*tree.topology(), footprint<CompositeBodies<Hybrid, double>>(*tree.topology()));
  Arena arena = workspace.arena(*tree.topology());
  Eigen::MatrixXd M(tree->nv, tree->nv);
  CompositeBodies<Hybrid, double>(arena).run(tree, x.q.data(), tree.armature.data(), M.data());
  const Eigen::VectorXd size = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(M).eigenvalues();
  return size(size.size() - 1) / size(0);
}

/// Raises an error to that of x.
void raise(double& error, const std::vector<double>& x, const std::vector<Exact>& exact) {
  Exact worst = 0, largest = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    worst = std::max(worst, abs(x[k] - exact[k]));
    largest = std::max(largest, abs(exact[k]));
  }
  error = std::max(error, static_cast<double>(worst / largest));
}

/// The errors of a tree at the states.
RoundingErrors errors_of(const Tree<double>& tree, const std::vector<State>& states) {
  using enum SpatialOrigin;
  const Tree<Exact> exact_tree = cast<Exact>(tree);
  RoundingErrors errors{};
  auto &inverse = errors.inverse_dynamics, &forward = errors.forward_dynamics;
  for (const State& state : states) {
    const Numbers<double> x{state.q, state.v, state.a};
    const Numbers<Exact> exact_x{cast_all<Exact>(state.q), cast_all<Exact>(state.v),
                                 cast_all<Exact>(state.a)};
    const std::vector<Exact> tau = forces<Hybrid>(exact_tree, exact_x, of_roots);
    raise(inverse.body, forces<BodyFixed>(tree, x, of_roots), tau);
    raise(inverse.spatial, forces<Spatial>(tree, x, of_roots), tau);
    raise(inverse.inertial, forces<Spatial>(tree, x, inertial), tau);
    raise(inverse.hybrid, forces<Hybrid>(tree, x, of_roots), tau);
    raise(inverse.mixed, forces<Mixed>(tree, x, of_roots), tau);

    std::vector<double> given;
    for (const Exact& force : tau) given.push_back(static_cast<double>(force));
    const std::vector<Exact> a =
        spatial_accelerations<Exact>(tree, exact_tree, exact_x, cast_all<Exact>(given), of_roots);
    raise(forward.body, accelerations<BodyFixed>(tree, x, given), a);
    raise(forward.spatial, spatial_accelerations<double>(tree, tree, x, given, of_roots), a);
    raise(forward.inertial, spatial_accelerations<double>(tree, tree, x, given, inertial), a);
    raise(forward.hybrid, accelerations<Hybrid>(tree, x, given), a);
    raise(forward.mixed, accelerations<Mixed>(tree, x, given), a);
    errors.condition = std::max(errors.condition, condition(tree, x));
  }
  return errors;
}

}  // namespace

std::vector<RoundingErrors> rounding_errors(const Model& model) {
  constexpr unsigned n_states = 10;
  const Tree<double>& tree = model.tree<double>();
  std::vector<State> states;
  for (unsigned k = 1; k <= n_states; ++k) states.push_back(random_state(model, k));
  std::vector<RoundingErrors> out;
  const auto add = [&](double distance, double heaviness) {
    TreeNumbers<double> numbers = tree;
    const double step = distance / std::sqrt(3.0);
    each_root(*tree.topology(), [&](int i) { numbers.B[i].r += Vec3<>{step, step, step}; });
    Inertia<>& last = numbers.M.back();
    last = {heaviness * last.m, heaviness * last.h, heaviness * last.Theta};
    out.push_back(errors_of(Tree<double>(tree.topology(), std::move(numbers)), states));
    out.back().distance = distance;
    out.back().heaviness = heaviness;
  };
  add(0, 1);
  for (const double distance : {1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6}) add(distance, 1);
  for (const double heaviness : {1e1, 1e2, 1e3, 1e4}) add(0, heaviness);
  return out;
}

}  // namespace axode::command
