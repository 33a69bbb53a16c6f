#include "python/bindings/support/array.hpp"

#define NPY_NO_DEPRECATED_API NPY_1_22_API_VERSION
#define PY_ARRAY_UNIQUE_SYMBOL axode_numpy_api
#include <numpy/arrayobject.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

#include "python/bindings/support/text.hpp"

namespace axode::python {
namespace {

std::string shape_text_of(const nb::ssize_t* lengths, int axes) {
  std::string text = "(";
  for (int k = 0; k < axes; ++k) text += (k > 0 ? ", " : "") + std::to_string(lengths[k]);
  return text + (axes == 1 ? ",)" : ")");
}

PyArrayObject* as_array(PyObject* object) { return reinterpret_cast<PyArrayObject*>(object); }

/// Converts an argument to an array of doubles in C order.
nb::object converted(const std::string& name, PyObject* given) {
  if (PyArray_Check(given) && nb::hasattr(given, "mask") &&
      PyObject_IsTrue(nb::handle(given).attr("mask").attr("any")().ptr()) == 1)
    throw nb::value_error((name + ": has masked entries; expected finite numbers").c_str());
  nb::object array = nb::steal(PyArray_FromAny(given, nullptr, 0, 0, 0, nullptr));
  if (!array.is_valid()) {
    nb::python_error error;
    if (!error.matches(PyExc_Exception)) throw error;  // not an Exception: e.g. KeyboardInterrupt
    nb::raise_from(error, PyExc_ValueError, "%s: expected numbers in rows of equal length, got %s",
                   name.c_str(), type_of(given).c_str());
  }
  const PyArray_Descr* type = PyArray_DESCR(as_array(array.ptr()));
  if (type->kind != 'f' && type->kind != 'i' && type->kind != 'u') {
    const std::string got = text_of(nb::str(nb::handle(reinterpret_cast<const PyObject*>(type))));
    throw nb::value_error((name + ": expected real numbers (float64), got " +
                           (PyArray_Check(given) ? "dtype " + got : type_of(given)))
                              .c_str());
  }
  array = nb::steal(PyArray_FromAny(array.ptr(), PyArray_DescrFromType(NPY_DOUBLE), 0, 0,
                                    NPY_ARRAY_CARRAY_RO | NPY_ARRAY_FORCECAST, nullptr));
  if (!array.is_valid()) throw nb::python_error();
  return array;
}

}  // namespace

bool all_finite(std::span<const double> numbers) {  // all bits of the exponent are set in infinities and NaNs
  const double* const x = numbers.data();
  const nb::ssize_t n = static_cast<nb::ssize_t>(numbers.size());
  constexpr std::uint64_t exponent = 0x7ff0000000000000;
  constexpr nb::ssize_t lanes = 8;
  std::array<std::uint64_t, lanes> carry{};  // sign bits: adding one to an exponent of ones carries into the
                                             // sign
  nb::ssize_t k = 0;
  for (; k + lanes <= n; k += lanes)
    for (nb::ssize_t l = 0; l < lanes; ++l)
      carry[l] |= (std::bit_cast<std::uint64_t>(x[k + l]) & exponent) + (std::uint64_t{1} << 52);
  for (; k < n; ++k) carry[0] |= (std::bit_cast<std::uint64_t>(x[k]) & exponent) + (std::uint64_t{1} << 52);
  std::uint64_t any = 0;
  for (const std::uint64_t c : carry) any |= c;
  return any >> 63 == 0;
}

nb::ssize_t Shape::size() const {
  nb::ssize_t n = 1;
  for (int k = 0; k < axes; ++k) n *= length[static_cast<std::size_t>(k)];
  return n;
}

Shape Shape::times(nb::ssize_t n) const {
  Shape more{n};
  for (int k = 0; k < axes; ++k)
    more.length[static_cast<std::size_t>(more.axes++)] = length[static_cast<std::size_t>(k)];
  return more;
}

std::string Shape::text() const { return shape_text_of(length.data(), axes); }

Numbers::Numbers(std::string name, ArrayLike given, Infinities infinities) : name_(std::move(name)) {
  PyObject* object = given.given;
  if (!PyArray_CheckExact(object) || PyArray_TYPE(as_array(object)) != NPY_DOUBLE ||
      !PyArray_ISCARRAY_RO(as_array(object))) {
    copy_ = converted(name_, object);
    object = copy_.ptr();
  }
  PyArrayObject* array = as_array(object);
  lengths_ = PyArray_DIMS(array);
  data_ = static_cast<const double*>(PyArray_DATA(array));
  size_ = PyArray_SIZE(array);
  axes_ = PyArray_NDIM(array);
  if (all_finite({data_, static_cast<std::size_t>(size_)})) return;
  const auto allowed = [&](double x) {
    return infinities == Infinities::allowed ? !std::isnan(x) : std::isfinite(x);
  };
  nb::ssize_t first = 0;
  while (first < size_ && allowed(data_[first])) ++first;
  if (first == size_) return;
  std::string at;
  nb::ssize_t k = first;
  for (int axis = axes_ - 1; axis >= 0; k /= lengths_[axis], --axis)
    at = std::to_string(k % lengths_[axis]) + (at.empty() ? "" : ", ") + at;
  throw nb::value_error((name_ + (axes_ > 0 ? "[" + at + "]" : "") + " is " +
                         (std::isnan(data_[first]) ? "nan"
                          : data_[first] > 0       ? "inf"
                                                   : "-inf") +
                         "; expected finite numbers")
                            .c_str());
}

std::string Numbers::shape_text() const { return shape_text_of(lengths_, axes_); }

bool Numbers::ends_with(const Shape& item) const {
  if (axes_ < item.axes) return false;
  for (int k = 0; k < item.axes; ++k)
    if (lengths_[axes_ - item.axes + k] != item.length[static_cast<std::size_t>(k)]) return false;
  return true;
}

void Numbers::wrong_shape(const std::string& expected) const {
  throw nb::value_error((name_ + ": expected shape " + expected + ", got " + shape_text()).c_str());
}

NewArray::NewArray(const Shape& shape)
    : array_(nb::steal(PyArray_SimpleNew(shape.axes, shape.length.data(), NPY_DOUBLE))),
      data_(nullptr),
      size_(shape.size()) {
  if (!array_.is_valid()) throw nb::python_error();
  data_ = static_cast<double*>(PyArray_DATA(as_array(array_.ptr())));
}

Array NewArray::array() {
  if (PyArray_NDIM(as_array(array_.ptr())) > 0) return {std::move(array_)};
  return {nb::steal(PyArray_Return(as_array(array_.release().ptr())))};  // a number instead of an array
                                                                         // without axes
}

Array NewArray::transposed() {
  const int axes = PyArray_NDIM(as_array(array_.ptr()));
  nb::object view = nb::steal(PyArray_SwapAxes(as_array(array_.ptr()), axes - 2, axes - 1));
  if (!view.is_valid()) throw nb::python_error();
  return {std::move(view)};
}

Array NewArray::part(nb::ssize_t k, int axes, bool columns) const {
  PyArrayObject* all = as_array(array_.ptr());
  const int axis = PyArray_NDIM(all) - axes - 1;
  Shape shape{}, strides{};
  for (int each = 0; each < PyArray_NDIM(all); ++each) {
    if (each == axis) continue;
    shape.length[static_cast<std::size_t>(shape.axes++)] = PyArray_DIM(all, each);
    strides.length[static_cast<std::size_t>(strides.axes++)] = PyArray_STRIDE(all, each);
  }
  if (columns) {
    const auto last = static_cast<std::size_t>(shape.axes - 1);
    std::swap(shape.length[last], shape.length[last - 1]);
    std::swap(strides.length[last], strides.length[last - 1]);
  }
  nb::object view =
      nb::steal(PyArray_New(&PyArray_Type, shape.axes, shape.length.data(), NPY_DOUBLE, strides.length.data(),
                            static_cast<char*>(PyArray_DATA(all)) + k * PyArray_STRIDE(all, axis), 0,
                            NPY_ARRAY_WRITEABLE, nullptr));
  if (!view.is_valid() || PyArray_SetBaseObject(as_array(view.ptr()), nb::object(array_).release().ptr()) < 0)
    throw nb::python_error();
  return {shape.axes > 0 ? std::move(view) : nb::steal(PyArray_Return(as_array(view.release().ptr())))};
}

double number(const std::string& name, nb::handle given) {
  const Numbers numbers(name, {given.ptr()});
  if (numbers.axes() > 0) numbers.wrong_shape("(), a number");
  return *numbers.data();
}

void import_numpy() {
  if (_import_array() < 0) throw nb::python_error();
}

}  // namespace axode::python
