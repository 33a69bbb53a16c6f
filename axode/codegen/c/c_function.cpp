#include "axode/codegen/c/c_function.hpp"

#include <array>
#include <charconv>
#include <utility>

#include "axode/codegen/c/emitter.hpp"

namespace axode::codegen {
namespace {

/// Writes a function in C for one state. Sines and cosines that can be computed together are, by one call.
class CEmitter : public Emitter {
 public:
  CEmitter(const Recording& recording, const Precision& precision, std::string sine_cosine)
      : Emitter(recording, precision), sine_cosine_(std::move(sine_cosine)) {}

 protected:
  /// Length of the arrays for this number of angles, filled up to whole registers.
  virtual int room(std::size_t angles) const {
    const int n = static_cast<int>(angles);
    return n <= 2 ? 2 : n <= 4 ? 4 : (n + 7) / 8 * 8;
  }
  std::string text(int k) override {
    if (is_turned(node(k)) && is_cut()) current().keeps = true;
    return Emitter::text(k);
  }

 private:
  void add_turn(std::size_t k) override {
    std::vector<int>& angles = turns_[numbers_[k].stage].angles;
    if (std::ranges::find(angles, node(k).a) == angles.end()) angles.push_back(node(k).a);
  }
  int slots_of_turns() const override {
    int slots = 0;
    for (const Turn& turn : turns_) slots += 3 * room(turn.angles.size());
    return slots;
  }
  void write_turn(std::size_t stage) override {
    const std::vector<int>& angles = turns_[stage].angles;
    if (angles.empty()) return;
    const std::string number = turns_.size() > 2 ? std::to_string(stage) : "";
    const int n = room(angles.size());
    std::array<std::string, 3> arrays{"angle" + number, "sine" + number, "cosine" + number};
    if (is_cut()) {
      for (int k = 0; k < n; ++k)
        body() += "  " + kept(turned_ + k) + " = " +
                  (k < std::ssize(angles) ? text(angles[k]) : precision_.literal(0)) + ";\n";
      for (int k = 0; k < 3; ++k) arrays[k] = "s + " + std::to_string(turned_ + k * n);
    } else {
      std::string list;
      for (const int k : angles) list += (list.empty() ? "" : ", ") + text(k);
      body() += filled("  const @T@ @ANGLE@[@N@] = {@LIST@};\n  @T@ @SINE@[@N@], @COSINE@[@N@];\n",
                       {{"T", type()},
                        {"N", std::to_string(n)},
                        {"ANGLE", arrays[0]},
                        {"SINE", arrays[1]},
                        {"COSINE", arrays[2]},
                        {"LIST", list}});
    }
    body() += "  " + sine_cosine_ + '(' + arrays[0] + ", " + arrays[1] + ", " + arrays[2] + ", " +
              std::to_string(n) + ");\n";
    for (std::size_t k = 0; k < numbers_.size(); ++k) {
      Number& x = numbers_[k];
      if (!x.needed || x.stage != static_cast<int>(stage) || !is_turned(node(k))) continue;
      const int array = node(k).operation == sine ? 1 : 2,
                at = static_cast<int>(std::ranges::find(angles, node(k).a) - angles.begin());
      x.text = is_cut() ? entry("s", turned_ + array * n + at) : entry(arrays[array], at);
    }
    if (is_cut()) turned_ += 3 * n;
  }

  std::string sine_cosine_;
  int turned_ = 0;  ///< slots of the array s that sines and cosines have taken so far
};

/// Writes a function in C that computes several states at once, one in each lane of a SIMD vector.
class LanesEmitter final : public CEmitter {
 public:
  using CEmitter::CEmitter;

 private:
  std::string type() const override { return "axode_lanes"; }
  std::string type_of_conditions() const override { return "axode_mask"; }
  std::string head(const std::string& name) const override {
    return c_declaration(
        recording_,
        std::string("static ") + (recording_.returns_singularity ? "axode_mask " : "void ") + name, type(),
        scratch());
  }
  std::string scratch_array() const override { return is_cut() ? "" : "  (void)s;\n"; }
  std::string constant(double value) const override { return "axode_all(" + precision_.literal(value) + ')'; }
  std::string constant_condition(bool value) const override {
    return value ? "~(axode_mask){0}" : "(axode_mask){0}";
  }
  std::string condition_as_number(const std::string& text) const override { return "(axode_lanes)" + text; }
  std::string number_as_condition(const std::string& text) const override {
    return "((axode_mask)" + text + ')';
  }
  int room(std::size_t angles) const override { return static_cast<int>(angles); }
  /// The text of node k as a number with lanes, even if the node is a constant.
  std::string spread(int k) { return is_literal(node(k)) ? "axode_all(" + text(k) + ')' : text(k); }
  std::string expression(const Tape::Node& x) override {
    switch (x.operation) {
      case root: return "axode_root(" + text(x.a) + ')';
      case angle: return "axode_angle(" + spread(x.a) + ", " + spread(x.b) + ')';
      case choice: return "axode_select(" + text(x.condition) + ", " + spread(x.a) + ", " + spread(x.b) + ')';
      case less:
      case less_equal: return "(axode_mask)(" + Emitter::expression(x) + ')';
      case negation: return '~' + text(x.a);
      default: return Emitter::expression(x);
    }
  }
};

}  // namespace

std::string filled(std::string text, std::initializer_list<std::pair<const char*, std::string>> values) {
  for (const auto& [key, value] : values) {
    const std::string mark = std::string("@") + key + '@';
    for (std::size_t at = 0; (at = text.find(mark, at)) != std::string::npos; at += value.size())
      text.replace(at, mark.size(), value);
  }
  return text;
}

std::string Precision::literal(double x) const {
  const double value = single ? static_cast<float>(x) : x;
  if (std::isnan(value)) return "(0.0 / 0.0)";
  if (std::isinf(value)) return value < 0 ? "(-1.0 / 0.0)" : "(1.0 / 0.0)";
  char digits[32];
  const auto [end, error] = single ? std::to_chars(digits, digits + sizeof digits, static_cast<float>(x))
                                   : std::to_chars(digits, digits + sizeof digits, x);
  std::string text(digits, end);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return single ? text + 'f' : text;
}

bool calls_math_library(const Recording& recording) {
  using enum Tape::Operation;
  const std::vector<char> need = needed(recording);
  for (std::size_t k = 0; k < need.size(); ++k)
    if (need[k] && (recording.nodes[k].operation == root || recording.nodes[k].operation == angle))
      return true;
  return false;
}

std::string c_declaration(const Recording& recording, const std::string& head, const std::string& type,
                          const std::string& tail) {
  std::string text = head + "(\n    ";
  for (const std::string& argument : recording.arguments)
    text += "const " + type + " *AXODE_RESTRICT " + argument + ", ";
  return text + type + " *AXODE_RESTRICT " + recording.result + tail + ')';
}

std::string c_signature(const Recording& recording, const std::string& name, const Precision& precision,
                        const std::string& tail) {
  return c_declaration(recording, (recording.returns_singularity ? "int " : "void ") + name, precision.type(),
                       tail);
}

Definition c_definition(const Recording& recording, const std::string& name, const std::string& sine_cosine,
                        const Precision& precision) {
  return CEmitter(recording, precision, sine_cosine).definition(name);
}
Definition lanes_definition(const Recording& recording, const std::string& name,
                            const std::string& sine_cosine, const Precision& precision) {
  return LanesEmitter(recording, precision, sine_cosine + "_lanes").definition(name);
}

}  // namespace axode::codegen
