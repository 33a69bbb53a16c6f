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
#include "axode/model/building/nearest_name.hpp"
#include "axode/model/kinds/shape_kinds.hpp"

/// The base of the readers of XML formats.
namespace axode::io {

using tinyxml2::XMLElement;

/// The attributes and children that a format knows in an element.
struct Grammar {
  std::string_view element;
  std::vector<std::string_view> attributes = {};
  std::vector<std::string_view> once = {};      ///< names of children that may occur once
  std::vector<std::string_view> repeated = {};  ///< names of children that may occur any number of times
};

/// A format: its names in messages, and its grammar.
struct XmlFormat {
  std::string_view name;    ///< name of the format, `URDF`
  std::string_view a_file;  ///< name of a file of the format, `a URDF`
  std::string_view root;    ///< name of the root element
  std::span<const Grammar> grammar;
  bool values_are_elements;  ///< whether numbers are texts of child elements instead of attributes
};

/// The entries of a rotational inertia by their names in URDF and SDFormat.
inline constexpr std::array<std::pair<const char*, double Sym3<>::*>, 6> inertia_entries{
    {{"ixx", &Sym3<>::xx},
     {"ixy", &Sym3<>::xy},
     {"ixz", &Sym3<>::xz},
     {"iyy", &Sym3<>::yy},
     {"iyz", &Sym3<>::yz},
     {"izz", &Sym3<>::zz}}};

/// Finds the elements, attributes and numbers of a text, with a fault for each that is wrong and a warning
/// for each kind of element and attribute that the format does not know.
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
  /// The severity of defects that a lenient reader accepts: an error if the reader is strict, else a warning.
  Severity lenient_severity() const {
    return strictness_ == Strictness::strict ? Severity::error : Severity::warning;
  }
  /// Counts something that the reader ignores.
  void ignore(std::string what, int line);
  /// Notes one warning for each kind of thing that was ignored.
  void report_ignored();
  /// ` (3 times, first here)` for a message; empty for 1.
  static std::string times(int count) {
    return count > 1 ? " (" + std::to_string(count) + " times, first here)" : "";
  }

  /// Parses the text and returns its root element. If the text is not XML, or the root is not that of the
  /// format, a fault is noted and the result is null.
  const XMLElement* parse(tinyxml2::XMLDocument& document);

  /// The child elements of that name, or all if `name` is null.
  static std::vector<const XMLElement*> children(const XMLElement& e, const char* name = nullptr);
  static std::string tag(const XMLElement& e) { return '<' + std::string(e.Name()) + '>'; }
  /// The grammar of an element; null if the format does not know it.
  const Grammar* grammar_of(std::string_view element) const;
  /// Whether something was ignored whose description begins like this.
  bool is_ignored(std::string_view beginning) const;
  /// Notes the attributes, children and texts in an element that the format does not know or allow.
  void inspect(const XMLElement& e, const std::string& owner);
  /// The first child of that name, after inspect(); null if there is none.
  const XMLElement* child_of(const XMLElement& e, const char* name, const std::string& owner);
  /// The first child of that name, after inspect(); null, with a fault, if there is none.
  const XMLElement* required_child(const XMLElement& e, const char* name, const std::string& owner);
  /// The text of an attribute; null, with a fault, if there is none.
  const char* required(const XMLElement& e, const char* attribute, const std::string& owner);
  /// The name in an attribute; empty, with a fault, if there is none.
  std::string name(const XMLElement& e, const char* attribute, const std::string& owner);
  /// The text of a child element; empty, with a fault, if there is none.
  std::string required_text(const XMLElement& e, const char* child, const std::string& owner);
  /// The text in an element, without blanks around it.
  static std::string text_of(const XMLElement& e);
  /// Returns a name that was read, and notes a fault if it is empty or cannot be printed.
  std::string checked_name(const char* value, const std::string& where_empty, const std::string& owner,
                           int line);

  /// The N numbers in a text; if the text is wrong, a fault is noted and the result is empty.
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
  /// A value in an element: the text of an attribute or, if values_are_elements, of a child.
  struct Value {
    std::string text, what;  ///< `what` is the name of the value in messages
    int line;
  };
  std::optional<Value> value(const XMLElement& e, const char* key) const;
  /// The N numbers in a value; the result is empty if the value is absent, or if it is wrong, which is noted
  /// as a fault.
  template <std::size_t N>
  std::optional<std::array<double, N>> numbers(const XMLElement& e, const char* key, const std::string& owner,
                                               Severity severity = Severity::error) {
    const std::optional<Value> given = value(e, key);
    if (!given) return std::nullopt;
    return numbers<N>(given->text, given->what, owner, given->line, severity);
  }
  std::optional<Vec3<>> vector(const XMLElement& e, const char* key, const std::string& owner,
                               Severity severity = Severity::error);
  double scalar(const XMLElement& e, const char* key, const std::string& owner, double otherwise);
  /// A limit. Infinity, and magnitudes of `unbounded` and more, mean that there is none.
  double bound(const XMLElement& e, const char* key, const std::string& owner, double otherwise,
               double unbounded);

  /// Reads the geometry of a visual or collision element and adds a copy of `shape` for each complete shape
  /// in it. As shapes do not affect the motion, wrong dimensions are errors of a strict reader only.
  void read_geometry(const XMLElement& e, ShapeDescription shape, const std::string& owner,
                     std::vector<ShapeDescription>& shapes);

  /// The row of a table of joint types with the type of an element; null, with a fault, if there is none.
  template <class Kind, std::size_t N>
  const Kind* kind_of(const XMLElement& e, const std::string& owner, const std::array<Kind, N>& kinds) {
    const char* type = required(e, "type", owner);
    if (type == nullptr) return nullptr;
    std::string known;
    for (const Kind& kind : kinds) {
      if (kind.type == type) return &kind;
      known += (known.empty() ? "" : &kind == &kinds.back() ? " and " : ", ") + std::string(kind.type);
    }
    error(Rule::wrong_value, owner,
          "type is " + in_quotes(type) + "; " + std::string(format_.name) + " knows " + known +
              did_you_mean(std::string_view(type).substr(0, 30), kinds, [](const Kind& k) { return k.type; }),
          e.GetLineNum());
    return nullptr;
  }

  /// All numbers in a text, however many there are. If one of them is wrong, a fault is noted and the result
  /// is empty.
  std::optional<std::vector<double>> numbers(std::string_view text, const std::string& what,
                                             const std::string& owner, int line, Severity severity);
  /// Notes that a text has another count of numbers than `needed`, which is a phrase such as `6 numbers`.
  void wrong_count(std::string_view text, const std::string& what, const std::string& needed,
                   std::size_t count, const std::string& owner, int line, Severity severity);

  XmlFormat format_;
  std::string_view text_;
  std::string file_;
  Strictness strictness_;

 private:
  bool read_dimensions(const XMLElement& e, const ShapeTraits& kind, const std::string& owner,
                       ShapeDescription& shape);

  struct Ignored {
    std::string what;
    int line, count;
  };
  Reading result_;
  std::vector<Ignored> ignored_;
  std::unordered_map<std::string, std::size_t> ignored_index_;
};

}  // namespace axode::io
