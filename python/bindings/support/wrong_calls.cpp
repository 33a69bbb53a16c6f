#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/text.hpp"

/// Replaces nanobind's message for arguments that do not fit, which names C++ types, by one from Python code.
namespace axode::python {
namespace {

/// The first members of nanobind's function objects (struct nb_func in its nb_internals.h). The member
/// `call`, nanobind's vectorcall, is the C function that runs when the object is called. Python's stable
/// interface does not give access to it.
static_assert(NB_VERSION_MAJOR == 3);
struct Function {
  PyVarObject head;
  vectorcallfunc call;
};

/// The original C functions of nanobind's function objects (field `vectorcall`); only a few different ones.
std::array<vectorcallfunc, 8> nanobind_calls{};
/// The Python function that composes a sentence: (function, arguments, keyword arguments) -> str or None.
nb::handle explanation;

/// Is called after a call from Python has failed. If the present Python error is nanobind's error for
/// arguments that do not fit, replaces it by a TypeError with the sentence that `explanation` returns.
void explain(PyObject* function, PyObject* const* given, std::size_t count, PyObject* keywords) {
  nb::python_error error;
  try {
    if (text_of(nb::str(error.value())).find("(): incompatible function arguments") != std::string::npos) {
      const bool constructs = text_of(nb::getattr(nb::handle(function), "__name__")) == "__init__";
      nb::list arguments;
      for (std::size_t k = 0; k < count; ++k)  // code in Python must not get an object that is not yet
                                               // constructed
        arguments.append(k == 0 && constructs ? nb::none() : nb::borrow(nb::handle(given[k])));
      nb::dict by_name;
      if (keywords != nullptr)
        for (const nb::handle name : nb::borrow<nb::tuple>(keywords))
          by_name[name] = nb::handle(given[count++]);
      const nb::object sentence = explanation(nb::handle(function), arguments, by_name);
      if (!sentence.is_none()) return PyErr_SetObject(PyExc_TypeError, sentence.ptr());
    }
  } catch (nb::python_error& another) {
    return another.restore();
  }
  error.restore();
}

/// A mask for the two highest bits of the number of arguments, which are flags of Python and of nanobind.
constexpr std::size_t flags = ~(std::numeric_limits<std::size_t>::max() >> 2);

template <std::size_t k>
PyObject* call(PyObject* function, PyObject* const* given, std::size_t count, PyObject* keywords) {
  PyObject* const result = nanobind_calls[k](function, given, count, keywords);
  if (result == nullptr && PyErr_ExceptionMatches(PyExc_TypeError))
    explain(function, given, count & ~flags, keywords);
  return result;
}
constexpr auto calls = []<std::size_t... k>(std::index_sequence<k...>) {
  return std::array<vectorcallfunc, sizeof...(k)>{call<k>...};
}
(std::make_index_sequence<nanobind_calls.size()>());

/// Makes the Python function `asked` write the messages about arguments that do not fit a function.
void explain_wrong_calls(nb::handle function, nb::handle asked) {
  Function& of = *reinterpret_cast<Function*>(function.ptr());
#ifndef Py_LIMITED_API
  if (Py_TYPE(function.ptr())->tp_vectorcall_offset != offsetof(Function, call)) return;
#endif
  if (std::ranges::find(calls, of.call) != calls.end())
    return;  // done already under another name of the
             // function
  const auto place = std::ranges::find_if(
      nanobind_calls, [&](vectorcallfunc known) { return known == nullptr || known == of.call; });
  if (place == nanobind_calls.end()) return;
  if (!explanation.is_valid()) explanation = nb::object(nb::borrow(asked)).release();
  *place = of.call;
  of.call = calls[static_cast<std::size_t>(place - nanobind_calls.begin())];
}

}  // namespace

void add_wrong_calls(nb::module_& module) {
  module.def("explain_wrong_calls", &explain_wrong_calls, nb::arg("function"), nb::arg("explanation"));
}

}  // namespace axode::python
