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

/// Functions of one model as machine code made for it: codegen's C, compiled when this is made ($CC, cc, clang or gcc) and
/// kept in a cache for the next time. T is double or float. Threads may share one.
///
///     const Specialised<> fast(arm, {{"inverse_dynamics"}});
///     batch::inverse_dynamics(fast, q, v, a, tau, 4);
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

  /// The function by its name, in N states, which lie one behind the other as in axode/batch.hpp, and so do their results, each
  /// as the catalogue's function of that name writes it. Checks, threads and the monitor are those of batch, and so is what
  /// becomes of states whose mass matrix may be singular: the library's own function decides. A state's result depends
  /// neither on its place nor on the threads; one state alone goes without lanes and may differ by rounding. Loads are refused.
  /// Throws std::invalid_argument for a function that was not asked for.
  batch::Outcome operator()(const codegen::Function& function, const catalog::Given<T>& given,
                            std::span<T> out, int threads = 1, const batch::Monitor& monitor = {}) const;

  /// What rollouts call.
  batch::CompiledDynamics<T> compiled_dynamics() const;

 private:
  struct Code;
  class Call;
  Model model_;
  std::shared_ptr<const Code> code_;
};

/// The functions of axode/batch.hpp by a specialised model: what they are given, give, check, ask and return is the same, and
/// results differ by rounding. They throw std::invalid_argument as well for a function that the model was specialised without.
namespace batch {

template <class T>
std::size_t inverse_dynamics(const Specialised<T>& model, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                             std::type_identity_t<std::span<T>> tau, int threads = 1,
                             const Monitor& monitor = {}) {
  return model({"inverse_dynamics"}, {.q = q, .v = v, .a = a}, tau, threads, monitor).done;
}
template <class T>
Outcome forward_dynamics(const Specialised<T>& model, Numbers<T> q, Numbers<T> v, Numbers<T> tau,
                         std::type_identity_t<std::span<T>> a, int threads = 1, const Monitor& monitor = {}) {
  return model({"forward_dynamics"}, {.q = q, .v = v, .tau = tau}, a, threads, monitor);
}

template <class T>
std::size_t mass_matrix(const Specialised<T>& model, Numbers<T> q, std::type_identity_t<std::span<T>> M,
                        int threads = 1, const Monitor& monitor = {}) {
  return model({"mass_matrix"}, {.q = q}, M, threads, monitor).done;
}
template <class T>
Outcome inverse_mass_matrix(const Specialised<T>& model, Numbers<T> q,
                            std::type_identity_t<std::span<T>> M_inverse, int threads = 1,
                            const Monitor& monitor = {}) {
  return model({"inverse_mass_matrix"}, {.q = q}, M_inverse, threads, monitor);
}
template <class T>
std::size_t poses(const Specialised<T>& model, Numbers<T> q, std::type_identity_t<std::span<SE3<T>>> C,
                  int threads = 1, const Monitor& monitor = {}) {
  return model({"poses"}, {.q = q}, catalog::as_numbers<T>(C), threads, monitor).done;
}

template <class T>
std::size_t inverse_dynamics_derivatives(const Specialised<T>& model, Numbers<T> q, Numbers<T> v,
                                         Numbers<T> a, std::type_identity_t<std::span<T>> dtau,
                                         int threads = 1, const Monitor& monitor = {}) {
  return model({"inverse_dynamics_derivatives"}, {.q = q, .v = v, .a = a}, dtau, threads, monitor).done;
}
template <class T>
Outcome forward_dynamics_derivatives(const Specialised<T>& model, Numbers<T> q, Numbers<T> v, Numbers<T> tau,
                                     std::type_identity_t<std::span<T>> da, int threads = 1,
                                     const Monitor& monitor = {}) {
  return model({"forward_dynamics_derivatives"}, {.q = q, .v = v, .tau = tau}, da, threads, monitor);
}

template <class T>
std::size_t inverse_dynamics_jvp(const Specialised<T>& model, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                                 Numbers<T> dq, Numbers<T> dv, Numbers<T> da,
                                 std::type_identity_t<std::span<T>> dtau, int threads = 1,
                                 const Monitor& monitor = {}) {
  return model({"inverse_dynamics_jvp"}, {.q = q, .v = v, .a = a, .dq = dq, .dv = dv, .da = da}, dtau,
               threads, monitor)
      .done;
}
template <class T>
Outcome forward_dynamics_jvp(const Specialised<T>& model, Numbers<T> q, Numbers<T> v, Numbers<T> tau,
                             Numbers<T> dq, Numbers<T> dv, Numbers<T> dtau,
                             std::type_identity_t<std::span<T>> da, int threads = 1,
                             const Monitor& monitor = {}) {
  return model({"forward_dynamics_jvp"}, {.q = q, .v = v, .tau = tau, .dq = dq, .dv = dv, .dtau = dtau}, da,
               threads, monitor);
}

template <class T>
std::size_t inverse_dynamics_vjp(const Specialised<T>& model, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                                 Numbers<T> w, std::type_identity_t<std::span<T>> gradient, int threads = 1,
                                 const Monitor& monitor = {}) {
  return model({"inverse_dynamics_vjp"}, {.q = q, .v = v, .a = a, .w = w}, gradient, threads, monitor).done;
}
template <class T>
Outcome forward_dynamics_vjp(const Specialised<T>& model, Numbers<T> q, Numbers<T> v, Numbers<T> tau,
                             Numbers<T> w, std::type_identity_t<std::span<T>> gradient, int threads = 1,
                             const Monitor& monitor = {}) {
  return model({"forward_dynamics_vjp"}, {.q = q, .v = v, .tau = tau, .w = w}, gradient, threads, monitor);
}

/// Of models that were specialised with forward_dynamics. Motions with coupled joints go through the lanes as well. Springs
/// act, and with joint_losses damping and dry friction; steps with friction are the library's own.
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
