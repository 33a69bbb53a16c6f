#pragma once
#include <algorithm>
#include <functional>

#include "axode/batch.hpp"
#include "axode/catalog.hpp"
#include "axode/kinematics/place.hpp"
#include "python/bindings/states/states.hpp"
#include "python/bindings/support/choice.hpp"

namespace axode::python {

/// A substitute for a function of the library for N states, such as one compiled for the model.
using Instead = std::function<batch::Outcome(const catalog::Arguments<double>&, std::span<double> out,
                                             const batch::Monitor&)>;

/// All arguments that functions of a state, such as inverse_dynamics, can have in Python.
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

/// An array that functions of a state can take, such as q, and the member of Arguments that holds it.
struct ArgumentOfState {
  catalog::Input input;
  ArrayLike Arguments::*argument;
};
inline constexpr ArgumentOfState arguments_of_state[] = {
    {catalog::Input::q, &Arguments::q},       {catalog::Input::v, &Arguments::v},
    {catalog::Input::a, &Arguments::a},       {catalog::Input::tau, &Arguments::tau},
    {catalog::Input::p, &Arguments::p},       {catalog::Input::dq, &Arguments::dq},
    {catalog::Input::dv, &Arguments::dv},     {catalog::Input::da, &Arguments::da},
    {catalog::Input::dtau, &Arguments::dtau}, {catalog::Input::weights, &Arguments::w}};
constexpr ArrayLike Arguments::*argument_of(catalog::Input input) {
  return std::ranges::find(arguments_of_state, input, &ArgumentOfState::input)->argument;
}
inline const char* name_of(catalog::Input input) { return to_string(input).data(); }

/// A function of the table in axode/catalog.hpp, such as inverse_dynamics, for one or several states.
class StateFunction {
 public:
  explicit StateFunction(const char* name);
  /// Calls the function and returns its result. Throws nb::value_error for a wrong argument, SingularError if
  /// a state cannot be computed (for example, because the mass matrix is singular), and NotFiniteError if
  /// numbers overflow; the latter two contain the result.
  Array operator()(const BoundModel& m, const Arguments& given) const;
  /// Calls the function, and returns entries such as the columns of Jacobians as rows.
  Array in_rows(const BoundModel& m, const Arguments& given) const;
  /// Calls the function, and returns its result as an array, or several results as a named tuple.
  nb::object all(const BoundModel& m, const Arguments& given) const;

 private:
  using Row = catalog::Function<double>;
  NewArray run(const BoundModel& m, const Arguments& given, const Row& row) const;
  const Row& row(const Algorithm& algorithm) const;

  catalog::Id id_;
  std::array<const Row*, 5> rows_;      ///< the row for each representation, and the row for Fast
  std::vector<ArgumentOfState> takes_;  ///< the arguments that the function takes in addition to q
};

/// The name of the type in axode.records that Python code gets for the results of a function. It is empty if
/// the function has one result, and "tuple" if it has several that are not derivatives.
std::string record_of(const catalog::Words& row);

/// The Python signature of a function in axode/catalog.hpp: `def name(self, arguments, options) -> result`.
std::string signature(const catalog::Words& row, const char* self, const std::string& options);

/// The docstring of a function with a line on the parts of a mechanism (such as loops) that it allows.
std::string documented(const char* name, std::string doc);

/// The type of the parameter in Python for an input other than loads.
template <catalog::Input input>
using Parameter =
    std::conditional_t<catalog::is_of_numbers(input), ArrayLike,
                       std::conditional_t<input == catalog::Input::form, CoriolisForm, FrameName>>;
template <catalog::Input input> auto parameter() {
  if constexpr (input == catalog::Input::form)
    return nb::arg(name_of(input)) = Words<CoriolisForm>::words.back().data();
  else
    return nb::arg(name_of(input));
}
/// The inputs of a row that are parameters without a keyword in Python, in their order; loads are apart.
inline constexpr auto parameters_of = [](const catalog::Words& row) {
  catalog::List<catalog::Input, 8> all;
  for (const catalog::Input input : row.takes)
    if (input != catalog::Input::loads && input != catalog::Input::at) all.add(input);
  return all;
};

/// The type Type: for an index sequence n, `Each<Type, n>...` is a list of as many types.
template <class Type, std::size_t> using Each = Type;
template <std::size_t, class Value> auto argument(const char* name, Value&& value) {
  return nb::arg(name) = std::forward<Value>(value);
}
template <std::size_t n> using Times = std::make_index_sequence<n>;

/// Defines functions in Python with the arguments, options and results that axode/catalog.hpp lists.
class StateFunctions {
 public:
  explicit StateFunctions(nb::module_& module) : module_(module) {}

  template <catalog::Id id> void define(const char* doc) const;

 private:
  nb::module_& module_;
};

template <catalog::Id id> void StateFunctions::define(const char* doc) const {
  using catalog::Input, catalog::Choice;
  constexpr const catalog::Words& row = id.words();
  constexpr bool about_a_frame = row.takes_input(Input::place), in_a_base = row.takes_input(Input::base);
  constexpr bool takes_loads = row.takes_input(Input::loads);
  // The loads are before the representation if the function is about them.
  constexpr bool loads_first = takes_loads && id == catalog::Id("generalized_loads");
  using Way = std::conditional_t<row.choice == Choice::recursion, Algorithm, Representation>;
  const char* const name = row.name.data();
  const char* const first_way = Words<Way>::words[0].data();
  const std::string loads = "loads: collections.abc.Sequence[axode.Load] | None = None, ";
  std::string options = loads_first ? loads : "";
  if (row.choice != Choice::none)
    options += "representation: " + std::string(Words<Way>::name.text) + " = '" + first_way + "', ";
  if (takes_loads && !loads_first) options += loads;
  options += "*, ";
  if (takes_loads) options += "joint_losses: bool = False, ";
  if (about_a_frame) options += "offset: numpy.typing.ArrayLike | None = None, ";
  if (in_a_base) options += "base_offset: numpy.typing.ArrayLike | None = None, ";
  options += "threads: int = 1";
  [&]<std::size_t... t, std::size_t... f, std::size_t... b, std::size_t... l, std::size_t... first,
      std::size_t... last, std::size_t... w>(std::index_sequence<t...>, std::index_sequence<f...>,
                                             std::index_sequence<b...>, std::index_sequence<l...>,
                                             std::index_sequence<first...>, std::index_sequence<last...>,
                                             std::index_sequence<w...>) {
    module_.def(
        name,
        [function = StateFunction(name)](
            const BoundModel& m, Parameter<parameters_of(id.words())[t]>... taken,
            Each<LoadList, first>... loads_before, Each<Way, w>... way, Each<LoadList, last>... loads_behind,
            Each<bool, l>... joint_losses, Each<ArrayLike, f>... offset, Each<ArrayLike, b>... base_offset,
            int threads) {
          Arguments given{.q = {}, .threads = threads};
          FrameName frame, base;
          const auto take = [&]<class X>(Input input, const X& x) {
            if constexpr (std::same_as<X, ArrayLike>)
              given.*argument_of(input) = x;
            else if constexpr (std::same_as<X, CoriolisForm>)
              given.form = x;
            else
              (input == Input::place ? frame : base) = x;
          };
          (take(parameters_of(id.words())[t], taken), ...);
          ((given.place = place(m, frame, offset)), ...);
          ((given.base = place(m, base, base_offset, "base")), ...);
          ((given.loads = loads_before), ...);
          ((given.loads = loads_behind), ...);
          ((given.joint_losses = joint_losses), ...);
          ((given.algorithm = {way}), ...);
          return function.all(m, given);
        },
        nb::arg("m"), parameter<parameters_of(row)[t]>()..., argument<first>("loads", nb::none())...,
        argument<w>("representation", first_way)..., argument<last>("loads", nb::none())..., nb::kw_only(),
        argument<l>("joint_losses", false)..., argument<f>("offset", nb::none())...,
        argument<b>("base_offset", nb::none())..., nb::arg("threads") = 1,
        nb::sig(signature(row, "m: Model", options).c_str()), documented(name, doc).c_str());
  }
  (Times<parameters_of(row).size()>(), Times<about_a_frame>(), Times<in_a_base>(), Times<takes_loads>(),
   Times<loads_first>(), Times < takes_loads && !loads_first > (), Times<row.choice != Choice::none>());
}

}  // namespace axode::python
