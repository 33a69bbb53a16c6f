#pragma once
#include <nanobind/nanobind.h>

#include <string>
#include <string_view>

/// Conversions of texts between Python and C++, either of which may have texts that are not valid UTF-8.
namespace axode::python {

namespace nb = nanobind;

/// The text of a Python str in UTF-8. Throws UnicodeEncodeError, a ValueError, if it cannot be encoded.
inline std::string text_of(nb::handle string) {
  Py_ssize_t size = 0;
  const char* text = PyUnicode_AsUTF8AndSize(string.ptr(), &size);
  if (text == nullptr) throw nb::python_error();
  return {text, static_cast<std::size_t>(size)};
}

/// The Python str of a UTF-8 text. Bytes that are not UTF-8 are shown by their numbers.
inline nb::str to_str(std::string_view text) {
  return nb::steal<nb::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "backslashreplace"));
}

/// The name of the type of a Python object, for a message, such as `list` or `numpy.ndarray`.
inline std::string type_of(nb::handle value) {
  const std::string module = text_of(nb::str(value.type().attr("__module__")));
  return (module == "builtins" ? "" : module + ".") + text_of(value.type().attr("__qualname__"));
}

/// The repr of an object, for a message.
inline std::string shown(nb::handle value) { return text_of(nb::repr(value)); }

}  // namespace axode::python
