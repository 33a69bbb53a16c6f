#include "axode/io/reading.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <unordered_set>
#include <utility>

#include "axode/model/building/nearest_name.hpp"
#include "axode/model/building/placement.hpp"

namespace axode::io {
namespace {

/// The number of bytes of the UTF-8 character at the start of a text; 0 if there is none.
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t k) { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0U; };
  const auto continues = [&](std::size_t k, unsigned low = 0x80, unsigned high = 0xBF) {
    return byte(k) >= low && byte(k) <= high;
  };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead <= 0xDF) return continues(1) ? 2 : 0;
  if (lead >= 0xE0 && lead <= 0xEF) {
    const bool second = continues(1, lead == 0xE0 ? 0xA0 : 0x80, lead == 0xED ? 0x9F : 0xBF);
    return second && continues(2) ? 3 : 0;
  }
  if (lead >= 0xF0 && lead <= 0xF4) {
    const bool second = continues(1, lead == 0xF0 ? 0x90 : 0x80, lead == 0xF4 ? 0x8F : 0xBF);
    return second && continues(2) && continues(3) ? 4 : 0;
  }
  return 0;
}

}  // namespace

bool has_error(const std::vector<Fault>& faults) {
  return std::any_of(faults.begin(), faults.end(),
                     [](const Fault& f) { return f.severity == Severity::error; });
}

void forgive(Reading& reading) {
  constexpr double none = std::numeric_limits<double>::infinity();
  std::vector<std::string> joints;
  for (const BodyDescription& body : expand(reading.description).bodies) joints.push_back(body.joint.name);
  const std::unordered_set<std::string_view> known(joints.begin(), joints.end());
  int suggestions = 0;
  for (BodyDescription& body : reading.description.bodies) {
    const auto warn = [&](Rule rule, std::string message) {
      reading.faults.push_back({Severity::warning, rule, "joint \"" + joint_name(body) + '"',
                                std::move(message),
                                body.joint.source.line > 0 ? body.joint.source : body.source});
    };
    for (Dof& dof : body.joint.dof) {
      if (!(dof.lower > dof.upper)) continue;
      warn(Rule::limits_crossed, "lower limit " + to_text(dof.lower) + " is above upper limit " +
                                     to_text(dof.upper) + "; it is taken as unlimited");
      dof.lower = -none;
      dof.upper = none;
    }
    if (body.joint.coupling && !known.contains(body.joint.coupling->leader)) {
      const std::string& leader = body.joint.coupling->leader;
      warn(Rule::coupling_unknown_joint,
           "follows joint " + in_quotes(leader) + ", which is not described, and moves on its own" +
               (++suggestions > most_suggestions
                    ? ""
                    : did_you_mean(leader, joints, [](const std::string& name) { return name; })));
      body.joint.coupling.reset();
    }
  }
}

Description accept(Reading reading) {
  if (has_error(reading.faults)) throw ModelError(reading.description.name, std::move(reading.faults));
  reading.description.warnings = std::move(reading.faults);
  return std::move(reading.description);
}

std::optional<Fault> not_text(std::string_view text, const std::string& file) {
  int line = 1;
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    if (length == 0 || text.front() == '\0')
      return Fault{Severity::error,
                   Rule::syntax,
                   "",
                   length == 0 ? "a byte is not UTF-8; save the file as UTF-8 text"
                               : "a byte is zero; this is not a text file",
                   {file, line}};
    if (text.front() == '\n') ++line;
    text.remove_prefix(length);
  }
  return std::nullopt;
}

bool is_control(char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; }

bool printable(std::string_view name) { return std::none_of(name.begin(), name.end(), is_control); }

Number number(std::string_view text) {
  Number result;
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), result.value);
  if (failure == std::errc::result_out_of_range) {
    result.broken = Rule::wrong_value;
    result.complaint = "is outside the range of a double";
  } else if (failure != std::errc{} || end != text.data() + text.size()) {
    result.broken = Rule::wrong_value;
    result.complaint = "is not a number";
  } else if (!std::isfinite(result.value)) {
    result.broken = Rule::non_finite_number;
    result.complaint = "is not finite";
  }
  return result;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string shown;
  while (!text.empty() && shown.size() < longest) {
    const std::size_t length = std::max<std::size_t>(character_length(text), 1);
    const char c = text.front();
    shown += is_control(c) ? std::string(" ") : std::string(text.substr(0, length));
    text.remove_prefix(length);
  }
  return '"' + shown + (text.empty() ? "" : "...") + '"';
}

}  // namespace axode::io
