#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "axode/constraints.hpp"
#include "axode/dynamics.hpp"
#include "axode/eigen.hpp"
#include "axode/integration.hpp"
#include "axode/kinematics.hpp"
#include "tests/fmi/instance_of.hpp"
#include "tests/support/random_loops.hpp"
#include "tests/support/random_tree.hpp"

/// An FMU computes what the library computes.
namespace axode::test {
namespace {

using fmi::Instance;
using fmi::Kind;
using fmi::Role;
using testing::HasSubstr;

Model random_model(std::uint64_t seed) {
  Random<double> random(seed);
  return ModelBuilder(described(random_mechanism(random, {.most_bodies = 8, .always_mass = true}), random))
      .build();
}

/// The states of model exchange, with the quaternions scaled by a factor.
std::vector<double> states_of(const Model& model, std::span<const double> q, std::span<const double> v,
                              double factor) {
  std::vector<double> states(q.begin(), q.end());
  for (const int i : model.tree<double>()->quaternion_bodies)
    for (int k = 0; k < 4; ++k) states[static_cast<std::size_t>(model.joint(i).iq + k)] *= factor;
  states.insert(states.end(), v.begin(), v.end());
  return states;
}

TEST(FmuRates, AreThoseOfForwardDynamicsAndDoNotDependOnNormsOfQuaternions) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Model model = random_model(seed);
    Random<double> random(seed);
    const State<double> state = random_state(model, random);
    Instance instance = instance_of(model, Kind::model_exchange);
    const fmi::VariableTable table = variables_of(model);
    instance.enter_initialization(0, {});
    instance.exit_initialization();
    std::vector<double> tau(static_cast<std::size_t>(model.nv())), a(tau);
    std::vector<double> inputs;
    for (const std::size_t c : table.driven()) inputs.push_back(tau[c] = random.number(-1, 1));
    instance.set(references(table, Role::force), inputs);
    Workspace<> workspace(model);
    add_spring_forces(model, workspace, std::span<const double>(state.q), std::span<const double>(state.v),
                      tau);
    ASSERT_TRUE(forward_dynamics(model, workspace, std::span<const double>(state.q),
                                 std::span<const double>(state.v), std::span<const double>(tau), a)
                    .ok());
    std::vector<double> expected = coordinate_rates(model, state.q, state.v);
    expected.insert(expected.end(), a.begin(), a.end());
    double size = 1;
    for (const double x : expected) size = std::max(size, std::abs(x));
    for (const double factor : {1.0, 3.0, 0.1}) {
      std::vector<double> rates(instance.n_states());
      instance.set_states(states_of(model, state.q, state.v, factor));
      instance.get_rates(rates);
      for (std::size_t k = 0; k < rates.size(); ++k)
        EXPECT_NEAR(rates[k], expected[k], 1e-9 * size) << "seed " << seed << ", " << k;
    }
  }
}

/// Compares the Jacobian by the states and inputs with differences of fourth order.
void expect_exact_derivatives(Instance& instance, const fmi::VariableTable& table, std::vector<double> states,
                              const std::string& about) {
  std::vector<unsigned> unknowns, knowns;
  for (const Role role : {Role::coordinate_rate, Role::acceleration, Role::drive_rate, Role::coordinate,
                          Role::velocity, Role::pose})
    std::ranges::copy(references(table, role), std::back_inserter(unknowns));
  for (const Role role : {Role::coordinate, Role::velocity, Role::drive_state, Role::force, Role::load})
    std::ranges::copy(references(table, role), std::back_inserter(knowns));
  std::vector<unsigned> all_inputs = references(table, Role::force);
  std::ranges::copy(references(table, Role::load), std::back_inserter(all_inputs));
  const std::vector<double> inputs = values(instance, all_inputs);
  const auto at = [&](std::size_t k, double by) {
    std::vector<double> x = states, u = inputs;
    (k < x.size() ? x[k] : u[k - x.size()]) += by;
    instance.set_states(x);
    instance.set(all_inputs, u);
    return values(instance, unknowns);
  };
  Eigen::MatrixXd J(unknowns.size(), knowns.size());
  at(0, 0);
  for (std::size_t k = 0; k < knowns.size(); ++k) {
    std::vector<double> column(unknowns.size());
    instance.directional_derivative(unknowns, std::vector{knowns[k]}, std::vector{1.0}, column);
    J.col(static_cast<Eigen::Index>(k)) = as_eigen(std::span<const double>(column));
  }
  const double size = J.cwiseAbs().maxCoeff(), h = 1e-3;
  for (std::size_t k = 0; k < knowns.size(); ++k) {
    const double by = k < states.size() ? h * table[knowns[k]].nominal : h;
    const std::vector<double> p2 = at(k, 2 * by), p1 = at(k, by), m1 = at(k, -by), m2 = at(k, -2 * by);
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      const double difference = (m2[i] - 8 * m1[i] + 8 * p1[i] - p2[i]) / (12 * by);
      EXPECT_NEAR(J(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)), difference, 1e-6 * size)
          << about << ": " << table[unknowns[i]].name << " by " << table[knowns[k]].name;
    }
  }
  at(0, 0);
  std::vector<double> seed(knowns.size()), weights(unknowns.size()), forward(unknowns.size()),
      backward(knowns.size());
  for (std::size_t k = 0; k < seed.size(); ++k) seed[k] = std::sin(1.0 + static_cast<double>(k));
  for (std::size_t k = 0; k < weights.size(); ++k) weights[k] = std::cos(static_cast<double>(k));
  instance.directional_derivative(unknowns, knowns, seed, forward);
  instance.adjoint_derivative(unknowns, knowns, weights, backward);
  const auto vector = [](const std::vector<double>& x) { return as_eigen(std::span<const double>(x)); };
  EXPECT_LT((vector(forward) - J * vector(seed)).norm(), 1e-12 * size * static_cast<double>(knowns.size()));
  EXPECT_LT((vector(backward) - J.transpose() * vector(weights)).norm(),
            1e-12 * size * static_cast<double>(unknowns.size()));
}

TEST(FmuDerivatives, AreThoseOfRatesAndPosesOfRandomTrees) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Model model = random_model(seed);
    Random<double> random(seed);
    const State<double> state = random_state(model, random);
    const std::string last = model.frame(model.n_bodies()).name;
    fmi::Settings settings{false, {last}, {last}};
    if (model.n_bodies() > 1) settings.loads.push_back(model.frame(1).name);
    Instance instance = instance_of(model, Kind::model_exchange, settings);
    instance.enter_initialization(0, {});
    instance.exit_initialization();
    expect_exact_derivatives(instance, variables_of(model, settings),
                             states_of(model, state.q, state.v, 1 + 0.1 * random.number(-1, 1)),
                             "seed " + std::to_string(seed));
  }
}

TEST(FmuDerivatives, AreThoseOfRatesWithLoopsSpringsDrivesAndMotions) {
  for (const char* file : {"four_bar.toml", "slider_crank.toml", "gough.toml", "governor.toml"}) {
    const Model model = shipped(file);
    const InitialState at = initial_state(model);
    const fmi::Settings settings{false, {}, {model.frame(model.n_bodies()).name}};
    Instance instance = instance_of(model, Kind::model_exchange, settings);
    const fmi::VariableTable table = variables_of(model, settings);
    start(instance, table, at.q, at.v);
    instance.set(references(table, Role::load), std::vector{0.1, 0.2, -0.3, 1.0, 2.0, -3.0});
    std::vector<double> states(instance.n_states());
    instance.get_states(states);
    expect_exact_derivatives(instance, table, states, file);
  }
}

TEST(FmuDerivatives, ByParametersAreThoseOfModelsWithOtherNumbers) {
  const Model model = load(AXODE_SOURCE_DIR "/tests/data/good/springs.toml");
  const fmi::VariableTable table = variables_of(model);
  const std::vector<unsigned> unknowns = references(table, Role::acceleration);
  Instance instance = instance_of(model, Kind::model_exchange);
  instance.enter_initialization(0, {});
  std::vector<double> q = random_configuration(model, 1), v(static_cast<std::size_t>(model.nv()), 0.3);
  instance.set(references(table, Role::coordinate), q);
  instance.set(references(table, Role::velocity), v);
  for (std::size_t k = 0; k < table.count(Role::parameter); ++k) {
    const std::vector<unsigned> known{static_cast<unsigned>(table.first(Role::parameter) + k)};
    std::vector<double> found(unknowns.size());
    if (!table.parameters()[k].has_derivative) {
      EXPECT_THROW(instance.directional_derivative(unknowns, known, std::vector{1.0}, found),
                   std::invalid_argument);
      continue;
    }
    const double value = table[known[0]].start, h = 1e-4 * (value == 0 ? 1 : std::abs(value));
    const auto at = [&](double steps) {
      instance.set(known, std::vector{value + steps * h});
      return values(instance, unknowns);
    };
    const std::vector<double> x0 = at(0), x1 = at(1), x2 = at(2), x3 = at(3), x4 = at(4);
    at(0);
    instance.directional_derivative(unknowns, known, std::vector{1.0}, found);
    double size = 1;
    for (const double x : found) size = std::max(size, std::abs(x));
    for (std::size_t i = 0; i < found.size(); ++i)
      EXPECT_NEAR(found[i], (-25 * x0[i] + 48 * x1[i] - 36 * x2[i] + 16 * x3[i] - 3 * x4[i]) / (12 * h),
                  1e-6 * size)
          << table[unknowns[i]].name << " by " << table[known[0]].name;
  }
}

TEST(FmuParameters, GiveTheModelWithTheseNumbers) {
  const Model model = shipped("four_bar.toml");
  const fmi::VariableTable table = variables_of(model);
  ModelBuilder heavier(model);
  heavier.body("coupler").inertia->mass *= 2;
  heavier.gravity({0, 1, -1.6});
  const Model expected = heavier.build();
  const InitialState at = initial_state(model);
  const Trajectory motion = simulate(expected, at.q, at.v, 0.5, {1e-12, 1e-13});
  Instance instance = instance_of(model, Kind::co_simulation);
  instance.set(reference(table, "body.coupler.mass"), std::vector{heavier.body("coupler").inertia->mass});
  for (const auto& [name, g] : {std::pair("gravity[0]", 0.0), {"gravity[1]", 1.0}, {"gravity[2]", -1.6}})
    instance.set(reference(table, name), std::vector{g});
  start(instance, table, at.q, at.v, 1e-11);
  instance.step(0, 0.5);
  const std::vector<double> q = values(instance, references(table, Role::coordinate));
  for (std::size_t k = 0; k < q.size(); ++k) EXPECT_NEAR(q[k], motion.q(motion.size() - 1)[k], 1e-9);
}

/// Integrates an instance for model exchange by the classical Runge-Kutta method, with events between steps.
void integrate(Instance& instance, double until, int steps) {
  const std::size_t n = instance.n_states();
  std::optional<double> next;
  const auto take_event = [&] {
    instance.enter(Instance::Mode::event);
    next = instance.update_discrete_states().next;
    instance.enter(Instance::Mode::continuous_time);
  };
  take_event();
  const double h = until / steps;
  Eigen::VectorXd x(n), k1(n), k2(n), k3(n), k4(n);
  instance.get_states(as_span(x));
  const auto rates = [&](double t, const Eigen::VectorXd& at, Eigen::VectorXd& out) {
    instance.set_time(t);
    instance.set_states(as_span(at));
    instance.get_rates(as_span(out));
  };
  for (int k = 0; k < steps; ++k) {
    const double t = k * h;
    rates(t, x, k1);
    rates(t + h / 2, x + h / 2 * k1, k2);
    rates(t + h / 2, x + h / 2 * k2, k3);
    rates(t + h, x + h * k3, k4);
    x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    instance.set_time((k + 1) * h);
    instance.set_states(as_span(std::as_const(x)));
    const bool is_due = next && (k + 1) * h > *next - 1e-12;
    if (is_due) instance.set_time(*next);
    if (!instance.needs_event() && !is_due) continue;
    take_event();
    instance.get_states(as_span(x));
  }
}

TEST(FmuMotion, IsThatOfTheLibraryInBothKinds) {
  for (const char* file : {"double_pendulum.toml", "four_bar.toml", "slider_crank.toml", "gough.toml"}) {
    const Model model = shipped(file);
    const fmi::VariableTable table = variables_of(model);
    const AssemblyResult at = assemble(model, initial_state(model).q, initial_state(model).v);
    const double until = 0.4;
    const Trajectory motion = simulate(model, at.q, at.v, until, {1e-12, 1e-13});
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    for (const Kind kind : {Kind::model_exchange, Kind::co_simulation}) {
      Instance instance = instance_of(model, kind);
      start(instance, table, at.q, at.v, 1e-11);
      if (kind == Kind::model_exchange) {
        integrate(instance, until, 2000);
      } else {
        for (int k = 0; k < 4; ++k) instance.step(0.1 * k, 0.1);
      }
      const std::vector<double> q = values(instance, references(table, Role::coordinate)),
                                v = values(instance, references(table, Role::velocity));
      for (std::size_t k = 0; k < q.size(); ++k)
        EXPECT_NEAR(q[k], motion.q(motion.size() - 1)[k], 1e-9) << file;
      for (std::size_t k = 0; k < v.size(); ++k)
        EXPECT_NEAR(v[k], motion.v(motion.size() - 1)[k], 1e-8) << file;
    }
  }
}

Model driven_pendulum() {
  BodyDescription rod{
      .name = "rod",
      .joint = {.name = "pin", .kind = JointKind::revolute, .axis = {0, 1, 0}},
      .inertia = MassProperties{.mass = 1, .com = {0, 0, -0.4}, .Theta = {0.02, 0.02, 0.001, 0, 0, 0}}};
  rod.joint.dof = {{.damping = 0.1, .friction = 0.3}};
  return ModelBuilder("driven")
      .gravity({0, 0, -9.81})
      .add(rod)
      .add({.name = "motor",
            .joints = {{"pin", 1.0}},
            .parameters = {{"resistance", 1.0}, {"inductance", 0.05}, {"torque_constant", 0.5}},
            .input = {.times = {0, 0.1}, .values = {3, -6}}})
      .build();
}

TEST(FmuDrives, CarryTheirStatesAndTakeStepsOfTheirInputs) {
  const Model model = driven_pendulum();
  const fmi::VariableTable table = variables_of(model);
  const std::vector<double> zero(1);
  const Trajectory motion = simulate(model, zero, zero, 0.4, {1e-12, 1e-13});
  const std::size_t last = motion.size() - 1;
  for (const Kind kind : {Kind::model_exchange, Kind::co_simulation}) {
    Instance instance = instance_of(model, kind);
    start(instance, table, zero, zero, 1e-11);
    if (kind == Kind::model_exchange)
      integrate(instance, 0.4, 2000);
    else
      for (int k = 0; k < 4; ++k) instance.step(0.1 * k, 0.1);
    EXPECT_NEAR(values(instance, reference(table, "q.pin"))[0], motion.q(last)[0], 1e-9);
    EXPECT_NEAR(values(instance, reference(table, "drive.motor.current"))[0], motion.x(last)[0], 1e-9);
  }
  Instance instance = instance_of(model, Kind::model_exchange);
  start(instance, table, zero, zero);
  expect_exact_derivatives(instance, table, {0.3, 0.5, 2}, "motor");
}

/// A controller that saturates at first: the derivatives are those of its present status.
TEST(FmuDrives, HaveTheDerivativesOfTheirStatusInCoSimulation) {
  constexpr double kp = 1, kd = 0.5, filter_time = 0.01, inertia = 0.1;
  const Model model =
      ModelBuilder("wheel")
          .add({.name = "wheel",
                .joint = {.name = "axle", .kind = JointKind::revolute, .axis = {0, 0, 1}},
                .inertia = MassProperties{.mass = 1, .Theta = {inertia, inertia, inertia, 0, 0, 0}}})
          .add({.name = "controller",
                .kind = DriveKind::pid,
                .joints = {{"axle", 1.0}},
                .parameters = {{"kp", kp}, {"kd", kd}, {"filter_time", filter_time}, {"limit", 0.3}},
                .input = {.values = {1}}})
          .build();
  const fmi::VariableTable table = variables_of(model);
  Instance instance = instance_of(model, Kind::co_simulation);
  start(instance, table, {{0}}, {{0}}, 1e-9);
  const auto by_q = [&] {
    const std::vector<double> one{1};
    std::vector<double> out(1);
    instance.directional_derivative(reference(table, "der(v.axle)"), reference(table, "q.axle"), one, out);
    return out[0];
  };
  EXPECT_EQ(by_q(), 0);
  for (int k = 0; k < 200; ++k) instance.step(0.02 * k, 0.02);
  EXPECT_NEAR(by_q(), -(kp + kd / filter_time) / inertia, 1e-9);
}

TEST(FmuFriction, SticksAndSlidesInCoSimulation) {
  const Model model = driven_pendulum();
  const fmi::Settings settings{.joint_losses = true};
  const fmi::VariableTable table = variables_of(model, settings);
  const std::vector<double> zero(1), q_0{0.6};
  SimulationOptions options;
  options.joint_losses = true;
  const Trajectory motion = simulate(model, q_0, zero, 3, {1e-12, 1e-13}, options);
  Instance instance = instance_of(model, Kind::co_simulation, settings);
  start(instance, table, q_0, zero, 1e-11);
  for (int k = 0; k < 30; ++k) instance.step(0.1 * k, 0.1);
  EXPECT_NEAR(values(instance, reference(table, "q.pin"))[0], motion.q(motion.size() - 1)[0], 1e-9);
  Instance at_rest = instance_of(model, Kind::co_simulation, settings);
  at_rest.enter_initialization(0, {});
  at_rest.set(reference(table, "q.pin"), std::vector{0.05});
  EXPECT_EQ(values(at_rest, reference(table, "der(v.pin)"))[0], 0);
  const auto by_force = [&] {
    const std::vector<double> one{1};
    std::vector<double> out(1);
    at_rest.directional_derivative(reference(table, "der(v.pin)"), reference(table, "tau.pin"), one, out);
    return out[0];
  };
  EXPECT_NEAR(by_force(), 0, 1e-12);
  at_rest.set(reference(table, "q.pin"), std::vector{0.6});
  EXPECT_LT(values(at_rest, reference(table, "der(v.pin)"))[0], -1);
  EXPECT_GT(by_force(), 1);
}

TEST(FmuLoads, ActInBothKinds) {
  const Model model = shipped("four_bar.toml");
  const fmi::Settings settings{false, {}, {"coupler"}};
  const fmi::VariableTable table = variables_of(model, settings);
  const InitialState at = initial_state(model);
  const std::vector<double> W{0.1, 0.2, 0.3, -1, 0.5, 0.4};
  SimulationOptions options;
  options.loads = fmi::applied(W, std::vector{model.frame_index("coupler")});
  const Trajectory motion = simulate(model, at.q, at.v, 0.4, {1e-12, 1e-13}, options);
  for (const Kind kind : {Kind::model_exchange, Kind::co_simulation}) {
    Instance instance = instance_of(model, kind, settings);
    start(instance, table, at.q, at.v, 1e-11);
    instance.set(references(table, Role::load), W);
    if (kind == Kind::model_exchange)
      integrate(instance, 0.4, 2000);
    else
      instance.step(0, 0.4);
    const std::vector<double> q = values(instance, references(table, Role::coordinate));
    for (std::size_t k = 0; k < q.size(); ++k) EXPECT_NEAR(q[k], motion.q(motion.size() - 1)[k], 1e-9);
  }
}

TEST(FmuStates, ContinueAsTheyWereSaved) {
  const Model model = shipped("four_bar.toml");
  const fmi::VariableTable table = variables_of(model);
  const InitialState at = initial_state(model);
  Instance instance = instance_of(model, Kind::co_simulation);
  start(instance, table, at.q, at.v);
  instance.set(references(table, Role::force), std::vector<double>(table.count(Role::force), 0.2));
  instance.step(0, 0.2);
  const Instance saved(instance);
  instance.step(0.2, 0.3);
  const std::vector<double> once = values(instance, references(table, Role::coordinate));
  Instance again(saved);
  again.step(0.2, 0.3);
  EXPECT_EQ(values(again, references(table, Role::coordinate)), once);
  instance.reset();
  start(instance, table, at.q, at.v);
  instance.set(references(table, Role::force), std::vector<double>(table.count(Role::force), 0.2));
  instance.step(0, 0.2);
  instance.step(0.2, 0.3);
  EXPECT_EQ(values(instance, references(table, Role::coordinate)), once);
}

TEST(FmuStart, ClosesTheLoopsNearTheValuesOfTheMaster) {
  const Model model = shipped("four_bar.toml");
  const fmi::VariableTable table = variables_of(model);
  Instance instance = instance_of(model, Kind::model_exchange);
  std::vector<double> q = initial_state(model).q;
  q[0] += 0.05;
  start(instance, table, q, std::vector<double>(static_cast<std::size_t>(model.nv())));
  const std::vector<double> closed = values(instance, references(table, Role::coordinate));
  LoopWorkspace<> workspace(model);
  std::vector<double> r(static_cast<std::size_t>(model.loops().residuals));
  loop_residual<double>(model, workspace, closed, r);
  for (const double each : r) EXPECT_NEAR(each, 0, 1e-11);
  EXPECT_NE(closed, q);
}

TEST(FmuStart, TakesAMechanismWithoutJoints) {
  const Model model = ModelBuilder("stone").add(BodyDescription{.name = "stone"}).build();
  for (const Kind kind : {Kind::model_exchange, Kind::co_simulation}) {
    Instance instance = instance_of(model, kind, {.frames = {"stone"}});
    start(instance, variables_of(model), {}, {});
    EXPECT_EQ(instance.n_states(), 0U);
    instance.get_rates({});
    if (kind == Kind::model_exchange)
      EXPECT_FALSE(instance.needs_event());
    else
      instance.step(0, 0.1);
    EXPECT_EQ(values(instance,
                     reference(variables_of(model, {.frames = {"stone"}}), "frame.stone.rotation[0,0]"))[0],
              1);
  }
}

template <class F> std::string refusal(const F& f) {
  try {
    f();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(FmuErrors, NameTheThing) {
  const Model model = shipped("arm7.toml");
  const fmi::VariableTable table = variables_of(model);
  Instance instance = instance_of(model, Kind::co_simulation);
  const auto set = [&](const char* name, double value) {
    return refusal([&] { instance.set(reference(table, name), std::vector{value}); });
  };
  EXPECT_THAT(set("q.A1", std::nan("")),
              HasSubstr("variable \"q.A1\" cannot be set to a number that is not finite"));
  EXPECT_THAT(set("der(v.A1)", 1), HasSubstr("variable \"der(v.A1)\" is computed"));
  EXPECT_THAT(refusal([&] { instance.step(0, 0.1); }), HasSubstr("before the initialization had ended"));
  EXPECT_EQ(set("body.link 1.mass", -1), "nothing was refused");
  instance.enter_initialization(0, {});
  EXPECT_THAT(refusal([&] { instance.exit_initialization(); }), HasSubstr("mass"));
  instance.reset();
  instance.enter_initialization(0, {});
  instance.exit_initialization();
  EXPECT_THAT(set("q.A1", 1), HasSubstr("before the end of the initialization"));
  EXPECT_THAT(refusal([&] { instance.step(0, 0); }), HasSubstr("must be positive"));
  EXPECT_THAT(refusal([&] { instance.step(0.5, 0.1); }), HasSubstr("the last one has ended at 0"));
  EXPECT_THAT(refusal([&] { values(instance, {100'000}); }), HasSubstr("value reference 100000"));
  std::vector<double> one(1);
  EXPECT_THAT(refusal([&] {
                instance.directional_derivative(reference(table, "time"), reference(table, "q.A1"), one, one);
              }),
              HasSubstr("variable \"time\" is no unknown"));
  EXPECT_THAT(refusal([&] {
                instance.directional_derivative(reference(table, "der(v.A1)"), reference(table, "time"), one,
                                                one);
              }),
              HasSubstr("variable \"time\" is no known"));
}

/// A master that has taken a step too far tries a shorter one.
TEST(FmuErrors, SayThatThereAreNoRatesBeyondTheSamplesOfAMotion) {
  Description d = shipped("double_pendulum.toml").description();
  d.motions = {{.of = "pin",
                .kind = MotionDescription::Kind::samples,
                .times = {0, 0.25, 0.5},
                .values = {0, 0.1, 0}}};
  const Model model = ModelBuilder(d).build();
  Instance instance = instance_of(model, Kind::model_exchange);
  instance.enter_initialization(0, {});
  instance.exit_initialization();
  std::vector<double> rates(instance.n_states());
  instance.set_time(0.5);
  EXPECT_NO_THROW(instance.get_rates(rates));
  instance.set_time(0.6);
  EXPECT_THROW(instance.get_rates(rates), fmi::NoRates);
  EXPECT_THROW(static_cast<void>(instance.needs_event()), fmi::NoRates);
  Instance late = instance_of(model, Kind::model_exchange);
  late.enter_initialization(0.6, {});
  EXPECT_THAT(refusal([&] { late.exit_initialization(); }), HasSubstr("known from 0 s to 0.5 s"));
}

TEST(FmuErrors, RefuseInOneSentenceWhatAKindDoesNotCount) {
  const fmi::Settings losses{.joint_losses = true};
  const auto refused = [](const Model& model, Kind kind, const fmi::Settings& settings) {
    return refusal([&] { check_supported(model, settings, kind); });
  };
  EXPECT_EQ(refused(driven_pendulum(), Kind::co_simulation, losses), "nothing was refused");
  EXPECT_THAT(refusal([] {
                fmi::fmu_files(shipped("arm7.toml"), {.settings = {false, {"hand"}}}, "");
              }),
              HasSubstr("no frame \"hand\""));
  EXPECT_THAT(refusal([] {
                fmi::fmu_files(shipped("arm7.toml"), {.settings = {false, {"flange", "flange"}}}, "");
              }),
              HasSubstr("frames: frame \"flange\" is given twice"));
  Description driven = driven_pendulum().description();
  driven.motions.push_back({.of = "pin", .coefficients = {0, 1}});
  EXPECT_THAT(refused(ModelBuilder(driven).build(), Kind::co_simulation, losses),
              HasSubstr("of a joint that follows a motion, and joint \"pin\""));
  EXPECT_THAT(refusal([] { fmi::fmu_files(shipped("arm7.toml"), {.kinds = {}}, ""); }),
              HasSubstr("needs a kind"));
}

}  // namespace
}  // namespace axode::test
