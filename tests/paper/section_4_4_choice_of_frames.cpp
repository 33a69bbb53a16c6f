#include "tests/paper/equation.hpp"

/// Section 4.4: choice of body-fixed reference frames.
namespace axode::test::paper {
namespace {

Matrix inverse_dynamics_of(const Model& model, const Motion& m) {
  Workspace<double> workspace(model);
  Matrix tau(model.nv(), 1);
  inverse_dynamics(model, workspace, m.q(), m.v(), m.a(), tau.entries());
  return tau;
}

// A_i = I: all body frames at the construction frame when q = 0. Then Y_i = X_i, and C_i = exp(X_1 q_1) ...
// exp(X_i q_i).
TEST(Paper, GlobalFrameChoice) {
  for (const Topology topology : one_screw_joints) {
    Equation eq;
    for (int s = 0; s < systems_each; ++s) {
      const Motion m(make_system(topology, s, BodyFrames::at_the_construction_frame), s);
      for (int i = 1; i <= m.n(); ++i) {
        eq.at(m.model().name() + ", " + m.body(i).name);
        SE3<> C;
        for (const int j : m.path(i)) C = C * exp(m.q(j) * m.X_screw(j));
        eq.holds(m.body(i).A, SE3<>{});
        eq.holds(m.drawn(i).Y, m.X(i));
        eq.holds(m.pose(i), C);
      }
      const System same_mechanism = make_system(topology, s, BodyFrames::random);
      eq.holds(inverse_dynamics_of(m.model(), m), inverse_dynamics_of(same_mechanism.model, m));
    }
    eq.conclude(topology);
  }
}

}  // namespace
}  // namespace axode::test::paper
