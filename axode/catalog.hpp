#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "axode/constraints/loops.hpp"
#include "axode/dynamics/closed_form/coriolis.hpp"
#include "axode/dynamics/joint_wrenches.hpp"
#include "axode/fast/fast.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"
#include "axode/table/check_counts.hpp"

/// The catalogue: a table with a row for each function of a state, such as inverse_dynamics. A row describes
/// the arguments and the results of the function and has pointers by which it is called.
namespace axode::catalog {

/// All arguments that a function of the catalogue can have. A function reads only the arguments of its row.
template <class T> struct Arguments {
  std::span<const T> q, v, a, tau, p;
  std::span<const T> dq = {}, dv = {}, da = {}, dtau = {};  ///< direction of a directional derivative
  std::span<const T> w = {};                                ///< weights of the results (gradients, Hessians)
  Loads<T> loads = {};
  Place<T> place = 0, base = 0;
  CoriolisForm form = CoriolisForm::christoffel;
  WrenchPoint at = WrenchPoint::body;
};
/// The member of Arguments that holds the numbers of an input.
template <class T> constexpr std::span<const T> Arguments<T>::*member_of(Input input) {
  switch (input) {
    case Input::q: return &Arguments<T>::q;
    case Input::v: return &Arguments<T>::v;
    case Input::a: return &Arguments<T>::a;
    case Input::tau: return &Arguments<T>::tau;
    case Input::p: return &Arguments<T>::p;
    case Input::dq: return &Arguments<T>::dq;
    case Input::dv: return &Arguments<T>::dv;
    case Input::da: return &Arguments<T>::da;
    case Input::dtau: return &Arguments<T>::dtau;
    default: return &Arguments<T>::w;
  }
}
template <class T> std::span<const T>& numbers(Arguments<T>& given, Input input) {
  return given.*member_of<T>(input);
}
template <class T> const std::span<const T>& numbers(const Arguments<T>& given, Input input) {
  return given.*member_of<T>(input);
}

/// A span of entries such as screws or poses as a span of their numbers, in the same memory.
template <class T, class E> std::span<T> as_numbers(std::span<E> entries) {
  static_assert(sizeof(E) % sizeof(T) == 0);
  return {reinterpret_cast<T*>(entries.data()), entries.size() * (sizeof(E) / sizeof(T))};
}

/// A row of the catalogue together with the C++ function that computes it.
template <class T> struct Function : Words {
  /// Calls the function for one state; `out` receives size() numbers.
  Solvability (*call)(const Model&, Workspace<T>&, const Arguments<T>&, std::span<T> out);
  /// Calls the function for a mechanism with loops; null unless the function takes loops into account.
  Solvability (*call_with_loops)(const Model&, LoopWorkspace<T>&, const Arguments<T>&, std::span<T> out);

  /// The number of numbers in the result if n_loads wrenches act.
  std::size_t size(const Model& model, std::size_t n_loads) const;
};

/// The catalogue: a row for each function of a state, such as inverse_dynamics, with its arguments, its
/// results and pointers by which it is called. Rep is the representation of twists and wrenches (BodyFixed,
/// Spatial, Hybrid or Mixed) in the results or, for a result that does not depend on it, in the recursion.
/// Rep can also be Fast, for the fastest recursion; the rows are then only those of functions that have a
/// fast recursion.
template <RecursionChoice Rep, class T = double> std::span<const Function<T>> functions();
/// The row of a function in the catalogue, or nullptr if no function has this name.
template <RecursionChoice Rep, class T = double> const Function<T>* find(std::string_view name);

/// The name in this library of a function that other libraries, or earlier versions of this one, call
/// `theirs`; for example `mass_matrix` for `crba`. Empty if there is none.
std::string_view name_here(std::string_view theirs);

}  // namespace axode::catalog
