#pragma once
#include <optional>
#include <utility>

#include "axode/table/families.hpp"

/// The table of functions of a state, which depend on q, v and other numbers at one time: their arguments,
/// results and costs, and which properties of mechanisms they take into account.
namespace axode::catalog {
namespace table {

using enum Input;
using enum Entry;
using enum Extent;
using enum Choice;
using enum Cost;
using enum Memory;

inline constexpr std::string_view screws = "rad/s, m/s", rates = "rad/s^2, m/s^2", wrenches = "N m, N",
                                  impulses = "N m s, N s", forces = "N m for angles, N for lengths",
                                  inertias = "kg m^2, kg m, kg";

}  // namespace table

/// All functions of a state, in the order of the documentation.
inline constexpr auto functions_of_state = [] {
  using namespace table;
  return std::to_array<Words>({
#define AXODE_ROW(function, ...) {.name = #function, __VA_ARGS__},
#include "axode/table/rows.hpp"
  });
}();

/// The index of a function in functions_of_state, found by name at compile time.
struct Id {
  std::size_t index = 0;
  consteval Id(const char* name) {  // NOLINT(google-explicit-constructor): a name converts to an Id
    while (index < functions_of_state.size() && functions_of_state[index].name != name) ++index;
    if (index == functions_of_state.size()) throw "no row has this name";
  }
  /// The row of a name that is known at run time; the result is empty if no row has this name.
  static constexpr std::optional<Id> of(std::string_view name) {
    Id found("poses");
    for (found.index = 0; found.index < functions_of_state.size(); ++found.index)
      if (functions_of_state[found.index].name == name) return found;
    return {};
  }
  constexpr const Words& words() const { return functions_of_state[index]; }
  constexpr bool operator==(const Id&) const = default;
};

/// Calls f.operator()<id>() for the id of every row, in the order of the table.
template <class F> constexpr void each_row(const F& f) {
  constexpr auto number = []<std::size_t index> {
    Id id("poses");
    id.index = index;
    return id;
  };
  [&]<std::size_t... k>(std::index_sequence<k...>) {
    (f.template operator()<number.template operator()<k>()>(), ...);
  }
  (std::make_index_sequence<functions_of_state.size()>());
}

}  // namespace axode::catalog
