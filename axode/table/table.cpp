#include "axode/table/check_counts.hpp"

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <string>

namespace axode::catalog {

std::string_view to_string(Extent extent) {
  switch (extent) {
    case Extent::nv: return "nv";
    case Extent::n_bodies: return "n_bodies";
    case Extent::n_joints: return "n_joints";
    case Extent::n_frames: return "n_frames";
    case Extent::n_screws: return "n_screws";
    case Extent::n_parameters: return "n_parameters";
    case Extent::n_loads: return "n_loads";
    case Extent::six: break;
  }
  return "6";
}

std::string_view to_string(Input input) {
  switch (input) {
    case Input::q: return "q";
    case Input::v: return "v";
    case Input::a: return "a";
    case Input::tau: return "tau";
    case Input::p: return "p";
    case Input::dq: return "dq";
    case Input::dv: return "dv";
    case Input::da: return "da";
    case Input::dtau: return "dtau";
    case Input::weights: return "w";
    case Input::loads: return "loads";
    case Input::place: return "frame";
    case Input::base: return "base";
    case Input::form: return "form";
    case Input::at: break;
  }
  return "at";
}

std::string to_string(const Counts& counts) {
  constexpr std::pair<Word, std::string_view> phrases[]{{Word::counted, "counts "},
                                                        {Word::optional, "counts on request: "},
                                                        {Word::partly, "counts a part on request: "},
                                                        {Word::of_the_tree, "ignores "},
                                                        {Word::refused, "refuses "}};
  std::string line;
  for (const auto& [word, phrase] : phrases) {
    std::string part;
    for (const auto& [property, member] : properties) {
      const Count& count = counts.*member;
      if (count.word != word) continue;
      part += (part.empty() ? phrase : std::string_view(", "));
      part += property;
      if (!count.sentence.empty()) part += " (" + std::string(count.sentence) + ")";
    }
    if (!part.empty()) line += (line.empty() ? "" : "; ") + part;
  }
  line[0] = static_cast<char>(std::toupper(line[0]));
  return line + ".";
}

namespace {

constexpr bool refuses_others(const Counts& counts) {
  for (const Count& count : {counts.passive_joints, counts.springs, counts.joint_losses, counts.contacts})
    if (count.word == Word::refused) return true;
  return false;
}
static_assert(std::ranges::none_of(functions_of_state, refuses_others, &Words::counts));
static_assert(std::ranges::none_of(other_functions, refuses_others, &Other::counts));

/// Whether the purpose of a row is a sentence that no other row has.
constexpr bool is_a_sentence_of_its_own(const Words& row) {
  return row.purpose[0] >= 'A' && row.purpose[0] <= 'Z' && row.purpose.ends_with('.') &&
         std::ranges::count(functions_of_state, row.purpose, &Words::purpose) == 1;
}
static_assert(std::ranges::all_of(functions_of_state, is_a_sentence_of_its_own));

/// How many instances of a property, such as loops, a model has; 0 for one that no function refuses.
std::size_t number_of(Count Counts::*property, const Model& model) {
  if (property == &Counts::loops) return model.loops().all.size();
  if (property == &Counts::motions) return model.motions().size();
  if (property == &Counts::drives) return model.drives().size();
  if (property == &Counts::plays) return model.loops().backlashes.size();
  return 0;
}

}  // namespace

void check_counts(std::string_view function, const Counts& counts, const Model& model, Caller caller) {
  const std::string name(function);
  for (const auto& [property, member] : properties) {
    const auto& [word, sentence] = counts.*member;
    const bool by_others = word == Word::counted && caller != Caller::whole;
    if (word != Word::refused && !by_others) continue;
    const std::size_t number = number_of(member, model);
    if (number == 0) continue;
    const std::string instead = word == Word::refused ? std::string(sentence)
                                : caller == Caller::workspace
                                    ? name + " with a LoopWorkspace counts them"
                                    : "axode's own " + name + ", not recorded or traced, counts them";
    throw std::invalid_argument(name + " does not count " + std::string(property) + ", and model \"" +
                                model.name() + "\" has " + std::to_string(number) + "; " + instead);
  }
}

namespace {

std::string name_of(const Words& row, std::size_t result) {
  const std::string symbol(row.symbols[result]), together(row.together);
  if (row.symbols.size() == 1 && !together.empty()) return together;
  return symbol.starts_with("by ") ? (together.empty() ? "result" : together) + " " + symbol : symbol;
}
[[noreturn]] void refuse_size(const std::string& name, std::size_t size, const std::string& meaning,
                              std::size_t expected) {
  throw std::invalid_argument(name + " has " + std::to_string(size) + " entries; expected " + meaning +
                              " = " + std::to_string(expected));
}

}  // namespace

void refuse_input(Input input, std::size_t size, const Model& model) {
  refuse_size(std::string(to_string(input)), size, "nv", static_cast<std::size_t>(model.nv()));
}
void refuse_result(const Words& row, std::size_t result, std::size_t size, std::size_t width,
                   const Model& model, std::size_t n_loads) {
  const std::size_t factor = static_cast<std::size_t>(numbers_of(row.entry)) / width;
  std::string meaning = factor == 1 ? "" : std::to_string(factor);
  for (const Extent extent : row.shape) {
    if (!meaning.empty()) meaning += " * ";
    meaning += extent == Extent::n_parameters ? "10 * n_bodies"
               : extent == Extent::n_joints   ? "n_bodies"  // each joint moves one body
                                              : to_string(extent);
  }
  refuse_size(name_of(row, result), size, meaning, numbers_of(row, model, n_loads) / width);
}
void refuse_shared(const Words& row, std::size_t result, std::string_view with) {
  throw std::invalid_argument(name_of(row, result) + " shares memory with " + std::string(with) +
                              "; this result needs memory of its own");
}

}  // namespace axode::catalog
