#include "axode/io/drawing/drawing_table.hpp"

#include <cmath>

#include "axode/io/pose.hpp"
#include "axode/model/building/checks/value_checks.hpp"

namespace axode::io {
namespace {

/// A value of TOML as messages show it, such as `"knee"`, `1.5` or `an array of 3`.
std::string shown(const toml::Value& value) {
  if (const auto* text = value.text()) return in_quotes(*text);
  if (const auto* x = value.number()) return to_text(*x);
  if (const auto* flag = value.flag()) return *flag ? "true" : "false";
  if (const auto* array = value.array()) return "an array of " + std::to_string(array->size());
  return value.table() != nullptr ? "a table" : "a date";
}

}  // namespace

void Table::wrong(std::string_view key, const toml::Value& value, std::string_view need) const {
  error(Rule::wrong_value, std::string(key) + " is " + shown(value) + "; " + std::string(need), &value);
}

void Table::finish() const {
  for (const auto& [key, entry] : entries_) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    std::string nearest = own_term_for(key, known_);
    if (nearest.empty()) nearest = did_you_mean(key, known_, [](std::string_view k) { return k; });
    notes_.error(Rule::unknown_element, element_, "key " + in_quotes(key) + " is not known" + nearest,
                 entry.line);
  }
}

std::optional<std::string> Table::text(std::string_view key) {
  const toml::Value* node = take(key);
  if (node == nullptr) return std::nullopt;
  const std::string* value = node->text();
  if (value != nullptr && printable(*value)) return *value;
  wrong(key, *node, value == nullptr ? "it needs a text in quotes" : "it must not hold control characters");
  return std::nullopt;
}

std::string Table::name(std::string_view key, std::string_view need) {
  const bool given = has(key);
  const auto value = text(key);
  if (!given) missing(key, need);
  if (value && value->empty())
    error(Rule::missing_name, std::string(key) + " is empty; " + std::string(need));
  return value.value_or("");
}

std::optional<double> Table::number(std::string_view key, bool may_be_infinite) {
  const toml::Value* node = take(key);
  if (node == nullptr) return std::nullopt;
  const double* x = node->number();
  if (x == nullptr) wrong(key, *node, "it needs a number");
  return x != nullptr && finite(key, *node, *x, may_be_infinite) ? std::optional(*x) : std::nullopt;
}

bool Table::flag(std::string_view key) {
  const toml::Value* node = take(key);
  if (node == nullptr) return false;
  if (node->flag() == nullptr) wrong(key, *node, "it needs true or false");
  return node->flag() != nullptr && *node->flag();
}

std::optional<std::array<double, 4>> Table::color(std::string_view key) {
  const toml::Value* node = look(key);
  if (node == nullptr || node->array() == nullptr || node->array()->size() != 3) return numbers<4>(key);
  const auto x = numbers<3>(key);
  return x ? std::optional(std::array<double, 4>{(*x)[0], (*x)[1], (*x)[2], 1}) : std::nullopt;
}

std::optional<Vec3<>> Table::direction(std::string_view key) {
  const toml::Value* node = look(key);
  if (node == nullptr || node->text() == nullptr) return vector(key);
  constexpr std::array<std::string_view, 6> names{"x", "y", "z", "-x", "-y", "-z"};
  const auto chosen = choice(key, names);
  if (!chosen) return std::nullopt;
  const double sign = *chosen < 3 ? 1 : -1;
  const std::size_t k = *chosen % 3;
  return Vec3<>{k == 0 ? sign : 0, k == 1 ? sign : 0, k == 2 ? sign : 0};
}

std::optional<std::array<std::string, 2>> Table::two_names(const toml::Value& value) {
  const auto* array = value.array();
  std::array<std::string, 2> names;
  if (array == nullptr || array->size() != 2) return std::nullopt;
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string* name = (*array)[k]->text();
    if (name == nullptr || !printable(*name) || name->empty()) return std::nullopt;
    names[k] = *name;
  }
  return names;
}

std::optional<std::array<std::string, 2>> Table::pair_of_names(std::string_view key, std::string_view need) {
  const toml::Value* node = take(key);
  if (node == nullptr) return std::nullopt;
  auto names = two_names(*node);
  if (!names) wrong(key, *node, need);
  return names;
}

std::vector<std::array<std::string, 2>> Table::pairs_of_names(std::string_view key, std::string_view need) {
  const toml::Value* node = take(key);
  if (node == nullptr) return {};
  std::vector<std::array<std::string, 2>> pairs;
  if (node->array() == nullptr) {
    wrong(key, *node, need);
    return pairs;
  }
  for (const toml::Value* entry : *node->array()) {
    if (auto names = two_names(*entry))
      pairs.push_back(std::move(*names));
    else
      error(Rule::wrong_value, std::string(key) + " holds " + shown(*entry) + "; " + std::string(need),
            entry);
  }
  return pairs;
}

template <class T, class Read>
std::vector<std::pair<std::string, T>> Table::named(std::string_view key, const Read& read) {
  std::vector<std::pair<std::string, T>> all;
  auto inner = table(key);
  if (!inner) return all;
  inner->rename(std::string(key) + " of " + element_);
  for (const auto& [name, entry] : inner->entries_) {
    if (!printable(name))
      inner->error(Rule::wrong_value, in_quotes(name) + " must not hold control characters", entry.value);
    if (std::optional<T> x = read(*inner, name, *entry.value)) all.emplace_back(name, std::move(*x));
  }
  return all;
}

std::vector<std::pair<std::string, double>> Table::named_numbers(std::string_view key) {
  return named<double>(
      key, [](Table& inner, const std::string& name, const toml::Value&) { return inner.number(name); });
}

std::vector<std::pair<std::string, std::vector<double>>> Table::named_lists(std::string_view key) {
  using Vector = std::vector<double>;
  return named<Vector>(key, [](Table& inner, const std::string& name, const toml::Value& entry) {
    if (entry.number() == nullptr) return inner.list(name, "it needs a number, or numbers in brackets");
    const std::optional<double> x = inner.number(name);
    return x ? std::optional(Vector{*x}) : std::nullopt;
  });
}

std::optional<std::vector<double>> Table::list(std::string_view key, std::string_view need) {
  const toml::Value* node = take(key);
  if (node == nullptr) return std::nullopt;
  std::vector<double> all;
  const auto* array = node->array();
  bool good = array != nullptr;
  for (std::size_t k = 0; good && k < array->size(); ++k) {
    const toml::Value& entry = *(*array)[k];
    good = entry.number() != nullptr;
    if (!good) break;
    if (!finite(key, entry, *entry.number(), false)) return std::nullopt;
    all.push_back(*entry.number());
  }
  if (good) return all;
  wrong(key, *node, need);
  return std::nullopt;
}

double Table::needed_number(std::string_view key, std::string_view unit) {
  if (!has(key)) missing(key, "give it in " + std::string(unit));
  return number(key).value_or(0);
}
std::vector<double> Table::needed_list(std::string_view key, std::string_view need) {
  if (!has(key)) missing(key, need);
  return list(key, need).value_or(std::vector<double>{});
}

std::optional<Sym3<>> Table::symmetric(std::string_view key) {
  const toml::Value* node = look(key);
  const auto* array = node == nullptr ? nullptr : node->array();
  if (array != nullptr && array->size() == 3 && array->front()->array() != nullptr) {
    const auto A = matrix(key);
    if (!A) return std::nullopt;
    const double largest = std::max({std::abs(A->x.x), std::abs(A->y.y), std::abs(A->z.z)});
    const double skew =
        std::max({std::abs(A->x.y - A->y.x), std::abs(A->x.z - A->z.x), std::abs(A->y.z - A->z.y)});
    if (skew <= 1e-9 * largest) return Sym3<>{A->x.x, A->y.y, A->z.z, A->y.x, A->z.x, A->z.y};
    wrong(key, *node, "its rows must form a symmetric matrix");
    return std::nullopt;
  }
  if (array != nullptr && array->size() == 3) {
    const auto d = vector(key);
    return d ? std::optional(Sym3<>{d->x, d->y, d->z, 0, 0, 0}) : std::nullopt;
  }
  if (node != nullptr && (array == nullptr || array->size() != 6)) {
    take(key);
    wrong(key, *node,
          "it needs [Ixx, Iyy, Izz], [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] or three rows of three numbers");
    return std::nullopt;
  }
  const auto t = numbers<6>(key);
  return t ? std::optional(Sym3<>{(*t)[0], (*t)[1], (*t)[2], (*t)[3], (*t)[4], (*t)[5]}) : std::nullopt;
}

SO3<> Table::rotation() {
  constexpr std::array<std::string_view, 3> ways{"rotation", "quaternion", "rpy"};
  if (std::count_if(ways.begin(), ways.end(), [&](std::string_view way) { return has(way); }) > 1)
    error(Rule::wrong_value, "gives more than one of rotation, quaternion and rpy; one is enough");
  std::optional<SO3<>> R;
  if (const auto rows = matrix("rotation")) {
    R = rows;
    if (!is_rotation(*rows)) {
      error(Rule::not_a_rotation,
            "rotation is not one: RᵀR must be the identity to 1e-6 and the determinant +1", look("rotation"));
      R.reset();
    }
  }
  if (const auto x = numbers<4>("quaternion")) {
    R = from_quaternion({(*x)[0], (*x)[1], (*x)[2], (*x)[3]});
    if (!R)
      error(Rule::not_a_rotation,
            "quaternion has a norm that differs from 1 by more than 1e-6; its order is x, y, z, w",
            look("quaternion"));
  }
  if (const auto angles = numbers<3>("rpy")) {
    const auto [roll, pitch, yaw] = *angles;
    R = from_roll_pitch_yaw({roll, pitch, yaw});
    if (auto complaint = degrees_complaint("rpy is", *angles))
      notes_.doubt(Rule::wrong_value, element_, std::move(*complaint), look("rpy")->line);
  }
  return R.value_or(SO3<>{});
}

std::optional<Table> Table::table(std::string_view key) {
  const toml::Value* node = take(key);
  if (node == nullptr) return std::nullopt;
  if (node->table() != nullptr) return Table(notes_, *node, element_);
  wrong(key, *node, "it needs a table, { key = value, ... }");
  return std::nullopt;
}

std::optional<SE3<>> Table::pose(std::string_view key) {
  auto inner = table(key);
  if (!inner) return std::nullopt;
  const SE3<> C = inner->pose();
  inner->finish();
  return C;
}

std::optional<std::array<SE3<>, 2>> Table::pair_of_poses(std::string_view key, std::string_view need) {
  const toml::Value* node = take(key);
  if (node == nullptr) return std::nullopt;
  const auto* array = node->array();
  const auto is_table = [](const toml::Value* entry) { return entry->table() != nullptr; };
  if (array == nullptr || array->size() != 2 || !std::ranges::all_of(*array, is_table)) {
    wrong(key, *node, need);
    return std::nullopt;
  }
  std::array<SE3<>, 2> poses;
  for (std::size_t k = 0; k < 2; ++k) {
    Table inner(notes_, *(*array)[k], element_);
    poses[k] = inner.pose();
    inner.finish();
  }
  return poses;
}

std::vector<Table> Table::tables(std::string_view key, const std::string& need) {
  const toml::Value* node = take(key);
  if (node == nullptr) return {};
  std::vector<Table> all;
  const auto* array = node->array();
  if (array == nullptr) {
    wrong(key, *node, need);
  } else {
    for (const toml::Value* entry : *array) {
      if (entry->table() != nullptr) {
        all.emplace_back(notes_, *entry, element_);
      } else {
        error(Rule::wrong_value, std::string(key) + " holds " + shown(*entry) + "; " + need, entry);
      }
    }
  }
  return all;
}

bool Table::finite(std::string_view key, const toml::Value& at, double x, bool may_be_infinite) const {
  if (std::isfinite(x) || (may_be_infinite && std::isinf(x))) return true;
  error(Rule::non_finite_number, std::string(key) + " holds " + to_text(x) + ", which is not finite", &at);
  return false;
}

}  // namespace axode::io
