#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "axode/constraints/loops.hpp"
#include "axode/dynamics/coriolis.hpp"
#include "axode/dynamics/joint_wrenches.hpp"
#include "axode/fast/fast.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"
#include "axode/table/check_counts.hpp"

/// The functions of a state as values: one row for each, with what it is given, what it makes and how it is called. The
/// command and the Python package are made from these rows, and laws that hold for all functions run over them.
namespace axode::catalog {

/// What a function can be given. What it does not take stays as it is.
template <class T> struct Arguments {
  std::span<const T> q, v, a, tau, p;
  std::span<const T> dq = {}, dv = {}, da = {}, dtau = {};  ///< a direction
  std::span<const T> w = {};                                ///< weights of a result
  Loads<T> loads = {};
  Place<T> place = 0, base = 0;
  CoriolisForm form = CoriolisForm::christoffel;
  WrenchPoint at = WrenchPoint::body;
};
/// Where an input of numbers stands.
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

/// Entries as the numbers that they consist of.
template <class T, class E> std::span<T> as_numbers(std::span<E> entries) {
  static_assert(sizeof(E) % sizeof(T) == 0);
  return {reinterpret_cast<T*>(entries.data()), entries.size() * (sizeof(E) / sizeof(T))};
}

/// A row, and how the function is called.
template <class T> struct Function : Words {
  /// Calls it. `out` has size() numbers.
  Solvability (*call)(const Model&, Workspace<T>&, const Arguments<T>&, std::span<T> out);
  /// Calls it for a mechanism with loops; null unless these are counted.
  Solvability (*call_with_loops)(const Model&, LoopWorkspace<T>&, const Arguments<T>&, std::span<T> out);

  /// How many numbers it makes.
  std::size_t size(const Model& model, std::size_t n_loads) const;
};

/// All functions, in the order of the documentation, with results in Rep or by the recursion in Rep; of functions to
/// which Rep means nothing the same row stands in every table. For Fast only those that have such a recursion, or none.
template <RecursionChoice Rep, class T = double> std::span<const Function<T>> functions();
/// The row of that name, or nullptr.
template <RecursionChoice Rep, class T = double> const Function<T>* find(std::string_view name);

/// The name here of what other libraries call so (`crba` is `mass_matrix`), or nothing.
std::string_view name_here(std::string_view theirs);

}  // namespace axode::catalog
