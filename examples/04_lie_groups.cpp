// Screws and displacements: exp and log, the differential of exp, and the screw axis of a displacement.
#include <cstdio>
#include <numbers>

#include "axode/eigen.hpp"
#include "axode/lie.hpp"

using namespace axode;

int main() {
  // A quarter turn about the vertical axis through (1, 2, 0), rising by 0.3 m.
  const double angle = std::numbers::pi / 2;
  const Screw<> X = angle * screw(Vec3<>{0, 0, 1}, Vec3<>{1, 2, 0}, 0.3 / angle);
  const SE3<> C = exp(X);
  std::printf("exp: takes the origin to (%.3f, %.3f, %.3f)\n", C.r.x, C.r.y, C.r.z);

  const ScrewAxis<> axis = screw_axis(log(C));
  std::printf("log: turns by %.3f rad about the axis through (%.3f, %.3f), pitch %.3f m/rad\n",
              axis.magnitude, axis.p.x, axis.p.y, axis.h);

  // dexp turns the rate of X into the spatial twist of exp X: compare with a difference quotient.
  const Screw<> dX{{0.1, -0.2, 0.3}, {0.4, 0.5, -0.6}};
  const double h = 1e-6;
  const Screw<> quotient = (1 / h) * log(exp(X + h * dX) * inverse(C));
  std::printf("dexp: differs from the difference quotient by %.0e\n",
              (to_eigen(dexp(X, dX)) - to_eigen(quotient)).norm());
  std::printf("dexp_inv: brings the rate back to %.0e\n",
              (to_eigen(dexp_inv(X, dexp(X, dX))) - to_eigen(dX)).norm());
}
