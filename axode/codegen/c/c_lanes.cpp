#include "axode/codegen/c/c_lanes.hpp"

#include <algorithm>
#include <functional>

namespace axode::codegen {
namespace {

/// Writes an `#if` for every possible value n of AXODE_LANES, with text(n) for n lanes.
std::string for_each_width(const std::function<std::string(int)>& text) {
  std::string all;
  for (const int n : {2, 4, 8, 16})
    all += (all.empty() ? "#if" : "#elif") + std::string(" AXODE_LANES == ") + std::to_string(n) + '\n' +
           text(n);
  return all + "#endif\n";
}

std::string listed(int n, const std::function<std::string(int)>& text) {
  std::string all;
  for (int l = 0; l < n; ++l) all += (l > 0 ? ", " : "") + text(l);
  return all;
}

std::string repeated(int n, const std::function<std::string(int)>& text) {
  std::string all;
  for (int l = 0; l < n; ++l) all += text(l);
  return all;
}
std::string row(int l) { return "r" + std::to_string(l); }

/// C code that transposes n rows of n lanes by n log2 n shuffles: lane l of row k becomes lane k of row l.
std::string transposition(int n) {
  std::string text;
  for (int s = 1; s < n; s *= 2) {
    const std::string low = listed(n, [&](int l) { return std::to_string(l & s ? n + l - s : l); }),
                      high = listed(n, [&](int l) { return std::to_string(l & s ? n + l : l + s); });
    for (int i = 0; i < n; ++i)
      if (!(i & s))
        text += "    a = " + row(i) + ", b = " + row(i + s) + ";\n    " + row(i) + " = AXODE_PICK(a, b, " +
                low + ");\n    " + row(i + s) + " = AXODE_PICK(a, b, " + high + ");\n";
  }
  return text;
}
/// Makes C code that moves the numbers of contiguous states to SIMD registers, with one state in each lane,
/// or back. Number k of state l is memory[l * n + k]. Numbers are transposed in blocks of as many numbers as
/// there are lanes; if n is not a multiple of the number of lanes, the last block overlaps the one before.
std::string transposed(int n, const char* load, const char* store, const char* one_by_one) {
  const auto each = [&](const char* statement) {
    return repeated(n, [&](int l) {
      return "    " + filled(statement, {{"R", row(l)}, {"L", std::to_string(l)}});
    });
  };
  return filled(
      "  for (k = 0; n >= @W@ && k < n; k += @W@) {\n    axode_lanes @ROWS@, a, b;\n    if (k > n - @W@) k = "
      "n - @W@;\n" +
          each(load) + transposition(n) + each(store) +
          "  }\n  for (k = 0; n < @W@ && k < n; ++k)\n    for (l = 0; l < @W@; ++l) " + one_by_one,
      {{"W", std::to_string(n)}, {"ROWS", listed(n, row)}});
}
std::string gathering(int n) {
  return transposed(n, "__builtin_memcpy(&@R@, in + @L@ * n + k, sizeof @R@);\n", "out[k + @L@] = @R@;\n",
                    "out[k][l] = in[l * n + k];\n");
}
std::string scattering(int n) {
  return transposed(n, "@R@ = in[k + @L@];\n", "__builtin_memcpy(out + @L@ * n + k, &@R@, sizeof @R@);\n",
                    "out[l * n + k] = in[k][l];\n");
}

constexpr const char* types = R"(
#if AXODE_LANES > 1
typedef @T@ axode_lanes __attribute__((vector_size(AXODE_LANES * sizeof(@T@))));
typedef @INTEGER@ axode_mask __attribute__((vector_size(AXODE_LANES * sizeof(@T@))));
#if defined(__clang__) || __GNUC__ >= 12
#define AXODE_PICK(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define AXODE_PICK(a, b, ...) __builtin_shuffle(a, b, (axode_mask){__VA_ARGS__})
#endif
static inline axode_lanes axode_all(@T@ x) { return x - (axode_lanes){0}; }
static inline axode_lanes axode_select(axode_mask c, axode_lanes a, axode_lanes b) {
  return (axode_lanes)(((axode_mask)a & c) | ((axode_mask)b & ~c));
}
)";

constexpr const char* math = R"(
static inline axode_lanes axode_root(axode_lanes a) {
  int l;
  for (l = 0; l < AXODE_LANES; ++l) a[l] = (@T@)sqrt(a[l]);
  return a;
}
static inline axode_lanes axode_angle(axode_lanes a, axode_lanes b) {
  int l;
  for (l = 0; l < AXODE_LANES; ++l) a[l] = (@T@)atan2(a[l], b[l]);
  return a;
}
)";

constexpr const char* turning = R"(
/* in[l * n + k], number k of state l, to lane l of out[k], and back. Where the states are fewer than the
   lanes, the last one stands in those that are left. */
static void axode_gather(const @T@ *in, long n, long states, axode_lanes *out) {
  long k, l;
  if (states < AXODE_LANES) {
    for (k = 0; k < n; ++k)
      for (l = 0; l < AXODE_LANES; ++l) out[k][l] = in[(l < states ? l : states - 1) * n + k];
    return;
  }
@GATHERING@}
static void axode_scatter(const axode_lanes *in, long n, long states, @T@ *out) {
  long k, l;
  if (states < AXODE_LANES) {
    for (k = 0; k < n; ++k)
      for (l = 0; l < states; ++l) out[l * n + k] = in[k][l];
    return;
  }
@SCATTERING@}
#endif

)";

}  // namespace

std::string c_lanes(const Precision& precision, int lanes, bool with_math_library) {
  const auto held = [&](int bytes) {
    return std::to_string(std::min(lanes, bytes / (precision.single ? 4 : 8)));
  };
  return "#if defined(__AVX512F__)\n#define AXODE_LANES " + held(64) +
         "\n#elif defined(__AVX__)\n#define AXODE_LANES " + held(32) + "\n#else\n#define AXODE_LANES " +
         held(16) + "\n#endif" +
         filled(types + std::string(with_math_library ? math : "") + turning,
                {{"GATHERING", for_each_width(gathering)},
                 {"SCATTERING", for_each_width(scattering)},
                 {"T", precision.type()},
                 {"INTEGER", precision.single ? "int" : "long long"}});
}

std::string c_states(const StatesFunction& f, const Precision& precision, int lanes) {
  int numbers = f.results + f.scratch, from = 0;
  for (const int n : f.arguments) numbers += n;
  std::string one, in_lanes, gather;
  for (std::size_t k = 0; k < f.arguments.size(); ++k) {
    const std::string n = std::to_string(f.arguments[k]),
                      argument = "arguments[" + std::to_string(k) + "] + k * " + n;
    one += argument + ", ";
    in_lanes += "x + " + std::to_string(from) + ", ";
    gather += "    axode_gather(" + argument + ", " + n + ", states, x + " + std::to_string(from) + ");\n";
    from += f.arguments[k];
  }
  const std::string call = f.name + '(' + one + "result + k * " + std::to_string(f.results) + ')';
  std::string text;
  if (lanes > 1)
    text = "#if AXODE_LANES > 1\nconst long @NAME@_scratch = " + std::to_string(numbers) +
           " * AXODE_LANES;\n#else\n";
  text += "const long @NAME@_scratch = 0;\n";
  if (lanes > 1) text += "#endif\n";
  text +=
      "void @NAME@_states(\n    long count, const @T@ *const *arguments, @T@ *result, @T@ *scratch, "
      "unsigned char *maybe_singular) {\n  long k = 0;\n";
  if (lanes > 1) {
    text +=
        "#if AXODE_LANES > 1\n  axode_lanes *const x = (axode_lanes *)scratch;\n"
        "  for (; scratch && k < count; k += AXODE_LANES) {\n"
        "    const long states = count - k < AXODE_LANES ? count - k : AXODE_LANES;\n";
    text += gather;
    text += f.returns_singularity ? "    const axode_mask singular = " : "    ";
    text += "@NAME@_lanes(" + in_lanes +
            "x + @Y@, x + @S@);\n    axode_scatter(x + @Y@, @N@, states, result + k * @N@);\n";
    if (f.returns_singularity)
      text += "    for (int l = 0; l < states; ++l) maybe_singular[k + l] = singular[l] != 0;\n";
    text += "  }\n#endif\n";
  }
  text += "  for (; k < count; ++k) " +
          (f.returns_singularity ? "maybe_singular[k] = (unsigned char)" : std::string()) + call + ";\n";
  text += std::string("  (void)scratch;\n") + (f.returns_singularity ? "" : "  (void)maybe_singular;\n") +
          (f.arguments.empty() ? "  (void)arguments;\n" : "") + "}\n";
  return filled(text, {{"NAME", f.name},
                       {"T", precision.type()},
                       {"Y", std::to_string(from)},
                       {"S", std::to_string(from + f.results)},
                       {"N", std::to_string(f.results)}});
}

}  // namespace axode::codegen
