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

/// The base class of the readers of XML formats (URDF and SDFormat).
namespace axode::io {

using tinyxml2::XMLElement;

/// The attributes and child elements that a format knows in one element.
struct Grammar {
  std::string_view element;
  std::vector<std::string_view> attributes = {};
  std::vector<std::string_view> once = {};      ///< names of children that may occur once
  std::vector<std::string_view> repeated = {};  ///< names of children that may occur any number of times
};

/// A format: its names in messages, its grammar, and the form of its numbers.
struct XmlFormat {
  std::string_view name;    ///< name of the format, such as `URDF`
  std::string_view a_file;  ///< name of a file of the format with its article, such as `a URDF`
  std::string_view root;    ///< name of the root element
  std::span<const Grammar> grammar;
  bool values_are_elements;  ///< whether numbers are texts of child elements, not attributes
};

/// The entries of a rotational inertia by their names in URDF and SDFormat.
inline constexpr std::array<std::pair<const char*, double Sym3<>::*>, 6> inertia_entries{
    {{"ixx", &Sym3<>::xx},
     {"ixy", &Sym3<>::xy},
     {"ixz", &Sym3<>::xz},
     {"iyy", &Sym3<>::yy},
     {"iyz", &Sym3<>::yz},
     {"izz", &Sym3<>::zz}}};

/// Reads elements, attributes and numbers of an XML text. It collects a fault for each that is wrong or
/// missing, and a warning for each kind of element and attribute that the format does not know.
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
  /// The severity of a defect that is accepted by lenient readers: an error for a strict one, else a warning.
  Severity lenient_severity() const {
    return strictness_ == Strictness::strict ? Severity::error : Severity::warning;
  }
  /// Counts an element, attribute or text that the reader ignores; report_ignored() reports it.
  void ignore(std::string what, int line);
  /// Adds one warning for each kind of element, attribute and text that was ignored, with their number.
  void report_ignored();
  /// The text ` (3 times, first here)` for a message, with the given count; empty for 1.
  static std::string times(int count) {
    return count > 1 ? " (" + std::to_string(count) + " times, first here)" : "";
  }

  /// Parses the text and returns its root element; null, with a fault, if it is not XML of the format.
  const XMLElement* parse(tinyxml2::XMLDocument& document);

  /// The child elements of e with the given name, or all child elements if `name` is null.
  static std::vector<const XMLElement*> children(const XMLElement& e, const char* name = nullptr);
  static std::string tag(const XMLElement& e) { return '<' + std::string(e.Name()) + '>'; }
  /// The grammar of an element; null if the format does not know it.
  const Grammar* grammar_of(std::string_view element) const;
  /// Whether the description of an ignored part begins with `beginning`, such as `<xacro:`.
  bool is_ignored(std::string_view beginning) const;
  /// Collects the attributes, child elements and texts of an element that the format does not know, for later
  /// warnings, and reports child elements that occur too often. `owner` is the name of the element in
  /// messages.
  void inspect(const XMLElement& e, const std::string& owner);
  /// The first child element of e with the given name, after inspect() of this child; null if there is none.
  const XMLElement* child_of(const XMLElement& e, const char* name, const std::string& owner);
  /// The first child element of e with the given name, after inspect() of it; null, with a fault, if none.
  const XMLElement* required_child(const XMLElement& e, const char* name, const std::string& owner);
  /// The text of an attribute. If the attribute is missing, a fault is added and the result is null.
  const char* required(const XMLElement& e, const char* attribute, const std::string& owner);
  /// The text of an attribute that is a name. A fault is added if it is missing, empty or not printable.
  std::string name(const XMLElement& e, const char* attribute, const std::string& owner);
  /// The text of a child element that is a name; empty, with a fault, if it is missing.
  std::string required_text(const XMLElement& e, const char* child, const std::string& owner);
  /// The first text in an element that is not blank, without the blanks around it; empty if there is none.
  static std::string text_of(const XMLElement& e);
  /// Returns the name `value`. It is a fault if it is empty (message `where_empty`) or not printable.
  std::string checked_name(const char* value, const std::string& where_empty, const std::string& owner,
                           int line);

  /// The N numbers in a text; empty, with a fault, if one of them is wrong or the count is not N.
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
  /// A value of an element: an attribute or, if the format has values_are_elements, a child element.
  struct Value {
    std::string text, what;  ///< `what` is the name of the value in messages
    int line;
  };
  std::optional<Value> value(const XMLElement& e, const char* key) const;
  /// The N numbers in the value `key` of an element; empty if it is absent or, with a fault, wrong.
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
  /// The limit in the value `key` of an element; `otherwise` if it is absent, infinite from `unbounded` on.
  double bound(const XMLElement& e, const char* key, const std::string& owner, double otherwise,
               double unbounded);
  /// The rotation by roll, pitch and yaw (rad). A fault is reported if an angle looks like degrees: if it is
  /// a multiple of 5 whose magnitude is above 4 π and at most 720. `subject` is the subject of the fault's
  /// sentence.
  SO3<> roll_pitch_yaw(const std::array<double, 3>& angles, const std::string& subject,
                       const std::string& owner, int line);

  /// Reads the geometry of a visual or collision element. For each shape in the geometry, a copy of `shape`,
  /// which has the role, pose and colour of the element, receives the kind and the dimensions of the shape
  /// and is appended to `shapes`. Wrong dimensions are errors only if the reader is strict.
  void read_geometry(const XMLElement& e, ShapeDescription shape, const std::string& owner,
                     std::vector<ShapeDescription>& shapes);

  /// The entry of `kinds` for the type of an element; null, with a fault, if it is missing or unknown.
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

  /// All numbers in a text. If one of them is wrong, a fault is added and the result is empty.
  std::optional<std::vector<double>> numbers(std::string_view text, const std::string& what,
                                             const std::string& owner, int line, Severity severity);
  /// Adds a fault about a text with `count` numbers instead of those `needed`, such as `6 numbers`.
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
