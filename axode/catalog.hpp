#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "axode/dynamics/coriolis.hpp"
#include "axode/fast/fast.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// The functions of a state as values: one row for each, with what it is given, what it makes and how it is called. The
/// command and the Python package are made from these rows, and laws that hold for all functions run over them.
namespace axode::catalog {

/// What a function can be given. What it does not take stays as it is.
template <class T> struct Given {
  std::span<const T> q, v, a, tau, p;
  std::span<const T> dq = {}, dv = {}, da = {}, dtau = {};  ///< a direction
  std::span<const T> w = {};                                ///< weights of a result
  Loads<T> loads = {};
  Place<T> place = 0, base = 0;
  CoriolisForm form = CoriolisForm::christoffel;
};
enum class Input { q, v, a, tau, p, dq, dv, da, dtau, weights, loads, place, base, form };
/// Those that are numbers for each coordinate or velocity.
inline constexpr std::array inputs_of_numbers{Input::q,  Input::v,  Input::a,  Input::tau,  Input::p,
                                              Input::dq, Input::dv, Input::da, Input::dtau, Input::weights};
std::string_view to_string(Input input);
/// Where such an input stands.
template <class T> std::span<const T>& numbers(Given<T>& given, Input input);

/// What an entry of a result is: so many numbers, six-vectors angular before linear.
enum class Entry {
  number,    ///< 1
  vector,    ///< 3, in inertial axes
  twist,     ///< 6, as all until momentum
  rate,      ///< of a twist
  wrench,    ///< or the rate of a momentum
  momentum,  ///< 6
  pose,      ///< 12: the columns of R, then r
  inertia,   ///< 10: m, h, Θ (xx yy zz xy xz yz)
};
int numbers_of(Entry entry);

/// Over what the entries of a result run.
enum class Extent { nv, n_bodies, n_joints, n_frames, n_screws, n_parameters, n_loads, six };
std::size_t value_of(Extent extent, const Model& model, std::size_t n_loads);

/// In which representation a result is, or the recursion runs.
enum class Choice {
  none,            ///< in none
  representation,  ///< in one of the four, on which it depends
  recursion,       ///< in any: the recursion runs in one of the four, or where it is quickest
};

enum class Cost { linear, quadratic, cubic };  ///< in the number of velocities, with memory for the result

template <class T> struct Function {
  std::string_view name;     ///< in C++, in Python and in the command
  std::string_view purpose;  ///< what it gives, in a few words
  std::string_view units;    ///< of its numbers
  std::vector<Input> takes;
  Choice choice;
  Entry entry;
  std::vector<Extent> shape;              ///< outermost first
  bool columns;                           ///< whether the entries of the last axis are columns to a reader
  std::vector<std::string_view> symbols;  ///< of the result, or of several of that shape, one after the other
  Cost cost;
  bool allocates;
  /// Calls it. `out` has size() numbers.
  Solvability (*call)(const Model&, Workspace<T>&, const Given<T>&, std::span<T> out);

  bool takes_input(Input input) const;
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
