#pragma once
#include <optional>
#include <string>
#include <vector>

#include "axode/batch/check_states.hpp"
#include "axode/catalog.hpp"
#include "axode/model/finite.hpp"

namespace axode::batch {

/// Checked arguments and results of one function in N states, and for each state whether its mass matrix
/// could be inverted. If a kernel reports that the mass matrix of a state may be singular, this state is
/// computed again by the function for one state, which decides whether it is singular.
template <class S> class StatesOfRow {
 public:
  enum Verdict : unsigned char { solved, maybe_singular, singular, not_finite };

  /// Throws std::invalid_argument for wrong sizes, threads < 1, and results that overlap an argument.
  StatesOfRow(const Model& model, const catalog::Function<S>& row, const catalog::Arguments<S>& given,
              std::span<S> out, int threads)
      : model_(model),
        row_(row),
        given_(given),
        out_(out),
        count_(check_states(model, given.q, threads)),
        size_(row.size(model, 0)) {
    for (const catalog::Input input : row.numbers())
      if (input != catalog::Input::q)
        check_size(name_of(input), catalog::numbers(given_, input).size(), length(input) * count_, "nv N");
    const std::size_t entry = catalog::numbers_of(row.entry);
    if (out.size() != size_ * count_)
      check_size(result_name(), out.size() / entry, size_ / entry * count_, meaning().c_str());
    for (const catalog::Input input : row.numbers())
      check_separate(result_name(), out, name_of(input), catalog::numbers(given_, input));
    if (row.may_fail && count_ > 1) verdicts_.resize(count_);
  }

  const Model& model() const { return model_; }
  const catalog::Function<S>& row() const { return row_; }
  std::size_t count() const { return count_; }
  /// length() is the number of numbers of an argument for one state, and size() that of the result.
  std::size_t length(catalog::Input input) const {
    return static_cast<std::size_t>(input == catalog::Input::q ? model_.nq() : model_.nv());
  }
  std::size_t size() const { return size_; }

  std::span<const S> argument(catalog::Input input, std::size_t first, std::size_t states) const {
    const std::size_t n = length(input);
    return catalog::numbers(given_, input).subspan(first * n, states * n);
  }
  std::span<S> result(std::size_t first, std::size_t states) const {
    return out_.subspan(first * size_, states * size_);
  }
  /// The verdicts on the states, beginning with state `first`; null if the function cannot fail.
  unsigned char* verdicts(std::size_t first) {
    if (!row_.may_fail) return nullptr;
    return verdicts_.empty() ? &only_verdict_ : &verdicts_[first];
  }

  /// Completes the results of `states` states, from state `first` on. States whose mass matrix may be
  /// singular are computed again with the function for one state, and the results of all other states are
  /// checked to be finite.
  void settle(std::optional<Workspace<S>>& workspace, std::size_t first, std::size_t states) {
    if (!row_.may_fail) return;
    for (std::size_t k = first; k < first + states; ++k) {
      unsigned char& verdict = *verdicts(k);
      if (verdict == solved) {
        if (!finite(result(k, 1))) verdict = not_finite;
      } else {
        if (!workspace) workspace.emplace(model_);
        verdict = call_one(*workspace, k).ok() ? solved : singular;
      }
    }
  }
  /// Calls the library's function for one state, state k.
  Solvability call_one(Workspace<S>& workspace, std::size_t k) const {
    catalog::Arguments<S> one;
    for (const catalog::Input input : row_.numbers()) catalog::numbers(one, input) = argument(input, k, 1);
    one.place = given_.place;
    return row_.call(model_, workspace, one, result(k, 1));
  }

  Outcome outcome(std::size_t done) {
    Outcome outcome{.done = done};
    if (!row_.may_fail) return outcome;
    for (std::size_t k = 0; k < done; ++k)
      if (*verdicts(k) != solved && outcome.singular_states++ == 0) outcome.first = k;
    if (outcome.ok()) return outcome;
    outcome.solvability.not_finite = true;
    if (*verdicts(outcome.first) == singular) {
      Workspace<S> workspace(model_);
      outcome.solvability = call_one(workspace, outcome.first);
    }
    return outcome;
  }

 private:
  static const char* name_of(catalog::Input input) { return catalog::to_string(input).data(); }
  const char* result_name() const { return row_.together.data(); }
  /// The number of entries of the result as text, such as "3 nv nv N".
  std::string meaning() const {
    const std::size_t several = row_.symbols.size();
    std::string text = several == 1 ? "" : std::to_string(several) + ' ';
    for (const catalog::Extent extent : row_.shape) text += std::string(catalog::to_string(extent)) + ' ';
    return text + 'N';
  }

  const Model& model_;
  const catalog::Function<S>& row_;
  const catalog::Arguments<S> given_;
  std::span<S> out_;
  std::size_t count_, size_;
  std::vector<unsigned char> verdicts_;  ///< empty for a single state
  unsigned char only_verdict_ = solved;
};

}  // namespace axode::batch
