#pragma once
#include <array>
#include <span>
#include <tuple>
#include <utility>

#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/long_call.hpp"

/// Extends functions of single items, such as a screw (6,), to arrays of items, such as (..., 6).
namespace axode::python {

/// Describes how items of the C++ type T are stored in arrays: the shape of an item, and functions that read
/// and write one. Reading throws nb::value_error, which names the argument, if the numbers are not such an
/// item.
template <class T> struct Item;
template <class T> inline constexpr Infinities infinities_of = Infinities::refused;

/// Checks an item, such as an inertia, that was read from a matrix. `made` is the matrix of the item. Throws
/// nb::value_error if it differs from the matrix `given` by more than 1e-6 of the largest entry.
void check_structure(const char* argument, const char* expected,
                     const Eigen::Ref<const Eigen::MatrixXd>& given,
                     const Eigen::Ref<const Eigen::MatrixXd>& made);
void check_rotation(const char* argument, const SO3<>& R);
void check_unit(const char* argument, const char* what, double norm);

template <> struct Item<double> {
  static inline const Shape shape{};
  static double read(const char*, const double* from) { return *from; }
  static void write(double x, double* to) { *to = x; }
};
template <> struct Item<Vec3<>> {
  static inline const Shape shape{3};
  static Vec3<> read(const char*, const double* from) { return vector_from(from); }
  static void write(const Vec3<>& a, double* to) { python::write(a, to); }
};
template <> struct Item<Screw<>> {
  static inline const Shape shape{6};
  static Screw<> read(const char*, const double* x) { return {vector_from(x), vector_from(x + 3)}; }
  static void write(const Screw<>& X, double* to) { write_screw(X, to); }
};
template <> struct Item<SE3<>> {
  static inline const Shape shape{4, 4};
  static SE3<> read(const char* argument, const double* from) { return pose_from(argument, from); }
  static void write(const SE3<>& C, double* to) { python::write(C, to); }
};
/// Items that are vectors and matrices of Eigen, row by row. Only the shape is checked.
template <int Rows, int Cols> struct Item<Eigen::Matrix<double, Rows, Cols>> {
  using Matrix = Eigen::Matrix<double, Rows, Cols>;
  static inline const Shape shape = Cols == 1 ? Shape{Rows} : Shape{Rows, Cols};
  static Matrix read(const char*, const double* from) {
    Matrix A;
    for (int i = 0; i < Rows; ++i)
      for (int j = 0; j < Cols; ++j) A(i, j) = from[i * Cols + j];
    return A;
  }
  static void write(const Matrix& A, double* to) {
    for (int i = 0; i < Rows; ++i)
      for (int j = 0; j < Cols; ++j) to[i * Cols + j] = A(i, j);
  }
};
/// An item that is a matrix of Rows × Cols numbers in numpy.
template <class T, int Rows, int Cols> struct MatrixItem {
  using Matrix = Item<Eigen::Matrix<double, Rows, Cols>>;
  static inline const Shape shape = Matrix::shape;
  static T read(const char* argument, const double* from) {
    return Item<T>::checked(argument, Matrix::read(argument, from));
  }
  static void write(const T& x, double* to) { Matrix::write(to_eigen(x), to); }
};
template <> struct Item<SO3<>> : MatrixItem<SO3<>, 3, 3> {
  static SO3<> checked(const char* argument, const Eigen::Matrix3d& matrix) {
    const SO3<> R = from_eigen<SO3<>>(matrix);
    check_rotation(argument, R);
    return R;
  }
};
template <> struct Item<Sym3<>> : MatrixItem<Sym3<>, 3, 3> {
  static Sym3<> checked(const char* argument, const Eigen::Matrix3d& matrix) {
    const Sym3<> Theta = from_eigen<Sym3<>>(matrix);
    check_structure(argument, "a symmetric matrix", matrix, to_eigen(Theta));
    return Theta;
  }
};
template <> struct Item<Inertia<>> : MatrixItem<Inertia<>, 6, 6> {
  static Inertia<> checked(const char* argument, const Matrix6<double>& matrix) {
    const Inertia<> M = from_eigen<Inertia<>>(matrix);
    check_structure(argument, "an inertia matrix [[Theta, h~], [-h~, m I]]", matrix, to_eigen(M));
    return M;
  }
};
template <> struct Item<Quaternion<>> : MatrixItem<Quaternion<>, 4, 1> {
  static Quaternion<> checked(const char* argument, const Eigen::Vector4d& numbers) {
    const Quaternion<> a = from_eigen<Quaternion<>>(numbers);
    check_unit(argument, "unit quaternion x y z w", norm(a));
    return a;
  }
};

/// An argument of a function of items, with its name.
template <class T> struct Given {
  using Array = ArrayLike;
  const char* name;
  ArrayLike array;
};

/// The lengths of the first `axes` axes of an argument, those in front of the axes of an item such as a
/// vector or a matrix. Throws nb::value_error if there are more than 30: an array has at most 32 axes, and an
/// item has up to two.
Shape first_axes(const Numbers& numbers, int axes);

/// The numbers of one argument of a function that is called for arrays of items.
class Operand {
 public:
  /// Reads an argument. Throws nb::value_error if its last axes do not have the shape of an item.
  Operand(const char* name, ArrayLike given, const Shape& item, Infinities infinities);
  const char* name() const { return name_; }
  const Shape& leading() const { return leading_; }
  std::string shape_text() const { return numbers_.shape_text(); }
  const double* operator[](nb::ssize_t k) const { return numbers_.data() + k * step_; }

 private:
  const char* name_;
  Numbers numbers_;
  Shape leading_{};
  nb::ssize_t step_ = 0;
};

/// The lengths of the leading axes of the operands, those in front of the axes of an item: (N,) for N vectors
/// in an array (N, 3). All operands must have the same leading axes, except operands that are single items
/// and have none. Throws nb::value_error if they differ.
Shape common_leading(std::span<const Operand> operands);
/// The shape that has the axes `leading`, followed by the axes of an item.
Shape with_item(const Shape& leading, const Shape& item);
/// Throws the error of an item again, with the index of the item added to the message.
[[noreturn]] void rethrow_with_place(const nb::builtin_exception& error, const Shape& leading, nb::ssize_t k);

/// The results of a function for all items: an array or, if it returns a tuple, an array for each entry.
template <class T> class Results {
 public:
  explicit Results(const Shape& leading) : array_(with_item(leading, Item<T>::shape)) {}
  void write(nb::ssize_t k, const T& x) { Item<T>::write(x, array_.data() + k * Item<T>::shape.size()); }
  Array take() { return array_.array(); }

 private:
  NewArray array_;
};
template <class... T> class Results<std::tuple<T...>> {
 public:
  explicit Results(const Shape& leading) : results_(Results<T>(leading)...) {}
  void write(nb::ssize_t k, const std::tuple<T...>& x) {
    [&]<std::size_t... n>(std::index_sequence<n...>) {
      (std::get<n>(results_).write(k, std::get<n>(x)), ...);
    }
    (std::index_sequence_for<T...>{});
  }
  auto take() {
    return std::apply([](auto&... each) { return std::array{each.take()...}; }, results_);
  }

 private:
  std::tuple<Results<T>...> results_;
};

/// Calls f for every item and returns arrays of the results. If there are many items, other Python threads
/// can run during the call, and Ctrl-C ends it.
template <class F, class... T> auto map_items(const F& f, const Given<T>&... given) {
  const std::array operands{Operand(given.name, given.array, Item<T>::shape, infinities_of<T>)...};
  const Shape leading = common_leading(operands);
  Results<std::invoke_result_t<const F&, const T&...>> results(leading);
  LongCall call(leading.size() > 200);
  const batch::Monitor monitor = call.monitor();
  batch::MonitorThrottle throttle(monitor, static_cast<std::size_t>(leading.size()));
  for (nb::ssize_t k = 0; k < leading.size() && throttle.should_continue(static_cast<std::size_t>(k)); ++k) {
    try {
      [&]<std::size_t... n>(std::index_sequence<n...>) {
        results.write(k, f(Item<T>::read(operands[n].name(), operands[n][k])...));
      }
      (std::index_sequence_for<T...>{});
    } catch (const nb::builtin_exception& error) {
      rethrow_with_place(error, leading, k);
    }
  }
  call.end();
  return results.take();
}

/// A function of arrays of items that calls f for every item.
template <class F, class... T> struct OfArrays {
  F f;
  std::array<const char*, sizeof...(T)> arguments;

  auto operator()(typename Given<T>::Array... arrays) const {
    std::size_t n = 0;
    const std::tuple<Given<T>...> given{Given<T>{arguments[n++], arrays}...};
    return std::apply([&](const Given<T>&... each) { return map_items(f, each...); }, given);
  }
};
/// Adds the function f, extended to arrays of items, to a module.
template <class... T, class F>
void add(nb::module_& module, const char* name, const std::array<const char*, sizeof...(T)>& arguments,
         const F& f, const char* documentation) {
  std::apply(
      [&](const auto*... argument) {
        module.def(name, OfArrays<F, T...>{f, arguments}, nb::arg(argument)..., documentation);
      },
      arguments);
}

}  // namespace axode::python
