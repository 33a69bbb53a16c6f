#include "axode/io/toml_scan.hpp"

namespace axode::io {
namespace {

constexpr int most_dots = 500;

class Scan {
 public:
  explicit Scan(std::string_view text) : text_(text) { skip("\xEF\xBB\xBF"); }

  std::optional<Stray> run() {
    bool at_start = true;  // of a line, but for blanks
    int depth = 0, dots = 0;
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        while (at_ < text_.size() && text_[at_] != '\n') ++at_;
        continue;
      }
      if (c == '"' || c == '\'') {
        if (!skip_text(c)) return std::nullopt;
        at_start = false;
        continue;
      }
      ++at_;
      if (static_cast<unsigned char>(c) >= 0x80)
        return Stray{"a character beyond ASCII may stand only in a text in quotes or in a comment", line_};
      if (c == '.' && ++dots > most_dots)
        return Stray{"more than 500 dots in one line; no drawing needs them", line_};
      if (c == '[' && at_start && depth == 0 && !header_has_key())
        return Stray{"a table header needs a key", line_};
      if (c == '[' || c == '{') ++depth;
      if (c == ']' || c == '}') --depth;
      if (c == '\n') ++line_, dots = 0;
      at_start = c == '\n' || (at_start && (c == ' ' || c == '\t'));
    }
    return std::nullopt;
  }

 private:
  bool skip(std::string_view word) {
    const bool there = text_.substr(at_).starts_with(word);
    if (there) at_ += word.size();
    return there;
  }

  /// Whether a key follows [ or [[ or, which the parser reports, nothing in between.
  bool header_has_key() const {
    std::size_t k = at_;
    if (k < text_.size() && text_[k] == '[') ++k;
    while (k < text_.size() && (text_[k] == ' ' || text_[k] == '\t')) ++k;
    if (k >= text_.size()) return true;
    const char c = text_[k];
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '"' || c == '\'' || c == ']';
  }

  /// Past a text in quotes, one or three on each side; false where it does not end.
  bool skip_text(char quote) {
    const char three[] = {quote, quote, quote, '\0'};
    const bool long_text = skip(three);
    if (!long_text) ++at_;
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '\n' && !long_text) return false;
      if (c == '\n') ++line_;
      if (c == '\\' && quote == '"') {
        at_ += 1;
        if (at_ < text_.size() && text_[at_] == '\n') continue;  // a line that goes on
        at_ += 1;
      } else if (!long_text) {
        ++at_;
        if (c == quote) return true;
      } else if (skip(three)) {
        for (int more = 0; more < 2 && at_ < text_.size() && text_[at_] == quote; ++more) ++at_;
        return true;
      } else {
        ++at_;
      }
    }
    return false;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

}  // namespace

std::optional<Stray> find_stray(std::string_view text) { return Scan(text).run(); }

}  // namespace axode::io
