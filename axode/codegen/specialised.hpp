#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/batch.hpp"
#include "axode/batch/compiled_rollout.hpp"
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

/// Functions of one model as machine code made for it: codegen's C, compiled when this is made ($CC, cc,
/// clang or gcc) and kept in a cache for the next time. T is double or float. Threads may share one.
///
///     const Specialised<> fast(arm, {{"inverse_dynamics"}});
///     const batch::Outcome outcome = batch::run(fast, {"inverse_dynamics"}, {.q = q, .v = v, .a = a}, tau, 4);
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

  /// What batch::run() does.
  batch::Outcome run(const codegen::Function& function, const catalog::Arguments<T>& given, std::span<T> out,
                     int threads, const batch::Monitor& monitor) const;

  /// What rollouts call.
  batch::CompiledDynamics<T> compiled_dynamics() const;

 private:
  struct Code;
  class Call;
  Model model_;
  std::shared_ptr<const Code> code_;
};

namespace batch {

/// A function that the model was specialised for, in N states, which lie one behind the other as in
/// axode/batch.hpp. Checks, threads and the monitor are those of a Model, and so is what becomes of states
/// whose mass matrix may be singular: the library's own function decides. Results differ by rounding. A
/// state's result depends neither on its place nor on the threads; one state alone goes without lanes and may
/// differ by rounding. Throws std::invalid_argument as well for a function that the model was specialised
/// without, and for loads.
template <class T>
Outcome run(const Specialised<T>& model, const codegen::Function& function,
            const catalog::Arguments<std::type_identity_t<T>>& given, std::type_identity_t<std::span<T>> out,
            int threads = 1, const Monitor& monitor = {}) {
  return model.run(function, given, out, threads, monitor);
}

/// Of models that were specialised with forward_dynamics. Motions with coupled joints go through the lanes as
/// well. Springs act, and with joint_losses damping and dry friction; steps with friction are the library's
/// own.
template <class T>
Outcome rollout(const Specialised<T>& model, Numbers<T> q, Numbers<T> v, Numbers<T> tau, double step,
                std::type_identity_t<std::span<T>> q_out, std::type_identity_t<std::span<T>> v_out,
                const Tableau& method = runge_kutta(4), int threads = 1, const Monitor& monitor = {},
                bool joint_losses = false) {
  return rollout<T>(model.model(), model.compiled_dynamics(), q, v, tau, step, q_out, v_out, method, threads,
                    monitor, joint_losses);
}
template <class T>
Outcome rollout(const Specialised<T>& model, Numbers<T> q, Numbers<T> v, const Drive& drive, std::size_t K,
                double step, std::type_identity_t<std::span<T>> q_out,
                std::type_identity_t<std::span<T>> v_out, const Tableau& method = runge_kutta(4),
                int threads = 1, const Monitor& monitor = {}, bool joint_losses = false) {
  return rollout<T>(model.model(), model.compiled_dynamics(), q, v, drive, K, step, q_out, v_out, method,
                    threads, monitor, joint_losses);
}

}  // namespace batch

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
