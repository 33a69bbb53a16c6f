#pragma once
#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "axode/io/reading.hpp"

/// What readers of XML have in common.
namespace axode::io {

using tinyxml2::XMLElement;

/// What a format knows in an element.
struct Grammar {
  std::string_view element;
  std::vector<std::string_view> attributes = {};
  std::vector<std::string_view> once = {};      ///< children, one of each at most
  std::vector<std::string_view> repeated = {};  ///< children, any number of each
};

/// A format as its messages name it.
struct XmlFormat {
  std::string_view a_file;  ///< `a URDF`
  std::string_view root;    ///< its root element
  std::span<const Grammar> grammar;
};

/// Finds the elements, attributes and numbers of a text, with a fault for each that is wrong and a warning for each kind
/// of element and attribute that the format does not know.
class XmlReader {
 protected:
  XmlReader(XmlFormat format, std::string_view text, std::string file, Strictness strictness)
      : format_(format), text_(text), file_(std::move(file)), strictness_(strictness) {}

  Description& description() { return result_.description; }
  std::vector<Fault>& faults() { return result_.faults; }
  Reading& result() { return result_; }
  Reading take_result() { return std::move(result_); }
  void note(Severity severity, Rule rule, std::string element, std::string message, int line) {
    faults().push_back({severity, rule, std::move(element), std::move(message), {file_, line}});
  }
  void error(Rule rule, std::string element, std::string message, int line) {
    note(Severity::error, rule, std::move(element), std::move(message), line);
  }
  /// What others forgive.
  Severity doubt() const { return strictness_ == Strictness::strict ? Severity::error : Severity::warning; }
  void ignore(std::string what, int line);
  /// A warning for all that was ignored, one for each kind.
  void report_ignored();
  static std::string times(int count) {
    return count > 1 ? " (" + std::to_string(count) + " times, first here)" : "";
  }

  /// The root element of the text; null, with a fault, where it is not that of the format.
  const XMLElement* parse(tinyxml2::XMLDocument& document);

  static std::string tag(const XMLElement& e) { return '<' + std::string(e.Name()) + '>'; }
  const Grammar* grammar_of(std::string_view element) const;
  bool is_ignored(std::string_view beginning) const;
  /// Notes whatever the format does not know or allow in an element.
  void inspect(const XMLElement& e, const std::string& owner);
  /// A child that is inspected on the way; null where there is none.
  const XMLElement* child_of(const XMLElement& e, const char* name, const std::string& owner);
  const XMLElement* required_child(const XMLElement& e, const char* name, const std::string& owner);
  const char* required(const XMLElement& e, const char* attribute, const std::string& owner);
  /// A name that an attribute gives; empty, with a fault, where there is none.
  std::string name(const XMLElement& e, const char* attribute, const std::string& owner);
  /// A name that was read; an empty one and one that cannot be printed have a fault.
  std::string checked_name(const char* value, const std::string& where_empty, const std::string& owner,
                           int line);

  /// N numbers of a text; nothing, with a note, where it is wrong.
  template <std::size_t N>
  std::optional<std::array<double, N>> numbers(std::string_view text, const std::string& what,
                                               const std::string& owner, int line,
                                               Severity severity = Severity::error) {
    const std::optional<std::vector<double>> all = numbers(text, what, owner, line, severity);
    if (!all) return std::nullopt;
    if (all->size() != N) {
      wrong_count(text, what, std::to_string(N) + (N == 1 ? " number" : " numbers"), all->size(), owner, line,
                  severity);
      return std::nullopt;
    }
    std::array<double, N> out{};
    std::copy(all->begin(), all->end(), out.begin());
    return out;
  }
  /// Those of an attribute; nothing where it is absent as well.
  template <std::size_t N>
  std::optional<std::array<double, N>> numbers(const XMLElement& e, const char* attribute,
                                               const std::string& owner,
                                               Severity severity = Severity::error) {
    const char* value = e.Attribute(attribute);
    if (value == nullptr) return std::nullopt;
    return numbers<N>(value, tag(e) + " " + attribute, owner, e.GetLineNum(), severity);
  }
  /// Any number of them.
  std::optional<std::vector<double>> numbers(std::string_view text, const std::string& what,
                                             const std::string& owner, int line, Severity severity);
  void wrong_count(std::string_view text, const std::string& what, const std::string& needed,
                   std::size_t count, const std::string& owner, int line, Severity severity);

  XmlFormat format_;
  std::string_view text_;
  std::string file_;
  Strictness strictness_;

 private:
  struct Ignored {
    std::string what;
    int line, count;
  };
  Reading result_;
  std::vector<Ignored> ignored_;
  std::unordered_map<std::string, std::size_t> ignored_index_;
};

}  // namespace axode::io
