#include "array.hpp"
#include "bindings.hpp"
#include "raise.hpp"

NB_MODULE(_axode, module) {
  using namespace axode::python;
  import_numpy();
  translate_exceptions();
  module.attr("__version__") = AXODE_VERSION;
  add_model(module);
  add_files(module);
  add_kinematics(module);
  add_dynamics(module);
  add_momentum(module);
}
