#include "axode/codegen/c/c_names.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <stdexcept>

namespace axode::codegen {
namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Makes an identifier from a name: characters that a C identifier cannot have become underscores. For
/// CasADi, identifiers have no two underscores in a row, and none at the beginning or the end.
std::string identifier(const std::string& name, Abi abi) {
  std::string text;
  for (const char c : name) {
    const bool stays = is_letter(c) || is_digit(c);
    if (abi != Abi::casadi || (stays && c != '_') || (!text.empty() && text.back() != '_'))
      text += stays ? c : '_';
  }
  if (abi == Abi::casadi && text.ends_with('_')) text.pop_back();
  return text;
}
std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(text.size(), width), ' ');
  return text;
}
std::string range(int first, int n) {
  if (n == 0) return "-";
  return std::to_string(first) + (n > 1 ? " to " + std::to_string(first + n - 1) : "");
}

}  // namespace

bool is_identifier(std::string_view name) {
  return !name.empty() && is_letter(name[0]) &&
         std::all_of(name.begin(), name.end(), [](char c) { return is_letter(c) || is_digit(c); });
}

std::string prefix_for(const Model& model, Abi abi) {
  const std::string prefix = identifier(model.name(), abi);
  if (is_identifier(prefix)) return prefix;
  return abi == Abi::casadi && prefix.empty() ? "model" : "model_" + prefix;
}

std::vector<std::string> frame_identifiers(const Model& model, Abi abi) {
  constexpr std::array endings{"", "_spatial", "_hybrid", "_mixed"};
  std::set<std::string> taken;
  const auto is_taken = [&](const std::string& name) {
    return std::ranges::any_of(endings, [&](const char* ending) { return taken.contains(name + ending); });
  };
  std::vector<std::string> names;
  for (const Frame& frame : model.frames()) {
    std::string plain = identifier(frame.name, abi);
    if (abi == Abi::casadi && plain.empty()) plain = "frame";
    std::string name = plain;
    for (int k = 2; is_taken(name); ++k) name = plain + '_' + std::to_string(k);
    for (const char* ending : endings) taken.insert(name + ending);
    names.push_back(name);
  }
  return names;
}

std::vector<std::string> function_names(const Model& model, std::span<const Function> functions,
                                        const std::string& prefix, Abi abi) {
  const std::vector<std::string> frames = frame_identifiers(model, abi);
  std::vector<std::string> names;
  for (const Function& function : functions) {
    std::string name = prefix + '_' + std::string(function.name());
    if (function.is_of_a_frame()) name += '_' + frames[function.frame];
    if (function.is("jacobian") && function.representation != Representation::body)
      name += '_' + std::string(word_for(function.representation));
    if (std::ranges::find(names, name) != names.end())
      throw std::invalid_argument(name + " is asked for twice");
    names.push_back(name);
  }
  return names;
}

std::string in_comment(std::string text) {
  for (std::size_t k = 0; k + 1 < text.size(); ++k)
    if ((text[k] == '*' && text[k + 1] == '/') || (text[k] == '/' && text[k + 1] == '*'))
      text.insert(k + 1, " ");
  return text;
}

std::string coordinates(const Model& model) {
  std::size_t width = 5;
  for (const Joint& joint : model.joints()) width = std::max(width, joint.name.size());
  std::string text = "     " + padded("joint", width) + "  kind       q         v\n";
  for (const Joint& joint : model.joints()) {
    text += "     " + padded(joint.name, width) + "  " + padded(std::string(to_string(joint.kind)), 9) + "  ";
    if (joint.leader)
      text += "follows " + model.joint(joint.leader->joint).name + "\n";
    else
      text += padded(range(joint.iq, joint.nq), 8) + "  " + range(joint.iv, joint.nv) + "\n";
  }
  return in_comment(text);
}

std::string counted(const Operations& count) {
  return std::to_string(count.products) + " products, " + std::to_string(count.sums) + " sums, " +
         std::to_string(count.divisions) + " divisions, " + std::to_string(count.angles) +
         " sines and cosines";
}

}  // namespace axode::codegen
