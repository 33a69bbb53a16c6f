#include "axode/view/mesh_formats.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

namespace axode::view {
namespace {

using Json = nlohmann::json;

/// The number of type T that begins at byte `place` of a little-endian file, which must be long enough.
template <class T> T number_at(std::string_view bytes, std::size_t place) {
  static_assert(std::endian::native == std::endian::little);
  T number;
  std::memcpy(&number, bytes.data() + place, sizeof(T));
  return number;
}

constexpr std::string_view blanks = " \t\r\n\f\v";

/// Removes the next word from a text and returns it; `between` has the characters that separate words.
std::string_view next_word(std::string_view& text, std::string_view between = blanks) {
  text.remove_prefix(std::min(text.find_first_not_of(between), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(between));
  text.remove_prefix(word.size());
  return word;
}
/// Removes the next line from a text and returns it.
std::string_view next_line(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(line.size() + 1, text.size()));
  return line;
}

/// The number of type T in a word. The result has no value if the word holds anything else.
template <class T> std::optional<T> number_in(std::string_view word) {
  T number{};
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return number;
}

/// A word for messages: quoted, cut after 30 characters, with ? for bytes that are not printable ASCII.
std::string shown(std::string_view word) {
  std::string text = "\"";
  for (const char c : word.substr(0, 30)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (word.size() > 30 ? "...\"" : "\"");
}

/// A sentence about the fault of a word that must be a number, finite as a float; empty if there is none.
std::string fault_of_coordinate(std::string_view word) {
  const std::optional<double> x = number_in<double>(word);
  if (x && std::abs(*x) <= std::numeric_limits<float>::max()) return "";
  return "one of its coordinates is " + (word.empty() ? "missing" : shown(word)) + ", no finite number";
}

constexpr std::size_t stl_head = 84, stl_triangle = 50,
                      stl_normal = 12;  // sizes of the parts of a binary STL, bytes

std::string fault_of_binary_stl(std::string_view bytes) {
  if (bytes.size() < stl_head) return "it has " + std::to_string(bytes.size()) + " bytes, too few for an STL";
  const std::uint64_t count = number_at<std::uint32_t>(bytes, stl_head - 4),
                      needed = stl_head + stl_triangle * count;
  if (count == 0) return "it has no triangles";
  if (bytes.size() < needed)
    return "it says that it has " + std::to_string(count) + " triangles, which take " +
           std::to_string(needed) + " bytes, and has " + std::to_string(bytes.size());
  for (std::uint64_t k = 0; k < count; ++k)
    for (std::size_t c = 0; c < 9; ++c)
      if (!std::isfinite(number_at<float>(bytes, stl_head + stl_triangle * k + stl_normal + 4 * c)))
        return "a vertex of triangle " + std::to_string(k) + " is not finite";
  return "";
}

std::string fault_of_text_stl(std::string_view bytes) {
  std::size_t vertices = 0;
  for (std::string_view word = next_word(bytes); !word.empty(); word = next_word(bytes)) {
    if (word != "vertex") continue;
    ++vertices;
    for (int c = 0; c < 3; ++c)
      if (std::string fault = fault_of_coordinate(next_word(bytes)); !fault.empty()) return fault;
  }
  if (vertices == 0) return "it has no triangles";
  return vertices % 3 == 0 ? "" : "it has " + std::to_string(vertices) + " vertices; a triangle takes three";
}

/// Whether a corner of an OBJ face is one of the `vertices` before it, from 1 on or backwards from -1.
bool is_vertex(std::string_view word, std::int64_t vertices) {
  const std::optional<std::int64_t> index = number_in<std::int64_t>(word.substr(0, word.find('/')));
  return index && *index != 0 && *index >= -vertices && *index <= vertices;
}

/// Whether an STL is text, which begins with "solid" and, unlike binary files, has no zero bytes.
bool is_text_stl(std::string_view bytes) {
  return bytes.starts_with("solid") && bytes.substr(0, 1024).find('\0') == std::string_view::npos;
}

/// Removes the next three words from a text and returns them as the coordinates of a vertex.
Vec3<> vertex_in(std::string_view& text) {
  const auto next = [&] { return number_in<double>(next_word(text)).value_or(0); };
  const double x = next(), y = next(), z = next();
  return {x, y, z};
}

}  // namespace

std::string fault_of_stl(std::string_view bytes) {
  return is_text_stl(bytes) ? fault_of_text_stl(bytes) : fault_of_binary_stl(bytes);
}

std::vector<Vec3<>> vertices_of_stl(std::string_view bytes) {
  std::vector<Vec3<>> all;
  if (is_text_stl(bytes)) {
    for (std::string_view word = next_word(bytes); !word.empty(); word = next_word(bytes))
      if (word == "vertex") all.push_back(vertex_in(bytes));
    return all;
  }
  const std::size_t triangles = number_at<std::uint32_t>(bytes, stl_head - 4);
  for (std::size_t k = 0; k < triangles; ++k)
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::size_t at = stl_head + stl_triangle * k + stl_normal + 12 * corner;
      const auto x = [&](std::size_t c) { return double{number_at<float>(bytes, at + 4 * c)}; };
      all.push_back({x(0), x(1), x(2)});
    }
  return all;
}

std::string fault_of_obj(std::string_view bytes) {
  std::int64_t vertices = 0, faces = 0;
  while (!bytes.empty()) {
    std::string_view line = next_line(bytes);
    const std::string_view kind = next_word(line);
    if (kind == "v") {
      ++vertices;
      for (int c = 0; c < 3; ++c)
        if (std::string fault = fault_of_coordinate(next_word(line)); !fault.empty()) return fault;
    } else if (kind == "f") {
      ++faces;
      int corners = 0;
      for (std::string_view corner = next_word(line); !corner.empty(); corner = next_word(line), ++corners)
        if (!is_vertex(corner, vertices))
          return "face " + std::to_string(faces) + " has the corner " + shown(corner) + ", and there are " +
                 std::to_string(vertices) + " vertices before it";
      if (corners < 3) return "face " + std::to_string(faces) + " has fewer than three corners";
    }
  }
  return faces > 0 ? "" : "it has no faces";
}

std::vector<Vec3<>> vertices_of_obj(std::string_view bytes) {
  std::vector<Vec3<>> all;
  while (!bytes.empty()) {
    std::string_view line = next_line(bytes);
    if (next_word(line) == "v") all.push_back(vertex_in(line));
  }
  return all;
}

namespace {

/// The first f(element) that is not empty, of elements with a name among `from`, later siblings, descendants.
template <class F> std::string first_fault(const tinyxml2::XMLElement* from, const char* name, const F& f) {
  std::string fault;
  for (const tinyxml2::XMLElement* e = from; e != nullptr && fault.empty(); e = e->NextSiblingElement())
    fault = std::strcmp(e->Name(), name) == 0 ? f(*e) : first_fault(e->FirstChildElement(), name, f);
  return fault;
}

/// A sentence about numbers of a COLLADA array that are not finite or not as many as declared, or "".
std::string fault_of_numbers(const tinyxml2::XMLElement& array) {
  std::string_view text = array.GetText() == nullptr ? "" : array.GetText();
  std::uint64_t count = 0;
  for (std::string_view word = next_word(text); !word.empty(); word = next_word(text), ++count)
    if (std::string fault = fault_of_coordinate(word); !fault.empty()) return fault;
  std::uint64_t declared = count;
  array.QueryUnsigned64Attribute("count", &declared);
  return declared == count ? ""
                           : "one of its arrays says that it has " + std::to_string(declared) +
                                 " numbers, and has " + std::to_string(count);
}

}  // namespace

std::string fault_of_dae(std::string_view bytes) {
  tinyxml2::XMLDocument document;
  if (document.Parse(bytes.data(), bytes.size()) != tinyxml2::XML_SUCCESS)
    return "it is no well-formed XML, see its line " + std::to_string(document.ErrorLineNum());
  const tinyxml2::XMLElement* root = document.RootElement();
  if (root == nullptr || std::strcmp(root->Name(), "COLLADA") != 0) return "it is XML, and no COLLADA";
  bool any = false;
  std::string fault = first_fault(root, "geometry", [&](const tinyxml2::XMLElement& geometry) {
    any = true;
    return first_fault(geometry.FirstChildElement(), "float_array", fault_of_numbers);
  });
  return any || !fault.empty() ? fault : "it has no geometry";
}

namespace {

/// Parses JSON; is_discarded() of the result is true for text that is no JSON or has more than 64 levels.
Json parsed(std::string_view text) {
  const auto shallow = [](int depth, Json::parse_event_t, Json&) {
    if (depth > 64) throw std::out_of_range("too deep");
    return true;
  };
  try {
    return Json::parse(text, shallow);
  } catch (const std::exception&) {
    return Json(Json::value_t::discarded);
  }
}

constexpr std::array<const char*, 3> compressions{"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                                  "KHR_texture_basisu"};

/// Returns a sentence if a glTF needs another file, uses a compression that the viewer cannot read, or has no
/// mesh; otherwise an empty text. Throws Json::exception if the JSON is not that of a glTF.
std::string fault_of_references(const Json& json) {
  for (const char* list : {"buffers", "images"})
    for (const Json& each : json.value(list, Json::array()))
      if (const std::string uri = each.value("uri", "data:"); !uri.starts_with("data:"))
        return "it needs another file, " + shown(uri) + "; a .glb has everything in one";
  for (const Json& extension : json.value("extensionsRequired", Json::array()))
    for (const char* compression : compressions)
      if (extension.get<std::string>() == compression)
        return "it is compressed by " + std::string(compression) + ", which the page cannot read";
  return json.at("meshes").empty() ? "it has no meshes" : "";
}

/// A sentence about accessors of a glTF outside its buffer, or with floats that are not finite; or "".
std::string fault_of_buffer(const Json& json, std::string_view buffer) {
  const Json views = json.value("bufferViews", Json::array());
  for (const Json& each : json.value("accessors", Json::array())) {
    if (!each.contains("bufferView")) continue;
    const Json& view = views.at(each.at("bufferView").get<std::size_t>());
    if (view.at("buffer").get<std::size_t>() != 0) return "it has more than one buffer";
    const std::string type = each.at("type");
    const std::uint64_t component = each.at("componentType"), count = each.at("count"),
                        width = component >= 5125   ? 4
                                : component >= 5122 ? 2
                                                    : 1,
                        numbers = type == "SCALAR"          ? 1
                                  : type.starts_with("VEC") ? static_cast<std::uint64_t>(type.back() - '0')
                                                            : 16,
                        stride = std::max<std::uint64_t>(view.value("byteStride", std::uint64_t{0}),
                                                         numbers * width),
                        first = view.value("byteOffset", std::uint64_t{0}) +
                                each.value("byteOffset", std::uint64_t{0});
    const bool is_matrix = type.starts_with("MAT");
    if (first > buffer.size() || stride > buffer.size() || count > buffer.size() ||
        (!is_matrix && count > 0 && first + stride * (count - 1) + numbers * width > buffer.size()))
      return "an accessor has " + std::to_string(count) + " entries, more than its buffer holds";
    if (component != 5126 || is_matrix) continue;
    for (std::uint64_t k = 0; k < count; ++k)
      for (std::uint64_t c = 0; c < numbers; ++c)
        if (!std::isfinite(number_at<float>(buffer, first + stride * k + 4 * c)))
          return "entry " + std::to_string(k) + " of an accessor is not finite";
  }
  return "";
}

/// Parses JSON and returns f(json), or a sentence if the text is not JSON or f throws a Json::exception.
template <class F> std::string fault_of_json(std::string_view text, const F& f) {
  const Json json = parsed(text);
  if (json.is_discarded()) return "its JSON chunk is not JSON";
  try {
    return f(json);
  } catch (const Json::exception&) {
    return "its JSON is not that of a glTF";
  }
}

}  // namespace

std::string fault_of_gltf(std::string_view bytes) { return fault_of_json(bytes, fault_of_references); }

std::string fault_of_glb(std::string_view bytes) {
  constexpr std::size_t head = 12, chunk_head = 8;
  if (bytes.size() < head + chunk_head || !bytes.starts_with("glTF")) return "it is no binary glTF";
  const std::uint64_t version = number_at<std::uint32_t>(bytes, 4),
                      declared = number_at<std::uint32_t>(bytes, 8),
                      text = number_at<std::uint32_t>(bytes, head);
  if (version != 2) return "it is glTF of version " + std::to_string(version) + "; 2 can be read";
  if (declared != bytes.size())
    return "it says that it has " + std::to_string(declared) + " bytes, and has " +
           std::to_string(bytes.size());
  const std::uint64_t after = head + chunk_head + text;
  if (after > bytes.size()) return "its JSON is cut short";
  std::string_view buffer;
  if (after + chunk_head <= bytes.size()) {
    const std::uint64_t length = number_at<std::uint32_t>(bytes, after);
    if (after + chunk_head + length > bytes.size()) return "its buffer is cut short";
    buffer = bytes.substr(after + chunk_head, length);
  }
  return fault_of_json(bytes.substr(head + chunk_head, text), [&](const Json& json) {
    const std::string fault = fault_of_references(json);
    return fault.empty() ? fault_of_buffer(json, buffer) : fault;
  });
}

}  // namespace axode::view
