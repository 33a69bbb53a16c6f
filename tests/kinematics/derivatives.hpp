#pragma once
#include <array>
#include <string>
#include <vector>

#include "axode/kinematics/path.hpp"
#include "axode/lie/representation_change.hpp"
#include "axode/scalar/dual.hpp"
#include "axode/scalar/taylor.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/any_scalar.hpp"

/// Motions in scalar types that carry derivatives, and functions that extract these derivatives.
namespace axode::test {

/// The four representations in double.
inline auto representations_in_double() { return testing::ValuesIn(cases().begin(), cases().begin() + 4); }

/// A random tree, and further random quantities from the same source.
inline Model random_model(Random<double>& random, const TreeRecipe& recipe) {
  return ModelBuilder(described(random_mechanism(random, recipe), random)).build();
}

/// The same tree or state in another scalar type.
template <class T> Tree<T> on(const Model& model) { return axode::cast<T>(model.tree<double>()); }
template <class T> std::vector<T> on(const std::vector<double>& x) { return {x.begin(), x.end()}; }

/// The configuration q ⊕ dv.
template <class T>
std::vector<T> moved(const Tree<T>& tree, const std::vector<T>& q, const std::vector<T>& dv) {
  std::vector<T> out(q.size());
  each_joint(tree, [&](const auto& joint, int i, bool coupled) {
    if (!coupled) joint.integrate(&q[tree->iq[i]], &dv[tree->iv[i]], &out[tree->iq[i]]);
  });
  return out;
}

/// The series q(t) that begins at q and has the left-trivialised velocities v(t). From the coefficients of q̇
/// = d/dε (q ⊕ ε v) up to one order follow those of q of the next order.
template <std::size_t N>
std::vector<Taylor<double, N>> flow(const Model& model, const std::vector<double>& q0,
                                    const std::vector<Taylor<double, N>>& v) {
  using Rate = Dual<Taylor<double, N>, 1>;
  const Tree<Rate> tree = on<Rate>(model);
  std::vector<Taylor<double, N>> q = on<Taylor<double, N>>(q0);
  std::vector<Rate> dv;
  for (const Taylor<double, N>& v_c : v) dv.push_back(Rate({}, {v_c}));
  for (std::size_t k = 0; k + 1 < N; ++k) {
    const std::vector<Rate> dq = moved(tree, std::vector<Rate>(q.begin(), q.end()), dv);
    for (std::size_t c = 0; c < q.size(); ++c) q[c].c[k + 1] = dq[c].dx[0].c[k] / static_cast<double>(k + 1);
  }
  return q;
}

/// The Jacobian of a place in any scalar type.
template <class Rep, class T>
std::vector<Twist<Rep, T>> jacobian_on(const Tree<T>& tree, const std::vector<T>& q, const Place<T>& place) {
  std::vector<Twist<BodyFixed, T>> columns(static_cast<std::size_t>(tree->nv));
  const SE3<T> C = each_body_fixed_column(tree, q.data(), place, [&](int, int c, const Screw<T>& X) {
    columns[static_cast<std::size_t>(c)] += twist<BodyFixed>(X);
  });
  std::vector<Twist<Rep, T>> J;
  for (const Twist<BodyFixed, T>& column : columns) J.push_back(change<Rep>(C, column));
  return J;
}

/// Applies f to every number in a quantity.
template <class T, class F> auto each_number(const Vec3<T>& a, const F& f) {
  return Vec3<decltype(f(a.x))>{f(a.x), f(a.y), f(a.z)};
}
template <template <class, class> class Kind, class Rep, class T, class F>
  requires is_screw_kind<Kind>
auto each_number(const Kind<Rep, T>& X, const F& f) {
  const auto& [a, b] = X;
  return Kind<Rep, decltype(f(a.x))>{each_number(a, f), each_number(b, f)};
}
template <class T, class F> auto each_number(const SE3<T>& C, const F& f) {
  using U = decltype(f(C.r.x));
  return SE3<U>{{each_number(C.R.x, f), each_number(C.R.y, f), each_number(C.R.z, f)}, each_number(C.r, f)};
}
template <class Entry, class F> auto each_number(const std::vector<Entry>& x, const F& f) {
  std::vector<decltype(each_number(x[0], f))> out;
  for (const Entry& entry : x) out.push_back(each_number(entry, f));
  return out;
}

/// The k-th time derivative of a quantity that is a series.
template <class Quantity> auto time_derivative(const Quantity& x, std::size_t k) {
  return each_number(x, [&](const auto& series) { return derivative(series, k); });
}

/// The unit vector e_k: velocity k is 1, and all others are 0.
inline std::vector<double> unit(int size, int k) {
  std::vector<double> e(static_cast<std::size_t>(size));
  e[static_cast<std::size_t>(k)] = 1;
  return e;
}

/// A random place on a model: a frame, or one with a random offset from a frame.
inline Place<> random_place(const Model& model, Random<double>& random) {
  const int frame = std::min(model.n_frames() - 1, static_cast<int>(random.number(0, model.n_frames())));
  const double kind = random.number(0, 3);
  if (kind < 1) return frame;
  if (kind < 2) return {frame, random.vector(0.3)};
  return {frame, SE3<>{random.rotation(), random.vector(0.3)}};
}
template <class T> Place<T> on(const Place<>& place) { return {place.frame, axode::cast<T>(place.offset)}; }

}  // namespace axode::test
