#pragma once
#include "axode/eigen.hpp"
#include "quantities.hpp"

/// Answers with a column of six numbers for each velocity, for every frame that the question is about.
namespace axode::command {

/// The frames that the question is about: those it names, or all.
inline std::vector<int> frames_of(const Question& ask) {
  if (!ask.frames.empty()) return ask.frames;
  std::vector<int> all;
  for (int f = 1; f < ask.model.n_frames(); ++f) all.push_back(f);
  return all;
}

/// Six rows with an entry for each column.
template <class Columns> Json rows_of(const Columns& columns) {
  Json rows = Json::array();
  for (int r = 0; r < 6; ++r) rows.push_back(Json::array());
  for (const auto& column : columns) {
    const auto x = to_eigen(column);
    for (int r = 0; r < 6; ++r) rows[r].push_back(x[r]);
  }
  return rows;
}

/// A matrix with a column for each velocity, printed with a row for each velocity.
template <class Columns>
void tabulate(const Model& model, const std::string& frame, const Columns& columns, Table& table) {
  const std::vector<std::string> names = velocity_names(model);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const auto x = to_eigen(columns[c]);
    table.row({c == 0 ? frame : "", names[c], x[0], x[1], x[2], x[3], x[4], x[5]});
  }
  table.rule();
}

/// f(columns, frame) fills nv columns of type Column for every frame asked for.
template <class Column, class F> Answer columns_each(const Question& ask, std::string label, F&& f) {
  Answer answer{std::move(label), Json::object(),
                Table({"frame", "velocity", "w x", "w y", "w z", "v x", "v y", "v z"})};
  std::vector<Column> columns(ask.model.nv());
  for (const int frame : frames_of(ask)) {
    f(columns, frame);
    const std::string& name = ask.model.frame(frame).name;
    answer.value[name] = rows_of(columns);
    tabulate(ask.model, name, columns, answer.table);
  }
  return answer;
}

}  // namespace axode::command
