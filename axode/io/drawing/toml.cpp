#include "axode/io/drawing/toml.hpp"

#include <charconv>
#include <cstdint>
#include <limits>
#include <utility>

#include "axode/io/reading.hpp"

namespace axode::io::toml {
namespace {

using MadeBy = Value::MadeBy;

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_hex_digit(char c) { return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); }
bool is_octal_digit(char c) { return c >= '0' && c <= '7'; }
bool is_binary_digit(char c) { return c == '0' || c == '1'; }
bool is_bare(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c) || c == '_' || c == '-';
}
bool is_blank(char c) { return c == ' ' || c == '\t'; }
/// Whether a comment or a text must not hold the character.
bool is_forbidden(char c) { return is_control(c) && c != '\t'; }

/// Reads the number in a word. plain_ collects the characters that were read, without underscores.
class NumberScan {
 public:
  explicit NumberScan(std::string_view word) : rest_(word) {}

  /// Reads a decimal number: [+-] integer [. digits] [e [+-] digits]. Empty if the word is anything else.
  std::optional<double> decimal() {
    if (!rest_.empty() && (rest_[0] == '+' || rest_[0] == '-')) take();
    const std::string_view whole = rest_;
    if (!digits(is_digit)) return std::nullopt;
    const bool leading_zero = whole[0] == '0' && whole.size() > 1 && (is_digit(whole[1]) || whole[1] == '_');
    if (leading_zero) return std::nullopt;
    if (!rest_.empty() && rest_[0] == '.') {
      take();
      if (!digits(is_digit)) return std::nullopt;
    }
    if (!rest_.empty() && (rest_[0] == 'e' || rest_[0] == 'E')) {
      take();
      if (!rest_.empty() && (rest_[0] == '+' || rest_[0] == '-')) take();
      if (!digits(is_digit)) return std::nullopt;
    }
    if (!rest_.empty()) return std::nullopt;
    const Number x = io::number(plain_);
    return x.broken ? std::nullopt : std::optional(x.value);
  }

  /// Reads an integer of at most 64 bits after 0x, 0o or 0b; empty if there is none. is_one() tells digits.
  std::optional<double> of_base(int base, bool (*is_one)(char)) {
    rest_.remove_prefix(2);
    std::uint64_t value = 0;
    if (!digits(is_one) || !rest_.empty()) return std::nullopt;
    const auto [end, failure] = std::from_chars(plain_.data(), plain_.data() + plain_.size(), value, base);
    return failure == std::errc{} ? std::optional(static_cast<double>(value)) : std::nullopt;
  }

 private:
  void take() {
    plain_ += rest_[0];
    rest_.remove_prefix(1);
  }
  /// Reads one or more digits, with single underscores between them. Returns false if there is none.
  bool digits(bool (*is_one)(char)) {
    if (rest_.empty() || !is_one(rest_[0])) return false;
    while (!rest_.empty() && is_one(rest_[0])) {
      take();
      if (rest_.size() > 1 && rest_[0] == '_' && is_one(rest_[1])) rest_.remove_prefix(1);
    }
    return true;
  }

  std::string_view rest_;
  std::string plain_;
};

std::optional<double> number_in(std::string_view word) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (word == "inf" || word == "+inf") return infinity;
  if (word == "-inf") return -infinity;
  if (word == "nan" || word == "+nan" || word == "-nan") return std::numeric_limits<double>::quiet_NaN();
  if (word.starts_with("0x")) return NumberScan(word).of_base(16, is_hex_digit);
  if (word.starts_with("0o")) return NumberScan(word).of_base(8, is_octal_digit);
  if (word.starts_with("0b")) return NumberScan(word).of_base(2, is_binary_digit);
  return NumberScan(word).decimal();
}

/// Whether a word begins like a date, 1979-05-27, or like a time of day, 07:32.
bool looks_like_date(std::string_view word) {
  const auto digits = [&](std::size_t from, std::size_t count) {
    for (std::size_t k = from; k < from + count; ++k)
      if (k >= word.size() || !is_digit(word[k])) return false;
    return true;
  };
  const bool day = digits(0, 4) && digits(5, 2) && digits(8, 2) && word[4] == '-' && word[7] == '-';
  const bool time = digits(0, 2) && digits(3, 2) && word[2] == ':';
  return day || time;
}

class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  Document run() {
    document_.values.push_back({Table{}, 1, MadeBy::header});
    section_ = &document_.values.front();
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;  // a byte order mark
    try {
      while (skip_blank_lines()) {
        if (peek() == '[') {
          header();
        } else {
          key_and_value(*section_, "a key, a [header] or a comment");
        }
        end_of_line();
      }
    } catch (Failure& failure) {
      document_.failure = std::move(failure);
    }
    return std::move(document_);
  }

 private:
  struct Key {
    std::string name;
    int line;
  };

  // ---------------------------------------------------------------- characters

  bool at_end() const { return at_ >= text_.size(); }
  char peek(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }
  bool take(std::string_view word) {
    const bool there = text_.substr(at_).starts_with(word);
    if (there) at_ += word.size();
    return there;
  }
  bool take_newline() {
    const bool there = take("\n") || take("\r\n");
    line_ += there;
    return there;
  }
  void skip_blanks() {
    while (is_blank(peek())) ++at_;
  }
  void skip_comment() {
    if (peek() != '#') return;
    while (!at_end() && peek() != '\n' && !(peek() == '\r' && peek(1) == '\n')) {
      if (is_forbidden(peek())) fail("a comment must not hold control characters");
      ++at_;
    }
  }
  /// Skips blank lines and comments. Returns false at the end of the file.
  bool skip_blank_lines() {
    do {
      skip_blanks();
      skip_comment();
    } while (take_newline());
    return !at_end();
  }
  void end_of_line() {
    skip_blanks();
    skip_comment();
    if (!take_newline() && !at_end()) expected("the end of the line");
  }

  [[noreturn]] void fail(std::string message) const { throw Failure{std::move(message), line_}; }
  [[noreturn]] void fail(std::string message, int line) const { throw Failure{std::move(message), line}; }
  /// Throws a Failure whose message says what was expected and what was found.
  [[noreturn]] void expected(const std::string& what) const {
    std::size_t length = 1;
    while (is_bare(peek(length - 1)) && is_bare(peek(length)) && length < 30) ++length;
    while ((static_cast<unsigned char>(peek(length)) & 0xC0) == 0x80) ++length;  // the rest of a character
    const bool at_newline = peek() == '\n' || peek() == '\r',
               beyond_ascii = static_cast<unsigned char>(peek()) > 0x7f;
    fail("expected " + what + ", found " +
         (at_end()     ? "the end of the file"
          : at_newline ? "the end of the line"
                       : in_quotes(text_.substr(at_, length))) +
         (beyond_ascii ? ", a character beyond ASCII, which needs a text in quotes" : ""));
  }

  // ---------------------------------------------------------------- keys and tables

  Key key(const std::string& what) {
    if (peek() == '"' || peek() == '\'') {
      if (take("\"\"\"") || take("'''")) fail("a key must be a text of one line");
      const int line = line_;
      return {text_in_quotes(), line};
    }
    const std::size_t begin = at_;
    while (is_bare(peek())) ++at_;
    if (at_ == begin) expected(what);
    return {std::string(text_.substr(begin, at_ - begin)), line_};
  }
  /// Reads a dotted key such as a.b.c. `what` says in a message what was expected.
  std::vector<Key> dotted_key(const std::string& what) {
    std::vector<Key> keys{key(what)};
    for (skip_blanks(); peek() == '.'; skip_blanks()) {
      ++at_;
      skip_blanks();
      keys.push_back(key("a key after the dot"));
    }
    return keys;
  }

  Value& make(Value value) { return document_.values.emplace_back(std::move(value)); }
  static Value* find(Value& table, const Key& key) {
    Table& entries = std::get<Table>(table.content);
    const auto found = entries.find(key.name);
    return found == entries.end() ? nullptr : found->second.value;
  }
  Value& add(Value& table, const Key& key, Value value) {
    Value& made = make(std::move(value));
    std::get<Table>(table.content).emplace(key.name, Entry{key.line, &made});
    return made;
  }
  [[noreturn]] void given_twice(const Key& key, const Value& before) const {
    fail(in_quotes(key.name) + " is given twice, first in line " + std::to_string(before.line), key.line);
  }

  /// Reads a header [a.b.c] or [[a.b.c]], makes the tables that it names, and sets section_ to the last one.
  void header() {
    const bool is_array = take("[[");
    if (!is_array) take("[");
    const std::string brackets = is_array ? "]]" : "]";
    const int line = line_;
    skip_blanks();
    const std::vector<Key> keys = dotted_key("the name of a table");
    if (!take(brackets)) expected("\"" + brackets + "\"");

    Value* at = &document_.values.front();
    for (std::size_t k = 0; k + 1 < keys.size(); ++k) {
      Value* next = find(*at, keys[k]);
      if (next == nullptr) next = &add(*at, keys[k], {Table{}, line, MadeBy::longer_header});
      if (Array* array = std::get_if<Array>(&next->content);
          array != nullptr && next->made_by == MadeBy::header)
        next = array->back();
      if (next->table() == nullptr || next->made_by == MadeBy::value) given_twice(keys[k], *next);
      at = next;
    }
    Value* last = find(*at, keys.back());
    if (is_array) {
      if (last == nullptr) last = &add(*at, keys.back(), {Array{}, line, MadeBy::header});
      if (last->array() == nullptr || last->made_by != MadeBy::header) given_twice(keys.back(), *last);
      section_ = &make({Table{}, line, MadeBy::header});
      std::get<Array>(last->content).push_back(section_);
    } else {
      if (last == nullptr) last = &add(*at, keys.back(), {Table{}, line, MadeBy::longer_header});
      if (last->table() == nullptr || last->made_by != MadeBy::longer_header) given_twice(keys.back(), *last);
      last->made_by = MadeBy::header;
      last->line = line;
      section_ = last;
    }
  }

  /// Reads a line such as a.b.c = value, and adds the value to the table.
  void key_and_value(Value& table, const std::string& what) {
    const std::vector<Key> keys = dotted_key(what);
    if (!take("=")) expected("\"=\" after the key " + in_quotes(keys.back().name));
    skip_blanks();
    Value* at = &table;
    for (std::size_t k = 0; k + 1 < keys.size(); ++k) {
      Value* next = find(*at, keys[k]);
      if (next == nullptr) next = &add(*at, keys[k], {Table{}, keys[k].line, MadeBy::dotted_key});
      if (next->table() == nullptr || next->made_by != MadeBy::dotted_key) given_twice(keys[k], *next);
      at = next;
    }
    if (const Value* before = find(*at, keys.back())) given_twice(keys.back(), *before);
    Value& made = value();
    std::get<Table>(at->content).emplace(keys.back().name, Entry{keys.back().line, &made});
  }

  // ---------------------------------------------------------------- values

  Value& value() {
    constexpr int deepest = 16;
    const int line = line_;
    if (peek() == '"' || peek() == '\'') return make({text_of_any_length(), line});
    if (peek() != '[' && peek() != '{') return make({word(), line});
    if (++depth_ > deepest) fail("values are nested more than " + std::to_string(deepest) + " deep");
    Value& made = make({Table{}, line});
    if (peek() == '[') {
      made.content = array();
    } else {
      inline_table(made);
    }
    --depth_;
    return made;
  }

  Array array() {
    Array items;
    const int first = line_;
    ++at_;
    while (skip_blank_lines() && peek() != ']') {
      items.push_back(&value());
      skip_blank_lines();
      if (!take(",")) break;
    }
    skip_blank_lines();
    if (!take("]")) expected("\",\" or \"]\" in the array that begins in line " + std::to_string(first));
    return items;
  }

  void inline_table(Value& table) {
    ++at_;
    skip_blanks();
    if (take("}")) return;
    do {
      skip_blanks();
      if (peek() == '\n' || peek() == '\r')
        fail("a table in braces must be in one line; or write each key in its own, such as joint.name = ...");
      key_and_value(table, "a key in a table in braces");
      skip_blanks();
    } while (take(","));
    if (!take("}")) expected("\",\" or \"}\" in a table in braces, all in one line");
    close(table);
  }
  /// Marks a table in braces, with the tables that dotted keys made in it, as closed to additions.
  static void close(Value& table) {
    std::vector<Value*> open{&table};
    while (!open.empty()) {
      Value* at = open.back();
      open.pop_back();
      at->made_by = MadeBy::value;
      for (const auto& [name, entry] : std::get<Table>(at->content))
        if (entry.value->made_by == MadeBy::dotted_key) open.push_back(entry.value);
    }
  }

  /// Reads a number, a truth value or a date.
  decltype(Value::content) word() {
    const auto belongs = [](char c) { return is_bare(c) || c == '+' || c == '.' || c == ':'; };
    std::size_t length = 0;
    while (belongs(peek(length))) ++length;
    const std::string_view word = text_.substr(at_, length);
    if (word.empty()) expected("a value");
    at_ += length;
    if (word == "true" || word == "false") return word == "true";
    if (looks_like_date(word)) {
      if (peek() == ' ' && looks_like_date(text_.substr(at_ + 1, 5))) {  // a time of day may follow the date
        ++at_;
        while (belongs(peek())) ++at_;
      }
      return Date{};
    }
    if (const auto x = number_in(word)) return *x;
    fail(in_quotes(word) + " is neither a number that fits nor a text in quotes");
  }

  std::string text_of_any_length() {
    for (const std::string_view three : {"\"\"\"", "'''"})
      if (take(three)) return long_text(three);
    return text_in_quotes();
  }
  /// Reads "text" or 'text'.
  std::string text_in_quotes() {
    const char quote = peek();
    std::string text;
    for (++at_; peek() != quote;) {
      if (at_end() || peek() == '\n' || peek() == '\r') fail("a text in quotes does not end in its line");
      character(quote, text);
    }
    ++at_;
    return text;
  }
  /// Reads the rest of a text after its opening quotes `three`, """ or ''', possibly of several lines.
  std::string long_text(std::string_view three) {
    const int first = line_;
    std::string text;
    take_newline();
    while (!take(three)) {
      if (at_end()) fail("a text in " + std::string(three) + " does not end", first);
      if (three[0] == '"' && goes_on_in_next_line()) continue;
      if (take_newline()) {
        text += '\n';
      } else {
        character(three[0], text);
      }
    }
    for (int more = 0; more < 2 && peek() == three[0]; ++more) text += text_[at_++];
    return text;
  }
  /// Skips a backslash at the end of a line and the white space after it; returns false if there is none.
  bool goes_on_in_next_line() {
    std::size_t k = 1;
    if (peek() != '\\') return false;
    while (is_blank(peek(k))) ++k;
    if (peek(k) != '\n' && !(peek(k) == '\r' && peek(k + 1) == '\n')) return false;
    at_ += k;
    while (take_newline()) skip_blanks();
    return true;
  }

  void character(char quote, std::string& text) {
    if (is_forbidden(peek())) fail("a text must not hold control characters");
    if (peek() == '\\' && quote == '"') {
      ++at_;
      escape(text);
    } else {
      text += text_[at_++];
    }
  }
  void escape(std::string& text) {
    constexpr std::string_view letters = "btnfr\"\\", meanings = "\b\t\n\f\r\"\\";
    const char c = peek();
    const std::size_t known = at_end() ? std::string_view::npos : letters.find(c);
    if (known != std::string_view::npos) {
      text += meanings[known];
      ++at_;
    } else if (c == 'u' || c == 'U') {
      const std::string_view digits = text_.substr(at_ + 1, c == 'u' ? 4 : 8);
      std::uint32_t code = 0;
      const auto [end, failure] = std::from_chars(digits.data(), digits.data() + digits.size(), code, 16);
      const bool whole = end == digits.data() + digits.size() && digits.size() == (c == 'u' ? 4U : 8U);
      if (failure != std::errc{} || !whole || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF))
        fail("a \\u needs the four and a \\U the eight hexadecimal digits of a character");
      append_utf8(code, text);
      at_ += 1 + digits.size();
    } else {
      fail("there is no escape \\" + std::string(c > ' ' ? 1 : 0, c) + "; write \\\\ for a backslash");
    }
  }
  static void append_utf8(std::uint32_t code, std::string& text) {
    const auto tail = [&](int shift) { text += static_cast<char>(0x80 | ((code >> shift) & 0x3F)); };
    if (code < 0x80) {
      text += static_cast<char>(code);
    } else if (code < 0x800) {
      text += static_cast<char>(0xC0 | (code >> 6));
      tail(0);
    } else if (code < 0x10000) {
      text += static_cast<char>(0xE0 | (code >> 12));
      tail(6);
      tail(0);
    } else {
      text += static_cast<char>(0xF0 | (code >> 18));
      tail(12);
      tail(6);
      tail(0);
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1, depth_ = 0;
  Document document_;
  Value* section_ = nullptr;  ///< the table that the last header opened
};

}  // namespace

Document parse(std::string_view text) { return Parser(text).run(); }

}  // namespace axode::io::toml
