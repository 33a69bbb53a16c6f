#pragma once
#include <utility>

#include "axode/kinematics/check_arguments.hpp"
#include "axode/table/check_counts.hpp"

/// Checks of the arguments of a public function by its description in the table of functions (axode/table).
namespace axode {
namespace detail {

/// The memory of an argument or of a result.
template <class T> struct Piece {
  const std::byte *begin, *end;
  std::size_t size;       ///< number of entries
  std::size_t width = 1;  ///< number of numbers in each entry

  template <class E>
  explicit Piece(std::span<E> x)
      : begin(reinterpret_cast<const std::byte*>(x.data())),
        end(begin + x.size_bytes()),
        size(x.size()),
        width(sizeof(E) / sizeof(T)) {}
  explicit Piece(const NumberSpan<T>& x) : Piece(std::span<const T>(x)) {}
  explicit Piece(const Loads<T>& loads) : Piece(loads.wrenches) {}
  std::span<const T> numbers() const { return {reinterpret_cast<const T*>(begin), size}; }
  bool overlaps(const Piece& other) const { return begin < other.end && other.begin < end; }
};

/// The inputs of a public function that are checked at each call: the arrays of numbers such as q and v, in
/// the order of the function's parameters, and then the loads, if it takes loads. `id` is the name of the
/// function in the table of functions (axode/table), which describes the arguments and results of functions.
template <catalog::Id id>
inline constexpr auto checked_inputs = [] {
  auto inputs = id.words().numbers();
  if (id.words().takes_input(catalog::Input::loads)) inputs.add(catalog::Input::loads);
  return inputs;
}();

/// Checks argument or result k of a call of the public function whose name in the table of functions
/// (axode/table) is `id`. An input must have the right size, and a configuration q must have unit
/// quaternions. A result must have the right size, and must share no memory with results before it or, if
/// the table requires it, with an input. Throws std::invalid_argument.
template <catalog::Id id, std::size_t k, class T>
void check_piece(const Model& model, const Piece<T>* pieces, std::size_t n_loads) {
  constexpr const catalog::Words& row = id.words();
  constexpr const auto& inputs = checked_inputs<id>;
  const Piece<T>& x = pieces[k];
  if constexpr (k >= inputs.size()) {
    constexpr std::size_t result = k - inputs.size();
    if (x.size * x.width != catalog::numbers_of(row, model, n_loads)) [[unlikely]]
      catalog::refuse_result(row, result, x.size, x.width, model, n_loads);
    for (std::size_t j = row.memory == catalog::Memory::own ? 0 : inputs.size(); j < k; ++j)
      if (x.overlaps(pieces[j])) [[unlikely]]
        catalog::refuse_shared(row, result,
                               j < inputs.size() ? to_string(inputs[j]) : row.symbols[j - inputs.size()]);
  } else if constexpr (inputs[k] == catalog::Input::q) {
    check_configuration(model, x.numbers());
  } else if constexpr (inputs[k] != catalog::Input::loads) {
    if (x.size != static_cast<std::size_t>(model.nv())) [[unlikely]]
      catalog::refuse_input(inputs[k], x.size, model);
  }
}

}  // namespace detail

/// Checks all arguments of a call of a public function against its description in the table of functions
/// (axode/table), where its name is `id`, and returns the memory of the workspace, from which the function
/// takes its scratch memory. The arguments are the model, the workspace, the inputs (numbers and loads) and
/// the results. Results may not share memory with each other, nor with the inputs if the table says so.
/// Throws std::invalid_argument with the name and the value of the argument and the rule that is broken.
template <catalog::Id id, class T, class... Given>
[[gnu::always_inline]] inline Arena checked(const Model& model, Workspace<T>& workspace,
                                            const Given&... given) {
  constexpr std::size_t results = sizeof...(Given) - detail::checked_inputs<id>.size();
  static_assert(results == 0 || results == id.words().symbols.size(), "a row names all of its results");
  catalog::check_counts<id>(model, workspace);
  workspace.check(model);
  std::size_t n_loads = 0;
  const auto check_if_loads = [&](const auto& x) {
    if constexpr (requires { x.wrenches; }) {
      check_loads(model, x, id.words().counts.joint_losses.word != catalog::Word::partly);
      n_loads = x.wrenches.size();
    }
  };
  (check_if_loads(given), ...);
  const detail::Piece<T> pieces[]{detail::Piece<T>(given)...};
  [&]<std::size_t... k>(std::index_sequence<k...>) {
    (detail::check_piece<id, k>(model, pieces, n_loads), ...);
  }
  (std::make_index_sequence<sizeof...(Given)>());
  return workspace.arena(model.topology());
}

}  // namespace axode
