#pragma once
#include <cstddef>
#include <functional>
#include <span>
#include <type_traits>

#include "axode/catalog.hpp"
#include "axode/integration/drives.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/solvability.hpp"

/// Many states of one mechanism at once: several in the lanes of each core's SIMD registers (SSE2, AVX2 or
/// AVX-512, whichever the processor has), and on several cores.
///
/// N states lie one behind the other: q has nq N numbers, v, a and tau have nv N, matrices nv nv N (row by
/// row), poses n_frames N; in the terms of linear algebra, a column for each state. N is read off q; any N
/// will do, 0 and 1 included. A state's result does not depend, to the last bit, on its place among the
/// others or on the number of threads, which is the largest number of cores to use. Frames, units and
/// conventions are those of the functions of the same name for one state. Each call allocates a workspace for
/// each thread. Throws std::invalid_argument for a wrong size, a quaternion off 1 (it names the state), a
/// result that shares memory with an argument, and for threads < 1. Of specialised models: axode/codegen.hpp.
namespace axode::batch {

/// Told every 20 milliseconds, in the thread of the call, about how many states of how many are done; the
/// call ends early where it returns false. The first states are then done, as many as the call says; of the
/// others some may be.
using Monitor = std::function<bool(std::size_t done, std::size_t of)>;

/// What came of N states whose mass matrices had to be inverted, or whose numbers were not finite.
struct [[nodiscard]] Outcome {
  std::size_t singular_states = 0;  ///< their results are NaN
  std::size_t first = 0;            ///< the first of them
  Solvability solvability;          ///< of that one
  union {
    bool loops_open = false;  ///< of a motion: whether it ended because its loops could not be kept closed
    [[deprecated("use loops_open")]] bool torn;  ///< the former name of loops_open
  };
  std::size_t done = 0;  ///< N, unless the monitor ended the call
  bool ok() const { return singular_states == 0; }
};

/// A function of the table in N states: the numbers of the states and the results lie one behind the other,
/// several results of a state as the catalogue writes them; settings are the same for all. Arguments have the
/// names of the function's own:
///
///     std::vector<double> tau(N * nv);
///     const Outcome outcome = batch::run(arm, "inverse_dynamics", {.q = q, .v = v, .a = a}, tau, threads);
///
/// Throws std::invalid_argument as well for a function without lanes (Words::lanes) and for loads. Of a
/// function that cannot fail the outcome says only how many states are done.
template <class T = double>
Outcome run(const Model& model, catalog::Id function,
            const catalog::Arguments<std::type_identity_t<T>>& given, std::type_identity_t<std::span<T>> out,
            int threads = 1, const Monitor& monitor = {});

/// N motions of K steps of one length (s), see axode::simulate_fixed: tau has nv K N numbers, constant in
/// each step; q_out and v_out get (K + 1) states for each motion, the first of which is the one given. A
/// motion that cannot go on is NaN from there. Loops, in double alone, are closed again after each step;
/// throws std::invalid_argument where they are open at first. With joint_losses damping and dry friction act
/// as in simulate_fixed(), friction in double alone and on one motion at a time.
template <class T>
Outcome rollout(const Model& model, std::span<const T> q, Numbers<T> v, Numbers<T> tau, double step,
                std::type_identity_t<std::span<T>> q_out, std::type_identity_t<std::span<T>> v_out,
                const Tableau& method = runge_kutta(4), int threads = 1, const Monitor& monitor = {},
                bool joint_losses = false);

/// The same of K steps under a drive that all motions share, which is asked at every stage of a step. It is
/// called for one motion at a time, by copies of its own in every thread; those of
/// axode/integration/drives.hpp go through the lanes, and what they follow is found once for all motions.
/// Throws std::invalid_argument for no drive.
template <class T>
Outcome rollout(const Model& model, std::span<const T> q, Numbers<T> v, const Drive& drive, std::size_t K,
                double step, std::type_identity_t<std::span<T>> q_out,
                std::type_identity_t<std::span<T>> v_out, const Tableau& method = runge_kutta(4),
                int threads = 1, const Monitor& monitor = {}, bool joint_losses = false);

/// The instruction set that this processor is served with: "SSE2", "AVX2" or "AVX-512".
const char* instruction_set();

}  // namespace axode::batch
