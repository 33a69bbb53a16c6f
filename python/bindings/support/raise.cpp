#include "python/bindings/support/raise.hpp"

#include "axode/model/building/nearest_name.hpp"
#include "python/bindings/support/text.hpp"

namespace axode::python {
namespace {

nb::object errors(const char* name) { return nb::module_::import_("axode.errors").attr(name); }

void set_error(const nb::object& error) {
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr());
}

}  // namespace

nb::object fault_object(const Fault& fault) {
  return errors("Fault")(fault.severity == Severity::error ? "error" : "warning",
                         to_str(to_string(fault.rule)), to_str(fault.element), to_str(fault.message),
                         to_str(fault.source.file), fault.source.line, to_str(to_string(fault)));
}

nb::list fault_list(std::span<const Fault> faults) {
  nb::list list;
  for (const Fault& fault : faults) list.append(fault_object(fault));
  return list;
}

void raise_of_states(const char* error, const std::string& sentence, const std::vector<std::size_t>& states,
                     Array result) {
  nb::list numbers;
  for (const std::size_t k : states) numbers.append(k);
  set_error(errors(error)(to_str(sentence), numbers, result.array));
  throw nb::python_error();
}

void raise_of_assembly(const std::string& sentence, Array q, double residual) {
  set_error(errors("AssemblyError")(to_str(sentence), q.array, residual));
  throw nb::python_error();
}

void translate_exceptions() {
  nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
    try {
      std::rethrow_exception(thrown);
    } catch (const ModelError& error) {
      set_error(errors("ModelError")(to_str(error.what()), fault_list(error.faults())));
    } catch (const UnknownName& error) {
      PyErr_SetObject(PyExc_KeyError, to_str(error.what()).ptr());
    }
  });
}

}  // namespace axode::python
