#pragma once
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <memory>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "axode/axode.hpp"
#include "tests/support/random_tree.hpp"

/// What laws are tested on: every representation and scalar behind one interface on doubles, so that a law is compiled
/// once.
namespace axode::test {

inline constexpr std::array representations{Representation::body, Representation::spatial,
                                            Representation::hybrid, Representation::mixed};

/// body, spatial, hybrid or mixed.
inline std::string name(Representation representation) { return std::string(word_for(representation)); }

/// What two computations of one quantity may differ by, as a part of the largest entry.
template <class T> inline constexpr double agreement = std::same_as<T, double> ? 1e-11 : 1e-3;

/// One way to compute.
struct Case {
  std::string name;               ///< body_double, fast_float, ...
  Representation representation;  ///< of results, where they depend on it; of Fast body-fixed
  bool fast, single;              ///< by the fast path; in float

  double agreement() const { return single ? test::agreement<float> : test::agreement<double>; }
  friend std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }
};
/// The four representations in double and in float.
const std::vector<Case>& cases();
/// And Fast in both.
const std::vector<Case>& cases_with_fast();
/// One for each scalar: hybrid, but named double and float.
const std::vector<Case>& scalars();
/// The case of the same scalar in another representation, or by the fast path.
Case in(Representation representation, const Case& c);
Case fast(const Case& c);
/// The same way in double.
Case in_double(const Case& c);
inline std::string name_of(const testing::TestParamInfo<Case>& info) { return info.param.name; }

/// A quantity of six components, angular before linear: a twist, a rate, a wrench or a momentum, in a representation.
struct Six {
  Vec3<> a, b;
};
inline Eigen::Matrix<double, 6, 1> to_eigen(const Six& x) {
  return {x.a.x, x.a.y, x.a.z, x.b.x, x.b.y, x.b.z};
}

inline Six operator+(const Six& x, const Six& y) { return {x.a + y.a, x.b + y.b}; }
inline Six operator-(const Six& x, const Six& y) { return {x.a - y.a, x.b - y.b}; }
/// The power of a wrench on a twist in the same representation; of a momentum twice the energy.
inline double operator|(const Six& W, const Six& V) { return dot(W.a, V.a) + dot(W.b, V.b); }

/// The same six components in another representation, of a body with pose C: a twist; its rate; a wrench or momentum.
Six changed_twist(Representation to, Representation from, const SE3<>& C, const Six& V);
Six changed_rate(Representation to, Representation from, const SE3<>& C, const Six& V, const Six& dV);
Six changed_wrench(Representation to, Representation from, const SE3<>& C, const Six& W);
template <class Rep> Twist<Rep> twist_of(const Six& x) { return {x.a, x.b}; }
template <class Rep> TwistRate<Rep> rate_of(const Six& x) { return {x.a, x.b}; }
template <class Rep> Wrench<Rep> wrench_of(const Six& x) { return {x.a, x.b}; }
template <template <class, class> class Kind, class Rep> Six six(const Kind<Rep, double>& x) {
  const auto& [a, b] = x;
  return {a, b};
}

/// What a function of the state is called with.
struct Ask {
  std::vector<double> q = {}, v = {}, a = {}, tau = {}, p = {};
  std::vector<double> dq = {}, dv = {}, da = {}, dtau = {}, w = {};
  Loads<> loads = {};
  Place<> place = 0, base = 0;
  CoriolisForm form = CoriolisForm::christoffel;
};
struct Answer {
  std::vector<double> numbers;
  Solvability solvability;
};

/// A model in the hands of a case.
class Subject {
 public:
  virtual ~Subject() = default;
  /// A function of the catalogue, by name. Numbers pass through the scalar of the case.
  virtual Answer call(std::string_view function, const Ask& ask) = 0;
  /// The same with memory for so many numbers, whether or not that is how many there are.
  virtual Answer call(std::string_view function, const Ask& ask, std::size_t size) = 0;
};
std::unique_ptr<Subject> subject(const Case& c, const Model& model);
/// With a workspace that was made for another model.
std::unique_ptr<Subject> subject(const Case& c, const Model& model, const Model& workspace_of);

std::vector<SE3<>> poses_of(const std::vector<double>& numbers);
std::vector<Six> sixes_of(const std::vector<double>& numbers);
std::vector<Vec3<>> vectors_of(const std::vector<double>& numbers);

/// The state with its numbers rounded to the scalar of a case.
State<double> rounded(const Case& c, const State<double>& state);

}  // namespace axode::test
