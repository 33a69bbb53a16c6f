#include "axode/codegen/c/cuda_kernel.hpp"

#include "axode/codegen/c/emitter.hpp"
#include "axode/codegen/tape/statement_order.hpp"

namespace axode::codegen {
namespace {

/// Writes the CUDA code by which one thread evaluates a recorded function at one of n states. Entry k of an
/// argument or a result of state i has the index k n + i in memory. Sines and cosines are computed for one
/// angle at a time, and the statements are ordered such that few registers are needed.
class CudaEmitter final : public Emitter {
 public:
  CudaEmitter(const Recording& recording, const Precision& precision)
      : Emitter(recording, precision), turn_of_(numbers_.size(), -1), loaded_in_(numbers_.size(), -1) {}

 private:
  std::string head(const std::string& name) const override {
    return "static __device__ __forceinline__ " + c_signature(recording_, name, precision_, tail());
  }
  std::string tail() const override { return ", int n"; }
  std::string entry(const std::string& array, std::size_t k) const override {
    return "axode_at<" + std::to_string(k) + ">(" + array + ", n)";
  }
  /// Returns the name of a constant for an entry of an argument; declares it where a part first needs it.
  std::string read_argument(const Tape::Node& x, std::size_t k) override {
    const std::string& array = recording_.arguments[x.a];
    const std::string name = array + std::to_string(x.b);
    if (loaded_in_[k] != now_) body() += "  const " + type() + ' ' + name + " = " + entry(array, x.b) + ";\n";
    loaded_in_[k] = now_;
    return name;
  }
  /// The largest number of statements in a part of a long function. Parts are long on a GPU, because they
  /// exchange numbers by slow memory.
  std::size_t longest_part() const override { return 1500; }
  int stages_of_a_turn() const override { return 0; }
  /// Adds the sine or cosine of node k to a step. One step computes both the sine and the cosine of an angle.
  void add_turn(std::size_t k) override {
    const int x = node(k).a;
    if (turn_of_[x] < 0) {
      turn_of_[x] = static_cast<int>(turns_.size());
      steps_.push_back({Step::turn, turns_.size()});
      turns_.push_back({{x}});
    }
    turns_[turn_of_[x]].made.push_back(k);
    numbers_[k].text = (node(k).operation == sine ? "sine" : "cosine") + std::to_string(x);
  }
  void write_turn(std::size_t turn) override {
    const int k = turns_[turn].angles[0];
    const std::string x = text(k);  // text() may also write a statement
    body() += filled("  @T@ sine@K@, cosine@K@;\n  @CALL@(@X@, &sine@K@, &cosine@K@);\n",
                     {{"T", type()}, {"K", std::to_string(k)}, {"CALL", function("sincos")}, {"X", x}});
    for (const std::size_t made : turns_[turn].made) keep(made);
  }
  void arrange_steps() override {
    std::erase_if(steps_, [&](const Step& step) {
      return step.kind == Step::result && recording_.results[step.index].is_constant();
    });
    std::vector<int> maker(numbers_.size(), -1), lasting;
    for (std::size_t s = 0; s < steps_.size(); ++s)
      for (const std::size_t k : made_by(steps_[s])) maker[k] = static_cast<int>(s);
    std::vector<std::vector<int>> operands(steps_.size());
    for (std::size_t s = 0; s < steps_.size(); ++s)
      each_use(steps_[s], [&, &from = operands[s]](std::size_t k) {
        if (maker[k] >= 0 && std::ranges::find(from, maker[k]) == from.end()) from.push_back(maker[k]);
      });
    const int singular = recording_.maybe_singular.node();
    if (!recording_.maybe_singular.is_constant() && maker[singular] >= 0) lasting.push_back(maker[singular]);
    std::vector<Step> ordered;
    for (const int s : order_for_few_registers(operands, lasting)) ordered.push_back(steps_[s]);
    steps_ = ordered;
  }
  /// Writes the statements that set constant results; most of these are zeros. If three or more results in a
  /// row have the same value, a loop sets them.
  void begin_statements() override {
    const std::vector<Trace>& results = recording_.results;
    std::size_t end = 0;
    for (std::size_t first = 0; first < results.size(); first = end) {
      end = first + 1;
      if (!results[first].is_constant()) continue;
      current().writes_results = true;
      const double value = results[first].factor();
      while (end < results.size() && results[end].is_constant() && results[end].factor() == value) ++end;
      if (end - first < 3)
        for (std::size_t r = first; r < end; ++r)
          body() += "  " + entry(recording_.result, r) + " = " + constant(value) + ";\n";
      else
        body() += filled("#pragma unroll 1\n  for (int k = @A@; k < @B@; ++k) @Y@[(long long)k * n] = @X@;\n",
                         {{"A", std::to_string(first)},
                          {"B", std::to_string(end)},
                          {"Y", recording_.result},
                          {"X", constant(value)}});
    }
  }

  std::vector<int> turn_of_;    ///< for each angle (by node): the index of its turn, or -1
  std::vector<int> loaded_in_;  ///< for each entry of the arguments: the last part that has read it
};

}  // namespace

const char* const cuda_entries =
    R"(/* Entry k of a state. The offset hides in an instruction: of what compilers see in k * n they make
   chains of sums, which take registers, and far longer to compile. */
template <int k, class X> static __device__ __forceinline__ X &axode_at(X *x, int n) {
#ifdef __CUDA_ARCH__
  long long offset;
  asm("mul.wide.s32 %0, %1, %2;" : "=l"(offset) : "r"(n), "n"(k * (int)sizeof(X)));
  return *(X *)((char *)x + offset);
#else
  return x[(long long)k * n];
#endif
}

)";

Definition cuda_definition(const Recording& recording, const std::string& name, const Precision& precision) {
  return CudaEmitter(recording, precision).definition(name);
}

std::string cuda_kernel(const Recording& recording, const std::string& name, const Precision& precision) {
  std::string call = name + '(';
  for (const std::string& argument : recording.arguments) call += argument + " + i, ";
  call += recording.result + " + i, n)";
  std::string text =
      c_declaration(recording, "extern \"C\" __global__ __launch_bounds__(128) void " + name + "_states",
                    precision.type(), ", int n") +
      " {\n  const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;\n"
      "  if (i >= (unsigned)n) return;\n";
  if (!recording.returns_singularity) return text + "  " + call + ";\n}\n";
  return text + filled(
                    "  if (@CALL@)\n#pragma unroll 1\n    for (int k = 0; k < @N@; ++k) @Y@[(long long)k * n "
                    "+ i] = @NAN@;\n}\n",
                    {{"CALL", call},
                     {"N", std::to_string(recording.results.size())},
                     {"Y", recording.result},
                     {"NAN", precision.single ? "nanf(\"\")" : "nan(\"\")"}});
}

}  // namespace axode::codegen
