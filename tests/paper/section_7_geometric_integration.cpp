#include "axode/integration/reconstruction.hpp"
#include "tests/paper/equation.hpp"

/// Section 7: geometric integration.
namespace axode::test::paper {
namespace {

/// C_{k-1}: where body i was a step of 0.3 s earlier, moving at constant rates.
SE3<> pose_before(const Motion& m, int i) {
  std::vector<double> back = m.v();
  for (double& x : back) x *= -0.3;
  return m.poses_at(integrate(m.model(), m.q(), back))[i];
}
PoseOfT constant(const SE3<>& C) { return cast<Series>(C); }

/// The pose at s = 1 that the library reconstructs from the twists of the motion C(0) exp X(s), or exp(X(s))
/// C(0), from s = 0.99 on, with X(1) = X and X'(1) = dX.
template <class Rep> SE3<> reconstructed(const SE3<>& C_0, const Screw<>& X, const Screw<>& dX) {
  const Screw<> change = dX + (-X);
  const auto X_at = [&](double s) { return s * X + (s * s - s) * change; };
  const auto twist_at = [&](double s) {
    const Screw<> at = X_at(s);
    return twist<Rep>(dexp(std::same_as<Rep, BodyFixed> ? -at : at, X + (2 * s - 1) * change));
  };
  std::vector<double> times;
  for (int k = 0; k <= 10; ++k) times.push_back(0.99 + 0.001 * k);
  return reconstruct<Rep>(reconstruction::moved<Rep>(C_0, exp(X_at(times[0]))), twist_at, times,
                          runge_kutta(5))
      .back();
}

// V̂^b = C⁻¹ Ċ and V̂^s = Ċ C⁻¹
TEST(Paper, Vbs) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat4 C = to_matrix(m.pose(i)), dC = rate(to_matrix(m.C_of_t(i)));
    eq.holds(hat(screw(m.twist<BodyFixed>(i))), C.inverse() * dC);
    eq.holds(hat(screw(m.twist<Spatial>(i))), dC * C.inverse());

    const double h = 0.1;  // s, after which a constant twist has displaced the body by exp(h V)
    const SE3<> start = m.pose(i);
    const SE3<> by_V_b =
        reconstruct<BodyFixed>(start, [&](double) { return m.twist<BodyFixed>(i); }, {{0, h}})[1];
    const SE3<> by_V_s =
        reconstruct<Spatial>(start, [&](double) { return m.twist<Spatial>(i); }, {{0, h}})[1];
    eq.holds(hat(log(inverse(start) * by_V_b)), h * C.inverse() * dC);
    eq.holds(hat(log(by_V_s * inverse(start))), h * dC * C.inverse());
  });
}

// V^b = dexp_{-X} Ẋ with C_{k-1}⁻¹ C = exp X
TEST(Paper, VdexpBody) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const PoseOfT increment = constant(inverse(pose_before(m, i))) * m.C_of_t(i);
    const Screw<Series> X = log(increment);
    const Vec6OfT X_of_t = to_matrix(X);
    eq.holds(now(increment), exp(from_six(now(X_of_t))));
    const Screw<> X_now = from_six(now(X_of_t)), dX = from_six(rate(X_of_t));
    eq.holds(m.V<BodyFixed>(i), dexp(-X_now, dX));
    eq.holds(m.twist<BodyFixed>(i), to_matrix(dexp_matrix(-X_now)) * dX);
    eq.holds(m.pose(i), reconstructed<BodyFixed>(pose_before(m, i), X_now, dX));
  });
}

// V^s = Ad_{C_{k-1}} dexp_X Ẋ with C_{k-1}⁻¹ C = exp X. Printed: without Ad_{C_{k-1}}, which is right for
// C = exp(X) C_{k-1}.
TEST(Paper, VdexpSpatial) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const SE3<> C_before = pose_before(m, i);
    const auto dexp_X_dX = [](const PoseOfT& increment) -> Vec6 {
      const Vec6OfT X = to_matrix(log(increment));
      return to_matrix(dexp(from_six(now(X)), from_six(rate(X))));
    };
    const PoseOfT right_increment = constant(inverse(C_before)) * m.C_of_t(i);
    const PoseOfT left_increment = m.C_of_t(i) * constant(inverse(C_before));
    eq.holds(m.twist<Spatial>(i), Ad(C_before) * dexp_X_dX(right_increment));
    eq.holds(m.twist<Spatial>(i), dexp_X_dX(left_increment));
    const Vec6OfT X = to_matrix(log(left_increment));
    eq.holds(m.pose(i), reconstructed<Spatial>(C_before, from_six(now(X)), from_six(rate(X))));
    eq.fails(m.twist<Spatial>(i), dexp_X_dX(right_increment));
  });
}

}  // namespace
}  // namespace axode::test::paper
