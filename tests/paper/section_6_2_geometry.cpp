#include "axode/derivatives.hpp"
#include "tests/lie/random_quantities.hpp"
#include "tests/paper/equation.hpp"

/// Section 6.2: derivatives by geometric parameters.
namespace axode::test::paper {
namespace {

/// exp(U π(t)) with π = x + t x'.
PoseOfT exp_of_t(const Screw<>& U, double x, double dx) {
  Series pi(x);
  pi.c[1] = dx;
  const auto times_pi = [&](const Vec3<>& a) {
    return Vec3<Series>{Series(a.x) * pi, Series(a.y) * pi, Series(a.z) * pi};
  };
  return exp(Screw<Series>{times_pi(U.w), times_pi(U.v)});
}

// B_i(π) = B_i0 exp(U_1 π_1) exp(U_2 π_2): C⁻¹ ∂C/∂π_l is U_l, transformed by all that stands to its right in
// C = C_{i-1} B_i(π) exp(X_i q_i), as for a joint's screw
TEST(Paper, GeometricParameters) {
  each_body([](Equation& eq, const Motion& m, int i) {
    Random<double> random(static_cast<std::uint64_t>(i));
    const Screw<> U_1 = random.screw(), U_2 = random.screw();
    const double pi_2 = 0.7, dpi_1 = 1.3, dpi_2 = -0.4;
    const auto still = [](const SE3<>& C) { return cast<Series>(C); };
    const SE3<> C_p = m.C(m.predecessor(i)), joint = inverse(C_p * m.body(i).B) * m.C(i);  // exp(X_i q_i)
    const auto moving = [&](double x_1, double x_2) {
      return still(C_p * m.body(i).B) * exp_of_t(U_1, x_1, dpi_1) * exp_of_t(U_2, x_2, dpi_2) * still(joint);
    };
    const auto body_fixed_twist = [](const PoseOfT& C) { return now(twist_of(C, Representation::body)); };
    const SE3<> right_of_1 = exp(Screw<>{pi_2 * U_2.w, pi_2 * U_2.v}) * joint;
    eq.holds(body_fixed_twist(moving(-0.2, pi_2)),
             Ad(inverse(right_of_1)) * Vec6(U_1) * dpi_1 + Ad(inverse(joint)) * Vec6(U_2) * dpi_2);

    // What the library answers is the same at π = 0, in all unit screws at once.
    Workspace<> workspace(m.model());
    const std::size_t n = static_cast<std::size_t>(m.n());
    std::vector<double> J(6 * n * 6);
    frame_geometry_jacobian<double>(m.model(), workspace, m.q(), i, J);
    Mat6 J_i;
    for (int row = 0; row < 6; ++row)
      for (int u = 0; u < 6; ++u)
        J_i(row, u) = J[(static_cast<std::size_t>(row) * n + static_cast<std::size_t>(i - 1)) * 6 +
                        static_cast<std::size_t>(u)];
    eq.holds(body_fixed_twist(moving(0, 0)), J_i * (Vec6(U_1) * dpi_1 + Vec6(U_2) * dpi_2));
  });
}

}  // namespace
}  // namespace axode::test::paper
