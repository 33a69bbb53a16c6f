#include "axode/codegen/c_function.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "axode/codegen/statement_order.hpp"

namespace axode::codegen {
namespace {

using enum Tape::Operation;

/// The statements of one function, in the order in which its numbers were recorded. Whatever has to wait for
/// sines comes after them: stage k for what needs sines of numbers of stage k - 1. A thread takes sines one by one, and its
/// statements are in the order in which it needs the fewest registers.
class Statements {
 public:
  Statements(const Recording& recording, const Precision& precision, const std::string& sine_cosine,
             Width width)
      : recording_(recording),
        precision_(precision),
        sine_cosine_(sine_cosine),
        width_(width),
        need_(needed(recording)),
        stage_(size()),
        stays_in_sum_(size()),
        text_(size()),
        part_(size(), -1),
        last_part_(size(), -1),
        slot_(size(), -1),
        loaded_in_(size(), -1) {
    order();
    if (on_thread()) order_for_thread();
    cut();
    if (on_thread()) write_constants();
    for (const Step& step : steps_) {
      enter(step.part);
      if (step.kind == Step::turn)
        on_thread() ? turn_on_thread(step.index) : turn(static_cast<int>(step.index));
      else if (step.kind == Step::define)
        define(step.index);
      else
        write_result(step.index);
    }
    enter(n_parts());
    if (recording.returns_singularity)
      body() +=
          "  return " +
          (recording.maybe_singular.is_constant() ? constant_condition(recording.maybe_singular.constant())
                                                  : text(recording.maybe_singular.node())) +
          ";\n";
  }

  /// The last one is the function itself; where there is but one, it is all there is.
  struct Part {
    std::string text;
    std::vector<char> reads;  ///< of the arguments
    bool writes_results = false, keeps = false;
  };
  const std::vector<Part>& parts() const { return parts_; }
  int scratch() const { return slots_; }

 private:
  struct Step {
    enum Kind { define, turn, result } kind;
    std::size_t index;  ///< of a node, a stage (of a thread: the node of an angle), a result
    int part = 0;
  };

  std::size_t size() const { return recording_.nodes.size(); }
  const Tape::Node& node(std::size_t k) const { return recording_.nodes[k]; }
  bool in_lanes() const { return width_ == Width::lanes; }
  bool on_thread() const { return width_ == Width::thread; }
  /// In statements. The longer a part, the more time compilers take for each of them; but a thread of a GPU keeps in far
  /// memory what one part hands on to the next.
  std::size_t longest_part() const { return on_thread() ? 1500 : 500; }
  const char* type() const { return in_lanes() ? "axode_lanes" : precision_.type(); }
  int n_parts() const { return static_cast<int>((steps_.size() + longest_part() - 1) / longest_part()); }
  bool is_cut() const { return n_parts() > 1; }
  static bool is_turned(const Tape::Node& x) { return x.operation == sine || x.operation == cosine; }
  static bool is_literal(const Tape::Node& x) {
    return x.operation == one || (x.operation == scale && x.a == 0);
  }
  static bool is_condition(const Tape::Node& x) {
    return x.operation == less || x.operation == less_equal || x.operation == both || x.operation == either ||
           x.operation == negation;
  }

  void order() {
    std::vector<int> uses(size()), uses_in_sums(size());
    int stages = 1;
    for (std::size_t k = 0; k < size(); ++k) {
      if (!need_[k]) continue;
      for (const int from : operands(node(k))) {
        const auto i = static_cast<std::size_t>(from);
        ++uses[i], uses_in_sums[i] += node(k).operation == sum;
        stage_[k] = std::max(stage_[k], stage_[i]);
      }
      if (is_turned(node(k)) && !on_thread()) ++stage_[k];
      stages = std::max(stages, stage_[k] + 1);
    }
    std::vector<std::vector<std::size_t>> results(size());  // by the number that they are multiples of
    for (std::size_t r = 0; r < recording_.results.size(); ++r) {
      if (on_thread() && recording_.results[r].is_constant()) continue;
      const auto k = static_cast<std::size_t>(recording_.results[r].node());
      results[k].push_back(r), ++uses[k];
    }
    angles_.resize(static_cast<std::size_t>(stages));
    for (int stage = 0; stage < stages; ++stage) {
      if (stage > 0) steps_.push_back({Step::turn, static_cast<std::size_t>(stage)});
      for (std::size_t k = 0; k < size(); ++k) {
        if (!need_[k] || stage_[k] != stage) continue;
        const Tape::Node& x = node(k);
        // What only one sum needs stays in it, where product and sum may become one instruction.
        stays_in_sum_[k] = x.operation == product && uses[k] == 1 && uses_in_sums[k] == 1;
        if (x.operation == input)
          text_[k] = recording_.arguments[static_cast<std::size_t>(x.a)] + '[' + std::to_string(x.b) + ']';
        else if (is_literal(x))
          text_[k] = precision_.literal(x.factor);
        else if (is_turned(x))
          on_thread() ? add_turn(k) : add_angle(stage, x.a);
        else if (!stays_in_sum_[k])
          steps_.push_back({Step::define, k});
        for (const std::size_t r : results[k])  // at once, so that k need not be kept
          steps_.push_back({Step::result, r});
      }
    }
  }
  void add_angle(int stage, int angle) {
    std::vector<int>& all = angles_[static_cast<std::size_t>(stage)];
    if (std::find(all.begin(), all.end(), angle) == all.end()) all.push_back(angle);
  }

  /// The sine and the cosine of an angle are one step.
  void add_turn(std::size_t k) {
    const auto angle = static_cast<std::size_t>(node(k).a);
    turned_from_.resize(size());
    if (turned_from_[angle].empty()) steps_.push_back({Step::turn, angle});
    turned_from_[angle].push_back(k);
    text_[k] = (node(k).operation == sine ? "sine" : "cosine") + std::to_string(angle);
  }
  /// The numbers with a name that a step makes.
  std::vector<std::size_t> made_by(const Step& step) const {
    if (step.kind == Step::define) return {step.index};
    if (step.kind == Step::turn && on_thread()) return turned_from_[step.index];
    return {};
  }
  /// Calls use(k) for each number with a name that a step needs.
  template <class Use> void each_use(const Step& step, const Use& use) const {
    if (step.kind == Step::define)
      each_use(step.index, use);
    else if (step.kind == Step::result)
      each_use_of(static_cast<std::size_t>(recording_.results[step.index].node()), use);
    else if (on_thread())
      each_use_of(step.index, use);
    else
      for (const int angle : angles_[step.index]) each_use_of(static_cast<std::size_t>(angle), use);
  }
  void order_for_thread() {
    std::vector<int> maker(size(), -1), lasting;
    for (std::size_t s = 0; s < steps_.size(); ++s)
      for (const std::size_t k : made_by(steps_[s])) maker[k] = static_cast<int>(s);
    std::vector<std::vector<int>> operands(steps_.size());
    for (std::size_t s = 0; s < steps_.size(); ++s) {
      std::vector<int>& from = operands[s];
      each_use(steps_[s], [&](std::size_t k) {
        if (maker[k] >= 0 && std::ranges::find(from, maker[k]) == from.end()) from.push_back(maker[k]);
      });
    }
    if (!recording_.maybe_singular.is_constant() && maker[singularity_node()] >= 0)
      lasting.push_back(maker[singularity_node()]);
    std::vector<Step> ordered;
    for (const int s : order_for_few_registers(operands, lasting))
      ordered.push_back(steps_[static_cast<std::size_t>(s)]);
    steps_ = ordered;
  }

  /// Which part each number is made in, the last one that it is used in, and where it is kept in between.
  void cut() {
    const std::size_t count = static_cast<std::size_t>(std::max(n_parts(), 1)),
                      balanced = std::max<std::size_t>((steps_.size() + count - 1) / count, 1);
    for (std::size_t s = 0; s < steps_.size(); ++s) {
      Step& step = steps_[s];
      step.part = static_cast<int>(s / balanced);
      for (const std::size_t k : made_by(step)) part_[k] = step.part;
      each_use(step, [&](std::size_t k) { last_part_[k] = step.part; });
    }
    if (!recording_.maybe_singular.is_constant()) last_part_[singularity_node()] = n_parts();
    parts_.resize(is_cut() ? static_cast<std::size_t>(n_parts()) + 1 : 1);
    for (Part& part : parts_) part.reads.resize(recording_.arguments.size());
    if (!is_cut()) return;
    for (std::vector<int>& angles : angles_) slots_ += on_thread() ? 0 : 3 * room(angles.size());
    std::vector<int> idle;
    std::vector<std::vector<int>> freed(parts_.size() + 1);
    int part = -1;
    for (const Step& step : steps_) {
      if (step.part != part) {
        part = step.part;
        const std::vector<int>& now = freed[static_cast<std::size_t>(part)];
        idle.insert(idle.end(), now.begin(), now.end());
      }
      for (const std::size_t k : made_by(step)) {
        if (last_part_[k] <= part) continue;
        if (idle.empty()) idle.push_back(slots_++);
        slot_[k] = idle.back();
        idle.pop_back();
        freed[static_cast<std::size_t>(last_part_[k]) + 1].push_back(slot_[k]);
      }
    }
  }
  /// Calls use(k) for each number with a name that number `of` is made from.
  template <class Use> void each_use(std::size_t of, const Use& use) const {
    for (const int from : operands(node(of))) each_use_of(static_cast<std::size_t>(from), use);
  }
  template <class Use> void each_use_of(std::size_t k, const Use& use) const {
    if (stays_in_sum_[k])
      each_use(k, use);
    else
      use(k);
  }

  std::size_t singularity_node() const { return static_cast<std::size_t>(recording_.maybe_singular.node()); }

  void enter(int part) {
    if (is_cut()) now_ = part;
  }
  Part& current() { return parts_[is_cut() ? static_cast<std::size_t>(now_) : 0]; }
  std::string& body() { return current().text; }
  std::string kept(int slot) {
    current().keeps = true;
    return "s[" + std::to_string(slot) + ']';
  }

  /// As many angles as fill whole registers, so that none is left to a loop of its own.
  int room(std::size_t angles) const {
    const int n = static_cast<int>(angles);
    return in_lanes() ? n : n <= 2 ? 2 : n <= 4 ? 4 : (n + 7) / 8 * 8;
  }
  /// An entry of an array of a thread: those of its state are n apart.
  static std::string entry(const std::string& array, std::size_t k) {
    return "axode_at<" + std::to_string(k) + ">(" + array + ", n)";
  }
  void keep(std::size_t k) {
    if (slot_[k] >= 0)
      body() += "  " + kept(slot_[k]) + " = " + (is_condition(node(k)) && in_lanes() ? "(axode_lanes)" : "") +
                text_[k] + ";\n";
  }
  void turn_on_thread(std::size_t angle) {
    const std::string x = text(static_cast<int>(angle)), number = std::to_string(angle);
    body() += filled("  @T@ sine@K@, cosine@K@;\n  @CALL@@X@, &sine@K@, &cosine@K@);\n",
                     {{"T", type()}, {"K", number}, {"CALL", called("", "sincos")}, {"X", x}});
    for (const std::size_t k : turned_from_[angle]) keep(k);
  }
  /// What results there are that depend on nothing, most of them zeros, in loops where several are neighbours.
  void write_constants() {
    const std::vector<Trace>& results = recording_.results;
    for (std::size_t first = 0, end; first < results.size(); first = end) {
      end = first + 1;
      if (!results[first].is_constant()) continue;
      current().writes_results = true;
      const double value = results[first].factor();
      while (end < results.size() && results[end].is_constant() && results[end].factor() == value) ++end;
      if (end - first < 3)
        for (std::size_t r = first; r < end; ++r)
          body() += "  " + entry(recording_.result, r) + " = " + precision_.literal(value) + ";\n";
      else
        body() += filled("#pragma unroll 1\n  for (int k = @A@; k < @B@; ++k) @Y@[(long long)k * n] = @X@;\n",
                         {{"A", std::to_string(first)},
                          {"B", std::to_string(end)},
                          {"Y", recording_.result},
                          {"X", precision_.literal(value)}});
    }
  }

  /// All sines and cosines of a stage at once.
  void turn(int stage) {
    const std::vector<int>& angles = angles_[static_cast<std::size_t>(stage)];
    if (angles.empty()) return;
    const std::string number = angles_.size() > 2 ? std::to_string(stage) : "";
    const int n = room(angles.size());
    std::array<std::string, 3> arrays{"angle" + number, "sine" + number, "cosine" + number};
    if (is_cut()) {
      for (std::string& array : arrays) {
        const std::string from = "s + " + std::to_string(turned_);
        for (int k = 0; &array == arrays.data() && k < n; ++k)
          body() +=
              "  " + kept(turned_ + k) + " = " +
              (k < std::ssize(angles) ? text(angles[static_cast<std::size_t>(k)]) : precision_.literal(0)) +
              ";\n";
        array = from;
        turned_ += n;
      }
    } else {
      std::string list;
      for (const int angle : angles) list += (list.empty() ? "" : ", ") + text(angle);
      body() += filled("  const @T@ @ANGLE@[@N@] = {@LIST@};\n  @T@ @SINE@[@N@], @COSINE@[@N@];\n",
                       {{"T", type()},
                        {"N", std::to_string(n)},
                        {"ANGLE", arrays[0]},
                        {"SINE", arrays[1]},
                        {"COSINE", arrays[2]},
                        {"LIST", list}});
    }
    body() += "  " + sine_cosine_ + (in_lanes() ? "_lanes(" : "(") + arrays[0] + ", " + arrays[1] + ", " +
              arrays[2] + ", " + std::to_string(n) + ");\n";
    for (std::size_t k = 0; k < size(); ++k) {
      if (!need_[k] || stage_[k] != stage || !is_turned(node(k))) continue;
      const auto at = std::find(angles.begin(), angles.end(), node(k).a) - angles.begin();
      const bool is_sine = node(k).operation == sine;
      text_[k] = is_cut()
                     ? "s[" + std::to_string(turned_ - (is_sine ? 2 : 1) * n + static_cast<int>(at)) + ']'
                     : arrays[is_sine ? 1 : 2] + '[' + std::to_string(at) + ']';
    }
  }

  void write_result(std::size_t r) {
    const Trace& x = recording_.results[r];
    current().writes_results = true;
    const std::string value =
        x.is_constant() ? all_lanes(precision_.literal(x.factor())) : scaled(x.factor(), x.node());
    body() +=
        "  " +
        (on_thread() ? entry(recording_.result, r) : recording_.result + '[' + std::to_string(r) + ']') +
        " = " + value + ";\n";
  }

  void define(std::size_t k) {
    const Tape::Node& x = node(k);
    text_[k] = 't' + std::to_string(++temporaries_);
    const std::string kind = !is_condition(x) ? type() : in_lanes() ? "axode_mask" : "int";
    const std::string value = expression(x);
    body() += "  const " + kind + ' ' + text_[k] + " = " + value + ";\n";
    keep(k);
  }
  /// The name of an argument that a thread reads where a part needs it first.
  std::string loaded(std::size_t k) {
    const Tape::Node& x = node(k);
    const std::string &array = recording_.arguments[static_cast<std::size_t>(x.a)],
                      name = array + std::to_string(x.b);
    if (loaded_in_[k] != now_)
      body() += std::string("  const ") + type() + ' ' + name + " = " +
                entry(array, static_cast<std::size_t>(x.b)) + ";\n";
    loaded_in_[k] = now_;
    return name;
  }

  /// A number or a condition where it is used.
  std::string text(int of) {
    const auto k = static_cast<std::size_t>(of);
    const Tape::Node& x = node(k);
    if (stays_in_sum_[k]) return expression(x);
    if (x.operation == input) current().reads[static_cast<std::size_t>(x.a)] = 1;
    if (x.operation == input && on_thread()) return loaded(k);
    if (is_turned(x) && is_cut() && !on_thread()) current().keeps = true;
    if (slot_[k] < 0 || part_[k] == now_) return text_[k];
    if (!is_condition(x)) return kept(slot_[k]);
    return in_lanes() ? "((axode_mask)" + kept(slot_[k]) + ')' : '(' + kept(slot_[k]) + " != 0)";
  }
  std::string all_lanes(const std::string& literal) const {
    return in_lanes() ? "axode_all(" + literal + ')' : literal;
  }
  /// A number that has lanes even where it is a constant.
  std::string spread(int k) {
    return is_literal(node(static_cast<std::size_t>(k))) ? all_lanes(text(k)) : text(k);
  }
  std::string constant_condition(bool value) const {
    return in_lanes() ? value ? "~(axode_mask){0}" : "(axode_mask){0}" : std::to_string(value);
  }
  std::string expression(const Tape::Node& x) {
    switch (x.operation) {
      case scale: return scaled(x.factor, x.a);
      case sum: return text(x.a) + (x.factor < 0 ? " - " : " + ") + scaled(std::abs(x.factor), x.b);
      case product: return text(x.a) + " * " + text(x.b);
      case reciprocal: return precision_.literal(1) + " / " + text(x.a);
      case root: return called("axode_root", "sqrt") + text(x.a) + ')';
      case angle: return called("axode_angle", "atan2") + spread(x.a) + ", " + spread(x.b) + ')';
      case choice:
        return in_lanes()
                   ? "axode_select(" + text(x.condition) + ", " + spread(x.a) + ", " + spread(x.b) + ')'
                   : text(x.condition) + " ? " + text(x.a) + " : " + text(x.b);
      case less: return compared(text(x.a) + " < " + text(x.b));
      case less_equal: return compared(text(x.a) + " <= " + text(x.b));
      case both: return text(x.a) + " & " + text(x.b);
      case either: return text(x.a) + " | " + text(x.b);
      case negation: return (in_lanes() ? '~' : '!') + text(x.a);
      default: return {};  // has a name already
    }
  }
  std::string called(const char* in_lanes_name, const char* name) const {
    return in_lanes() ? std::string(in_lanes_name) + '('
                      : std::string(name) + (precision_.single ? "f(" : "(");
  }
  std::string compared(const std::string& text) const {
    return in_lanes() ? "(axode_mask)(" + text + ')' : text;
  }
  /// A node times a factor.
  std::string scaled(double factor, int k) {
    if (k == 0) return precision_.literal(factor);
    return (factor == 1 ? "" : factor == -1 ? "-" : precision_.literal(factor) + " * ") + text(k);
  }

  const Recording& recording_;
  const Precision& precision_;
  const std::string& sine_cosine_;
  Width width_;
  std::vector<char> need_;
  std::vector<int> stage_;
  std::vector<char> stays_in_sum_;
  std::vector<std::string> text_;  ///< of each number: its name, or what it is
  std::vector<int> part_, last_part_, slot_;
  std::vector<int> loaded_in_;            ///< for each argument of a thread: the part that has read it
  std::vector<std::vector<int>> angles_;  ///< by stage
  std::vector<std::vector<std::size_t>> turned_from_;  ///< sine and cosine, by the angle
  std::vector<Step> steps_;
  std::vector<Part> parts_;
  int now_ = 0, slots_ = 0, turned_ = 0, temporaries_ = 0;
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
  const std::vector<char> need = needed(recording);
  for (std::size_t k = 0; k < need.size(); ++k)
    if (need[k] && (recording.nodes[k].operation == root || recording.nodes[k].operation == angle))
      return true;
  return false;
}

std::string c_signature(const Recording& recording, const std::string& name, const Precision& precision,
                        Width width) {
  const std::string type = precision.type();
  std::string text = (recording.returns_singularity ? "int " : "void ") + name + "(\n    ";
  for (const std::string& argument : recording.arguments)
    text.append("const ").append(type).append(" *AXODE_RESTRICT ").append(argument).append(", ");
  return text + type + " *AXODE_RESTRICT " + recording.result + (width == Width::thread ? ", int n)" : ")");
}

Definition c_definition(const Recording& recording, const std::string& name, const std::string& sine_cosine,
                        const Precision& precision, Width width) {
  const Statements statements(recording, precision, sine_cosine, width);
  const std::vector<Statements::Part>& parts = statements.parts();
  const bool in_lanes = width == Width::lanes, on_thread = width == Width::thread, is_cut = parts.size() > 1;
  const std::string type = in_lanes ? "axode_lanes" : precision.type();
  std::string parameters, arguments;
  for (const std::string& argument : recording.arguments) {
    parameters += "const " + type + " *AXODE_RESTRICT " + argument + ", ";
    arguments += argument + ", ";
  }
  parameters += type + " *AXODE_RESTRICT " + recording.result + (on_thread ? ", int n" : "");
  const std::string with_scratch = parameters + ", " + type + " *AXODE_RESTRICT s";
  const auto unused = [&](const Statements::Part& part, bool passes_on) {
    std::string text;
    for (std::size_t k = 0; k < part.reads.size() && !passes_on; ++k)
      if (!part.reads[k]) text += "  (void)" + recording.arguments[k] + ";\n";
    if (!part.writes_results && !passes_on) text += "  (void)" + recording.result + ";\n";
    return text;
  };
  Definition definition{.scratch = statements.scratch()};
  std::string& text = definition.text;
  std::string calls;
  for (std::size_t k = 0; is_cut && k + 1 < parts.size(); ++k) {
    const std::string part = name + "_part_" + std::to_string(k + 1);
    text += "static AXODE_PART void " + part + "(\n    " + with_scratch + ") {\n" + unused(parts[k], false) +
            (parts[k].keeps ? "" : "  (void)s;\n") + parts[k].text + "}\n";
    calls += "  " + part + '(' + arguments + recording.result + (on_thread ? ", n" : "") + ", s);\n";
  }
  text += in_lanes ? std::string("static ") + (recording.returns_singularity ? "axode_mask " : "void ") +
                         name + "(\n    " + with_scratch + ')'
                   : (on_thread ? "static __device__ __forceinline__ " : "") +
                         c_signature(recording, name, precision, width);
  text += " {\n" + unused(parts.back(), is_cut);
  if (is_cut && !in_lanes) text += "  " + type + " s[" + std::to_string(definition.scratch) + "];\n";
  if (!is_cut && in_lanes) text += "  (void)s;\n";
  text += calls + parts.back().text + "}\n";
  return definition;
}

}  // namespace axode::codegen
