// A humanoid that floats without gravity and waves its arms. In momentum variables one can see what is
// conserved.
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

using namespace axode;

int main() {
  const Model humanoid =
      ModelBuilder(load(AXODE_ROBOTS_DIR "/humanoid.urdf", Base::free)).gravity({}).build();
  Workspace<> workspace(humanoid);
  std::vector<double> q = neutral(humanoid), v(humanoid.nv()), p(humanoid.nv()), dp(p), tau(humanoid.nv());
  for (int c = 6; c < humanoid.nv(); ++c) tau[c] = 0.2 * (c % 3 - 1);  // N m; the base has no drive

  const auto report = [&](double t) {
    const Momentum<Spatial> Pi = spatial_momentum(humanoid, workspace, q, v);
    std::printf("%5.2f s   %9.5f J   (%8.1e %8.1e %8.1e) N m s   (%8.1e %8.1e %8.1e) N s\n", t,
                kinetic_energy(humanoid, workspace, q, v), Pi.l.x, Pi.l.y, Pi.l.z, Pi.p.x, Pi.p.y, Pi.p.z);
  };
  std::printf("time      energy        total angular momentum             total linear momentum\n");
  const double dt = 1e-3;
  for (int step = 0; step <= 200; ++step) {
    // q' = M(q)⁻¹ p and p' = τ + Jᵀ W + (ad_V J)ᵀ Π. The simplest step takes first p and then q.
    if (!momentum_form(humanoid, workspace, q, p, tau, v, dp).ok()) return 1;
    if (step % 50 == 0) report(step * dt);
    for (int c = 0; c < humanoid.nv(); ++c) p[c] += dt * dp[c];
    if (!momentum_form(humanoid, workspace, q, p, tau, v, dp).ok()) return 1;
    std::vector<double> dq = v;
    for (double& x : dq) x *= dt;
    q = integrate(humanoid, q, dq);
  }
}
