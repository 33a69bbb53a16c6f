#pragma once
#include <Eigen/SparseCore>
#include <concepts>
#include <vector>

#include "axode/lie.hpp"
#include "axode/scalar/taylor.hpp"

/// Matrices of any size, with the operations that the paper writes; they are compiled once. A column of
/// numbers is a matrix with one column. The library's results convert to matrices implicitly. Shapes that do
/// not fit throw std::logic_error.
namespace axode::test::paper {

/// A matrix of numbers, or of series in t.
template <class T> class MatrixOf {
 public:
  MatrixOf() = default;
  MatrixOf(int rows, int cols);  ///< a matrix of zeros
  /// The components of a quantity of the library, the angular part first.
  MatrixOf(const Vec3<T>& x);
  MatrixOf(const SO3<T>& R);
  MatrixOf(const SE3<T>& C);  ///< 4×4
  MatrixOf(const Sym3<T>& A);
  MatrixOf(const Inertia<T>& M);
  MatrixOf(const CentralInertia<T>& M) : MatrixOf(Inertia<T>(M)) {}
  MatrixOf(const Screw<T>& X);
  template <template <class, class> class Kind, class Rep>
    requires is_screw_kind<Kind> MatrixOf(const Kind<Rep, T>& x) : MatrixOf(screw_of(x)) {}
    /// The entries of a vector or matrix of Eigen.
    template <int Rows, int Cols> MatrixOf(const Eigen::Matrix<T, Rows, Cols>& x);
    MatrixOf(const Eigen::SparseMatrix<T>& x);
    /// A matrix with a single entry, or with a single column.
    MatrixOf(const T& x) : rows_(1), cols_(1), entries_{x} {}
    explicit MatrixOf(std::vector<T> column)
        : rows_(static_cast<int>(column.size())), cols_(1), entries_(std::move(column)) {}

    int rows() const { return rows_; }
    int cols() const { return cols_; }
    /// The entries, column after column.
    const std::vector<T>& entries() const { return entries_; }
    std::vector<T>& entries() { return entries_; }
    T& operator()(int r, int c) { return entries_[static_cast<std::size_t>(c * rows_ + r)]; }
    const T& operator()(int r, int c) const { return entries_[static_cast<std::size_t>(c * rows_ + r)]; }
    T& operator[](int k) { return entries_[static_cast<std::size_t>(k)]; }
    const T& operator[](int k) const { return entries_[static_cast<std::size_t>(k)]; }

    MatrixOf operator+(const MatrixOf& B) const;
    MatrixOf operator-(const MatrixOf& B) const;
    MatrixOf operator*(const MatrixOf& B) const;
    MatrixOf operator*(const T& x) const;
    MatrixOf operator-() const;
    MatrixOf& operator+=(const MatrixOf& B) { return *this = *this + B; }
    MatrixOf& operator*=(const MatrixOf& B) { return *this = *this * B; }
    MatrixOf& operator-=(const MatrixOf& B) { return *this = *this - B; }
    friend MatrixOf operator*(const T& x, const MatrixOf& A) { return A * x; }
    MatrixOf transpose() const;

    MatrixOf block(int row, int col, int rows, int cols) const;
    MatrixOf col(int c) const { return block(0, c, rows_, 1); }
    MatrixOf middle_cols(int c, int n) const { return block(0, c, rows_, n); }
    /// Replaces the block whose first entry is at (row, col) by B.
    void set_block(int row, int col, const MatrixOf& B);

    // For matrices of numbers only. (These are templates because Clang 14 instantiates members of explicit
    // instances even if their requirement is not met.)
    template <std::same_as<double> U = T> MatrixOf inverse() const;
    template <std::same_as<double> U = T> double norm() const;  ///< the Frobenius norm
    template <std::same_as<double> U = T> double squared_norm() const { return norm() * norm(); }
    template <std::same_as<double> U = T> double largest_entry() const;
    template <std::same_as<double> U = T> double trace() const;
    template <std::same_as<double> U = T> double dot(const MatrixOf& b) const { return (transpose() * b)[0]; }
    template <std::same_as<double> U = T> MatrixOf cross(const MatrixOf& b) const;

   private:
    template <template <class, class> class Kind, class Rep> static Screw<T> screw_of(const Kind<Rep, T>& x) {
      const auto& [a, b] = x;
      return {a, b};
    }

    int rows_ = 0, cols_ = 0;
    std::vector<T> entries_;
};

using Matrix = MatrixOf<double>;
using Series = Taylor<double, 3>;
extern template class MatrixOf<double>;
extern template class MatrixOf<Series>;

void expect_shape(int rows, int cols, int wanted_rows, int wanted_cols);

/// A matrix whose type has its shape; it begins as zeros.
template <class T, int Rows, int Cols> class Shaped : public MatrixOf<T> {
 public:
  Shaped() : MatrixOf<T>(Rows, Cols) {}
  template <std::convertible_to<MatrixOf<T>> Quantity> Shaped(const Quantity& x) : MatrixOf<T>(x) {
    expect_shape(this->rows(), this->cols(), Rows, Cols);
  }
};
using Vec3d = Shaped<double, 3, 1>;
using Vec6 = Shaped<double, 6, 1>;
using Mat3 = Shaped<double, 3, 3>;
using Mat4 = Shaped<double, 4, 4>;
using Mat6 = Shaped<double, 6, 6>;
using MatrixOfT = MatrixOf<Series>;
using Vec6OfT = Shaped<Series, 6, 1>;

Matrix identity(int n);
/// (a; b).
Matrix stack(const Matrix& a, const Matrix& b);
/// [[A, B], [C, D]].
Matrix blocks(const Matrix& A, const Matrix& B, const Matrix& C, const Matrix& D);
/// diag(A, B).
Matrix block_diagonal(const Matrix& A, const Matrix& B);

/// The same column as a vector of Eigen.
Eigen::VectorXd to_eigen_vector(const Matrix& x);
inline Matrix to_matrix(const Matrix& x) { return x; }
inline MatrixOfT to_matrix(const MatrixOfT& x) { return x; }
/// The vector, screw, twist, rate, wrench or momentum that has these components.
inline Vec3<> vec3(const Vec3d& x) { return {x[0], x[1], x[2]}; }
template <class Quantity = Screw<>> Quantity from_six(const Vec6& x) {
  return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
}

}  // namespace axode::test::paper
