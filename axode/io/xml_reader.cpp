#include "axode/io/xml_reader.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/io/pose.hpp"
#include "axode/model/building/checks/value_checks.hpp"

namespace axode::io {
namespace {

std::string why_not_xml(tinyxml2::XMLError error, const XmlFormat& format) {
  switch (error) {
    case tinyxml2::XML_ERROR_EMPTY_DOCUMENT:
      return "the file is empty; " + std::string(format.a_file) + " holds one <" + std::string(format.root) +
             ">";
    case tinyxml2::XML_ERROR_MISMATCHED_ELEMENT:
      return "this element is not closed, or closed by another name";
    case tinyxml2::XML_ERROR_PARSING_ELEMENT: return "this is not a well-formed element";
    case tinyxml2::XML_ERROR_PARSING_ATTRIBUTE:
      return "an attribute of this element is malformed or given twice";
    case tinyxml2::XML_ERROR_PARSING_TEXT: return "there is text outside the root element";
    case tinyxml2::XML_ERROR_PARSING_CDATA: return "this CDATA section never ends";
    case tinyxml2::XML_ERROR_PARSING_COMMENT: return "this comment never ends";
    case tinyxml2::XML_ERROR_PARSING_DECLARATION: return "this <?...?> is malformed or in the wrong place";
    case tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED: return "elements are nested more than 100 deep";
    default: return "this is not well-formed XML";
  }
}

}  // namespace

std::string_view root_element(std::string_view text) {
  const auto skip_past = [&](std::string_view end) {
    const std::size_t at = text.find(end);
    text.remove_prefix(at == std::string_view::npos ? text.size() : at + end.size());
  };
  while (!text.empty()) {
    skip_past("<");
    if (text.starts_with("!--")) {
      skip_past("-->");
    } else if (text.starts_with("?") || text.starts_with("!")) {
      skip_past(">");
    } else {
      return text.substr(0, text.find_first_of(" \t\r\n/>"));
    }
  }
  return {};
}

void XmlReader::ignore(std::string what, int line) {
  const auto [known, is_new] = ignored_index_.emplace(what, ignored_.size());
  if (is_new) ignored_.push_back({std::move(what), line, 0});
  ++ignored_[known->second].count;
}

void XmlReader::report_ignored() {
  for (const Ignored& it : ignored_) {
    const bool extension = it.what.find(':') != std::string::npos && !it.what.starts_with("<xacro:");
    note(Severity::warning, Rule::unknown_element, it.what,
         (extension ? "belongs to an extension of " + std::string(format_.name) + " and is ignored"
                    : "says nothing about the mechanism and is ignored") +
             times(it.count),
         it.line);
  }
}

const XMLElement* XmlReader::parse(tinyxml2::XMLDocument& document) {
  if (auto fault = not_text(text_, file_)) {
    faults().push_back(std::move(*fault));
    return nullptr;
  }
  if (document.Parse(text_.data(), text_.size()) != tinyxml2::XML_SUCCESS) {
    error(Rule::syntax, "", why_not_xml(document.ErrorID(), format_), document.ErrorLineNum());
    return nullptr;
  }
  const XMLElement* root = document.RootElement();
  if (root == nullptr) {
    error(Rule::syntax, "", why_not_xml(tinyxml2::XML_ERROR_EMPTY_DOCUMENT, format_), 1);
    return nullptr;
  }
  const std::string expected = "<" + std::string(format_.root) + ">";
  if (root->Name() != format_.root) {
    error(
        Rule::syntax, "",
        "the root element is " + tag(*root) + "; that of " + std::string(format_.a_file) + " is " + expected,
        root->GetLineNum());
    return nullptr;
  }
  for (const tinyxml2::XMLNode* node = document.FirstChild(); node != nullptr; node = node->NextSibling()) {
    if (node != root && (node->ToElement() != nullptr || node->ToText() != nullptr))
      error(Rule::syntax, "", "there is something outside " + expected + "; it must be the only root element",
            node->GetLineNum());
  }
  return root;
}

std::vector<const XMLElement*> XmlReader::children(const XMLElement& e, const char* name) {
  std::vector<const XMLElement*> all;
  for (const XMLElement* child = e.FirstChildElement(name); child != nullptr;
       child = child->NextSiblingElement(name))
    all.push_back(child);
  return all;
}

const Grammar* XmlReader::grammar_of(std::string_view element) const {
  const auto found = std::ranges::find(format_.grammar, element, &Grammar::element);
  return found == format_.grammar.end() ? nullptr : &*found;
}

bool XmlReader::is_ignored(std::string_view beginning) const {
  return std::ranges::any_of(ignored_, [&](const Ignored& it) { return it.what.starts_with(beginning); });
}

void XmlReader::inspect(const XMLElement& e, const std::string& owner) {
  const Grammar* grammar = grammar_of(e.Name());
  if (grammar == nullptr) return;
  const auto in = [](const std::vector<std::string_view>& list, std::string_view name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  for (const auto* a = e.FirstAttribute(); a != nullptr; a = a->Next()) {
    const std::string_view attribute = a->Name();
    if (!attribute.starts_with("xmlns") && !in(grammar->attributes, attribute))
      ignore("attribute " + std::string(attribute) + " of " + tag(e), a->GetLineNum());
  }
  std::vector<const XMLElement*> seen;
  for (const tinyxml2::XMLNode* node = e.FirstChild(); node != nullptr; node = node->NextSibling()) {
    if (node->ToText() != nullptr) ignore("text in " + tag(e), node->GetLineNum());
    const XMLElement* child = node->ToElement();
    if (child == nullptr || in(grammar->repeated, child->Name())) continue;
    const auto before = std::find_if(seen.begin(), seen.end(), [&](const XMLElement* other) {
      return std::string_view(other->Name()) == child->Name();
    });
    if (!in(grammar->once, child->Name())) {
      ignore(tag(*child), child->GetLineNum());
    } else if (before == seen.end()) {
      seen.push_back(child);
    } else if (child->NoChildren() && (*before)->NoChildren() && child->ShallowEqual(*before)) {
      note(lenient_severity(), Rule::duplicate_element, owner, tag(e) + " holds two equal " + tag(*child),
           child->GetLineNum());
    } else {
      error(Rule::duplicate_element, owner, tag(e) + " holds " + tag(*child) + " twice", child->GetLineNum());
    }
  }
}

const XMLElement* XmlReader::child_of(const XMLElement& e, const char* name, const std::string& owner) {
  const XMLElement* child = e.FirstChildElement(name);
  if (child != nullptr) inspect(*child, owner);
  return child;
}

const XMLElement* XmlReader::required_child(const XMLElement& e, const char* name, const std::string& owner) {
  const XMLElement* child = child_of(e, name, owner);
  if (child == nullptr)
    error(Rule::missing_element, owner, tag(e) + " has no <" + name + ">; it needs one", e.GetLineNum());
  return child;
}

const char* XmlReader::required(const XMLElement& e, const char* attribute, const std::string& owner) {
  const char* value = e.Attribute(attribute);
  if (value == nullptr)
    error(Rule::missing_element, owner, tag(e) + " has no attribute " + attribute + "; it needs one",
          e.GetLineNum());
  return value;
}

std::string XmlReader::name(const XMLElement& e, const char* attribute, const std::string& owner) {
  const char* value = required(e, attribute, owner);
  return value == nullptr ? ""
                          : checked_name(value, tag(e) + " has an empty " + attribute, owner, e.GetLineNum());
}

std::string XmlReader::required_text(const XMLElement& e, const char* child, const std::string& owner) {
  const XMLElement* given = e.FirstChildElement(child);
  if (given != nullptr)
    return checked_name(text_of(*given).c_str(), tag(*given) + " is empty", owner, given->GetLineNum());
  error(Rule::missing_element, owner, tag(e) + " has no <" + child + ">; it needs one", e.GetLineNum());
  return {};
}

std::string XmlReader::text_of(const XMLElement& e) {
  for (const tinyxml2::XMLNode* node = e.FirstChild(); node != nullptr; node = node->NextSibling())
    if (const tinyxml2::XMLText* text = node->ToText()) {
      const std::string_view all = text->Value();
      const std::size_t first = all.find_first_not_of(" \t\r\n");
      if (first == std::string_view::npos) continue;
      return std::string(all.substr(first, all.find_last_not_of(" \t\r\n") + 1 - first));
    }
  return {};
}

std::string XmlReader::checked_name(const char* value, const std::string& where_empty,
                                    const std::string& owner, int line) {
  if (*value == '\0') error(Rule::missing_name, owner, where_empty, line);
  if (!printable(value))
    error(Rule::wrong_value, owner, in_quotes(value) + " holds a control character; a name must not", line);
  return value;
}

std::optional<std::vector<double>> XmlReader::numbers(std::string_view text, const std::string& what,
                                                      const std::string& owner, int line, Severity severity) {
  constexpr std::string_view blank = " \t\r\n";
  std::vector<double> out;
  for (std::size_t at; (at = text.find_first_not_of(blank)) != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(blank, at), text.size());
    const std::string_view word = text.substr(at, end - at);
    text.remove_prefix(end);
    const Number x = number(word);
    if (x.broken) {
      note(severity, *x.broken, owner,
           what + ": " + in_quotes(word) + " " + x.complaint +
               (severity == Severity::warning ? "; it is ignored" : ""),
           line);
      return std::nullopt;
    }
    out.push_back(x.value);
  }
  return out;
}

std::optional<XmlReader::Value> XmlReader::value(const XMLElement& e, const char* key) const {
  if (format_.values_are_elements) {
    const XMLElement* child = e.FirstChildElement(key);
    if (child == nullptr) return std::nullopt;
    return Value{text_of(*child), tag(*child), child->GetLineNum()};
  }
  const char* attribute = e.Attribute(key);
  if (attribute == nullptr) return std::nullopt;
  return Value{attribute, tag(e) + " " + key, e.GetLineNum()};
}

std::optional<Vec3<>> XmlReader::vector(const XMLElement& e, const char* key, const std::string& owner,
                                        Severity severity) {
  const auto x = numbers<3>(e, key, owner, severity);
  return x ? std::optional(Vec3<>{(*x)[0], (*x)[1], (*x)[2]}) : std::nullopt;
}

double XmlReader::scalar(const XMLElement& e, const char* key, const std::string& owner, double otherwise) {
  const auto x = numbers<1>(e, key, owner);
  return x ? (*x)[0] : otherwise;
}

double XmlReader::bound(const XMLElement& e, const char* key, const std::string& owner, double otherwise,
                        double unbounded) {
  const std::optional<Value> given = value(e, key);
  const Number x = given ? number(given->text) : Number{};
  if (x.broken == Rule::non_finite_number && std::isinf(x.value)) return x.value;
  const double limit = scalar(e, key, owner, otherwise);
  return std::abs(limit) < unbounded ? limit : std::copysign(std::numeric_limits<double>::infinity(), limit);
}

SO3<> XmlReader::roll_pitch_yaw(const std::array<double, 3>& angles, const std::string& subject,
                                const std::string& owner, int line) {
  if (auto complaint = degrees_complaint(subject, angles))
    note(lenient_severity(), Rule::wrong_value, owner, std::move(*complaint), line);
  const auto [roll, pitch, yaw] = angles;
  return from_roll_pitch_yaw({roll, pitch, yaw});
}

void XmlReader::read_geometry(const XMLElement& e, ShapeDescription shape, const std::string& owner,
                              std::vector<ShapeDescription>& shapes) {
  if (const char* given = e.Attribute("name"); given != nullptr && printable(given)) shape.name = given;
  const XMLElement* geometry = required_child(e, "geometry", owner);
  if (geometry == nullptr) return;
  for (const XMLElement* given : children(*geometry)) {
    const auto kind = std::ranges::find(shape_kinds, std::string_view(given->Name()), &ShapeTraits::name);
    if (kind == shape_kinds.end()) continue;
    if (kind->kind == ShapeKind::plane && !format_.values_are_elements) continue;  // URDF has none
    inspect(*given, owner);
    if (read_dimensions(*given, *kind, owner, shape)) shapes.push_back(shape);
  }
}

/// Reads the kind and the dimensions of a shape from an element; false if a dimension is missing or wrong.
bool XmlReader::read_dimensions(const XMLElement& e, const ShapeTraits& kind, const std::string& owner,
                                ShapeDescription& shape) {
  shape.kind = kind.kind;
  if (kind.kind == ShapeKind::mesh) {
    shape.file = format_.values_are_elements ? required_text(e, "uri", owner) : name(e, "filename", owner);
    shape.scale = vector(e, "scale", owner, lenient_severity()).value_or(Vec3<>{1, 1, 1});
    return !shape.file.empty();
  }
  if (kind.kind == ShapeKind::plane) {
    const Vec3<> normal = vector(e, "normal", owner, lenient_severity()).value_or(Vec3<>{0, 0, 1});
    const double length = norm(normal);
    if (length > 0) shape.pose.R = shape.pose.R * rotation_to((1 / length) * normal);
    return length > 0;
  }
  bool complete = true;
  const auto is_there = [&](const std::string& key) {
    if (value(e, key.c_str())) return true;
    note(lenient_severity(), Rule::missing_element, owner,
         tag(e) + " has no " + (format_.values_are_elements ? "<" + key + ">" : "attribute " + key) +
             "; a shape without one is ignored",
         e.GetLineNum());
    return complete = false;
  };
  const auto length = [&](const char* key) {
    const auto x = is_there(key) ? numbers<1>(e, key, owner, lenient_severity()) : std::nullopt;
    complete &= x.has_value();
    return x ? (*x)[0] : 0;
  };
  if (!kind.size.empty()) {
    const bool radii = format_.values_are_elements && kind.kind == ShapeKind::ellipsoid;
    const char* key = radii ? "radii" : kind.size.data();
    const auto size = is_there(key) ? vector(e, key, owner, lenient_severity()) : std::nullopt;
    complete &= size.has_value();
    shape.size = size.value_or(Vec3<>{});
  }
  if (kind.radius) shape.radius = length("radius");
  if (kind.length) shape.length = length("length");
  return complete;
}

void XmlReader::wrong_count(std::string_view text, const std::string& what, const std::string& needed,
                            std::size_t count, const std::string& owner, int line, Severity severity) {
  note(severity, Rule::wrong_value, owner,
       what + " is " + in_quotes(text) + "; it needs " + needed + " and has " + std::to_string(count) +
           (severity == Severity::warning ? "; it is ignored" : ""),
       line);
}

}  // namespace axode::io
