#pragma once
#include <vector>

#include "axode/constraints/loop_system.hpp"
#include "axode/constraints/loops.hpp"
#include "axode/kinematics/check_arguments.hpp"

/// The checks that the functions of this floor make before they compute.
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

/// A loop that is open by no more, rad and m, is closed where a motion begins.
inline constexpr double closed_enough = 1e-6;
/// Throws where q leaves a loop open or v tears one, by more than that: which one, by how much. The system is at q then.
void check_closed(LoopSystem<double>& system, Numbers<double> q, Numbers<double> v);
/// Throws where a tears a loop, (A v)' = A a + γ being more than a thousandth of 1 + |a| + |v|²: which one, by how much, or
/// what is wrong with q or v if that is why. After force() at (q, v, a).
void check_accelerations(LoopSystem<double>& system, Numbers<double> q, Numbers<double> v, Numbers<double> a);
/// Throws where drives cannot do a task, by what inverse_dynamics leaves: more than rounding, 1e-8.
void check_driven(double left, const char* task);

inline void check_rows(const char* name, std::size_t size, int rows, const char* meaning, int columns = 1) {
  check_size(name, size, static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns), meaning);
}

}  // namespace axode
