#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/batch.hpp"
#include "axode/catalog.hpp"
#include "axode/codegen/c_source.hpp"

namespace axode {

struct SpecialisedOptions {
  int lanes = 16;  ///< states in a register, at most: 1, 2, 4, 8 or 16; as many as fit where that is less
  std::vector<std::string> flags = {"-O3", "-march=native", "-ffp-contract=fast"};  ///< for the compiler
  batch::Monitor monitor = {};  ///< told while the compiler runs, which it ends by saying no
};

/// The monitor said no while the compiler ran.
class CompilationEnded : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Functions of one model as machine code made for it: codegen's C, compiled when this is made ($CC, cc, clang or gcc) and
/// kept in a cache for the next time. T is double or float. Threads may share one.
///
///     const Specialised<> fast(arm, {{codegen::Quantity::inverse_dynamics}});
///     fast({codegen::Quantity::inverse_dynamics}, {.q = q, .v = v, .a = a}, tau);
///
/// The C++ library itself needs no compiler, and stays what it is where there is none.
template <class T = double> class Specialised {
 public:
  /// Throws std::invalid_argument for what codegen::c_source does and for lanes that are none of those, and
  /// std::runtime_error where there is no compiler or it fails.
  Specialised(const Model& model, std::span<const codegen::Function> functions,
              SpecialisedOptions options = {});
  Specialised(const Model& model, std::initializer_list<codegen::Function> functions,
              SpecialisedOptions options = {})
      : Specialised(model, std::span(functions.begin(), functions.size()), std::move(options)) {}

  const Model& model() const { return model_; }
  bool has(const codegen::Function& function) const;

  /// The function in N states, which lie one behind the other as in axode/batch.hpp, and so do their results, each as the
  /// catalogue's function of that name writes it. Checks are those of batch, and so is what becomes of states whose mass
  /// matrix may be singular: the library's own function decides. Loads are refused.
  /// Throws std::invalid_argument for a function that was not asked for.
  batch::Outcome operator()(const codegen::Function& function, const catalog::Given<T>& given,
                            std::span<T> out, int threads = 1, const batch::Monitor& monitor = {}) const;

 private:
  struct Code;
  class Run;
  Model model_;
  std::shared_ptr<const Code> code_;
};

/// What is kept of specialised models: in $XDG_CACHE_HOME/axode, or in ~/.cache/axode.
struct SpecialisedCache {
  std::string folder;  ///< empty where there is none
  std::size_t models = 0;
  std::uintmax_t bytes = 0;
};
SpecialisedCache specialised_cache();
/// Removes all of it, but not what is being compiled right now. Models that are loaded stay as they are.
void clear_specialised_cache();

}  // namespace axode
