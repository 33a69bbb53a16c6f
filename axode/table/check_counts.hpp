#pragma once
#include <string>

#include "axode/model/workspace.hpp"
#include "axode/table/other_functions.hpp"

namespace axode::catalog {

/// A sentence on the properties of mechanisms, such as loops, that a function takes into account or refuses.
std::string to_string(const Counts& counts);

/// How a function is called, which decides whether it can take properties such as loops into account.
enum class Caller {
  workspace,  ///< C++ with a Workspace, which has the spanning tree only
  /// A call with all properties of the model: in C++ with a LoopWorkspace, in Python, or by the command.
  whole,
  tape  ///< recording for generated and specialised code, of the spanning tree only
};

/// Throws std::invalid_argument if the result of the function would be wrong because the model has a
/// property, such as loops, that this way to call the function does not take into account. A call with a
/// Workspace, for example, computes with the spanning tree only. The message says what to call instead.
void check_counts(std::string_view function, const Counts& counts, const Model& model, Caller caller);
inline void check_counts(const Words& row, const Model& model, Caller caller) {
  check_counts(row.name, row.counts, model, caller);
}
template <OtherId id> void check_counts(const Model& model, Caller caller = Caller::whole) {
  constexpr const Other& other = other_functions[id.index];
  check_counts(other.name, other.counts, model, caller);
}

/// Checks a call with a Workspace. Throws std::invalid_argument if the model has loops or prescribed motions
/// that would change the result, unless the workspace was made for the spanning tree (CutTree). It costs two
/// comparisons.
template <Id row, class T> void check_counts(const Model& model, const Workspace<T>& workspace) {
  constexpr const Counts& counts = row.words().counts;
  constexpr bool motions = counts.motions.word == Word::refused;
  static_assert(counts.drives.word != Word::refused && counts.plays.word != Word::refused,
                "functions of a state take the forces of drives, and plays are free in them");
  if constexpr (motions || counts.loops.word != Word::of_the_tree)
    if ((!model.loops().empty() || (motions && !model.motions().empty())) && !workspace.is_for_cut_tree())
        [[unlikely]]
      check_counts(row.words(), model, Caller::workspace);
}
/// The check for a LoopWorkspace: throws if the model has prescribed motions and the function refuses them.
template <Id row> void check_motions(const Model& model) {
  if constexpr (row.words().counts.motions.word == Word::refused)
    if (!model.motions().empty()) [[unlikely]]
      check_counts(row.words(), model, Caller::whole);
}

inline std::size_t value_of(Extent extent, const Model& model, std::size_t n_loads) {
  const auto size = [](int n) { return static_cast<std::size_t>(n); };
  switch (extent) {
    case Extent::nv: return size(model.nv());
    case Extent::n_bodies:
    case Extent::n_joints: return size(model.n_bodies());
    case Extent::n_frames: return size(model.n_frames());
    case Extent::n_screws: return size(model.n_screws());
    case Extent::n_parameters: return 10 * size(model.n_bodies());
    case Extent::n_loads: return n_loads;
    case Extent::six: break;
  }
  return 6;
}
/// The count of numbers in one result of a row; a row can have several results.
inline std::size_t numbers_of(const Words& row, const Model& model, std::size_t n_loads) {
  std::size_t n = static_cast<std::size_t>(numbers_of(row.entry));
  for (const Extent extent : row.shape) n *= value_of(extent, model, n_loads);
  return n;
}

/// These functions throw std::invalid_argument. The message of refuse_input() says that an input has `size`
/// entries, and how many it must have. The message of refuse_result() says that a result has `size` entries,
/// of `width` numbers each, and how many entries it must have. The message of refuse_shared() says that a
/// result shares memory with `with`, the name of an argument or of another result.
[[noreturn]] void refuse_input(Input input, std::size_t size, const Model& model);
[[noreturn]] void refuse_result(const Words& row, std::size_t result, std::size_t size, std::size_t width,
                                const Model& model, std::size_t n_loads);
[[noreturn]] void refuse_shared(const Words& row, std::size_t result, std::string_view with);

}  // namespace axode::catalog
