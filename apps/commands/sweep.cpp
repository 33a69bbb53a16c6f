#include <fmt/format.h>

#include <cmath>

#include "apps/files/csv_file.hpp"
#include "apps/files/state.hpp"
#include "apps/files/text_file.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/table.hpp"
#include "axode/model/configuration.hpp"

namespace axode::command {
namespace {

using Cells = std::vector<std::string>;

/// The entry of a State that receives the numbers of a column of a CSV file.
struct Column {
  std::vector<double> State::*member = nullptr;  ///< the vector of the state; null for the time and for an
                                                 ///< ignored column
  std::size_t place = 0;
};

class SweepReader {
 public:
  SweepReader(const Model& model, std::string file) : model_(model), file_(std::move(file)) {
    const auto add = [&](const char* what, std::vector<double> State::*member,
                         const std::vector<std::string>& names) {
      for (std::size_t k = 0; k < names.size(); ++k) known_.push_back({what + names[k], {member, k}});
    };
    known_.push_back({"t", {}});
    const std::vector<std::string> velocities = velocity_names(model);
    add("q ", &State::q, coordinate_names(model));
    add("v ", &State::v, velocities);
    add("a ", &State::a, velocities);
    add("jerk ", &State::jerk, velocities);
    add("snap ", &State::snap, velocities);
    add("tau ", &State::tau, velocities);
    known_.push_back({"energy", {}});
  }

  Sweep read() {
    std::vector<Cells> rows;
    for_rows_of_csv(file_, [&](std::size_t, const Cells& cells) { rows.push_back(cells); });
    if (rows.size() < 2)
      throw InputError(file_ + ": expected a line with the names of columns, and states below it");
    const std::vector<Column> columns = columns_of(rows[0]);
    const auto timed = std::ranges::find(rows[0], "t");
    Sweep sweep{{}, {}, timed != rows[0].end()};
    for (std::size_t i = 1; i < rows.size(); ++i) {
      State state = neutral_state(model_);
      const std::vector<double> numbers = numbers_of(rows, i);
      for (std::size_t k = 0; k < columns.size(); ++k)
        if (columns[k].member != nullptr) (state.*columns[k].member)[columns[k].place] = numbers[k];
      try {
        check_configuration(model_, state.q);
      } catch (const std::invalid_argument& off) {
        fault(i, off.what());
      }
      if (!faults_.empty()) throw InputError(std::move(faults_));
      sweep.states.push_back(std::move(state));
      sweep.t.push_back(sweep.timed ? numbers[static_cast<std::size_t>(timed - rows[0].begin())]
                                    : static_cast<double>(i - 1));
    }
    return sweep;
  }

 private:
  void fault(std::size_t row, const std::string& sentence) {
    faults_.push_back(fmt::format("{}: state {}: {}", file_, row - 1, sentence));
  }

  std::vector<Column> columns_of(const Cells& names) {
    std::vector<Column> columns;
    const auto name_of = [](const auto& known) { return known.first; };
    for (std::size_t k = 0; k < names.size(); ++k) {
      const auto found = std::ranges::find(known_, names[k], name_of);
      if (found == known_.end()) {
        faults_.push_back(fmt::format(
            "{}: the column \"{}\" has no meaning here; columns are t, and q, v, a, jerk, snap and tau, "
            "each followed by a name{}",
            file_, names[k], did_you_mean(names[k], known_, name_of)));
      } else if (std::ranges::count(names, names[k]) > 1 &&
                 std::ranges::find(names, names[k]) == names.begin() + static_cast<std::ptrdiff_t>(k)) {
        faults_.push_back(fmt::format("{}: the column \"{}\" is given more than once", file_, names[k]));
      } else {
        columns.push_back(found->second);
      }
    }
    if (!faults_.empty()) throw InputError(std::move(faults_));
    return columns;
  }

  std::vector<double> numbers_of(const std::vector<Cells>& rows, std::size_t i) {
    std::vector<double> numbers(rows[0].size());
    if (rows[i].size() != numbers.size()) {
      fault(i, fmt::format("has {}, and there are {} columns", counted(rows[i].size(), "number"),
                           numbers.size()));
      throw InputError(std::move(faults_));
    }
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      numbers[k] = number_in(rows[i][k]).value_or(NAN);
      if (!std::isfinite(numbers[k]))
        fault(i, fmt::format("{} is \"{}\", which is not a finite number", rows[0][k], rows[i][k]));
    }
    return numbers;
  }

  const Model& model_;
  std::string file_;
  std::vector<std::pair<std::string, Column>> known_;
  std::vector<std::string> faults_;
};

}  // namespace

Sweep read_sweep(const Model& model, const std::string& file) { return SweepReader(model, file).read(); }

}  // namespace axode::command
