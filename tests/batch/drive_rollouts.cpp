#include <gmock/gmock.h>

#include "axode/batch.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/integration/driven_mechanisms.hpp"

/// Rollouts of mechanisms with drives that have states equal simulations of each state alone.
namespace axode::test {
namespace drive_rollouts {
namespace {

/// The states of N motions of K steps.
struct Rolled {
  std::size_t N, K, nq, nv, nx;
  Numbers q, v, x;

  Rolled(const Model& model, std::size_t count, std::size_t steps, std::size_t states)
      : N(count),
        K(steps),
        nq(static_cast<std::size_t>(model.nq())),
        nv(static_cast<std::size_t>(model.nv())),
        nx(states),
        q(N * (K + 1) * nq),
        v(N * (K + 1) * nv),
        x(N * (K + 1) * nx) {}
  Span q_at(std::size_t n, std::size_t k) const { return Span(q).subspan((n * (K + 1) + k) * nq, nq); }
  Span v_at(std::size_t n, std::size_t k) const { return Span(v).subspan((n * (K + 1) + k) * nv, nv); }
  Span x_at(std::size_t n, std::size_t k) const { return Span(x).subspan((n * (K + 1) + k) * nx, nx); }
};

/// The initial states of N motions; x is empty if the drives choose it.
struct Starts {
  Numbers q, v, x;
  std::size_t N;

  Starts(const Model& model, std::size_t count, std::uint64_t seed, std::size_t nx = 0) : N(count) {
    Random<double> random(seed + 7);
    for (std::size_t n = 0; n < N; ++n) {
      const Numbers q_n = random_configuration(model, seed + n),
                    v_n = random_numbers(random, model.nv(), 0.5),
                    x_n = random_numbers(random, static_cast<int>(nx), 0.01);
      q.insert(q.end(), q_n.begin(), q_n.end());
      v.insert(v.end(), v_n.begin(), v_n.end());
      x.insert(x.end(), x_n.begin(), x_n.end());
    }
  }
};

struct Call {
  double step;
  const Tableau& method = runge_kutta(4);
  int threads = 1;
  bool joint_losses = false;
};
batch::Outcome roll(const Model& model, const Starts& from, const Drive& drive, const Call& call,
                    Rolled& out) {
  return batch::rollout<double>(model, from.q, from.v, drive, out.K, call.step, out.q, out.v, call.method,
                                call.threads, {}, call.joint_losses, {}, {.x = from.x, .x_out = out.x});
}

/// Motion n as simulate_fixed() gives it.
Trajectory simulated(const Model& model, const Starts& from, const Drive& drive, const Call& call,
                     const Rolled& out, std::size_t n) {
  SimulationOptions options{.drive = drive, .joint_losses = call.joint_losses};
  if (!from.x.empty()) {
    const Span x = Span(from.x).subspan(n * out.nx, out.nx);
    options.x.assign(x.begin(), x.end());
  }
  return simulate_fixed(model, Span(from.q).subspan(n * out.nq, out.nq),
                        Span(from.v).subspan(n * out.nv, out.nv), static_cast<double>(out.K) * call.step,
                        call.step, call.method, options);
}
/// Expects that every motion of `out` is that of simulate_fixed() to the last bit. Returns how many steps of
/// the simulations ended early, where a status changed or an input jumped.
std::size_t expect_simulations(const Model& model, const Starts& from, const Drive& drive, const Call& call,
                               const Rolled& out) {
  std::size_t early = 0;
  for (std::size_t n = 0; n < from.N; ++n) {
    const Trajectory motion = simulated(model, from, drive, call, out, n);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    std::size_t i = 0;
    for (std::size_t k = 0; k <= out.K && motion.complete; ++k, ++i) {
      for (; motion.t()[i] < static_cast<double>(k) * call.step; ++i) ++early;
      EXPECT_TRUE(std::ranges::equal(motion.q(i), out.q_at(n, k))) << n << " " << k;
      EXPECT_TRUE(std::ranges::equal(motion.v(i), out.v_at(n, k))) << n << " " << k;
      EXPECT_TRUE(std::ranges::equal(motion.x(i), out.x_at(n, k))) << n << " " << k;
    }
  }
  return early;
}

/// A drive that is a function of time and state.
void sway(double t, Span, Span v, std::span<double> out) {
  for (std::size_t c = 0; c < out.size(); ++c) out[c] = std::sin(9 * t + static_cast<double>(c)) - 0.1 * v[c];
}

TEST(DriveRollouts, AreSimulationsToTheLastBit) {
  std::size_t early = 0;
  for_seeds(25, [&](std::uint64_t seed) {
    Description described = Driven(seed).model.description();
    described.drives[0].input = {.times = {0, 0.033, 0.061}, .values = {1, -2, 3}};
    const Model model = ModelBuilder(described).build();
    const Starts from(model, 3, seed, seed % 2 == 0 ? 0 : DriveSystem(model).nx());
    Rolled out(model, from.N, 40, DriveSystem(model).nx()), with_threads(out);
    Call call{.step = 2.5e-3, .method = runge_kutta(1 + static_cast<int>(seed % 5))};
    call.joint_losses = seed % 3 == 0;
    const batch::Outcome outcome = roll(model, from, sway, call, out);
    if (!outcome.ok()) {  // of some hundred mechanisms, one has a motion that diverges; it does so in both
      EXPECT_FALSE(simulated(model, from, sway, call, out, outcome.first).complete);
      return;
    }
    early += expect_simulations(model, from, sway, call, out);
    call.threads = 8;
    ASSERT_TRUE(roll(model, from, sway, call, with_threads).ok());
    EXPECT_EQ(out.q, with_threads.q);
    EXPECT_EQ(out.v, with_threads.v);
    EXPECT_EQ(out.x, with_threads.x);
  });
  EXPECT_GT(early, 200U);
}

TEST(DriveRollouts, CloseLoopsAsSimulationsDo) {
  Description d = four_bar();
  d.bodies[0].joint.name = "crank";
  d.drives = {motor_on("crank")};
  const Model model = ModelBuilder(d).build();
  Starts from(model, 2, 1);
  from.q.assign(static_cast<std::size_t>(2 * model.nq()), 0);
  from.v.assign(static_cast<std::size_t>(2 * model.nv()), 0);
  Rolled out(model, 2, 200, 1);
  const Call call{.step = 2.5e-3, .threads = 2};
  ASSERT_TRUE(roll(model, from, sway, call, out).ok());
  EXPECT_GT(expect_simulations(model, from, sway, call, out), 4U);
}

/// A wheel with dry friction and a gear, which the motor turns to and fro, so that it sticks and slides.
TEST(DriveRollouts, StickAndSlideAsSimulationsDo) {
  for (const double gear_loss : {0.0, 0.3}) {
    Description d{.name = "wheel", .gravity = {}};
    d.bodies = {
        {.name = "wheel",
         .joint = {.name = "hinge",
                   .kind = JointKind::revolute,
                   .dof = {{.damping = 0.1, .friction = 0.4, .armature = 0.02, .gear_loss = gear_loss}}},
         .inertia = MassProperties{.mass = 1, .com = {}, .Theta = {1, 1, 0.05, 0, 0, 0}}}};
    d.drives = {motor_on("hinge")};
    const Model model = ModelBuilder(d).build();
    const Starts from(model, 3, 1);
    Rolled out(model, 3, 200, 1);
    const Call call{.step = 2.5e-3, .threads = 2, .joint_losses = true};
    ASSERT_TRUE(roll(model, from, sway, call, out).ok());
    EXPECT_GT(expect_simulations(model, from, sway, call, out), 6U);

    // A rollout that receives these forces for each step takes the same motion as with a function of time.
    const auto constant = [](double, Span, Span, std::span<double> tau) { tau[0] = 0.2; };
    Rolled by_drive(out), by_rows(out);
    ASSERT_TRUE(roll(model, from, constant, call, by_drive).ok());
    const Numbers tau(3 * 200, 0.2);
    ASSERT_TRUE(batch::rollout<double>(model, from.q, from.v, tau, call.step, by_rows.q, by_rows.v,
                                       call.method, 1, {}, true, {}, {.x_out = by_rows.x})
                    .ok());
    Comparison("q", 1e-9).expect_equal(by_rows.q, by_drive.q);
    Comparison("x", 1e-9).expect_equal(by_rows.x, by_drive.x);
    Rolled late(model, 3, 1, 1);
    EXPECT_THAT(
        [&] {
          static_cast<void>(batch::rollout<double>(model, from.q, from.v, Numbers(3), call.step, late.q,
                                                   late.v, call.method, 1, {}, true, {}, {.t = 1}));
        },
        testing::ThrowsMessage<std::invalid_argument>(
            testing::HasSubstr("the motions begin at t = 1 s; with drives and dry friction or losses "
                               "of gears, they begin "
                               "at 0 s")));
  }
}

TEST(DriveRollouts, TakeForcesOfEachStepAndContinue) {
  for_seeds(10, [](std::uint64_t seed) {
    const Model model = Driven(seed).model;
    const std::size_t nx = DriveSystem(model).nx(), K = 10;
    const double step = 5e-3;
    const Starts from(model, 2, seed);
    Random<double> random(seed);
    const Numbers tau = random_numbers(random, static_cast<int>(2 * 2 * K) * model.nv());
    Rolled whole(model, 2, 2 * K, nx), half(model, 2, K, nx);
    const auto run = [&](const Numbers& q, const Numbers& v, const Numbers& forces, Rolled& out,
                         const batch::DriveMotions& drives) {
      ASSERT_TRUE(batch::rollout<double>(model, q, v, forces, step, out.q, out.v, runge_kutta(4), 1, {},
                                         false, {}, drives)
                      .ok());
    };
    run(from.q, from.v, tau, whole, {.x_out = whole.x});
    const auto rows = [&](std::size_t first) {
      Numbers some;
      for (std::size_t n = 0; n < 2; ++n) {
        const Span of_n = Span(tau).subspan((n * 2 * K + first) * whole.nv, K * whole.nv);
        some.insert(some.end(), of_n.begin(), of_n.end());
      }
      return some;
    };
    run(from.q, from.v, rows(0), half, {.x_out = half.x});
    Numbers q, v, x;
    for (std::size_t n = 0; n < 2; ++n) {
      EXPECT_TRUE(std::ranges::equal(half.x_at(n, K), whole.x_at(n, K)));
      for (auto& [to, of] :
           {std::pair<Numbers*, Span>{&q, half.q_at(n, K)}, {&v, half.v_at(n, K)}, {&x, half.x_at(n, K)}})
        to->insert(to->end(), of.begin(), of.end());
    }
    run(q, v, rows(K), half, {.x = x, .x_out = half.x, .t = K * step});
    for (std::size_t n = 0; n < 2; ++n) {
      const auto numbers = [](Span all) { return Numbers(all.begin(), all.end()); };
      Comparison("q", 1e-9).expect_equal(numbers(half.q_at(n, K)), numbers(whole.q_at(n, 2 * K)));
      Comparison("x", 1e-9).expect_equal(numbers(half.x_at(n, K)), numbers(whole.x_at(n, 2 * K)));
    }
  });
}

/// A relay that pushes a wheel back as soon as it turns: it switches without end.
struct Relay {
  std::vector<DriveState> states() const { return {}; }
  void start(const DrivePoint<double>&, std::span<double>) const {}
  template <class T>
  void evaluate(const DrivePoint<T>&, std::span<const int> statuses, DriveResponse<T>& out) const {
    out.force = T(-10 * statuses[0]);
  }
  std::size_t n_statuses() const { return 1; }
  void choose(const DrivePoint<double>& at, DriveLaw::Statuses statuses) const {
    statuses[0] = at.w < 0 ? -1 : 1;
  }
  double margin(std::size_t, const DrivePoint<double>& at, std::span<const int> statuses) const {
    return statuses[0] * at.w;
  }
  void change(std::size_t, const DrivePoint<double>&, DriveLaw::Statuses statuses, std::span<double>) const {
    statuses[0] = -statuses[0];
  }
};

TEST(DriveRollouts, SayWhyAMotionCannotContinue) {
  Description d{.name = "wheel", .gravity = {}};
  d.bodies = {{.name = "wheel",
               .joint = {.name = "hinge", .kind = JointKind::revolute},
               .inertia = MassProperties{.mass = 1, .com = {}, .Theta = {1, 1, 0.05, 0, 0, 0}}}};
  const Model model = ModelBuilder(d).build();
  Rolled out(model, 2, 20, 0);
  const Numbers q(2), v{0, 1}, tau(40);
  const batch::DriveMotions relay{.added = {{.name = "relay",
                                             .joints = {{"hinge", 1.0}},
                                             .law = std::make_shared<DriveLawOf<Relay>>(Relay{})}}};
  const batch::Outcome chatters =
      batch::rollout<double>(model, q, v, tau, 1e-2, out.q, out.v, runge_kutta(4), 1, {}, false, {}, relay);
  EXPECT_EQ(chatters.singular_states, 2U);
  EXPECT_TRUE(chatters.too_many_changes);
  EXPECT_FALSE(std::isnan(out.v_at(0, 0)[0]));
  EXPECT_TRUE(std::isnan(out.v_at(0, 20)[0]));

  const batch::Monitor stop = [](std::size_t, std::size_t) { return false; };
  d.drives = {motor_on("hinge")};
  const Model driven = ModelBuilder(d).build();
  Rolled many(driven, 1, 2'000'000, 1);
  EXPECT_EQ(batch::rollout<double>(driven, Numbers(1), Numbers(1), sway, many.K, 1e-3, many.q, many.v,
                                   runge_kutta(4), 1, stop)
                .done,
            0U);

  const auto refuses = [](const char* why) {
    return testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(why));
  };
  const auto call = [&](const Model& of, const batch::DriveMotions& drives) {
    static_cast<void>(
        batch::rollout<double>(of, q, v, tau, 1e-2, out.q, out.v, runge_kutta(4), 1, {}, false, {}, drives));
  };
  const Numbers short_x(1), bad_x{0, std::nan("")};
  Numbers room(41);
  EXPECT_THAT([&] { call(driven, {.x = short_x}); }, refuses("x has 1 entries; expected nx N = 2"));
  EXPECT_THAT([&] { call(driven, {.x = bad_x}); },
              refuses("state 1: the state \"motor.current\" of a drive is not finite"));
  EXPECT_THAT([&] { call(driven, {.x_out = room}); }, refuses("x_out has 41 entries; expected (K + 1) nx N"));
  EXPECT_THAT([&] { call(driven, {.x_out = out.q}); }, refuses("x_out shares memory with q_out"));
  EXPECT_THAT([&] { call(driven, {.t = std::nan("")}); }, refuses("it must be finite"));
  EXPECT_THAT([&] { call(model, {.x = short_x}); }, refuses("x has 1 entries; expected nx N = 0"));
  std::vector<float> q_f(42), v_f(42);
  EXPECT_THAT(
      [&] {
        static_cast<void>(batch::rollout<float>(driven, std::vector<float>(2), std::vector<float>(2),
                                                std::vector<float>(40), 1e-2, q_f, v_f));
      },
      refuses("model \"wheel\" has drives with states, which rollouts count in double precision alone"));
  const Numbers lost{std::nan(""), 0};
  EXPECT_TRUE(batch::rollout<double>(driven, q, lost, tau, 1e-2, out.q, out.v).solvability.not_finite);
  EXPECT_FALSE(std::isnan(out.v_at(1, 20)[0]));
}

}  // namespace
}  // namespace drive_rollouts
}  // namespace axode::test
