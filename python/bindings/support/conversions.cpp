#include "python/bindings/support/conversions.hpp"

#include <cmath>
#include <limits>

namespace axode::python {

void write(const SE3<>& C, double* to) {
  const double rows[16] = {C.R.x.x, C.R.y.x, C.R.z.x, C.r.x, C.R.x.y, C.R.y.y, C.R.z.y, C.r.y,
                           C.R.x.z, C.R.y.z, C.R.z.z, C.r.z, 0,       0,       0,       1};
  std::copy_n(rows, 16, to);
}

double rotation_error(const SO3<>& R) {
  const SO3<> RtR = transpose(R) * R;
  double off = 0;
  for (const Vec3<>& d :
       {RtR.x - Vec3<>{1, 0, 0}, RtR.y - Vec3<>{0, 1, 0}, RtR.z - Vec3<>{0, 0, 1}, cross(R.x, R.y) - R.z})
    off = std::isfinite(norm(d)) ? std::max(off, norm(d)) : std::numeric_limits<double>::infinity();
  return off;
}

SE3<> pose_from(const std::string& argument, const double* C) {
  const SE3<> pose{{{C[0], C[4], C[8]}, {C[1], C[5], C[9]}, {C[2], C[6], C[10]}}, {C[3], C[7], C[11]}};
  const double off = rotation_error(pose.R);
  if (off > 1e-6 || C[12] != 0 || C[13] != 0 || C[14] != 0 || C[15] != 1)
    throw nb::value_error(
        (argument +
         ": expected a pose, a matrix of a rotation and an origin with (0, 0, 0, 1) as its last "
         "row; " +
         (off > 1e-6 ? "its rotation is off by " + to_text(off) : "its last row differs"))
            .c_str());
  return pose;
}

Array to_array(std::span<const double> numbers) {
  NewArray out({static_cast<nb::ssize_t>(numbers.size())});
  std::copy(numbers.begin(), numbers.end(), out.data());
  return out.array();
}
Array to_array(const Vec3<>& a) {
  NewArray out({3});
  write(a, out.data());
  return out.array();
}
Array to_array(const SE3<>& C) {
  NewArray out({4, 4});
  write(C, out.data());
  return out.array();
}
Array to_array(const Inertia<>& M) { return to_array(to_eigen(M)); }
Array to_array(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  NewArray out({matrix.rows(), matrix.cols()});
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::Map<Rows>(out.data(), matrix.rows(), matrix.cols()) = matrix;
  return out.array();
}

}  // namespace axode::python
