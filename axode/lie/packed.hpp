#pragma once
#include "axode/lie/inertia.hpp"
#include "axode/lie/mat3.hpp"

/// Three-vectors in one SIMD register of four lanes, whose last lane is 0. This is the fastest layout for one
/// state of one mechanism. Packed<T> has such vectors, and Plain<T> vectors of three separate numbers; both
/// have the same members, so that algorithms can use either.
namespace axode {

namespace packed {

template <class T> struct alignas(4 * sizeof(T)) Vector {
  using Lanes [[gnu::vector_size(4 * sizeof(T))]] = T;
  Lanes x{};

  Vector() = default;
  explicit Vector(const Lanes& lanes) : x(lanes) {}
  Vector(const Vec3<T>& a)
      : x{a.x, a.y, a.z, T(0)} {}  // NOLINT(google-explicit-constructor): the same vector
  Vector(T a, T b, T c) : x{a, b, c, T(0)} {}
  static Vector all(T a) { return Vector(a - Lanes{}); }
  operator Vec3<T>() const { return {x[0], x[1], x[2]}; }  // NOLINT(google-explicit-constructor)

  friend Vector operator+(const Vector& a, const Vector& b) { return Vector(a.x + b.x); }
  friend Vector operator-(const Vector& a, const Vector& b) { return Vector(a.x - b.x); }
  friend Vector operator-(const Vector& a) { return Vector(-a.x); }
  friend Vector operator*(T s, const Vector& a) { return Vector(s * a.x); }
  Vector& operator+=(const Vector& b) { return x += b.x, *this; }
  Vector& operator-=(const Vector& b) { return x -= b.x, *this; }
};

/// The vector of the lanes i, j, k and l of a.
template <int i, int j, int k, int l, class T> Vector<T> permute(const Vector<T>& a) {
#if defined(__clang__)
  return Vector<T>(__builtin_shufflevector(a.x, a.x, i, j, k, l));
#else
  using Integer = std::conditional_t<sizeof(T) == 8, long long, int>;
  using Order [[gnu::vector_size(4 * sizeof(T))]] = Integer;
  return Vector<T>(__builtin_shuffle(a.x, Order{i, j, k, l}));
#endif
}

/// A vector as a factor of cross products: its two cyclic permutations, so that they are computed once.
template <class T> struct Factor {
  Vector<T> yzx, zxy;
  Factor() = default;
  explicit Factor(const Vector<T>& a) : yzx(permute<1, 2, 0, 3>(a)), zxy(permute<2, 0, 1, 3>(a)) {}
};
template <class T> Vector<T> cross(const Factor<T>& a, const Factor<T>& b) {
  return Vector<T>(a.yzx.x * b.zxy.x - a.zxy.x * b.yzx.x);
}

/// The three components of a vector, each repeated in all lanes of a register.
template <class T> struct Spread {
  Vector<T> x, y, z;
  explicit Spread(const Vector<T>& a)
      : x(permute<0, 0, 0, 0>(a)), y(permute<1, 1, 1, 1>(a)), z(permute<2, 2, 2, 2>(a)) {}
  /// Spreads a vector in memory. Loading a number into all lanes costs no more than loading it into one.
  explicit Spread(const Vec3<T>& a)
      : x(Vector<T>::all(a.x)), y(Vector<T>::all(a.y)), z(Vector<T>::all(a.z)) {}
};

/// A 3×3 matrix, stored by its columns.
template <class T> struct Matrix {
  Vector<T> x, y, z;
  Matrix() = default;
  Matrix(const Vector<T>& a, const Vector<T>& b, const Vector<T>& c) : x(a), y(b), z(c) {}
  explicit Matrix(const SO3<T>& R) : x(R.x), y(R.y), z(R.z) {}
  explicit Matrix(const Sym3<T>& A) : x(A.xx, A.xy, A.xz), y(A.xy, A.yy, A.yz), z(A.xz, A.yz, A.zz) {}
};
template <class T> Vector<T> operator*(const Matrix<T>& A, const Spread<T>& a) {
  return Vector<T>(A.x.x * a.x.x + A.y.x * a.y.x + A.z.x * a.z.x);
}
/// A number, repeated in all lanes of a register.
template <class T> struct Number {
  Vector<T> lanes;
  Number() = default;
  Number(T a) : lanes(Vector<T>::all(a)) {}  // NOLINT(google-explicit-constructor): the same number
  explicit Number(const Vector<T>& in_all_lanes) : lanes(in_all_lanes) {}
  friend Number operator+(const Number& a, const Number& b) { return Number(a.lanes + b.lanes); }
  friend Number operator-(const Number& a, const Number& b) { return Number(a.lanes - b.lanes); }
  friend Number operator-(const Number& a) { return Number(-a.lanes); }
  friend Number operator*(const Number& a, const Number& b) {
    return Number(Vector<T>(a.lanes.x * b.lanes.x));
  }
  friend Number operator/(const Number& a, const Number& b) {
    return Number(Vector<T>(a.lanes.x / b.lanes.x));
  }
  friend Vector<T> operator*(const Number& a, const Vector<T>& b) { return Vector<T>(a.lanes.x * b.x); }
};
template <class T> T value(const Number<T>& a) { return a.lanes.x[0]; }
/// The sum of all four lanes.
template <class T> Number<T> sum(const Vector<T>& products) {
  const Vector<T> pairs = products + permute<1, 0, 3, 2>(products);
  return Number<T>(pairs + permute<2, 3, 0, 1>(pairs));
}
template <class T> Number<T> dot(const Vector<T>& a, const Vector<T>& b) { return sum(Vector<T>(a.x * b.x)); }
/// The sum a · b + c · d.
template <class T>
Number<T> dot(const Vector<T>& a, const Vector<T>& b, const Vector<T>& c, const Vector<T>& d) {
  return sum(Vector<T>(a.x * b.x + c.x * d.x));
}

/// The product a × b e_z.
template <class T> Vector<T> cross_z(const Vector<T>& a, T b) {
  return Vector<T>(permute<1, 0, 2, 3>(a).x * (b * Vector<T>(T(1), T(-1), T(0)).x));
}
/// The sum a + b e_z.
template <class T> Vector<T> add_z(const Vector<T>& a, T b) {
  return Vector<T>(a.x + b * Vector<T>(T(0), T(0), T(1)).x);
}
template <class T> T z(const Vector<T>& a) { return a.x[2]; }

}  // namespace packed

/// The product a × b e_z.
template <class T> constexpr Vec3<T> cross_z(const Vec3<T>& a, const T& b) {
  return {a.y * b, -(a.x * b), T(0)};
}
/// The sum a · b + c · d.
template <class T> constexpr T dot(const Vec3<T>& a, const Vec3<T>& b, const Vec3<T>& c, const Vec3<T>& d) {
  return dot(a, b) + dot(c, d);
}
template <class T> constexpr const T& value(const T& a) { return a; }
/// The sum a + b e_z.
template <class T> constexpr Vec3<T> add_z(const Vec3<T>& a, const T& b) { return {a.x, a.y, a.z + b}; }
template <class T> constexpr const T& z(const Vec3<T>& a) { return a.z; }

/// The geometry of kernels for any scalar T: a three-vector is three numbers.
template <class T> struct Plain {
  using Number = T;
  using Vector = Vec3<T>;
  using Factor = Vec3<T>;
  using Spread = Vec3<T>;
  using Matrix = SO3<T>;
  using Tensor = Sym3<T>;
  struct Forms {
    Vector vector;
    explicit constexpr Forms(const Vector& a) : vector(a) {}
    constexpr const Vector& spread() const { return vector; }
    constexpr const Vector& factor() const { return vector; }
  };
};
/// The geometry of kernels for T = double or float: a three-vector is one register of four lanes.
template <class T> struct Packed {
  using Number = packed::Number<T>;
  using Vector = packed::Vector<T>;
  using Factor = packed::Factor<T>;
  using Spread = packed::Spread<T>;
  using Matrix = packed::Matrix<T>;
  using Tensor = packed::Matrix<T>;
  /// A vector, and the forms of it that products with matrices and cross products need.
  class Forms {
   public:
    Vector vector;
    explicit Forms(const Vector& a) : vector(a), spread_(a), factor_(a) {}
    const Spread& spread() const { return spread_; }
    const Factor& factor() const { return factor_; }

   private:
    Spread spread_;
    Factor factor_;
  };
};

}  // namespace axode
