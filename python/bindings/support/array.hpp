#pragma once
#include <nanobind/nanobind.h>

#include <array>
#include <cstddef>
#include <span>
#include <string>

/// Arrays of numpy. Arrays that Python passes are read without a copy if their layout allows it.
namespace axode::python {

namespace nb = nanobind;

/// The lengths of the axes of an array.
struct Shape {
  static constexpr int most = 32;  ///< the number of axes that every version of numpy allows
  std::array<nb::ssize_t, most> length{};
  int axes = 0;

  Shape(std::initializer_list<nb::ssize_t> lengths) {
    for (const nb::ssize_t n : lengths) length[static_cast<std::size_t>(axes++)] = n;
  }
  nb::ssize_t size() const;
  /// The shape with one more axis, of length n, in front.
  Shape times(nb::ssize_t n) const;
  std::string text() const;  ///< the shape as Python writes it: `(2, 7)`
};

/// An argument with real numbers: arrays, lists or tuples; annotated in Python as numpy.typing.ArrayLike.
struct ArrayLike {
  PyObject* given = nullptr;
};
/// A result for Python, annotated there as an array of float64.
struct Array {
  nb::object array;
};

/// Whether numbers may be infinite, as some limits and pitches are. NaN is never allowed.
enum class Infinities { refused, allowed };

/// The numbers of an argument as doubles in C order, copied only if necessary. Throws nb::value_error, which
/// names the argument, for anything but real numbers that are finite (or infinite, if Infinities allow it).
class Numbers {
 public:
  Numbers(std::string name, ArrayLike given, Infinities infinities = Infinities::refused);

  int axes() const { return axes_; }
  nb::ssize_t length(int axis) const { return lengths_[axis]; }
  nb::ssize_t size() const { return size_; }
  const double* data() const { return data_; }
  std::string shape_text() const;
  /// Whether the last axes of the array have the shape of an item.
  bool ends_with(const Shape& item) const;
  /// Throws nb::value_error for an argument of a wrong shape; `expected` says which shapes are right.
  [[noreturn]] void wrong_shape(const std::string& expected) const;

 private:
  std::string name_;
  nb::object copy_;
  const nb::ssize_t* lengths_ = nullptr;
  const double* data_ = nullptr;
  nb::ssize_t size_ = 0;
  int axes_ = 0;
};

/// Whether there is neither an infinity nor a NaN among the numbers.
bool all_finite(std::span<const double> numbers);

/// One finite number in an argument. Throws nb::value_error, which names the argument, for anything else.
double number(const std::string& name, nb::handle given);

/// A new array of doubles in C order. Its entries are not set.
class NewArray {
 public:
  explicit NewArray(const Shape& shape);
  double* data() const { return data_; }
  std::span<double> all() const { return {data_, static_cast<std::size_t>(size_)}; }
  Array array();  ///< the array, or a number if it has no axes
  /// The array with its last two axes exchanged, as a matrix that was written column by column needs it.
  Array transposed();
  /// Entry k along the axis before the last `axes` axes, transposed if `columns` is true. It is a view of this
  /// array, because copies of large results take as long as to compute them.
  Array part(nb::ssize_t k, int axes, bool columns = false) const;

 private:
  nb::object array_;
  double* data_;
  nb::ssize_t size_;
};

/// Imports numpy. Must be called once, when the module is imported.
void import_numpy();

}  // namespace axode::python

namespace nanobind::detail {

template <> struct type_caster<axode::python::ArrayLike> {
  NB_TYPE_CASTER(axode::python::ArrayLike, const_name("numpy.typing.ArrayLike"))
  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    value.given = source.ptr();
    return true;
  }
};
template <> struct type_caster<axode::python::Array> {
  NB_TYPE_CASTER(axode::python::Array, const_name("numpy.typing.NDArray[numpy.float64]"))
  static handle from_cpp(axode::python::Array& result, rv_policy, cleanup_list*) noexcept {
    return result.array.release();
  }
  static handle from_cpp(axode::python::Array&& result, rv_policy, cleanup_list*) noexcept {
    return result.array.release();
  }
};

}  // namespace nanobind::detail
