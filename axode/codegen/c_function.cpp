#include "axode/codegen/c_function.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "axode/scalar/sine_cosine.hpp"

namespace axode::codegen {
namespace {

using enum Tape::Operation;

/// `text` with every @KEY@ replaced.
std::string filled(std::string text, std::initializer_list<std::pair<const char*, std::string>> values) {
  for (const auto& [key, value] : values) {
    const std::string mark = std::string("@") + key + '@';
    for (std::size_t at = 0; (at = text.find(mark, at)) != std::string::npos; at += value.size())
      text.replace(at, mark.size(), value);
  }
  return text;
}

/// The statements of one function, in the order in which its numbers were recorded. Whatever has to wait for
/// sines comes after them: stage k for what needs sines of numbers of stage k - 1.
class Statements {
 public:
  Statements(const Recording& recording, const Precision& precision, const std::string& sine_cosine)
      : recording_(recording),
        precision_(precision),
        sine_cosine_(sine_cosine),
        text_(size()),
        stage_(size()) {
    const std::vector<char> need = needed(recording);
    std::vector<int> uses(size()), uses_in_sums(size());
    for (std::size_t k = 0; k < size(); ++k) {
      if (!need[k]) continue;
      const Tape::Node& x = node(k);
      for (const int from : operands(x)) {
        const auto i = static_cast<std::size_t>(from);
        ++uses[i], uses_in_sums[i] += x.operation == sum;
        stage_[k] = std::max(stage_[k], stage_[i]);
      }
      if (x.operation == sine || x.operation == cosine) ++stage_[k];
      stages_ = std::max(stages_, stage_[k] + 1);
    }
    std::vector<std::vector<std::size_t>> results(size());  // by the number that they are multiples of
    for (std::size_t r = 0; r < recording.results.size(); ++r) {
      const auto k = static_cast<std::size_t>(recording.results[r].node());
      results[k].push_back(r), ++uses[k];
    }
    for (int stage = 0; stage < stages_; ++stage) {
      if (stage > 0) turn(stage, need);
      for (std::size_t k = 0; k < size(); ++k) {
        if (!need[k] || stage_[k] != stage) continue;
        // What only one sum needs stays in it, where product and sum may become one instruction.
        if (node(k).operation == product && uses[k] == 1 && uses_in_sums[k] == 1)
          text_[k] = expression(node(k));
        else if (text_[k].empty())
          define(k);
        for (const std::size_t r : results[k]) write_result(r);  // at once, so that k need not be kept
      }
    }
    if (recording.returns_doubt)
      body_ += "  return " +
               (recording.doubt.is_constant() ? std::to_string(recording.doubt.constant())
                                              : text(recording.doubt.node())) +
               ";\n";
  }

  const std::string& text() const { return body_; }

 private:
  std::size_t size() const { return recording_.nodes.size(); }
  const Tape::Node& node(std::size_t k) const { return recording_.nodes[k]; }
  const std::string& text(int k) const { return text_[static_cast<std::size_t>(k)]; }

  /// All sines and cosines of a stage at once.
  void turn(int stage, const std::vector<char>& need) {
    std::vector<int> angles;
    const std::string number = stages_ > 2 ? std::to_string(stage) : "";
    for (std::size_t k = 0; k < size(); ++k) {
      const Tape::Node& x = node(k);
      if (!need[k] || stage_[k] != stage || (x.operation != sine && x.operation != cosine)) continue;
      std::size_t at =
          static_cast<std::size_t>(std::find(angles.begin(), angles.end(), x.a) - angles.begin());
      if (at == angles.size()) angles.push_back(x.a);
      text_[k] = (x.operation == sine ? "sine" : "cosine") + number + '[' + std::to_string(at) + ']';
    }
    if (angles.empty()) return;
    // Whole registers, so that no angle is left to a loop of its own.
    const std::size_t n = angles.size(), room = n <= 2 ? 2 : n <= 4 ? 4 : (n + 7) / 8 * 8;
    std::string list;
    for (const int angle : angles) list += (list.empty() ? "" : ", ") + text(angle);
    body_ += filled(
        "  const @T@ angle@K@[@N@] = {@LIST@};\n"
        "  @T@ sine@K@[@N@], cosine@K@[@N@];\n"
        "  @CALL@(angle@K@, sine@K@, cosine@K@, @N@);\n",
        {{"T", precision_.type()},
         {"K", number},
         {"N", std::to_string(room)},
         {"LIST", list},
         {"CALL", sine_cosine_}});
  }

  void write_result(std::size_t r) {
    const Trace& x = recording_.results[r];
    body_ +=
        "  " + recording_.result + '[' + std::to_string(r) + "] = " + scaled(x.factor(), x.node()) + ";\n";
  }

  void define(std::size_t k) {
    const Tape::Node& x = node(k);
    if (x.operation == input) {
      text_[k] = recording_.arguments[static_cast<std::size_t>(x.a)] + '[' + std::to_string(x.b) + ']';
    } else if (x.operation == one || (x.operation == scale && x.a == 0)) {
      text_[k] = precision_.literal(x.factor);
    } else {
      text_[k] = 't' + std::to_string(++temporaries_);
      const bool condition = x.operation == less || x.operation == less_equal || x.operation == both ||
                             x.operation == either || x.operation == negation;
      body_ += std::string("  const ") + (condition ? "int " : precision_.type() + std::string(" ")) +
               text_[k] + " = " + expression(x) + ";\n";
    }
  }

  std::string expression(const Tape::Node& x) const {
    const std::string &a = text(x.a), &b = text(x.b);
    switch (x.operation) {
      case scale: return scaled(x.factor, x.a);
      case sum: return a + (x.factor < 0 ? " - " : " + ") + scaled(std::abs(x.factor), x.b);
      case product: return a + " * " + b;
      case reciprocal: return precision_.literal(1) + " / " + a;
      case root: return std::string(precision_.single ? "sqrtf(" : "sqrt(") + a + ')';
      case angle: return std::string(precision_.single ? "atan2f(" : "atan2(") + a + ", " + b + ')';
      case choice: return text(x.condition) + " ? " + a + " : " + b;
      case less: return a + " < " + b;
      case less_equal: return a + " <= " + b;
      case both: return a + " & " + b;
      case either: return a + " | " + b;
      case negation: return '!' + a;
      default: return {};  // has a name already
    }
  }
  /// A node times a factor.
  std::string scaled(double factor, int k) const {
    if (k == 0) return precision_.literal(factor);
    return (factor == 1 ? "" : factor == -1 ? "-" : precision_.literal(factor) + " * ") + text(k);
  }

  const Recording& recording_;
  const Precision& precision_;
  const std::string& sine_cosine_;
  std::vector<std::string> text_;  ///< of each number: its name, or what it is
  std::vector<int> stage_;
  int stages_ = 1, temporaries_ = 0;
  std::string body_;
};

}  // namespace

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
  const std::vector<char> need = needed(recording);
  for (std::size_t k = 0; k < need.size(); ++k)
    if (need[k] && (recording.nodes[k].operation == root || recording.nodes[k].operation == angle))
      return true;
  return false;
}

std::string c_signature(const Recording& recording, const std::string& name, const Precision& precision) {
  const std::string type = precision.type();
  std::string text = (recording.returns_doubt ? "int " : "void ") + name + "(\n    ";
  for (const std::string& argument : recording.arguments)
    text.append("const ").append(type).append(" *AXODE_RESTRICT ").append(argument).append(", ");
  return text + type + " *AXODE_RESTRICT " + recording.result + ')';
}

std::string c_definition(const Recording& recording, const std::string& name, const std::string& sine_cosine,
                         const Precision& precision) {
  const std::vector<char> need = needed(recording);
  std::vector<char> is_read(recording.arguments.size());
  for (std::size_t k = 0; k < need.size(); ++k)
    if (need[k] && recording.nodes[k].operation == input)
      is_read[static_cast<std::size_t>(recording.nodes[k].a)] = 1;
  const std::string statements = Statements(recording, precision, sine_cosine).text();
  std::string unused;
  for (std::size_t k = 0; k < is_read.size(); ++k)
    if (!is_read[k]) unused += "  (void)" + recording.arguments[k] + ";\n";
  if (recording.results.empty()) unused += "  (void)" + recording.result + ";\n";
  return c_signature(recording, name, precision) + " {\n" + unused + statements + "}\n";
}

std::string c_sine_cosine(const std::string& name, const Precision& precision) {
  namespace reduced = reduced_angle;
  const auto polynomial = [&](const auto& c) {
    std::string text = precision.literal(c[std::size(c) - 1]);
    for (std::size_t k = std::size(c) - 1; k-- > 0;)
      text.insert(0, 1, '(').append(" * z + ").append(precision.literal(c[k])).append(1, ')');
    return text;
  };
  const auto number = [](double x) { return Precision{false}.literal(x); };
  return filled(
      R"(/* Sines and cosines without a branch, so that several are computed at once: x = m pi/2 + r + low with
   pi/2 in parts whose products with m are exact, and polynomials in r. The error is below 2 units in the
   last place for |x| <= 1e5. */
static void @NAME@(
    const @T@ *AXODE_RESTRICT angle, @T@ *AXODE_RESTRICT sine, @T@ *AXODE_RESTRICT cosine, int count) {
  int k;
  for (k = 0; k < count; ++k) {
    const double x = (double)angle[k], m = (x * @TWO_OVER_PI@ + @ROUNDER@) - @ROUNDER@;
    const double u = x - m * @PART_0@, m1 = m * @PART_1@, m2 = m * @PART_2@;
    const double u1 = u - m1, u2 = u1 - m2;
    const double rest = (((u - u1) - m1) + ((u1 - u2) - m2)) - m * @PART_3@;
    const @T@ quadrant = (@T@)(m - 4.0 * ((m * 0.25 + @ROUNDER@) - @ROUNDER@));
    const @T@ r = (@T@)u2, low = (@T@)rest, z = r * r, half = @0.5@ * z, c = @1@ - half;
    const @T@ p = @SINE@;
    const @T@ g = @COSINE@;
    const @T@ s1 = r + (r * z * p + low * c), c1 = c + (((@1@ - c) - half) + (z * z * g - r * low));
    const int odd = quadrant * quadrant == @1@;
    const @T@ s2 = odd ? c1 : s1, c2 = odd ? s1 : c1;
    sine[k] = ((quadrant < -@0.5@) | (quadrant > @1.5@)) ? -s2 : s2;
    cosine[k] = ((quadrant > @0.5@) | (quadrant < -@1.5@)) ? -c2 : c2;
  }
}
)",
      {{"NAME", name},
       {"T", precision.type()},
       {"TWO_OVER_PI", number(reduced::two_over_pi)},
       {"ROUNDER", number(reduced::rounder)},
       {"PART_0", number(reduced::part[0])},
       {"PART_1", number(reduced::part[1])},
       {"PART_2", number(reduced::part[2])},
       {"PART_3", number(reduced::part[3])},
       {"SINE", precision.single ? polynomial(reduced::sine<float>) : polynomial(reduced::sine<double>)},
       {"COSINE",
        precision.single ? polynomial(reduced::cosine<float>) : polynomial(reduced::cosine<double>)},
       {"0.5", precision.literal(0.5)},
       {"1", precision.literal(1)},
       {"1.5", precision.literal(1.5)}});
}

}  // namespace axode::codegen
