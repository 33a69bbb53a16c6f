#pragma once
#include <string>

#include "axode/model/workspace.hpp"
#include "axode/table/functions.hpp"

namespace axode::catalog {

/// What a row counts, in a line for its documentation.
std::string to_string(const Counts& counts);

/// Who calls a function, and therefore what a refusal names.
enum class Way {
  workspace,  ///< C++ with a Workspace, which knows the tree alone
  whole,      ///< whoever counts all that the row counts: C++ with a LoopWorkspace, Python, the command
  tape        ///< a recording, of which generated and specialised code are made; it knows trees alone
};

/// Throws std::invalid_argument where a function, called in this way, would answer for another mechanism than the model: one
/// sentence that says what to call instead.
void check_counts(std::string_view function, const Counts& counts, const Model& model, Way way);
inline void check_counts(const Words& row, const Model& model, Way way) {
  check_counts(row.name, row.counts, model, way);
}
template <OtherId id> void check_counts(const Model& model) {
  constexpr const Other& other = other_functions[id.index];
  check_counts(other.name, other.counts, model, Way::whole);
}

/// The same for a call with a workspace, which costs a comparison. One that was made for the cut tree lets everything through.
template <Id row, class T> void check_counts(const Model& model, const Workspace<T>& workspace) {
  constexpr Word loops = row.words().counts.loops.word;
  static_assert(loops == Word::counted || loops == Word::refused,
                "this row answers for the tree by definition");
  if (!model.loops().empty() && !workspace.is_for_cut_tree()) [[unlikely]]
    check_counts(row.words(), model, Way::workspace);
}

}  // namespace axode::catalog
