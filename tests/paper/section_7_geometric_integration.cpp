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

// V̂^b = C⁻¹ Ċ and V̂^s = Ċ C⁻¹
TEST(Paper, Vbs) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat4 C = to_matrix(m.pose(i)), dC = rate(to_matrix(m.C_of_t(i)));
    eq.holds(hat(screw(m.twist<BodyFixed>(i))), C.inverse() * dC);
    eq.holds(hat(screw(m.twist<Spatial>(i))), dC * C.inverse());
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
    eq.fails(m.twist<Spatial>(i), dexp_X_dX(right_increment));
  });
}

}  // namespace
}  // namespace axode::test::paper
