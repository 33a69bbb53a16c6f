#pragma once
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "axode/io/drawing/toml.hpp"
#include "axode/io/foreign_terms.hpp"
#include "axode/io/reading.hpp"
#include "axode/model/building/nearest_name.hpp"

/// Access to the tables of a drawing. Keys are read one by one, and a fault is added for each that is wrong.
namespace axode::io {

/// The names of all kinds in a table such as joint_kinds, as the choices of a key.
template <class Traits, std::size_t N>
constexpr std::array<std::string_view, N> names_of(const std::array<Traits, N>& kinds) {
  std::array<std::string_view, N> names;
  std::ranges::transform(kinds, names.begin(), &Traits::name);
  return names;
}

/// The choices of a key that says in which frame numbers are given.
inline constexpr std::array<std::string_view, 2> frame_names{"construction", "body"};

/// The list of faults of one file, and the name of the file.
struct Notes {
  std::vector<Fault>& faults;
  std::string file;
  Strictness strictness;

  void error(Rule rule, std::string element, std::string message, int line) const {
    faults.push_back({Severity::error, rule, std::move(element), std::move(message), {file, line}});
  }
  /// Adds a defect that is accepted by lenient readers: an error for a strict one, else a warning.
  void doubt(Rule rule, std::string element, std::string message, int line) const {
    const Severity severity = strictness == Strictness::lenient ? Severity::warning : Severity::error;
    faults.push_back({severity, rule, std::move(element), std::move(message), {file, line}});
  }
};

/// One table of a drawing (a TOML file that describes a mechanism). Each reading function takes the value of
/// a key and returns it, or an empty result if the key is absent or its value is wrong; a wrong value is
/// reported as a fault. At the end, finish() reports the keys that were not read.
class Table {
 public:
  Table(const Notes& notes, const toml::Value& table, std::string element)
      : notes_(notes), entries_(*table.table()), line_(table.line), element_(std::move(element)) {}

  int line() const { return line_; }
  const std::string& file() const { return notes_.file; }
  bool has(std::string_view key) const { return entries_.contains(key); }
  const toml::Value* look(std::string_view key) const {
    const auto found = entries_.find(key);
    return found == entries_.end() ? nullptr : found->second.value;
  }
  void rename(std::string element) { element_ = std::move(element); }
  const std::string& element() const { return element_; }
  /// The number of faults in the file so far.
  std::size_t faults() const { return notes_.faults.size(); }

  const toml::Value* take(std::string_view key) {
    known_.emplace_back(key);
    return look(key);
  }
  void error(Rule rule, std::string message, const toml::Value* at = nullptr) const {
    notes_.error(rule, element_, std::move(message), at == nullptr ? line() : at->line);
  }
  void wrong(std::string_view key, const toml::Value& value, std::string_view need) const;
  void missing(std::string_view key, std::string_view need) const {
    error(Rule::missing_element, "has no " + std::string(key) + "; " + std::string(need));
  }
  /// Adds a fault if the table has a key that other tables of this type have and this one must not have.
  void refuse(std::string_view key, std::string_view reason) {
    if (const toml::Value* node = take(key))
      error(Rule::unknown_element, std::string(key) + " has no meaning here: " + std::string(reason), node);
  }
  void finish() const;

  std::optional<std::string> text(std::string_view key);
  /// A name that the table must have. If it is missing or wrong, a fault is added and the result is empty.
  std::string name(std::string_view key, std::string_view need);
  template <std::size_t N>
  std::optional<std::size_t> choice(std::string_view key, const std::array<std::string_view, N>& choices) {
    const toml::Value* node = take(key);
    if (node == nullptr) return std::nullopt;
    if (const auto* value = node->text()) {
      const auto found = std::find(choices.begin(), choices.end(), *value);
      if (found != choices.end()) return static_cast<std::size_t>(found - choices.begin());
    }
    std::string list = N == 1 ? "it must be " : "it is one of ";
    for (std::size_t k = 0; k < N; ++k)
      list += (k == 0 ? "" : k + 1 == N ? " or " : ", ") + in_quotes(choices[k]);
    const auto* value = node->text();
    if (value != nullptr && N > 1) {
      const std::string called = own_term_for(*value, choices);
      list += called.empty() ? did_you_mean(*value, choices, [](std::string_view c) { return c; }) : called;
    }
    wrong(key, *node, list);
    return std::nullopt;
  }

  std::optional<double> number(std::string_view key, bool may_be_infinite = false);
  bool flag(std::string_view key);
  template <std::size_t N>
  std::optional<std::array<double, N>> numbers(std::string_view key, bool may_be_infinite = false) {
    const toml::Value* node = take(key);
    if (node == nullptr) return std::nullopt;
    std::array<double, N> out{};
    const Found found = read_numbers(key, *node, out, may_be_infinite);
    if (found == Found::wrong) wrong(key, *node, "it needs " + std::to_string(N) + " numbers in brackets");
    return found == Found::good ? std::optional(out) : std::nullopt;
  }
  std::optional<Vec3<>> vector(std::string_view key) {
    const auto x = numbers<3>(key);
    return x ? std::optional(Vec3<>{(*x)[0], (*x)[1], (*x)[2]}) : std::nullopt;
  }
  /// Red, green, blue and opacity, 0 to 1. If only three numbers are given, the opacity is 1.
  std::optional<std::array<double, 4>> color(std::string_view key);
  /// A direction, given by three numbers or by the name of an axis, such as "-x".
  std::optional<Vec3<>> direction(std::string_view key);
  /// N rows of three numbers. `need` is the part of a message that says what the key needs.
  template <std::size_t N>
  std::optional<std::array<Vec3<>, N>> rows(std::string_view key, std::string_view need) {
    const toml::Value* node = take(key);
    if (node == nullptr) return std::nullopt;
    std::array<Vec3<>, N> m{};
    const auto* given = node->array();
    Found found = given != nullptr && given->size() == N ? Found::good : Found::wrong;
    for (std::size_t i = 0; i < N && found == Found::good; ++i) {
      std::array<double, 3> x{};
      found = read_numbers(key, *(*given)[i], x, false);
      m[i] = {x[0], x[1], x[2]};
    }
    if (found == Found::wrong) wrong(key, *node, need);
    return found == Found::good ? std::optional(m) : std::nullopt;
  }
  std::optional<SO3<>> matrix(std::string_view key) {
    const auto m = rows<3>(key, "it needs three rows of three numbers");
    return m ? std::optional(transpose(SO3<>{(*m)[0], (*m)[1], (*m)[2]})) : std::nullopt;
  }
  /// A pair of names, an array of two texts. Messages about faults contain `need`, what the key needs.
  std::optional<std::array<std::string, 2>> pair_of_names(std::string_view key, std::string_view need);
  /// Pairs of names, given as an array of arrays of two texts; empty if the key is absent.
  std::vector<std::array<std::string, 2>> pairs_of_names(std::string_view key, std::string_view need);
  /// The keys of a table inside this one, each with its number; empty if there is no such table.
  std::vector<std::pair<std::string, double>> named_numbers(std::string_view key);
  /// The numbers of an array of any length, which must be finite.
  std::optional<std::vector<double>> list(std::string_view key, std::string_view need);

  /// These functions read a number or a list that must be given. If it is absent or wrong, a fault is added
  /// and the result is 0 or an empty list. `unit` and `need` say in the message of this fault what is
  /// expected.
  double needed_number(std::string_view key, std::string_view unit);
  std::vector<double> needed_list(std::string_view key, std::string_view need);
  /// The keys of a table in this one, each with one or several numbers; empty if there is no such table.
  std::vector<std::pair<std::string, std::vector<double>>> named_lists(std::string_view key);
  /// A symmetric tensor: Ixx Iyy Izz, Ixx Iyy Izz Ixy Ixz Iyz, or the three rows of a symmetric matrix.
  std::optional<Sym3<>> symmetric(std::string_view key);

  /// The rotation in `rotation` (rows of a matrix), `quaternion` (x y z w) or `rpy` (roll, pitch and yaw,
  /// rad); the identity if none of these keys is given or it is wrong.
  SO3<> rotation();
  SE3<> pose() {
    const Vec3<> r = vector("position").value_or(Vec3<>{});
    return {rotation(), r};
  }

  /// The table inside this one with the given key.
  std::optional<Table> table(std::string_view key);
  std::optional<SE3<>> pose(std::string_view key);
  std::optional<std::array<SE3<>, 2>> pair_of_poses(std::string_view key, std::string_view need);
  /// The tables of an array of tables; empty if the key is absent. Messages contain `need`.
  std::vector<Table> tables(std::string_view key, const std::string& need);

 private:
  /// Reads the table that this one has at the key `key`. Calls read(table, name, entry) for each entry of
  /// that table, and returns pairs of the entry's name and its result. Entries whose result is empty are left
  /// out with their names. Returns no pairs if there is no such table.
  template <class T, class Read>
  std::vector<std::pair<std::string, T>> named(std::string_view key, const Read& read);
  /// Reads an array of N numbers into `out`. A fault is added only for a number that is not finite.
  enum class Found { good, wrong, not_finite };
  template <std::size_t N>
  Found read_numbers(std::string_view key, const toml::Value& value, std::array<double, N>& out,
                     bool may_be_infinite) const {
    const toml::Array* array = value.array();
    if (array == nullptr || array->size() != N) return Found::wrong;
    for (std::size_t k = 0; k < N; ++k) {
      const double* x = (*array)[k]->number();
      if (x == nullptr) return Found::wrong;
      if (!finite(key, *(*array)[k], *x, may_be_infinite)) return Found::not_finite;
      out[k] = *x;
    }
    return Found::good;
  }
  static std::optional<std::array<std::string, 2>> two_names(const toml::Value& value);
  bool finite(std::string_view key, const toml::Value& at, double x, bool may_be_infinite) const;

  Notes notes_;
  const toml::Table& entries_;
  int line_;
  std::string element_;
  std::vector<std::string> known_;
};

}  // namespace axode::io
