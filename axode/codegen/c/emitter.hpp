#pragma once
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "axode/codegen/c/c_function.hpp"

namespace axode::codegen {

/// Writes one recorded function (a list of operations) in C or CUDA; subclasses define the language. The
/// statements are written in stages 0, 1, ... Between two stages is a step, called a turn, that computes all
/// sines and cosines of angles of the stage before it together. A statement that needs them is in a later
/// stage. A long function is cut into parts, which exchange numbers by the slots of an array.
class Emitter {
 public:
  using enum Tape::Operation;

  Emitter(const Recording& recording, const Precision& precision)
      : recording_(recording), precision_(precision), numbers_(recording.nodes.size()) {
    const std::vector<char> need = needed(recording);
    for (std::size_t k = 0; k < need.size(); ++k) numbers_[k].needed = need[k] != 0;
  }
  virtual ~Emitter() = default;

  Definition definition(const std::string& name) {
    list_steps();
    arrange_steps();
    cut();
    write_statements();
    Definition definition{.scratch = slots_};
    std::string calls;
    for (std::size_t k = 0; k + 1 < parts_.size(); ++k) {
      const std::string part = name + "_part_" + std::to_string(k + 1);
      definition.text +=
          c_declaration(recording_, "static AXODE_PART void " + part, type(), tail() + scratch()) + " {\n" +
          unused(parts_[k]) + (parts_[k].keeps ? "" : "  (void)s;\n") + parts_[k].text + "}\n";
      calls += "  " + part + '(';
      for (const std::string& argument : recording_.arguments) calls += argument + ", ";
      calls += recording_.result + (tail().empty() ? "" : ", n") + ", s);\n";
    }
    definition.text += head(name) + " {\n" + (is_cut() ? "" : unused(parts_.back())) + scratch_array() +
                       calls + parts_.back().text + "}\n";
    return definition;
  }

 protected:
  struct Step {
    enum Kind { define, turn, result } kind;
    std::size_t index;  ///< index of a node, of a turn or of a result, depending on `kind`
    int part = 0;
  };
  /// A step that computes sines and cosines of some angles.
  struct Turn {
    std::vector<int> angles;
    std::vector<std::size_t> made = {};  ///< nodes of sines and cosines that get a name in this step
  };
  struct Number {
    bool needed = false;
    bool stays_in_sum = false;  ///< whether only one sum uses it, and is written together with it, so that
                                ///< compilers can fuse product and sum
    int stage = 0;
    std::string text;               ///< name of its variable, or the expression that computes it
    int part = -1;                  ///< index of the part that defines it
    int last_part = -1, slot = -1;  ///< the last part that uses it, and the slot of the array that keeps it
                                    ///< until then
  };
  /// One of the functions into which a long function is cut. The last part is the function itself, which
  /// calls the others.
  struct Part {
    std::string text;
    std::vector<char> reads;  ///< whether it reads each of the arguments
    bool writes_results = false, keeps = false;
  };

  // The following functions define the language.
  virtual std::string type() const { return precision_.type(); }
  virtual std::string type_of_conditions() const { return "int"; }
  virtual std::string head(const std::string& name) const {
    return c_signature(recording_, name, precision_);
  }
  virtual std::string tail() const { return ""; }
  /// The statement that declares the array of numbers that parts exchange, if the function is cut into parts.
  virtual std::string scratch_array() const {
    return is_cut() ? "  " + type() + " s[" + std::to_string(slots_) + "];\n" : "";
  }
  virtual std::string entry(const std::string& array, std::size_t k) const {
    return array + '[' + std::to_string(k) + ']';
  }
  virtual std::string read_argument(const Tape::Node& x, std::size_t) {
    return entry(recording_.arguments[x.a], x.b);
  }
  virtual std::string constant(double value) const { return precision_.literal(value); }
  virtual std::string constant_condition(bool value) const { return std::to_string(value); }
  virtual std::string condition_as_number(const std::string& text) const { return text; }
  virtual std::string number_as_condition(const std::string& text) const { return '(' + text + " != 0)"; }
  virtual std::string expression(const Tape::Node& x) {
    switch (x.operation) {
      case scale: return scaled(x.factor, x.a);
      case sum: return text(x.a) + (x.factor < 0 ? " - " : " + ") + scaled(std::abs(x.factor), x.b);
      case product: return text(x.a) + " * " + text(x.b);
      case reciprocal: return precision_.literal(1) + " / " + text(x.a);
      case root: return function("sqrt") + '(' + text(x.a) + ')';
      case angle: return function("atan2") + '(' + text(x.a) + ", " + text(x.b) + ')';
      case choice: return text(x.condition) + " ? " + text(x.a) + " : " + text(x.b);
      case less: return text(x.a) + " < " + text(x.b);
      case less_equal: return text(x.a) + " <= " + text(x.b);
      case both: return text(x.a) + " & " + text(x.b);
      case either: return text(x.a) + " | " + text(x.b);
      case negation: return '!' + text(x.a);
      default: return {};  // the text of the node is known already
    }
  }

  // Sines and cosines, and the order of the steps.
  /// The largest number of statements in a part of a long function. The longer a part is, the more time
  /// compilers take for each of its statements.
  virtual std::size_t longest_part() const { return 500; }
  virtual int stages_of_a_turn() const { return 1; }
  /// Adds the sine or cosine of node k to a turn.
  virtual void add_turn(std::size_t k) = 0;
  virtual void write_turn(std::size_t turn) = 0;
  /// The number of slots of the array that turns need, in addition to the slots of single numbers.
  virtual int slots_of_turns() const { return 0; }
  virtual void arrange_steps() {}
  virtual void begin_statements() {}

  const Tape::Node& node(std::size_t k) const { return recording_.nodes[k]; }
  bool is_cut() const { return n_parts() > 1; }
  static bool is_turned(const Tape::Node& x) { return x.operation == sine || x.operation == cosine; }
  static bool is_literal(const Tape::Node& x) {
    return x.operation == one || (x.operation == scale && x.a == 0);
  }
  static bool is_condition(const Tape::Node& x) {
    return x.operation == less || x.operation == less_equal || x.operation == both || x.operation == either ||
           x.operation == negation;
  }
  /// The name of a function of <math.h> in the present precision.
  std::string function(const char* name) const { return name + std::string(precision_.single ? "f" : ""); }
  std::string scratch() const { return ", " + type() + " *AXODE_RESTRICT s"; }

  Part& current() { return parts_[is_cut() ? now_ : 0]; }
  std::string& body() { return current().text; }
  std::string kept(int slot) {
    current().keeps = true;
    return "s[" + std::to_string(slot) + ']';
  }
  void keep(std::size_t k) {
    const Number& x = numbers_[k];
    if (x.slot < 0) return;
    body() +=
        "  " + kept(x.slot) + " = " + (is_condition(node(k)) ? condition_as_number(x.text) : x.text) + ";\n";
  }
  /// The text of node k, a number or a condition, in an expression that uses it.
  virtual std::string text(int k) {
    const Tape::Node& x = node(k);
    const Number& number = numbers_[k];
    if (number.stays_in_sum) return expression(x);
    if (x.operation == input) {
      current().reads[x.a] = 1;
      return read_argument(x, k);
    }
    if (number.slot < 0 || number.part == now_) return number.text;
    return is_condition(x) ? number_as_condition(kept(number.slot)) : kept(number.slot);
  }
  /// The text of node k times a factor.
  std::string scaled(double factor, int k) {
    if (k == 0) return precision_.literal(factor);
    return (factor == 1 ? "" : factor == -1 ? "-" : precision_.literal(factor) + " * ") + text(k);
  }

  /// The nodes of the numbers to which a step gives names.
  std::vector<std::size_t> made_by(const Step& step) const {
    if (step.kind == Step::define) return {step.index};
    return step.kind == Step::turn ? turns_[step.index].made : std::vector<std::size_t>{};
  }
  /// Calls use(k) for the node k of each named number that a step uses.
  template <class Use> void each_use(const Step& step, const Use& use) const {
    if (step.kind == Step::result) return each_named(recording_.results[step.index].node(), use);
    if (step.kind == Step::turn)
      for (const int k : turns_[step.index].angles) each_named(k, use);
    else
      for (const int from : operands(node(step.index))) each_named(from, use);
  }

  const Recording& recording_;
  const Precision& precision_;
  std::vector<Number> numbers_;  ///< one for each node of the recording
  std::vector<Turn> turns_;
  std::vector<Step> steps_;
  std::vector<Part> parts_;
  int now_ = 0;  ///< index of the part that is being written
  int slots_ = 0;

 private:
  int n_parts() const { return static_cast<int>((steps_.size() + longest_part() - 1) / longest_part()); }

  void list_steps() {
    std::vector<int> uses(numbers_.size()), uses_in_sums(numbers_.size());
    int stages = 1;
    for (std::size_t k = 0; k < numbers_.size(); ++k) {
      int& stage = numbers_[k].stage;
      if (!numbers_[k].needed) continue;
      for (const int from : operands(node(k))) {
        ++uses[from];
        uses_in_sums[from] += node(k).operation == sum;
        stage = std::max(stage, numbers_[from].stage);
      }
      if (is_turned(node(k))) stage += stages_of_a_turn();
      stages = std::max(stages, stage + 1);
    }
    std::vector<std::vector<std::size_t>> results(numbers_.size());  // for each node: the results that are
                                                                     // multiples of it
    for (std::size_t r = 0; r < recording_.results.size(); ++r) {
      const int k = recording_.results[r].node();
      results[k].push_back(r);
      ++uses[k];
    }
    if (stages_of_a_turn() > 0) turns_.resize(stages);
    for (int stage = 0; stage < stages; ++stage) {
      if (stage > 0) steps_.push_back({Step::turn, static_cast<std::size_t>(stage)});
      for (std::size_t k = 0; k < numbers_.size(); ++k) {
        Number& number = numbers_[k];
        if (!number.needed || number.stage != stage) continue;
        const Tape::Node& x = node(k);
        number.stays_in_sum = x.operation == product && uses[k] == 1 && uses_in_sums[k] == 1;
        if (is_literal(x))
          number.text = precision_.literal(x.factor);
        else if (is_turned(x))
          add_turn(k);
        else if (x.operation != input && !number.stays_in_sum)
          steps_.push_back({Step::define, k});
        for (const std::size_t r : results[k])
          steps_.push_back({Step::result, r});  // written at once, so that k need not be kept for it
      }
    }
  }

  /// Cuts the list of statements into parts, each of which becomes a function. Determines for each number the
  /// part that defines it, the last part that uses it, and the slot of the array that keeps it in between.
  void cut() {
    const std::size_t count = std::max(n_parts(), 1),
                      balanced = std::max<std::size_t>((steps_.size() + count - 1) / count, 1);
    for (std::size_t s = 0; s < steps_.size(); ++s) {
      Step& step = steps_[s];
      step.part = static_cast<int>(s / balanced);
      for (const std::size_t k : made_by(step)) numbers_[k].part = step.part;
      each_use(step, [&](std::size_t k) { numbers_[k].last_part = step.part; });
    }
    if (!recording_.maybe_singular.is_constant())
      numbers_[recording_.maybe_singular.node()].last_part = n_parts();
    parts_.resize(is_cut() ? count + 1 : 1);
    for (Part& part : parts_) part.reads.resize(recording_.arguments.size());
    if (!is_cut()) return;
    slots_ = slots_of_turns();
    std::vector<int> idle;
    std::vector<std::vector<int>> freed(parts_.size() + 1);
    int part = -1;
    for (const Step& step : steps_) {
      if (step.part != part) {
        part = step.part;
        idle.insert(idle.end(), freed[part].begin(), freed[part].end());
      }
      for (const std::size_t k : made_by(step)) {
        if (numbers_[k].last_part <= part) continue;
        if (idle.empty()) idle.push_back(slots_++);
        numbers_[k].slot = idle.back();
        idle.pop_back();
        freed[numbers_[k].last_part + 1].push_back(numbers_[k].slot);
      }
    }
  }
  template <class Use> void each_named(std::size_t k, const Use& use) const {
    if (!numbers_[k].stays_in_sum) return use(k);
    for (const int from : operands(node(k))) each_named(from, use);
  }

  void write_statements() {
    begin_statements();
    for (const Step& step : steps_) {
      enter(step.part);
      switch (step.kind) {
        case Step::define: define(step.index); break;
        case Step::turn: write_turn(step.index); break;
        case Step::result: write_result(step.index); break;
      }
    }
    enter(n_parts());
    const Trace::Condition& singular = recording_.maybe_singular;
    if (recording_.returns_singularity)
      body() += "  return " +
                (singular.is_constant() ? constant_condition(singular.constant()) : text(singular.node())) +
                ";\n";
  }
  void enter(int part) {
    if (is_cut()) now_ = part;
  }
  void define(std::size_t k) {
    const Tape::Node& x = node(k);
    std::string& name = numbers_[k].text;
    name = 't' + std::to_string(++temporaries_);
    const std::string value = expression(x);  // expression() may also write statements
    body() +=
        "  const " + (is_condition(x) ? type_of_conditions() : type()) + ' ' + name + " = " + value + ";\n";
    keep(k);
  }
  void write_result(std::size_t r) {
    const Trace& x = recording_.results[r];
    current().writes_results = true;
    const std::string value = x.is_constant() ? constant(x.factor()) : scaled(x.factor(), x.node());
    body() += "  " + entry(recording_.result, r) + " = " + value + ";\n";
  }
  std::string unused(const Part& part) const {
    std::string text;
    for (std::size_t k = 0; k < part.reads.size(); ++k)
      if (!part.reads[k]) text += "  (void)" + recording_.arguments[k] + ";\n";
    return text + (part.writes_results ? "" : "  (void)" + recording_.result + ";\n");
  }

  int temporaries_ = 0;
};

}  // namespace axode::codegen
