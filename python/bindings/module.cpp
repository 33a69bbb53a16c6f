#include <nanobind/stl/string_view.h>

#include "axode/catalog.hpp"
#include "python/bindings/support/array.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/raise.hpp"

namespace {

/// Sets the attribute `__signature__` of a type of nanobind, for which setattr() refuses it.
void describe(nanobind::handle type, nanobind::handle signature) {
  if (PyObject_GenericSetAttr(type.ptr(), nanobind::str("__signature__").ptr(), signature.ptr()) != 0)
    throw nanobind::python_error();
  PyType_Modified(reinterpret_cast<PyTypeObject*>(type.ptr()));
}

}  // namespace

NB_MODULE(_axode, module) {
  using namespace axode::python;
  using namespace nb::literals;
  import_numpy();
  translate_exceptions();
  module.attr("version") = AXODE_VERSION;
  module.attr("instruction_set") = axode::instruction_set();  // throws if AXODE_INSTRUCTION_SET is wrong
  module.def("name_here", &axode::catalog::name_here, nb::arg("theirs"),
             "The name in axode of a function of another library, or ''.");
  module.def("describe", &describe, "type"_a, "signature"_a);
  add_wrong_calls(module);
  add_table(module);
  nb::module_ lie = module.def_submodule("lie", "See axode.lie.");
  add_lie(lie);
  add_cayley(lie);
  add_rigid_body(lie);
  add_model(module);
  add_files(module);
  add_view(module);
  add_kinematics(module);
  add_dynamics(module);
  add_momentum(module);
  add_derivatives(module);
  add_rates(module);
  add_constraints(module);
  add_joint_state(module);
  add_mobility(module);
  add_task_space(module);
  add_contact(module);
  add_integration(module);
  add_rollout(module);
  add_reconstruction(module);
  add_prescribed_motion(module);
  add_sensitivities(module);
  add_drives(module);
  add_references(module);
  nb::module_ closed_form = module.def_submodule("closed_form", "See axode.closed_form.");
  add_system_matrices(closed_form);
  add_closed_form(closed_form);
  nb::module_ codegen = module.def_submodule("codegen", "See axode.codegen.");
  add_codegen(codegen);
  add_specialised(codegen);
  nb::module_ jax = module.def_submodule("jax", "See axode.jax.");
  add_jax(jax);
}
