#pragma once
#include <vector>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/constraints/loops.hpp"
#include "axode/kinematics/check_arguments.hpp"

/// Checks of the arguments of functions for mechanisms with loops.
namespace axode {

template <class T> LoopSystem<T>& checked(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q) {
  check_configuration(model, q);
  return workspace.system(model);
}
template <class T>
LoopSystem<T>& checked(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v) {
  check_size("v", v.size(), static_cast<std::size_t>(model.nv()), "nv");
  return checked(model, workspace, q);
}

/// Throws std::invalid_argument for a velocity that does not exist.
void check_drives(const Model& model, std::span<const int> drives);
/// The velocities with drives: the given ones or, if there are none, those of all joints that are not
/// passive. Throws std::invalid_argument for a velocity that does not exist.
std::vector<int> driven(const Model& model, std::span<const int> drives);

/// The largest residual of a loop, rad and m, with which a motion may start.
inline constexpr double closed_enough = 1e-6;
/// Throws std::invalid_argument, with the loop and its residual, if q leaves a loop open or v does not keep
/// it closed. Updates the kinematics of the system.
void check_closed(LoopSystem<double>& system, Numbers<double> q, Numbers<double> v);
/// Throws std::invalid_argument, with the loop, if |A a + γ| is more than a thousandth of 1 + |a| + |v|², or
/// with the fault of q or v if that is the cause. It follows force() and make_rows(), or
/// force_fast(), at (q, v, a).
void check_accelerations(LoopSystem<double>& system, Numbers<double> q, Numbers<double> v, Numbers<double> a);
/// Throws std::invalid_argument if `left`, the part of the required forces that no drive can produce, is more
/// than 1e-8. `task` completes the message "the drives cannot ...".
void check_driven(double left, const char* task);

inline void check_rows(const char* name, std::size_t size, int rows, const char* meaning, int columns = 1) {
  check_size(name, size, static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns), meaning);
}

}  // namespace axode
