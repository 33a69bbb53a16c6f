#include <numbers>

#include "tests/laws/law.hpp"

/// Mechanisms whose equations of motion are in textbooks; the expected numbers are worked out by hand.
namespace axode::test {
namespace {

constexpr double g = 9.81;

class Textbook : public Law {
 protected:
  /// The drive forces of a model in a state.
  static std::vector<double> drives(const Model& model, const State<double>& state,
                                    bool joint_losses = false) {
    Trial trial(GetParam(), model, state);
    return trial.inverse_dynamics(trial.state.v, trial.state.a, {.joint_losses = joint_losses});
  }
  static void expect_drives(const Model& model, const State<double>& state,
                            const std::vector<double>& expected) {
    Comparison torque("torque", GetParam().single ? 1e-5 : 1e-14);
    torque.expect_equal(drives(model, state), expected, 1 + g * model.total_mass());
  }
};
INSTANTIATE_TEST_SUITE_P(Dynamics, Textbook, testing::ValuesIn(cases()), name_of);

MassProperties point_mass(double mass, const Vec3<>& at) { return {.mass = mass, .com = at}; }

TEST_P(Textbook, PendulumWithRotor) {  // (m l² + I) q'' + m g l sin q
  const double m = 2, l = 0.5, I = 0.3, q = 0.7, v = 1.3, a = -0.4;
  const Model model =
      ModelBuilder()
          .add({.name = "bob",
                .joint = {.kind = JointKind::revolute, .axis = {0, -3, 0}, .dof = {{.armature = I}}},
                .inertia = point_mass(m, {0, 0, -l})})
          .build();
  expect_drives(model, {{q}, {v}, {a}}, {(m * l * l + I) * a + m * g * l * std::sin(q)});
}

TEST_P(Textbook, DoublePendulum) {
  const double m1 = 1.5, m2 = 0.8, l1 = 0.6, l2 = 0.4;
  const double q1 = 0.3, q2 = -1.1, v1 = 2, v2 = -1, a1 = 0.5, a2 = 3;
  const auto hinge = [](double z) {
    return JointDescription{.kind = JointKind::revolute, .axis = {0, -1, 0}, .point = {0, 0, z}};
  };
  const Model model =
      ModelBuilder()
          .add({.name = "upper", .joint = hinge(0), .inertia = point_mass(m1, {0, 0, -l1})})
          .add({.name = "lower",
                .predecessor = "upper",
                .joint = hinge(-l1),
                .inertia =
                    MassProperties{.mass = m2, .com = {0, 0, -l1 - l2}, .in = GivenIn::construction_frame}})
          .build();
  const double c2 = std::cos(q2), s2 = std::sin(q2), k = m2 * l1 * l2;
  const double weight2 = m2 * g * l2 * std::sin(q1 + q2);
  const double tau1 = (m1 * l1 * l1 + m2 * (l1 * l1 + l2 * l2) + 2 * k * c2) * a1 +
                      (m2 * l2 * l2 + k * c2) * a2 - k * s2 * (2 * v1 * v2 + v2 * v2) +
                      (m1 + m2) * g * l1 * std::sin(q1) + weight2;
  const double tau2 = (m2 * l2 * l2 + k * c2) * a1 + m2 * l2 * l2 * a2 + k * s2 * v1 * v1 + weight2;
  expect_drives(model, {{q1, q2}, {v1, v2}, {a1, a2}}, {tau1, tau2});
}

TEST_P(Textbook, CartWithPendulum) {
  const double M = 3, m = 0.5, l = 0.7, x = 0.2, q = 0.9, vx = 1, v = 2, ax = -1, a = 4;
  const Model model = ModelBuilder()
                          .add({.name = "cart",
                                .joint = {.kind = JointKind::prismatic, .axis = {1, 0, 0}},
                                .inertia = point_mass(M, {})})
                          .add({.name = "bob",
                                .predecessor = "cart",
                                .joint = {.kind = JointKind::revolute, .axis = {0, -1, 0}},
                                .inertia = point_mass(m, {0, 0, -l})})
                          .build();
  const double c = std::cos(q), s = std::sin(q);
  expect_drives(model, {{x, q}, {vx, v}, {ax, a}},
                {(M + m) * ax + m * l * (c * a - s * v * v), m * l * c * ax + m * l * l * a + m * g * l * s});
}

TEST_P(Textbook, NutOnAScrew) {  // (I + m h²) q'' + m g h
  const double m = 2, I = 0.01, h = 0.05, a = 7;
  const Model model =
      ModelBuilder()
          .add({.name = "nut",
                .joint = {.kind = JointKind::helical, .point = {0.3, -0.2, 0}, .pitch = h},
                .inertia = MassProperties{.mass = m, .com = {0.3, -0.2, 0.5}, .Theta = {I, I, I}}})
          .build();
  expect_drives(model, {{2}, {30}, {a}}, {(I + m * h * h) * a + m * g * h});
}

TEST_P(Textbook, MassesOnAPulley) {  // Atwood's machine: one coordinate for two masses
  const double m1 = 3, m2 = 2, a = 0.6;
  const Model model =
      ModelBuilder()
          .add({.name = "left",
                .joint = {.name = "rope", .kind = JointKind::prismatic},
                .inertia = point_mass(m1, {0, 0, 1})})
          .add({.name = "right",
                .joint = {.kind = JointKind::prismatic, .coupling = Coupling{"rope", -1, 0.4}},
                .inertia = point_mass(m2, {1, 0, 0})})
          .build();
  expect_drives(model, {{0.1}, {2}, {a}}, {(m1 + m2) * a + (m1 - m2) * g});
}

TEST_P(Textbook, FreeFallNeedsNoDrive) {
  const Model model = ModelBuilder()
                          .add({.name = "stone",
                                .joint = {.kind = JointKind::free},
                                .inertia = MassProperties{.mass = 4, .Theta = {0.1, 0.1, 0.1}}})
                          .build();
  const double s = 0.6, c = 0.8;  // sine and cosine of half the angle about x
  const double R_yz = 2 * s * c, R_zz = c * c - s * s;
  // v' = Rᵀ g - ω × v in the axes of the stone.
  const Vec3<> w{1, -2, 0.5}, v{3, 1, -1}, fall = Vec3<>{0, -g * R_yz, -g * R_zz} - cross(w, v);
  expect_drives(model,
                {{s, 0, 0, c, 1, 2, 3}, {w.x, w.y, w.z, v.x, v.y, v.z}, {0, 0, 0, fall.x, fall.y, fall.z}},
                {0, 0, 0, 0, 0, 0});
}

TEST_P(Textbook, FreeRotationObeysEuler) {  // τ = Θ ω' + ω × Θ ω
  const Sym3<> Theta{0.3, 0.5, 0.6, 0, 0, 0};
  const Model model = ModelBuilder()
                          .gravity({})
                          .add({.name = "top",
                                .joint = {.kind = JointKind::spherical},
                                .inertia = MassProperties{.mass = 1, .Theta = Theta}})
                          .build();
  const Vec3<> w{2, -1, 0.5}, a{0.1, 0.2, -0.3};
  const Vec3<> tau = Theta * a + cross(w, Theta * w);
  expect_drives(model, {{0, 0.6, 0, 0.8}, {w.x, w.y, w.z}, {a.x, a.y, a.z}}, {tau.x, tau.y, tau.z});
}

TEST_P(Textbook, HeavyTopPrecessesSteadily) {
  // A top with precession Ω about the vertical, spin n about its axis and nutation θ. Under its weight it
  // precesses steadily if Ω (J n + (J - I) Ω cos θ) = m g l, with I about the support and n relative to the
  // precessing frame.
  const double m = 1.2, l = 0.2, I = 0.08, J = 0.02, theta = 0.5, precession = 3;
  const double spin = (m * g * l / precession - (J - I) * precession * std::cos(theta)) / J;
  const auto turn = [](Vec3<> axis) { return JointDescription{.kind = JointKind::revolute, .axis = axis}; };
  const double I_c = I - m * l * l;
  const Model model =
      ModelBuilder()
          .add({.name = "yoke", .joint = turn({0, 0, 1})})
          .add({.name = "fork", .predecessor = "yoke", .joint = turn({1, 0, 0})})
          .add({.name = "top",
                .predecessor = "fork",
                .joint = turn({0, 0, 1}),
                .inertia = MassProperties{.mass = m, .com = {0, 0, l}, .Theta = {I_c, I_c, J}}})
          .build();
  expect_drives(model, {{0.4, theta, -0.7}, {precession, 0, spin}, {0, 0, 0}}, {0, 0, 0});
}

TEST_P(Textbook, PlanarSlideOnAnIncline) {
  // A disc on a plane through e_y, inclined by 30°: gravity has the component g/2 down the slope.
  const double m = 2, J = 0.1, slope = std::numbers::pi / 6;
  const Model model =
      ModelBuilder()
          .add({.name = "disc",
                .joint = {.kind = JointKind::planar, .axis = {std::sin(slope), 0, std::cos(slope)}},
                .inertia = MassProperties{.mass = m, .Theta = {J, J, J}}})
          .build();
  // The disc does not turn at this instant, and its x-axis points down the slope; v̇ = a + ω × v.
  const double w = 3, vx = 1, vy = 2, ax = 0.5, ay = -0.25, dw = 4;
  expect_drives(model, {{0, 0.3, 0.1}, {w, vx, vy}, {dw, ax, ay}},
                {J * dw, m * (ax - w * vy) - m * g / 2, m * (ay + w * vx)});
}

TEST_P(Textbook, LossesResistTheMotion) {
  const Model model = ModelBuilder()
                          .gravity({})
                          .add({.name = "sled",
                                .joint = {.kind = JointKind::prismatic,
                                          .axis = {1, 0, 0},
                                          .dof = {{.damping = 3, .friction = 0.5}}},
                                .inertia = point_mass(2, {})})
                          .build();
  EXPECT_EQ(drives(model, {{0}, {-4}, {1}}), std::vector<double>{2});
  EXPECT_EQ(drives(model, {{0}, {-4}, {1}}, true), std::vector<double>{2 - 12 - 0.5});
  EXPECT_EQ(drives(model, {{0}, {0}, {1}}, true), std::vector<double>{2});
}

TEST_P(Textbook, JointsOfACantileverTransmitItsWeight) {
  const double m = 3, l = 0.8;  // a beam along x on a hinge about the vertical, so that its weight causes no
                                // drive force
  const Model model = ModelBuilder()
                          .add({.name = "beam",
                                .joint = {.kind = JointKind::revolute, .axis = {0, 0, 1}},
                                .inertia = point_mass(m, {l, 0, 0})})
                          .build();
  Trial trial(GetParam(), model, {{0.5}, {0}, {0}});
  const Six W = changed_wrench(Representation::body, GetParam().representation, trial.poses()[1],
                               trial.joint_wrenches()[0]);
  Comparison wrench("wrench", GetParam().single ? 1e-6 : 1e-15);
  wrench.expect_equal(W, Six{{0, -m * g * l, 0}, {0, 0, m * g}});
}

}  // namespace
}  // namespace axode::test
