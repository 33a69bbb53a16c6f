#pragma once
#include <tuple>

#include "axode/batch.hpp"
#include "axode/catalog.hpp"
#include "axode/kinematics/place.hpp"
#include "states.hpp"

namespace axode::python {

/// What a function of the state is given in Python; what it does not take stays as it is.
struct Arguments {
  ArrayLike q, v = {}, a = {}, tau = {}, p = {};
  ArrayLike dq = {}, dv = {}, da = {}, dtau = {}, w = {};
  Algorithm algorithm = {Representation::body};
  LoadList loads = {};
  bool joint_losses = false;
  Place<> place = 0, base = 0;
  CoriolisForm form = CoriolisForm::christoffel;
  int threads = 1;
};

/// A function of the catalogue for one state or N of them, in SIMD lanes where the library can.
class StateFunction {
 public:
  explicit StateFunction(const char* name);
  /// Throws nb::value_error for what is wrong with an argument, SingularError for states that cannot be solved and
  /// NotFiniteError for those whose numbers overflow, both with the result.
  Array operator()(const BoundModel& m, const Arguments& given) const;
  /// With entries in rows, also where they are the columns of a matrix.
  Array in_rows(const BoundModel& m, const Arguments& given) const;
  /// Of a function with two results.
  std::tuple<Array, Array> both(const BoundModel& m, const Arguments& given) const;
  /// Of a function with several results, as a named tuple of axode.records.
  nb::object named(const char* type, const BoundModel& m, const Arguments& given) const;

 private:
  using Row = catalog::Function<double>;
  /// The same for N states at once: all of one argument lie one behind the other.
  using InLanes = batch::Outcome (*)(const Model&, const catalog::Given<double>&, std::span<double> out,
                                     int threads, const batch::Monitor&);
  static InLanes in_lanes(std::string_view name);
  NewArray run(const BoundModel& m, const Arguments& given, const Row& row) const;
  const Row& row(const Algorithm& algorithm) const;

  std::array<const Row*, 5> rows_;  ///< by representation, and the fast one
  InLanes in_lanes_;
  bool takes_v_, takes_a_, takes_tau_, takes_p_;
  std::vector<std::pair<catalog::Input, ArrayLike Arguments::*>> directions_;  ///< and weights, that it takes
};

/// Defines functions by what they are given.
class StateFunctions {
 public:
  explicit StateFunctions(nb::module_& module) : module_(module) {}

  void of_q(const char* name, const char* doc) const;
  void of_q_v(const char* name, const char* doc) const;
  void of_q_p(const char* name, const char* doc) const;
  void of_q_v_a(const char* name, const char* doc) const;
  /// With the representation of the result.
  void of_q_v_in(const char* name, const char* doc) const;
  void of_q_v_a_in(const char* name, const char* doc) const;
  /// With the frame that the result is about, and its representation.
  void of_q_at(const char* name, const char* doc) const;
  void of_q_v_at(const char* name, const char* doc) const;
  /// With the recursion to run.
  void of_q_by(const char* name, const char* doc) const;

 private:
  nb::module_& module_;
};

}  // namespace axode::python
