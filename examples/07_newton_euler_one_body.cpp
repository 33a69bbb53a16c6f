// The Newton-Euler equations of one body: the wrench that causes a motion in four representations, and the
// motion that a wrench causes.
#include <cstdio>

#include "axode/eigen.hpp"
#include "axode/lie/newton_euler.hpp"

using namespace axode;

int main() {
  // A brick of 2 kg whose frame sits on a corner, somewhere in space, tumbling.
  const Inertia<> M = inertia_from_com(2.0, Vec3<>{0.05, 0.1, 0.2}, Sym3<>{.033, .028, .008, 0, 0, 0});
  const SE3<> C{exp_SO3(Vec3<>{0.4, -0.2, 0.9}), {1, 2, 0.5}};
  const Twist<BodyFixed> V{{3, -1, 2}, {0.5, 0, -0.2}};
  const TwistRate<BodyFixed> dV{{0, 4, -1}, {1, 0, 2}};

  const auto show = [&]<class Rep>(const char* name, Rep) {
    const Twist<Rep> V_rep = change<Rep>(C, V);
    const TwistRate<Rep> dV_rep = change<Rep>(C, V, dV);
    const Wrench<Rep> W_rep = wrench(C, M, V_rep, dV_rep);  // from the motion in this representation alone
    const double back = (to_eigen(acceleration(C, M, V_rep, W_rep)) - to_eigen(dV_rep)).norm();
    std::printf(
        "%-8s m = (%7.3f, %7.3f, %7.3f) N m  f = (%7.3f, %7.3f, %7.3f) N  power %.6f W  back to %.0e\n", name,
        W_rep.m.x, W_rep.m.y, W_rep.m.z, W_rep.f.x, W_rep.f.y, W_rep.f.z, W_rep | V_rep, back);
  };
  show("body", BodyFixed{}), show("spatial", Spatial{}), show("hybrid", Hybrid{}), show("mixed", Mixed{});
}
