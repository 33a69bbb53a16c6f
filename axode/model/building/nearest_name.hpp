#pragma once
#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace axode {

/// Exception for the name of a joint, body or frame that a model does not have.
struct UnknownName : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// The Levenshtein distance: the smallest number of inserted, deleted and replaced characters from a to b.
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

/// The largest number of unknown names in a description for which similar names are suggested, to save time.
inline constexpr int most_suggestions = 20;

/// A text such as `; did you mean "forearm"?` with the known name nearest to `name`, or an empty text if none
/// is near. name_of(candidate) is the name of a candidate.
template <class Range, class NameOf>
std::string did_you_mean(std::string_view name, const Range& candidates, NameOf name_of) {
  std::string best;
  if (name.size() > 100) return best;
  std::size_t least = 1 + name.size() / 3;
  for (const auto& candidate : candidates) {
    const std::string other(name_of(candidate));
    if (std::max(name.size(), other.size()) > least + std::min(name.size(), other.size())) continue;
    const std::size_t distance = edit_distance(name, other);
    if (distance <= least && distance < std::max(name.size(), other.size()) && !other.empty()) {
      if (distance < least || best.empty()) best = other;
      least = distance;
    }
  }
  return best.empty() ? "" : "; did you mean \"" + best + "\"?";
}

}  // namespace axode
