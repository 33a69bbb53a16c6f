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

/// The interface through which laws call the library. It takes and gives doubles for every representation and
/// scalar type, so that a law is compiled once and not for each of them.
namespace axode::test {

inline constexpr std::array representations{Representation::body, Representation::spatial,
                                            Representation::hybrid, Representation::mixed};

/// The word for a representation: body, spatial, hybrid or mixed.
inline std::string name(Representation representation) { return std::string(word_for(representation)); }

/// The largest difference that two computations of one quantity may have, relative to its largest entry.
template <class T> inline constexpr double agreement = std::same_as<T, double> ? 1e-11 : 1e-3;

/// One way to compute: in a representation or by the fast path, and in one scalar type.
struct Case {
  std::string name;               ///< such as body_double or fast_float
  Representation representation;  ///< the representation of results that have one; body-fixed for the fast
                                  ///< path
  bool fast, single;              ///< whether the fast path is used; whether numbers are floats

  double agreement() const { return single ? test::agreement<float> : test::agreement<double>; }
  friend std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }
};
/// The four representations in double and in float.
const std::vector<Case>& cases();
/// These eight and the fast path in double and in float.
const std::vector<Case>& cases_with_fast();
/// One case for each scalar type. They compute in the hybrid representation, but their names are double and
/// float.
const std::vector<Case>& scalars();
/// The case with the same scalar type in another representation, or by the fast path.
Case in(Representation representation, const Case& c);
Case fast(const Case& c);
/// The same representation or fast path, in double.
Case in_double(const Case& c);
inline std::string name_of(const testing::TestParamInfo<Case>& info) { return info.param.name; }

/// A quantity of six components in some representation, the angular part before the linear one: a twist, a
/// twist rate, a wrench or a momentum.
struct Six {
  Vec3<> a, b;
};
inline Eigen::Matrix<double, 6, 1> to_eigen(const Six& x) {
  return {x.a.x, x.a.y, x.a.z, x.b.x, x.b.y, x.b.z};
}

inline Six operator+(const Six& x, const Six& y) { return {x.a + y.a, x.b + y.b}; }
inline Six operator-(const Six& x, const Six& y) { return {x.a - y.a, x.b - y.b}; }
/// The power of a wrench on a twist in the same representation. A momentum in place of the wrench gives twice
/// the kinetic energy.
inline double operator|(const Six& W, const Six& V) { return dot(W.a, V.a) + dot(W.b, V.b); }

/// The twist, the twist rate, and the wrench or momentum of a body with pose C, changed from one
/// representation into another.
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

/// The arguments of a call; each function reads those that it takes.
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

/// A model whose functions are called in the way of a case. If it has loops, functions count them if their
/// rows say so, and the others are of the cut tree.
class Subject {
 public:
  virtual ~Subject() = default;
  /// Calls a function of the catalogue by its name. Arguments are rounded to the scalar type of the case, and
  /// results are returned as doubles.
  virtual Answer call(std::string_view function, const Ask& ask) = 0;
  /// The same with a result of `size` numbers, even if the function needs another size.
  virtual Answer call(std::string_view function, const Ask& ask, std::size_t size) = 0;
};
std::unique_ptr<Subject> subject(const Case& c, const Model& model);
/// The same with a workspace that was made for the model `workspace_of`.
std::unique_ptr<Subject> subject(const Case& c, const Model& model, const Model& workspace_of);

std::vector<SE3<>> poses_of(const std::vector<double>& numbers);
std::vector<Six> sixes_of(const std::vector<double>& numbers);
std::vector<Vec3<>> vectors_of(const std::vector<double>& numbers);

/// The state after rounding of its numbers to the scalar type of a case.
State<double> rounded(const Case& c, const State<double>& state);

}  // namespace axode::test
