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

/// Throws std::invalid_argument if an index in `drives` is not that of a velocity, 0 to nv - 1.
void check_drives(const Model& model, std::span<const int> drives);
/// Returns the indices of the velocities on which drives act. These are the indices in `drives` or, if it is
/// empty, the velocities of all joints that are not passive. Throws std::invalid_argument for an index that
/// is not from 0 to nv - 1.
std::vector<int> driven(const Model& model, std::span<const int> drives);

/// The largest norm of the residual of one loop, rad and m, with which a motion may start.
inline constexpr double closed_enough = 1e-6;
/// Throws std::invalid_argument, with the name of the loop and its residual, if a loop is open at q by more
/// than 1e-6 rad or m, or if the velocities v open it with a rate of more than 1e-6 (1 + |v|). Updates the
/// kinematics of `system` to q.
void check_closed(LoopSystem<double>& system, Numbers<double> q, Numbers<double> v);
/// Throws std::invalid_argument, with the name of the loop, if the accelerations a do not keep a loop closed:
/// if the residual of its equations for accelerations has a norm of more than 1e-3 (1 + |a| + |v|²). The loop
/// equations of `system` must have been computed for the motion (q, v, a).
void check_accelerations(LoopSystem<double>& system, Numbers<double> q, Numbers<double> v, Numbers<double> a);
/// Checks that the drives can produce the required forces. `left` is the part that no drive can produce, as a
/// ratio of norms. Throws std::invalid_argument if it is above 1e-8; the message begins with "the drives
/// cannot" and continues with `task`.
void check_driven(double left, const char* task);

inline void check_rows(const char* name, std::size_t size, int rows, const char* meaning, int columns = 1) {
  check_size(name, size, static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns), meaning);
}

}  // namespace axode
