#pragma once
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "apps/shell/commands.hpp"
#include "axode/catalog.hpp"
#include "axode/dynamics/closed_form/coriolis.hpp"
#include "axode/lie/twist.hpp"
#include "axode/model/building/nearest_name.hpp"

/// Choices on the command line: words that stand for values.
namespace axode::command {

enum class Format { table, json };

inline constexpr std::array<std::pair<std::string_view, Format>, 2> formats{
    {{"table", Format::table}, {"json", Format::json}}};

inline constexpr std::array<std::pair<std::string_view, CoriolisForm>, 4> coriolis_forms{
    {{"paper", CoriolisForm::paper},
     {"skew", CoriolisForm::skew},
     {"spatial", CoriolisForm::spatial},
     {"christoffel", CoriolisForm::christoffel}}};

inline constexpr std::array<std::pair<std::string_view, WrenchPoint>, 2> wrench_points{
    {{"body", WrenchPoint::body}, {"joint", WrenchPoint::joint}}};

/// A hint for an unknown name, as the end of a message: `; did you mean "poses"?` with the nearest valid
/// name, `; it is called "mass_matrix" here` for a name from other libraries, or `; names that contain it:
/// "kinetic_energy", ...`. Empty if there is none.
template <class Range, class NameOf>
std::string suggestion(std::string_view word, const Range& candidates, NameOf name_of) {
  const std::string_view here = catalog::name_here(word);
  for (const auto& candidate : candidates)
    if (!here.empty() && here == name_of(candidate))
      return "; it is called \"" + std::string(here) + "\" here";
  std::string holding;
  for (const auto& candidate : candidates) {
    const std::string name(name_of(candidate));
    if (word.size() > 2 && name.find(word) != std::string::npos)
      holding += (holding.empty() ? "" : ", ") + ('"' + name + '"');
  }
  const std::string near = did_you_mean(word, candidates, name_of);
  return near.empty() && !holding.empty() ? "; names that contain it: " + holding : near;
}

/// A message for an unknown word, such as `"fre" is none of fixed, free; did you mean "free"?`.
template <class Range, class NameOf>
std::string none_of(std::string_view word, const Range& candidates, NameOf name_of) {
  std::string sentence = '"' + std::string(word) + "\" is none of ";
  const char* separator = "";
  for (const auto& candidate : candidates) {
    sentence += separator + std::string(name_of(candidate));
    separator = ", ";
  }
  return sentence + suggestion(word, candidates, name_of);
}

/// The value that a word stands for. Throws Error, with a message that `where` begins, if it is not a choice.
template <class Error = UsageError, class Value, std::size_t N>
Value choose(const std::string& where, std::string_view word,
             const std::array<std::pair<std::string_view, Value>, N>& choices) {
  for (const auto& [name, value] : choices)
    if (name == word) return value;
  throw Error(where + ": " + none_of(word, choices, [](const auto& choice) { return choice.first; }));
}

/// The valid words of a choice in the form `table|json`, which the help shows and shell completion reads.
template <class Choices> std::string words(const Choices& choices) {
  std::string all;
  for (const auto& choice : choices) all += (all.empty() ? "" : "|") + std::string(choice.first);
  return all;
}

/// The word that stands for a value.
template <class Value, std::size_t N>
std::string_view word_for(Value wanted, const std::array<std::pair<std::string_view, Value>, N>& choices) {
  for (const auto& [name, value] : choices)
    if (value == wanted) return name;
  return "";
}

}  // namespace axode::command
