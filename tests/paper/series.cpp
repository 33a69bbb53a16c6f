#include "tests/paper/series.hpp"

#include "axode/eigen.hpp"

namespace axode::test::paper {
namespace {

Matrix coefficient(const MatrixOfT& x, std::size_t k) {
  Matrix out(x.rows(), x.cols());
  for (std::size_t e = 0; e < out.entries().size(); ++e) out.entries()[e] = x.entries()[e].c[k];
  return out;
}

}  // namespace

MatrixOfT derivative(const MatrixOfT& x) {
  MatrixOfT out = x;
  for (Series& entry : out.entries()) entry = derivative(entry);
  return out;
}
Matrix now(const MatrixOfT& x) { return coefficient(x, 0); }
Matrix rate(const MatrixOfT& x) { return coefficient(x, 1); }

Mat6 Ad(const SE3<>& C) { return Ad_matrix(C); }
Mat6 Ad(const SO3<>& R) { return Ad_matrix(R); }
Mat6 Ad(const Vec3<>& r) { return Ad_matrix(r); }
Mat6 Ad(const Mat3& R) { return Ad(SO3<>{vec3(R.col(0)), vec3(R.col(1)), vec3(R.col(2))}); }
Mat6 Ad(const Vec3d& r) { return Ad(vec3(r)); }
MatrixOfT Ad(const SE3<Series>& C) { return Ad_matrix(C); }
MatrixOfT Ad(const SO3<Series>& R) { return Ad_matrix(R); }
MatrixOfT Ad(const Vec3<Series>& r) { return Ad_matrix(r); }

Mat6 ad(const Vec6& X) { return ad_matrix(from_six(X)); }
Mat6 ad_w(const Vec3d& w) { return ad(stack(w, Vec3d())); }
Mat6 ad_v(const Vec3d& v) { return ad(stack(Vec3d(), v)); }

Mat3 tilde(const Vec3d& x) { return skew(vec3(x)); }
Mat4 hat(const Screw<>& X) { return axode::hat(X); }
MatrixOfT hat(const Screw<Series>& X) { return axode::hat(X); }

Vec3d angular(const Vec6& X) { return X.block(0, 0, 3, 1); }
Vec3d linear(const Vec6& X) { return X.block(3, 0, 3, 1); }
Vec6 angular_screw(const Vec6& X) { return stack(angular(X), Vec3d()); }

Vec6OfT twist_of(const PoseOfT& C, Representation representation) {
  const Eigen::Matrix4<Series> C_t = to_eigen(C), C_inv = to_eigen(inverse(C));
  const Eigen::Matrix4<Series> dC = C_t.unaryExpr([](const Series& x) { return derivative(x); });
  const Screw<Series> V_b = from_hat(C_inv * dC), V_s = from_hat(dC * C_inv);
  switch (representation) {
    case Representation::body: return V_b;
    case Representation::spatial: return V_s;
    case Representation::hybrid: return Screw<Series>{V_s.w, derivative(C.r)};
    case Representation::mixed: break;
  }
  return Screw<Series>{V_b.w, derivative(C.r)};
}

}  // namespace axode::test::paper
