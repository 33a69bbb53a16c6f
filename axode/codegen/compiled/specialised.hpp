#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/batch.hpp"
#include "axode/catalog.hpp"
#include "axode/codegen/c/c_source.hpp"

namespace axode {

struct SpecialisedOptions {
  int lanes = 16;  ///< largest number of states in a register: 1, 2, 4, 8 or 16
  std::vector<std::string> flags = {"-O3", "-march=native", "-ffp-contract=fast"};  ///< flags
  batch::Monitor monitor = {};  ///< called while the compiler runs; if it returns false, this ends
};

/// The error that is thrown if the monitor returns false while a model is compiled.
class CompilationEnded : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Functions of one model as machine code. The constructor generates C for the model and compiles it with
/// $CC, cc, clang or gcc, or loads the code from a cache. T, the type of numbers, is double or float. Several
/// threads may share one object. With a Model `arm`, and several states in q, v and a:
///
///     const Specialised<> fast(arm, {{"inverse_dynamics"}});
///     batch::Outcome outcome =
///         batch::run(fast, {"inverse_dynamics"}, {.q = q, .v = v, .a = a}, tau, threads);
///
/// Only this class of the library needs a compiler at run time.
template <class T = double> class Specialised {
 public:
  /// Compiles functions of the model. Throws std::invalid_argument if `functions` is empty, names a function
  /// twice, or has a function for which no code can be generated (such as `pose`), that does not take a
  /// property of the model, such as loops, into account, or whose frame does not exist. Also throws it if
  /// options.lanes is not 1, 2, 4, 8 or 16. Throws std::runtime_error if there is no compiler or it fails,
  /// and CompilationEnded if options.monitor returns false.
  Specialised(const Model& model, std::span<const codegen::Function> functions,
              SpecialisedOptions options = {});
  Specialised(const Model& model, std::initializer_list<codegen::Function> functions,
              SpecialisedOptions options = {})
      : Specialised(model, std::span(functions.begin(), functions.size()), std::move(options)) {}

  const Model& model() const { return model_; }
  bool has(const codegen::Function& function) const;

  /// Implements batch::run() for a Specialised, see there.
  batch::Outcome run(const codegen::Function& function, const catalog::Arguments<T>& given, std::span<T> out,
                     int threads, const batch::Monitor& monitor) const;

  /// The compiled forward dynamics, for calls of batch::rollout(). Throws std::invalid_argument if the
  /// constructor was not asked to compile forward_dynamics.
  batch::CompiledDynamics<T> compiled_dynamics() const;

 private:
  struct Code;
  class Call;
  Model model_;
  std::shared_ptr<const Code> code_;
};

namespace batch {

/// Computes one of the compiled functions in N states. Arguments, results, threads and the monitor are those
/// of batch::run() in axode/batch.hpp. If the mass matrix of a state may be singular, the library's own
/// function computes this state again and decides whether the matrix is singular. Results differ from the
/// library's by rounding. They depend neither on the index of a state nor on the number of threads; only the
/// result of a call for a single state may differ by rounding. Throws std::invalid_argument for wrong
/// arguments, for a function that was not compiled, and for loads and joint losses.
template <class T>
Outcome run(const Specialised<T>& model, const codegen::Function& function,
            const catalog::Arguments<std::type_identity_t<T>>& given, std::type_identity_t<std::span<T>> out,
            int threads = 1, const Monitor& monitor = {}) {
  return model.run(function, given, out, threads, monitor);
}

/// Integrates N motions of a model whose forward_dynamics was compiled. The arguments are those of
/// batch::rollout() in axode/batch.hpp. Motions with coupled joints are computed in SIMD lanes as well.
/// Springs act. If `joint_losses` is set, damping and dry friction act; steps with dry friction are computed
/// by the library's own functions.
template <class T>
Outcome rollout(const Specialised<T>& model, Numbers<T> q, Numbers<T> v, Numbers<T> tau, double step,
                std::type_identity_t<std::span<T>> q_out, std::type_identity_t<std::span<T>> v_out,
                const Tableau& method = runge_kutta(4), int threads = 1, const Monitor& monitor = {},
                bool joint_losses = false, const DriveMotions& drives = {}) {
  return rollout<T>(model.model(), q, v, tau, step, q_out, v_out, method, threads, monitor, joint_losses,
                    model.compiled_dynamics(), drives);
}
template <class T>
Outcome rollout(const Specialised<T>& model, Numbers<T> q, Numbers<T> v, const Drive& drive, std::size_t K,
                double step, std::type_identity_t<std::span<T>> q_out,
                std::type_identity_t<std::span<T>> v_out, const Tableau& method = runge_kutta(4),
                int threads = 1, const Monitor& monitor = {}, bool joint_losses = false,
                const DriveMotions& drives = {}) {
  return rollout<T>(model.model(), q, v, drive, K, step, q_out, v_out, method, threads, monitor, joint_losses,
                    model.compiled_dynamics(), drives);
}

}  // namespace batch

/// The cache of compiled models in $XDG_CACHE_HOME/axode or ~/.cache/axode: folder, number of models, bytes.
struct SpecialisedCache {
  std::string folder;  ///< empty if there is no cache
  std::size_t models = 0;
  std::uintmax_t bytes = 0;
};
SpecialisedCache specialised_cache();
/// Removes all compiled models from the cache, and the work folders that compilations have left. Compilations
/// that are still running are not disturbed, and loaded models remain usable.
void clear_specialised_cache();

}  // namespace axode
