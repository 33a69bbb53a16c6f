#include <nanobind/stl/string.h>

#include "axode/table/check_counts.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/bound_model.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/named_tuple.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

nb::object text(std::string_view words) { return nb::str(words.data(), words.size()); }

constexpr std::array<std::string_view, 3> choices{"none", "representation", "recursion"};
constexpr std::array<std::string_view, 5> words_of_counts{"counted", "of_the_tree", "optional", "partly",
                                                          "refused"};

nb::object row_of(const catalog::Words& row) {
  nb::list takes, shape, symbols;
  for (const catalog::Input input : row.takes) takes.append(text(to_string(input)));
  for (const catalog::Extent extent : row.shape) shape.append(text(to_string(extent)));
  for (const std::string_view symbol : row.symbols) symbols.append(text(symbol));
  nb::dict counts;
  for (const auto& [property, count] : catalog::properties) {
    const catalog::Count& each = row.counts.*count;
    counts[text(property)] =
        nb::make_tuple(text(words_of_counts[static_cast<std::size_t>(each.word)]), text(each.sentence));
  }
  return named_tuple("axode.table", "Row", text(row.name), text(row.purpose), text(row.units),
                     nb::tuple(takes), text(choices[static_cast<std::size_t>(row.choice.value)]),
                     catalog::numbers_of(row.entry), nb::tuple(shape), nb::tuple(symbols),
                     text(row.derivative_of), bool(row.may_fail), bool(row.tape), counts);
}

}  // namespace

void add_table(nb::module_& module) {
  nb::list functions;
  for (const catalog::Words& row : catalog::functions_of_state) functions.append(text(row.name));
  module.attr("__all__") = functions;
  module.def(
      "rows",
      [] {
        nb::list rows;
        for (const catalog::Words& row : catalog::functions_of_state) rows.append(row_of(row));
        return rows;
      },
      nb::sig("def rows() -> list[axode.table.Row]"), "The rows of the table of functions, see axode.table.");
  module.def(
      "check_counts",
      [](const BoundModel& m, const std::string& function) {
        const auto check = [&](const auto& rows) {
          for (const auto& row : rows)
            if (row.name == function) catalog::check_counts(row.name, row.counts, *m, catalog::Caller::tape);
        };
        check(catalog::functions_of_state);
        check(catalog::other_functions);
      },
      "m"_a, "function"_a,
      "Raises ValueError if the function of a state, as compiled or traced code, would not count everything "
      "that m has.");
}

}  // namespace axode::python
