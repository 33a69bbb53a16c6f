#pragma once
#include <nanobind/nanobind.h>

/// The functions by which the files of python/bindings add to the module, in the order of the library.
namespace axode::python {

void add_lie(nanobind::module_& lie);
void add_cayley(nanobind::module_& lie);
void add_rigid_body(nanobind::module_& lie);
void add_model(nanobind::module_& module);
void add_kinematics(nanobind::module_& module);
void add_system_matrices(nanobind::module_& closed_form);
void add_dynamics(nanobind::module_& module);
void add_momentum(nanobind::module_& module);
void add_derivatives(nanobind::module_& module);
void add_rates(nanobind::module_& module);
void add_constraints(nanobind::module_& module);
void add_joint_state(nanobind::module_& module);
void add_mobility(nanobind::module_& module);
void add_task_space(nanobind::module_& module);
void add_contact(nanobind::module_& module);
void add_integration(nanobind::module_& module);
void add_rollout(nanobind::module_& module);
void add_reconstruction(nanobind::module_& module);
void add_prescribed_motion(nanobind::module_& module);
void add_sensitivities(nanobind::module_& module);
void add_drives(nanobind::module_& module);
void add_references(nanobind::module_& module);
void add_closed_form(nanobind::module_& closed_form);
void add_files(nanobind::module_& module);
void add_view(nanobind::module_& module);
void add_codegen(nanobind::module_& codegen);
void add_specialised(nanobind::module_& codegen);
void add_jax(nanobind::module_& jax);
void add_table(nanobind::module_& module);
void add_wrong_calls(nanobind::module_& module);

}  // namespace axode::python
