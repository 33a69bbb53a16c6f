#pragma once
#include <algorithm>
#include <functional>
#include <tuple>

#include "axode/batch.hpp"
#include "axode/catalog.hpp"
#include "axode/kinematics/place.hpp"
#include "states.hpp"

namespace axode::python {

/// What takes the library's place: a function of N states, whose arguments lie one behind the other.
using Instead = std::function<batch::Outcome(const catalog::Given<double>&, std::span<double> out,
                                             const batch::Monitor&)>;

/// What a function of the state is given in Python; what it does not take stays as it is.
struct Arguments {
  ArrayLike q, v = {}, a = {}, tau = {}, p = {};
  ArrayLike dq = {}, dv = {}, da = {}, dtau = {}, w = {};
  Algorithm algorithm = {Representation::body};
  LoadList loads = {};
  bool joint_losses = false;
  Place<> place = 0, base = 0;
  CoriolisForm form = CoriolisForm::christoffel;
  WrenchPoint at = WrenchPoint::body;
  int threads = 1;
  const Instead* instead = nullptr;
};

/// Those that are numbers of a state, and the inputs of a function that they are.
struct ArgumentOfState {
  catalog::Input input;
  ArrayLike Arguments::*argument;
  const char* name() const { return catalog::to_string(input).data(); }
};
inline constexpr ArgumentOfState arguments_of_state[] = {
    {catalog::Input::q, &Arguments::q},       {catalog::Input::v, &Arguments::v},
    {catalog::Input::a, &Arguments::a},       {catalog::Input::tau, &Arguments::tau},
    {catalog::Input::p, &Arguments::p},       {catalog::Input::dq, &Arguments::dq},
    {catalog::Input::dv, &Arguments::dv},     {catalog::Input::da, &Arguments::da},
    {catalog::Input::dtau, &Arguments::dtau}, {catalog::Input::weights, &Arguments::w}};
inline const char* name_of(ArrayLike Arguments::*argument) {
  return std::ranges::find(arguments_of_state, argument, &ArgumentOfState::argument)->name();
}

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
  /// Of a function with several results, as a named tuple of axode.records; of one result where there is no type.
  nb::object named(const char* type, const BoundModel& m, const Arguments& given) const;

 private:
  using Row = catalog::Function<double>;
  NewArray run(const BoundModel& m, const Arguments& given, const Row& row) const;
  const Row& row(const Algorithm& algorithm) const;

  catalog::Id id_;
  std::array<const Row*, 5> rows_;      ///< by representation, and the fast one
  std::vector<ArgumentOfState> takes_;  ///< besides q
};

/// `def name(m, arguments, options) -> a type of axode.records, or an array`.
std::string signature(const char* name, std::initializer_list<const char*> arguments, const char* options,
                      const char* type);
template <ArrayLike Arguments::*> using OneArray = ArrayLike;

/// A docstring with what the row counts, in a line before its example.
std::string documented(const char* name, std::string doc);

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
  /// With a frame.
  void of_q_frame(const char* name, const char* doc) const;
  /// With the recursion to run.
  void of_q_by(const char* name, const char* doc) const;
  /// With loads, and several results in a type of axode.records; nullptr for one result.
  template <ArrayLike Arguments::*... given>
  void of_loaded(const char* name, const char* type, const char* doc) const;
  /// The same without loads.
  template <ArrayLike Arguments::*... given>
  void of(const char* name, const char* type, const char* doc) const;

 private:
  nb::module_& module_;
};

template <ArrayLike Arguments::*... given>
void StateFunctions::of_loaded(const char* name, const char* type, const char* doc) const {
  module_.def(
      name,
      [f = StateFunction(name), type](const BoundModel& m, OneArray<given>... arrays, LoadList loads,
                                      bool joint_losses, int threads) {
        Arguments all{.q = {}, .loads = loads, .joint_losses = joint_losses, .threads = threads};
        ((all.*given = arrays), ...);
        return f.named(type, m, all);
      },
      nb::arg("m"), nb::arg(name_of(given))..., nb::arg("loads") = nb::none(), nb::kw_only(),
      nb::arg("joint_losses") = false, nb::arg("threads") = 1,
      nb::sig(signature(
                  name, {name_of(given)...},
                  "loads: collections.abc.Sequence[axode.Load] | None = None, *, joint_losses: bool = False, "
                  "threads: int = 1",
                  type)
                  .c_str()),
      documented(name, doc).c_str());
}

template <ArrayLike Arguments::*... given>
void StateFunctions::of(const char* name, const char* type, const char* doc) const {
  module_.def(
      name,
      [f = StateFunction(name), type](const BoundModel& m, OneArray<given>... arrays, int threads) {
        Arguments all{.q = {}, .threads = threads};
        ((all.*given = arrays), ...);
        return f.named(type, m, all);
      },
      nb::arg("m"), nb::arg(name_of(given))..., nb::kw_only(), nb::arg("threads") = 1,
      nb::sig(signature(name, {name_of(given)...}, "*, threads: int = 1", type).c_str()),
      documented(name, doc).c_str());
}

}  // namespace axode::python
