#include <nanobind/stl/string_view.h>

#include "array.hpp"
#include "axode/catalog.hpp"
#include "bindings.hpp"
#include "raise.hpp"

NB_MODULE(_axode, module) {
  using namespace axode::python;
  import_numpy();
  translate_exceptions();
  module.attr("version") = AXODE_VERSION;
  module.def("name_here", &axode::catalog::name_here, nb::arg("theirs"),
             "What a function of other libraries is called here, or ''.");
  nb::module_ lie = module.def_submodule("lie", "See axode.lie.");
  add_lie(lie);
  add_rigid_body(lie);
  add_model(module);
  add_files(module);
  add_kinematics(module);
  add_dynamics(module);
  add_momentum(module);
  nb::module_ closed_form = module.def_submodule("closed_form", "See axode.closed_form.");
  add_system_matrices(closed_form);
  add_closed_form(closed_form);
  nb::module_ codegen = module.def_submodule("codegen", "See axode.codegen.");
  add_codegen(codegen);
}
