#include "tests/paper/matrix.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "axode/eigen.hpp"

namespace axode::test::paper {
namespace {

std::string shape(int rows, int cols) { return std::to_string(rows) + " x " + std::to_string(cols); }
void expect_fit(bool fit, int rows, int cols, const char* with, int other_rows, int other_cols) {
  if (!fit) throw std::logic_error(shape(rows, cols) + with + shape(other_rows, other_cols));
}

}  // namespace

void expect_shape(int rows, int cols, int wanted_rows, int wanted_cols) {
  expect_fit(rows == wanted_rows && cols == wanted_cols, rows, cols, " instead of ", wanted_rows,
             wanted_cols);
}

template <class T>
MatrixOf<T>::MatrixOf(int rows, int cols)
    : rows_(rows), cols_(cols), entries_(static_cast<std::size_t>(rows * cols)) {}
template <class T>
template <int Rows, int Cols>
MatrixOf<T>::MatrixOf(const Eigen::Matrix<T, Rows, Cols>& x)
    : rows_(static_cast<int>(x.rows())),
      cols_(static_cast<int>(x.cols())),
      entries_(x.data(), x.data() + x.size()) {}
template <class T> MatrixOf<T>::MatrixOf(const Eigen::SparseMatrix<T>& x) : MatrixOf(Eigen::MatrixX<T>(x)) {}
template <class T> MatrixOf<T>::MatrixOf(const Vec3<T>& x) : MatrixOf(to_eigen(x)) {}
template <class T> MatrixOf<T>::MatrixOf(const SO3<T>& R) : MatrixOf(to_eigen(R)) {}
template <class T> MatrixOf<T>::MatrixOf(const SE3<T>& C) : MatrixOf(to_eigen(C)) {}
template <class T> MatrixOf<T>::MatrixOf(const Sym3<T>& A) : MatrixOf(to_eigen(A)) {}
template <class T> MatrixOf<T>::MatrixOf(const Inertia<T>& M) : MatrixOf(to_eigen(M)) {}
template <class T> MatrixOf<T>::MatrixOf(const Screw<T>& X) : MatrixOf(to_eigen(X)) {}

template <class T> MatrixOf<T> MatrixOf<T>::operator+(const MatrixOf& B) const {
  expect_fit(rows_ == B.rows_ && cols_ == B.cols_, rows_, cols_, " + ", B.rows_, B.cols_);
  MatrixOf sum = *this;
  for (std::size_t k = 0; k < entries_.size(); ++k) sum.entries_[k] = entries_[k] + B.entries_[k];
  return sum;
}
template <class T> MatrixOf<T> MatrixOf<T>::operator-(const MatrixOf& B) const { return *this + -B; }
template <class T> MatrixOf<T> MatrixOf<T>::operator*(const MatrixOf& B) const {
  expect_fit(cols_ == B.rows_, rows_, cols_, " times ", B.rows_, B.cols_);
  MatrixOf product(rows_, B.cols_);
  for (int c = 0; c < B.cols_; ++c)
    for (int k = 0; k < cols_; ++k)
      for (int r = 0; r < rows_; ++r) product(r, c) = product(r, c) + (*this)(r, k) * B(k, c);
  return product;
}
template <class T> MatrixOf<T> MatrixOf<T>::operator*(const T& x) const {
  MatrixOf product = *this;
  for (T& entry : product.entries_) entry = entry * x;
  return product;
}
template <class T> MatrixOf<T> MatrixOf<T>::operator-() const { return *this * T(-1); }
template <class T> MatrixOf<T> MatrixOf<T>::transpose() const {
  MatrixOf transposed(cols_, rows_);
  for (int c = 0; c < cols_; ++c)
    for (int r = 0; r < rows_; ++r) transposed(c, r) = (*this)(r, c);
  return transposed;
}
template <class T> MatrixOf<T> MatrixOf<T>::block(int row, int col, int rows, int cols) const {
  expect_fit(row + rows <= rows_ && col + cols <= cols_, row + rows, col + cols, " beyond ", rows_, cols_);
  MatrixOf part(rows, cols);
  for (int c = 0; c < cols; ++c)
    for (int r = 0; r < rows; ++r) part(r, c) = (*this)(row + r, col + c);
  return part;
}
template <class T> void MatrixOf<T>::set_block(int row, int col, const MatrixOf& B) {
  expect_fit(row + B.rows_ <= rows_ && col + B.cols_ <= cols_, row + B.rows_, col + B.cols_, " beyond ",
             rows_, cols_);
  for (int c = 0; c < B.cols_; ++c)
    for (int r = 0; r < B.rows_; ++r) (*this)(row + r, col + c) = B(r, c);
}

template <class T> template <std::same_as<double> U> MatrixOf<T> MatrixOf<T>::inverse() const {
  expect_fit(rows_ == cols_, rows_, cols_, " is no ", cols_, cols_);
  MatrixOf A = *this, inverse = identity(rows_);  // elimination with the largest entry of each column as its
                                                  // pivot
  for (int k = 0; k < rows_; ++k) {
    int pivot = k;
    for (int r = k; r < rows_; ++r)
      if (std::abs(A(r, k)) > std::abs(A(pivot, k))) pivot = r;
    const double scale = 1 / A(pivot, k);
    for (int c = 0; c < cols_; ++c) {
      std::swap(A(k, c), A(pivot, c)), std::swap(inverse(k, c), inverse(pivot, c));
      A(k, c) *= scale, inverse(k, c) *= scale;
    }
    for (int r = 0; r < rows_; ++r) {
      const double factor = A(r, k);
      if (r == k) continue;
      for (int c = 0; c < cols_; ++c) A(r, c) -= factor * A(k, c), inverse(r, c) -= factor * inverse(k, c);
    }
  }
  return inverse;
}
template <class T> template <std::same_as<double> U> double MatrixOf<T>::norm() const {
  double squares = 0;
  for (const double x : entries_) squares += x * x;
  return std::sqrt(squares);
}
template <class T> template <std::same_as<double> U> double MatrixOf<T>::largest_entry() const {
  double largest = 0;
  for (const double x : entries_) largest = std::max(largest, std::abs(x));
  return largest;
}
template <class T> template <std::same_as<double> U> double MatrixOf<T>::trace() const {
  double trace = 0;
  for (int k = 0; k < rows_; ++k) trace += (*this)(k, k);
  return trace;
}
template <class T> template <std::same_as<double> U> MatrixOf<T> MatrixOf<T>::cross(const MatrixOf& b) const {
  return axode::cross(vec3(*this), vec3(b));
}

Eigen::VectorXd to_eigen_vector(const Matrix& x) {
  return Eigen::Map<const Eigen::VectorXd>(x.entries().data(), x.rows());
}

Matrix identity(int n) {
  Matrix I(n, n);
  for (int k = 0; k < n; ++k) I(k, k) = 1;
  return I;
}
Matrix stack(const Matrix& a, const Matrix& b) {
  Matrix out(a.rows() + b.rows(), a.cols());
  out.set_block(0, 0, a), out.set_block(a.rows(), 0, b);
  return out;
}
Matrix blocks(const Matrix& A, const Matrix& B, const Matrix& C, const Matrix& D) {
  Matrix out(A.rows() + C.rows(), A.cols() + B.cols());
  out.set_block(0, 0, A), out.set_block(0, A.cols(), B);
  out.set_block(A.rows(), 0, C), out.set_block(A.rows(), A.cols(), D);
  return out;
}
Matrix block_diagonal(const Matrix& A, const Matrix& B) {
  return blocks(A, Matrix(A.rows(), B.cols()), Matrix(B.rows(), A.cols()), B);
}

template class MatrixOf<double>;
template class MatrixOf<Series>;
template Matrix Matrix::inverse<double>() const;
template double Matrix::norm<double>() const;
template double Matrix::largest_entry<double>() const;
template double Matrix::trace<double>() const;
template Matrix Matrix::cross<double>(const Matrix&) const;
template Matrix::MatrixOf(const Eigen::MatrixXd&);
template Matrix::MatrixOf(const Eigen::VectorXd&);
template Matrix::MatrixOf(const Eigen::Matrix3d&);
template Matrix::MatrixOf(const Eigen::Matrix4d&);
template Matrix::MatrixOf(const Eigen::Matrix<double, 6, 6>&);
template MatrixOfT::MatrixOf(const Eigen::Matrix4<Series>&);
template MatrixOfT::MatrixOf(const Eigen::Matrix<Series, 6, 6>&);

}  // namespace axode::test::paper
