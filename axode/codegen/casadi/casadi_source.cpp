#include "axode/codegen/casadi/casadi_source.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "axode/codegen/c/c_function.hpp"
#include "axode/codegen/c/c_names.hpp"
#include "axode/codegen/c/c_sine_cosine.hpp"
#include "axode/codegen/casadi/casadi_functions.hpp"

namespace axode::codegen {
namespace {

constexpr Precision precision{false};

constexpr const char* head = R"(
#include <math.h>
#ifndef casadi_real
#define casadi_real double
#endif
#ifndef casadi_int
#define casadi_int long long int
#endif
#if defined(_WIN32)
#define AXODE_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define AXODE_EXPORT __attribute__((visibility("default")))
#else
#define AXODE_EXPORT
#endif
#ifdef __GNUC__
#define AXODE_PART __attribute__((noinline, unused))
#else
#define AXODE_PART
#endif
#ifdef __cplusplus
#define AXODE_RESTRICT __restrict
extern "C" {
#else
#define AXODE_RESTRICT restrict
#endif

)";

constexpr const char* foot = R"(#undef AXODE_EXPORT
#undef AXODE_PART
#undef AXODE_RESTRICT
#ifdef __cplusplus
}
#endif
)";

/// C source, for a function @F@, by which CasADi asks for its inputs, outputs, sparsity and memory.
constexpr const char* questions = R"(AXODE_EXPORT casadi_int @F@_n_in(void) { return @N_IN@; }
AXODE_EXPORT casadi_int @F@_n_out(void) { return @N_OUT@; }
AXODE_EXPORT const char *@F@_name_in(casadi_int i) {
  static const char *const names[] = {@NAMES_IN@};
  return i >= 0 && i < @N_IN@ ? names[i] : 0;
}
AXODE_EXPORT const char *@F@_name_out(casadi_int i) {
  static const char *const names[] = {@NAMES_OUT@};
  return i >= 0 && i < @N_OUT@ ? names[i] : 0;
}
AXODE_EXPORT const casadi_int *@F@_sparsity_in(casadi_int i) {
  static const casadi_int *const patterns[] = {@PATTERNS_IN@};
  return i >= 0 && i < @N_IN@ ? patterns[i] : 0;
}
AXODE_EXPORT const casadi_int *@F@_sparsity_out(casadi_int i) {
  static const casadi_int *const patterns[] = {@PATTERNS_OUT@};
  return i >= 0 && i < @N_OUT@ ? patterns[i] : 0;
}
AXODE_EXPORT int @F@_work(casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = @N_IN@;
  if (sz_res) *sz_res = @N_OUT@;
  if (sz_iw) *sz_iw = 0;
  if (sz_w) *sz_w = @WORK@;
  return 0;
}
)";

template <class Numbers> std::string list(const Numbers& numbers) {
  std::string text;
  for (const auto& x : numbers) text += (text.empty() ? "" : ", ") + std::to_string(x);
  return text;
}
template <class Items, class Word> std::string words(const Items& items, const Word& word) {
  std::string text;
  for (const auto& item : items) text += (text.empty() ? "" : ", ") + word(item);
  return text;
}

/// Returns a sparsity pattern in CasADi's format: the numbers of rows and columns, the index of the first
/// entry of each column, the number of entries, and the row of each entry; for a dense matrix, only the
/// numbers of rows and columns and a 1. The pattern is that of the matrices of several states, which stand
/// side by side or, if `diagonal` is true, are the blocks of a block diagonal matrix. Derivatives by the
/// arguments are block diagonal, as the result for one state does not depend on the arguments of the others.
std::vector<int> compressed(const Pattern& pattern, int states, bool diagonal) {
  const int down = diagonal ? pattern.rows : 0;
  std::vector<int> numbers{pattern.rows + (states - 1) * down, states * pattern.columns};
  if (pattern.is_dense() && !pattern.entries.empty() && (states == 1 || !diagonal)) {
    numbers.push_back(1);
    return numbers;
  }
  std::vector<int> begin{0}, rows;
  for (int state = 0; state < states; ++state) {
    std::vector<int> in_column(pattern.columns);
    for (const int entry : pattern.entries) {
      ++in_column[entry / pattern.rows];
      rows.push_back(entry % pattern.rows + state * down);
    }
    for (const int n : in_column) begin.push_back(begin.back() + n);
  }
  numbers.insert(numbers.end(), begin.begin(), begin.end());
  numbers.insert(numbers.end(), rows.begin(), rows.end());
  return numbers;
}

/// The constant arrays of a generated file. Equal arrays are defined once.
class Tables {
 public:
  Tables(const std::string& prefix, const char* type) : prefix_(prefix), type_(type) {}
  std::string operator()(const std::vector<int>& numbers) {
    const auto [at, is_new] = names_.try_emplace(numbers, prefix_ + std::to_string(names_.size()));
    if (is_new)
      text_ += std::string("static const ") + type_ + ' ' + at->second + "[] = {" + list(numbers) + "};\n";
    return at->second;
  }
  const std::string& text() const { return text_; }

 private:
  std::string prefix_, type_, text_;
  std::map<std::vector<int>, std::string> names_;
};

/// Collects the text of one generated file.
class File {
 public:
  File(const std::string& prefix, int states)
      : prefix_(prefix),
        states_(states),
        patterns_(prefix + "_pattern_", "casadi_int"),
        places_(prefix + "_places_", "int") {}

  void add(const CasadiFamily& family, Source& source) {
    for (std::size_t k = 0; k < family.recordings.size(); ++k) {
      const Recording& recording = family.recordings[k];
      if (!family.inverse || k == 0) define(recording, numbers_of(family.functions[k].name));
      for (const int length : recording.lengths) longest_ = std::max(longest_, length);
    }
    if (family.inverse) add_loops(family);
    for (const CasadiFunction& function : family.functions) {
      definitions_ += definition(family, function) + asked(family, function) + '\n';
      source.functions.push_back({function.name, cost(family, function)});
    }
  }
  std::string text() const {
    std::string text = head;
    text += "static const casadi_real " + prefix_ + "_zeros[" + std::to_string(std::max(longest_, 1)) +
            "] = {0};\n";
    text += patterns_.text() + places_.text() + '\n';
    if (turns_) text += c_sine_cosine(sine_cosine(), precision, Angles::all) + '\n';
    return text + definitions_ + foot;
  }

 private:
  void define(const Recording& recording, const std::string& name) {
    if (recording.results.empty()) return;
    definitions_ += "static " + c_signature(recording, name, precision) + ";\n" +
                    c_definition(recording, name, sine_cosine(), precision).text + '\n';
    turns_ = turns_ || operations(recording).angles > 0;
  }
  /// Adds the C functions for the derivatives of M⁻¹, which multiply matrices in `for` loops.
  void add_loops(const CasadiFamily& family) {
    if (family.recordings[0].results.empty()) return;  // the model has no velocities
    if (!std::exchange(loops_, true)) definitions_ += CasadiInverse::loops(prefix_);
    for (std::size_t k = 0; k < CasadiInverse::kinds; ++k) {
      const auto kind = static_cast<CasadiInverse::Kind>(k);
      const std::string masses = family.functions[k + 1].name + "_masses";
      define(family.inverse->of_masses(kind), masses);
      const Recording& signature = family.recordings[k + 1];
      if (signature.results.empty()) continue;
      definitions_ +=
          "static " + c_signature(signature, numbers_of(family.functions[k + 1].name), precision) +
          family.inverse->body(kind, prefix_, numbers_of(family.functions[0].name), masses,
                               [&](const std::vector<int>& numbers) { return places_(numbers); }) +
          '\n';
    }
  }

  std::string sine_cosine() const { return prefix_ + "_sine_cosine"; }
  static std::string numbers_of(const std::string& name) { return name + "_numbers"; }

  /// The indices of the recordings that a function needs.
  static std::vector<std::size_t> used(const CasadiFunction& function) {
    std::vector<std::size_t> all;
    for (const CasadiOutput& out : function.outputs)
      if (!out.results.empty() && std::ranges::find(all, out.recording) == all.end())
        all.push_back(out.recording);
    return all;
  }
  static void add(Operations& sum, const Operations& more) {
    sum.products += more.products;
    sum.sums += more.sums;
    sum.divisions += more.divisions;
    sum.roots += more.roots;
    sum.angles += more.angles;
  }
  static Operations operations_of(const CasadiFamily& family, std::size_t k) {
    const Operations own = operations(family.recordings[k]);
    if (!family.inverse || k == 0) return own;
    Operations sum = family.inverse->operations(static_cast<CasadiInverse::Kind>(k - 1));
    add(sum, operations(family.recordings[0]));
    return sum;
  }
  static Operations cost(const CasadiFamily& family, const CasadiFunction& function) {
    Operations sum;
    for (const std::size_t k : used(function)) add(sum, operations_of(family, k));
    return sum;
  }
  static std::size_t work(const CasadiFamily& family, const CasadiFunction& function) {
    std::size_t most = 0;
    for (const std::size_t k : used(function)) {
      const bool in_loops = family.inverse && k > 0;
      most = std::max(most, family.recordings[k].results.size() + (in_loops ? family.inverse->scratch() : 0));
    }
    return most;
  }

  std::string definition(const CasadiFamily& family, const CasadiFunction& function) {
    std::string text =
        "AXODE_EXPORT int " + function.name +
        "(const casadi_real **arg, casadi_real **res, casadi_int *iw, casadi_real *w, int mem) {\n";
    text += "  int s, k, failed = 0;\n  (void)arg, (void)res, (void)iw, (void)w, (void)mem, (void)k;\n";
    text += "  for (s = 0; s < " + std::to_string(states_) + "; ++s) {\n";
    for (const std::size_t k : used(function)) text += block(family, function, k);
    return text + "  }\n  return failed;\n}\n";
  }
  /// The C statements that call one recorded function if any of its results is wanted, and copy the results.
  std::string block(const CasadiFamily& family, const CasadiFunction& function, std::size_t k) {
    const Recording& recording = family.recordings[k];
    std::string wanted, copies, arguments;
    for (std::size_t o = 0; o < function.outputs.size(); ++o) {
      const CasadiOutput& out = function.outputs[o];
      if (out.recording != k || out.results.empty()) continue;
      const std::string result = "res[" + std::to_string(o) + ']', n = std::to_string(out.results.size());
      wanted += (wanted.empty() ? "" : " || ") + result;
      copies += "      if (" + result + ")\n        for (k = 0; k < " + n + "; ++k) " + result + "[s * " + n +
                " + k] = w[" + position_of(out.results) + "];\n";
    }
    for (const std::string& argument : recording.arguments) {
      const auto at = std::ranges::find(function.inputs, argument, &CasadiInput::name);
      const std::string given = "arg[" + std::to_string(at - function.inputs.begin()) + ']';
      arguments += given + " ? " + given + " + s * " + std::to_string(at->pattern.entries.size()) + " : " +
                   prefix_ + "_zeros, ";
    }
    const std::string name = numbers_of(family.functions[k].name);
    return "    if (" + wanted + ") {\n      " + (recording.returns_singularity ? "failed |= " : "") + name +
           '(' + arguments + "w);\n" + copies + "    }\n";
  }
  std::string position_of(const std::vector<int>& results) {
    for (std::size_t k = 0; k < results.size(); ++k)
      if (results[k] != results[0] + static_cast<int>(k)) return places_(results) + "[k]";
    return std::to_string(results[0]) + " + k";
  }
  std::string asked(const CasadiFamily& family, const CasadiFunction& function) {
    const auto name = [](const auto& port) { return '"' + port.name + '"'; };
    const auto pattern = [&](const auto& port) {
      return patterns_(compressed(port.pattern, states_, false));
    };
    const auto result = [&](const auto& port) {
      return patterns_(compressed(port.pattern, states_, function.is_jacobian));
    };
    return filled(questions, {{"F", function.name},
                              {"N_IN", std::to_string(function.inputs.size())},
                              {"N_OUT", std::to_string(function.outputs.size())},
                              {"NAMES_IN", words(function.inputs, name)},
                              {"NAMES_OUT", words(function.outputs, name)},
                              {"PATTERNS_IN", words(function.inputs, pattern)},
                              {"PATTERNS_OUT", words(function.outputs, result)},
                              {"WORK", std::to_string(work(family, function))}});
  }

  std::string prefix_, definitions_;
  int states_;
  Tables patterns_, places_;
  bool turns_ = false, loops_ = false;
  int longest_ = 1;
};

void check(std::span<const Function> functions, const std::string& prefix, const Options& options) {
  if (options.states < 1)
    throw std::invalid_argument("states is " + std::to_string(options.states) + "; expected 1 or more");
  if (options.single_precision)
    throw std::invalid_argument("single_precision is set, but CasADi computes in double precision");
  if (prefix.find("__") != std::string::npos || prefix.starts_with('_') || prefix.ends_with('_'))
    throw std::invalid_argument(
        "the prefix \"" + prefix +
        "\" is not a name in CasADi: underscores must be single, and between letters or digits");
  for (const Function& function : functions)
    if (const catalog::Words& row = function.row.words(); !row.derivative_of.empty())
      throw std::invalid_argument(
          std::string(row.name) + " comes with " + std::string(row.derivative_of) +
          " for CasADi, as jac_, fwd1_, adj1_ and jac_adj1_; generate that function instead");
}

/// Throws std::invalid_argument if an index into the matrices of all states does not fit into an int.
void check_size(const CasadiFamily& family, int states) {
  const std::size_t most = std::numeric_limits<int>::max() / states;
  const auto check = [&](const std::string& function, const auto& port) {
    const Pattern& pattern = port.pattern;
    const int longer = std::max(pattern.rows, pattern.columns);
    if (std::max(pattern.entries.size(), static_cast<std::size_t>(longer)) > most)
      throw std::invalid_argument("states is " + std::to_string(states) + "; " + port.name + " of " +
                                  function + " would have more than 2147483647 entries for so many states");
  };
  for (const CasadiFunction& function : family.functions) {
    for (const CasadiInput& in : function.inputs) check(function.name, in);
    for (const CasadiOutput& out : function.outputs) check(function.name, out);
  }
}

}  // namespace

Source casadi_source(const Model& model, std::span<const Function> functions, const std::string& prefix,
                     const Options& options) {
  check(functions, prefix, options);
  const std::vector<std::string> names = function_names(model, functions, prefix, Abi::casadi),
                                 frames = frame_identifiers(model, Abi::casadi);
  Source source;
  File file(prefix, options.states);
  std::string declared;
  for (std::size_t k = 0; k < functions.size(); ++k) {
    const CasadiFamily family = casadi_family(model, functions[k], names[k], frames);
    check_size(family, options.states);
    const std::size_t first = source.functions.size();
    file.add(family, source);
    for (std::size_t i = 0; i < family.functions.size(); ++i) {
      const auto name = [](const auto& port) { return port.name; };
      const CasadiFunction& f = family.functions[i];
      declared += "     " + f.name + '(' + words(f.inputs, name) + ")\n       " +
                  counted(source.functions[first + i].operations) + "\n";
    }
  }
  source.text =
      "/* " + in_comment(model.name()) +
      ", external functions of CasADi, generated by axode " AXODE_VERSION
      ".\n\n   Units are m, kg, s, rad. q has " +
      std::to_string(model.nq()) + " entries; v, a and tau have " + std::to_string(model.nv()) + ":\n\n" +
      coordinates(model) +
      "\n   Quaternions are x y z w, and count divided by their length. Functions return 1 where the mass\n"
      "   matrix may be singular.\n\n" +
      declared +
      "\n   To be compiled without -ffast-math, which breaks the sines; products and sums may become one\n"
      "   instruction (-ffp-contract=fast). */\n\n"
      "#ifdef __FAST_MATH__\n#error \"compile this file without -ffast-math\"\n#endif\n" +
      file.text();
  return source;
}

}  // namespace axode::codegen
