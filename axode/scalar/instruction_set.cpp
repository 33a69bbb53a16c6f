#include "axode/scalar/instruction_set.hpp"

#include <cstddef>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace axode {
namespace {

#ifdef AXODE_ONLY_SET
constexpr std::size_t compiled[]{0};
constexpr const char* names[]{AXODE_ONLY_SET};
constexpr char all_names[] = AXODE_ONLY_SET ", for which this library is compiled";

bool processor_has(std::size_t) { return true; }
#else
constexpr std::size_t compiled[]{AXODE_SETS};  // indices in `names`
constexpr const char* names[]{"x86-64", "x86-64-v3", "x86-64-v4"};
constexpr const char all_names[] = "x86-64, x86-64-v3 or x86-64-v4";

/// Whether processor and operating system support an instruction set, by tests of some of its extensions.
bool processor_has(std::size_t set) {
  __builtin_cpu_init();
  const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                  __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  const bool v4 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                  __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512vl");
  return set == 0 || (v3 && (set == 1 || v4));
}
#endif

/// The chosen instruction set. `code` is its index in the list `compiled` of the sets for which the library
/// has code; both lists, `compiled` and `names`, begin with the smallest set. `fault` says why
/// AXODE_INSTRUCTION_SET was not used; it is empty if the variable was used or is not set.
struct Choice {
  std::size_t code = std::size(compiled) - 1;
  std::string fault;

  const char* name() const { return names[compiled[code]]; }
};

Choice choose() {
  Choice best;
  while (!processor_has(compiled[best.code])) --best.code;
  const char* const wanted = std::getenv("AXODE_INSTRUCTION_SET");
  if (wanted == nullptr) return best;
  const std::string message = "AXODE_INSTRUCTION_SET is \"" + std::string(wanted) + "\"; ";
  for (std::size_t set = 0; set < std::size(names); ++set) {
    if (names[set] != std::string(wanted)) continue;
    if (!processor_has(set))
      return {best.code,
              message + "this processor does not have it; the best one with code here is " + best.name()};
    for (std::size_t code = 0; code < std::size(compiled); ++code)
      if (compiled[code] == set) return {code, ""};
    return {best.code, message + "this library has no code for it, but for " + best.name()};
  }
  return {best.code, message + "it must be " + all_names};
}

/// The choice of an instruction set, which is made once, when the library is loaded.
const Choice& choice() {
  static const Choice chosen = choose();
  return chosen;
}

}  // namespace

const char* instruction_set() {
  if (!choice().fault.empty()) throw std::invalid_argument(choice().fault);
  return choice().name();
}

/// Chooses the code for the present instruction set when the library is loaded. of_sets[k] has the addresses
/// of n functions that were compiled for instruction set compiled[k]; the addresses for the chosen set are
/// copied to `chosen`.
extern "C" void axode_choose_entries(const void** chosen, const void* const* const* of_sets, std::size_t n) {
  const void* const* const entries = of_sets[choice().code];
  for (std::size_t k = 0; k < n; ++k) chosen[k] = entries[k];
}

}  // namespace axode
