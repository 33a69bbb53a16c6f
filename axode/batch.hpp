#pragma once
#include <cstddef>
#include <functional>
#include <span>
#include <type_traits>
#include <vector>

#include "axode/batch/compiled_dynamics.hpp"
#include "axode/catalog.hpp"
#include "axode/drives/added_drive.hpp"
#include "axode/integration/drives.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/solvability.hpp"
#include "axode/scalar/instruction_set.hpp"

/// Functions of many states of one mechanism. Several states are computed at once, one in each lane of the
/// SIMD registers, and on several cores. instruction_set() names the instruction set.
///
/// Arrays hold one state after the other: for N states q has nq N numbers, v, a and tau have nv N, mass
/// matrices have nv nv N (each row by row), and poses of all frames n_frames N entries. Seen as a matrix in
/// column-major order, each array has one column for each state. N follows from the size of q. `threads` is
/// the largest number of cores that a call uses. To the last bit, the result of a state depends neither on
/// its index nor on `threads`. Units and conventions are those of the functions of equal names for one state.
/// Each call allocates a workspace for each thread. The functions throw std::invalid_argument for an argument
/// of a wrong size, a quaternion that is not of unit norm (the message names the state), a result that shares
/// memory with an argument, and threads < 1.
namespace axode::batch {

/// Progress callback of long batch calls. It is called in the calling thread, at most every 20 ms, with the
/// number of finished states and the number of all states. If it returns false, the call ends early: the
/// states before Outcome::done are complete; later ones may or may not be.
using Monitor = std::function<bool(std::size_t done, std::size_t of)>;

/// Result of a batch call that can fail: how many states have a singular mass matrix or numbers that are not
/// finite, which state is the first of them, and why it failed.
struct [[nodiscard]] Outcome {
  std::size_t singular_states = 0;  ///< number of failed states; their results are not finite
  std::size_t first = 0;            ///< index of the first failed state
  Solvability solvability;          ///< why the first failed state has no result
  bool loops_open = false;          ///< whether the loops of state `first` could not be kept closed
  bool too_many_changes = false;    ///< whether drives of state `first` change their statuses without end
  std::size_t done = 0;             ///< number of finished states: N, unless the monitor ended the call
  bool ok() const { return singular_states == 0; }
};

/// Computes a function of the catalogue (axode/catalog.hpp), given by its name, in N states. Arrays hold one
/// state after the other; several results of one state follow each other in the order of the catalogue. The
/// arguments have the names that they have in the function for one state. Arguments that are not numbers,
/// such as the frame of a pose, are common to all states. For example, for a model `arm`:
///
///     std::vector<double> tau(N * nv);
///     const Outcome outcome = batch::run(arm, "inverse_dynamics", {.q = q, .v = v, .a = a}, tau, threads);
///
/// Besides the errors of all functions of axode/batch.hpp, throws std::invalid_argument for a function that
/// cannot compute several states at once, for loads (external wrenches), and for joint losses.
template <class T = double>
Outcome run(const Model& model, catalog::Id function,
            const catalog::Arguments<std::type_identity_t<T>>& given, std::type_identity_t<std::span<T>> out,
            int threads = 1, const Monitor& monitor = {});

/// The states x of the drives of a mechanism (see axode/drives.hpp) in N motions. Each motion has nx numbers:
/// the states of all drives, one drive after the other.
struct DriveMotions {
  std::span<const double> x = {};      ///< at the start, nx N numbers; if empty, chosen by the drives
  std::span<double> x_out = {};        ///< receives K + 1 states for each motion; may be empty
  double t = 0;                        ///< time at the start, s, for the inputs and a Drive
  std::vector<AddedDrive> added = {};  ///< drives in addition to those of the model
};

/// Integrates N motions of K steps of equal length `step` (s) by an explicit Runge-Kutta-Munthe-Kaas method,
/// as axode::simulate_fixed() does for one motion. q and v are the initial states of the N motions. tau has
/// the drive forces: nv numbers for each step of each motion, constant during the step. q_out and v_out
/// receive K + 1 states for each motion, beginning with the initial state. Each array has one motion after
/// the other, and each motion one step after the other. If a motion cannot continue, its later states are
/// NaN. If `compiled` is not empty, accelerations are computed by it instead of the library's forward
/// dynamics.
///
/// Loops are closed again after each step. If `joint_losses` is set, damping, dry friction and losses of
/// gears act. Drives with states (motors, controllers, ...) of the model and of `drives` act in addition to
/// tau. A step is divided at the times when the law of such a drive changes its form, for example at a limit,
/// and when an input of a drive jumps. Motions with such drives, dry friction or losses of gears are computed
/// one at a time in each thread.
///
/// Throws std::invalid_argument if a loop is open in an initial state; for T = float, if the model has loops,
/// or if drives with states, dry friction or losses of gears act; and if motions with drives with states and
/// dry friction or losses of gears do not begin at t = 0.
template <class T>
Outcome rollout(const Model& model, std::span<const T> q, Numbers<T> v, Numbers<T> tau, double step,
                std::type_identity_t<std::span<T>> q_out, std::type_identity_t<std::span<T>> v_out,
                const Tableau& method = runge_kutta(4), int threads = 1, const Monitor& monitor = {},
                bool joint_losses = false, const CompiledDynamics<T>& compiled = {},
                const DriveMotions& drives = {});

/// Integrates N motions of K steps of length `step` (s) under the drive forces that `drive` computes from the
/// time and the state (q, v) of a motion; all else is as in rollout() for given drive forces. Each thread
/// calls its own copy of `drive`. Throws std::invalid_argument if `drive` is empty.
template <class T>
Outcome rollout(const Model& model, std::span<const T> q, Numbers<T> v, const Drive& drive, std::size_t K,
                double step, std::type_identity_t<std::span<T>> q_out,
                std::type_identity_t<std::span<T>> v_out, const Tableau& method = runge_kutta(4),
                int threads = 1, const Monitor& monitor = {}, bool joint_losses = false,
                const CompiledDynamics<T>& compiled = {}, const DriveMotions& drives = {});

/// The value of axode::instruction_set(), which determines how many states are computed at once.
[[deprecated("use axode::instruction_set")]] const char* instruction_set();

}  // namespace axode::batch
