#pragma once
#include <cstddef>
#include <functional>
#include <span>
#include <type_traits>

#include "axode/batch/compiled_dynamics.hpp"
#include "axode/catalog.hpp"
#include "axode/integration/drives.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/solvability.hpp"
#include "axode/scalar/instruction_set.hpp"

/// Functions of many states of one mechanism, computed in the lanes of SIMD registers of the instruction set
/// that instruction_set() names, and on several cores.
///
/// N states are contiguous: q has nq N numbers, v, a and tau have nv N, matrices nv nv N (row by row), poses
/// n_frames N; in terms of linear algebra, a column for each state. N follows from the size of q and may be 0
/// or 1. To the last bit, the result of a state does not depend on its index or on the number of threads,
/// which is the largest number of cores to use. Frames, units and conventions are those of the functions of
/// equal names for one state. Each call allocates a workspace for each thread. Throws std::invalid_argument
/// for a wrong size, a quaternion that is not of unit norm (it names the state), a result that shares memory
/// with an argument, and for threads < 1. See axode/codegen.hpp for specialised models.
namespace axode::batch {

/// Progress callback. It is called in the calling thread, at most every 20 ms, with the number of finished
/// states and the total. If it returns false, the call ends early: the states before the returned count are
/// complete, later ones may or may not be.
using Monitor = std::function<bool(std::size_t done, std::size_t of)>;

/// Result of a batch call that can fail: how many states have a singular mass matrix or numbers that are not
/// finite, which is the first of them, and why it failed.
struct [[nodiscard]] Outcome {
  std::size_t singular_states = 0;  ///< number of failed states; their results are NaN
  std::size_t first = 0;            ///< index of the first failed state
  Solvability solvability;          ///< why the first failed state has no result
  bool loops_open = false;          ///< whether its motion ended because its loops could not be kept closed
  std::size_t done = 0;             ///< N, unless the monitor ended the call
  bool ok() const { return singular_states == 0; }
};

/// Computes a function of the table in N states. Arguments and results of the states are contiguous; several
/// results of one state are in the order of the catalogue, and settings are common to all states. Each
/// argument has the name that it has in the function for one state:
///
///
///     std::vector<double> tau(N * nv);
///     const Outcome outcome = batch::run(arm, "inverse_dynamics", {.q = q, .v = v, .a = a}, tau, threads);
///
/// Also throws std::invalid_argument for a function without lanes (Words::lanes) and for loads. The outcome
/// of a function that cannot fail has only the number of finished states.
template <class T = double>
Outcome run(const Model& model, catalog::Id function,
            const catalog::Arguments<std::type_identity_t<T>>& given, std::type_identity_t<std::span<T>> out,
            int threads = 1, const Monitor& monitor = {});

/// Integrates N motions of K steps of equal length (s), see axode::simulate_fixed(). tau has nv K N numbers,
/// which are constant in each step; q_out and v_out receive (K + 1) states for each motion, beginning with
/// the given one. If a motion cannot continue, its later states are NaN. Loops, in double precision only, are
/// closed again after each step; throws std::invalid_argument if they are open at first. With joint_losses
/// damping, dry friction and losses of gears act as in simulate_fixed(), the last two in double precision
/// only; motions with friction are computed one at a time. `compiled` replaces the library's forward dynamics
/// if it is not empty.
template <class T>
Outcome rollout(const Model& model, std::span<const T> q, Numbers<T> v, Numbers<T> tau, double step,
                std::type_identity_t<std::span<T>> q_out, std::type_identity_t<std::span<T>> v_out,
                const Tableau& method = runge_kutta(4), int threads = 1, const Monitor& monitor = {},
                bool joint_losses = false, const CompiledDynamics<T>& compiled = {});

/// Integrates N motions of K steps under a drive that all motions share and that is called at every stage of
/// a step. Each thread has a copy of the drive and calls it for one motion at a time. Drives of
/// axode/integration/drives.hpp are computed in lanes, and their reference is evaluated once for all motions.
/// Throws std::invalid_argument if the drive is empty.
template <class T>
Outcome rollout(const Model& model, std::span<const T> q, Numbers<T> v, const Drive& drive, std::size_t K,
                double step, std::type_identity_t<std::span<T>> q_out,
                std::type_identity_t<std::span<T>> v_out, const Tableau& method = runge_kutta(4),
                int threads = 1, const Monitor& monitor = {}, bool joint_losses = false,
                const CompiledDynamics<T>& compiled = {});

/// The value of axode::instruction_set(), on which lanes depend.
[[deprecated("use axode::instruction_set")]] const char* instruction_set();

}  // namespace axode::batch
