#include <Eigen/Core>
#include <atomic>
#include <cerrno>
#include <cstdlib>

#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/constraints/embedding/task_space.hpp"
#include "axode/integration/driven/drive_steps.hpp"
#include "axode/integration/momenta/contact_motion.hpp"
#include "axode/io.hpp"
#include "tests/contact/scene.hpp"
#include "tests/contact/two_shapes.hpp"
#include "tests/integration/driven_mechanisms.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/functions.hpp"

/// The algorithms allocate no memory once the workspace exists. Operator new and Eigen get their memory from
/// malloc() and aligned_alloc(), whose calls this program counts.
namespace {

std::atomic<long> allocations{0}, releases{0};

void* counted(void* memory) {
  ++allocations;
  return memory;
}

}  // namespace

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) { return counted(__libc_malloc(size)); }
void* calloc(std::size_t count, std::size_t size) { return counted(__libc_calloc(count, size)); }
void* realloc(void* memory, std::size_t size) { return counted(__libc_realloc(memory, size)); }
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return counted(__libc_memalign(alignment, size));
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  *memory = counted(__libc_memalign(alignment, size));
  return *memory == nullptr ? ENOMEM : 0;
}
void free(void* memory) {
  if (memory != nullptr) ++releases;
  __libc_free(memory);
}
}

namespace axode::test {
namespace {

/// The number of allocations and releases during f().
template <class F> long memory_operations(const F& f) {
  const long before = allocations + releases;
  f();
  return allocations + releases - before;
}

/// The lists that partials of a Jacobian need have a size that grows with the order, and not a number.
TEST(NoAllocation, OfPartialsOfAJacobianDoNotGrowWithTheOrder) {
  const Model model = load(AXODE_SOURCE_DIR "/examples/robots/arm7.toml");
  Workspace<> workspace(model);
  const std::vector<double> q = neutral(model);
  for (const Representation representation : representations)
    with_representation(representation, [&]<class Rep>(Rep) {
      std::vector<long> counts;
      for (const std::size_t size : {7UL * 7, 7UL * 7 * 7 * 7 * 7}) {
        std::vector<Twist<Rep>> J(size);
        counts.push_back(memory_operations(
            [&] { jacobian_partials<Rep>(model, workspace, q, "flange", size == 49 ? 1 : 4, J); }));
      }
      EXPECT_EQ(counts[1], counts[0]);
      EXPECT_LE(counts[0], 20);
    });
}

TEST(NoAllocation, IsWhatTheCounterWouldNotice) {
  volatile std::size_t size = 3;
  EXPECT_EQ(memory_operations([&] { std::vector<double> numbers(size); }), 2);
  const std::align_val_t line{64};
  EXPECT_EQ(memory_operations([&] { ::operator delete(::operator new(size, line), line); }), 2);
  EXPECT_GE(memory_operations([&] { std::string text(100 * size, 'x'); }), 2);
  volatile double last = 0;
  const Eigen::Index rows = static_cast<Eigen::Index>(size);
  EXPECT_EQ(memory_operations([&] { last = Eigen::VectorXd::Ones(rows).eval()[rows - 1]; }), 2);
  EXPECT_EQ(memory_operations([] {}), 0);
}

class NoAllocation : public Law {};
INSTANTIATE_TEST_SUITE_P(Guards, NoAllocation, testing::ValuesIn(cases_with_fast()), name_of);

/// Whether a function accepts the model; some functions refuse trees without mass.
template <class F> bool takes(const F& call) {
  try {
    call();
  } catch (const std::domain_error&) {
    return false;
  }
  return true;
}

TEST_P(NoAllocation, InEveryFunction) {
  int functions = 0;
  with_scalar(GetParam(), [&](auto scalar) {
    using T = decltype(scalar);
    for_seeds(100, [&](std::uint64_t seed) {
      Random<double> random(seed);
      const Model model =
          ModelBuilder(with_springs(described(random_mechanism(random), random), random)).build();
      const Arguments<T> arguments(model, random);
      const catalog::Arguments<T> given = arguments.given();
      Workspace<T> workspace(model);
      for (const catalog::Function<T>& function : functions_of<T>(GetParam())) {
        if (function.allocates || (function.cost == catalog::Cost::cubic && model.nv() > 20)) continue;
        std::vector<T> out(function.size(model, arguments.wrenches.size()));
        const auto call = [&] { static_cast<void>(function.call(model, workspace, given, out)); };
        if (model.total_mass() == 0 && !takes(call)) continue;
        ++functions;
        EXPECT_EQ(memory_operations(call), 0) << function.name;
      }
    });
  });
  EXPECT_GT(functions, 1000);
}

// ------------------------------------------------------------------------------ what is not in the catalogue

class NoAllocationBeside : public Law {};
INSTANTIATE_TEST_SUITE_P(Guards, NoAllocationBeside, testing::ValuesIn(cases()), name_of);

/// Calls law(Rep(), T()) with the types of a case.
template <class F> void with_types(const Case& c, const F& law) {
  with_scalar(c, [&](auto scalar) {
    with_representation(c.representation, [&](auto representation) { law(representation, scalar); });
  });
}

TEST_P(NoAllocationBeside, InColumnsAndMotionOfHigherOrder) {
  with_types(GetParam(), [](auto representation, auto scalar) {
    using Rep = decltype(representation);
    using T = decltype(scalar);
    for_seeds(100, [&](std::uint64_t seed) {
      Random<double> random(seed);
      const Model model = ModelBuilder(described(random_mechanism(random), random)).build();
      const Arguments<T> at(model, random);
      Workspace<T> workspace(model);
      const int tip = model.n_frames() - 1, order = 4;
      std::vector<JacobianColumn<Rep, T>> columns(static_cast<std::size_t>(model.n_screws()));
      EXPECT_EQ(memory_operations([&] { jacobian_columns<Rep>(model, workspace, at.q, tip, columns); }), 0);
      const std::array<Place<T>, 2> places{tip, 0};
      std::vector<Twist<Rep, T>> J(2 * at.v.size());
      EXPECT_EQ(memory_operations([&] { jacobians<Rep>(model, workspace, at.q, places, J); }), 0);

      HigherOrderMotion<T> motion(model, order);
      const std::vector<T> rates((order + 1) * at.v.size(), T(0.5));
      std::vector<TwistRate<Rep, T>> dJ(at.v.size() + 1);
      const std::span<TwistRate<Rep, T>> of_velocities(dJ.data(), at.v.size());
      EXPECT_EQ(memory_operations([&] { motion.evaluate(at.q, rates); }), 0);
      EXPECT_EQ(memory_operations([&] { dJ[0] = motion.template twist_derivative<Rep>(tip, order); }), 0);
      EXPECT_EQ(
          memory_operations([&] { motion.template jacobian_derivative<Rep>(tip, order, of_velocities); }), 0);
    });
  });
}

TEST_P(NoAllocationBeside, InFactorsFormsInTwistsAndSpatialMomentaAndLinearSystems) {
  with_types(GetParam(), [](auto representation, auto scalar) {
    using Rep = decltype(representation);
    using T = decltype(scalar);
    for_seeds(100, [&](std::uint64_t seed) {
      Random<double> random(seed);
      const Model model =
          ModelBuilder(described(random_mechanism(random, {.most_bodies = 20}), random)).build();
      const Arguments<T> at(model, random);
      const Loads<T> loads = at.given().loads;
      Workspace<T> workspace(model);
      const std::size_t nv = at.v.size(), n = static_cast<std::size_t>(model.n_bodies());
      std::vector<T> x(nv), M(nv * nv);
      std::vector<Twist<Rep, T>> V(n);
      std::vector<TwistRate<Rep, T>> dV(n);
      std::vector<Momentum<Spatial, T>> Pi(n);
      std::vector<Wrench<Spatial, T>> dPi(n);
      MassMatrixFactor<T> factor(model);
      mass_matrix(model, workspace, at.q, M);
      const auto counted = [](const auto& f) {
        EXPECT_EQ(memory_operations([&] { static_cast<void>(f()); }), 0);
      };
      counted([&] { return factor.factorize(M); });
      counted([&] { return twist_form<Rep>(model, workspace, at.q, V, at.a, x, dV, loads); });
      counted([&] { return spatial_momentum_form(model, workspace, at.q, Pi, at.a, x, dPi, loads); });
      std::vector<T> A(4 * nv * nv), B(2 * nv * nv);
      counted([&] { return linearize(model, workspace, at.q, at.v, at.tau, {A, B}, loads); });
    });
  });
}

TEST(NoAllocation, InContactPointsAndDistances) {
  Random<double> random(1);
  std::vector<ShapeDescription> all{collision_shape(ShapeKind::plane, {}, 0, 0)};
  for (const ShapeKind kind : bounded_kinds)
    for (int k = 0; k < 4; ++k) all.push_back(random_collision_shape(random, kind));
  const Model model = free_bodies(all);
  ContactFinder finder{ContactShapes(model)};
  Distances distances(model);
  std::vector<double> J(distances.shapes().pairs().size() * static_cast<std::size_t>(model.nv()));
  std::size_t touching = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    const std::vector<double> q = random_configurations(model, static_cast<std::uint64_t>(seed), 1);
    WithScratch<double, BodyPoses<double>> poses(model.topology());
    poses->run(model.tree<double>(), q.data());
    const std::span<const SE3<>> C(&(*poses)[0], static_cast<std::size_t>(model.n_bodies()) + 1);
    EXPECT_EQ(memory_operations([&] { touching += finder.find(C, 0.01) ? finder.points().size() : 0; }), 0);
    EXPECT_EQ(memory_operations([&] { static_cast<void>(distances.evaluate(q)); }), 0);
    EXPECT_EQ(memory_operations([&] {
                distances.jacobian(
                    std::span(J).first(distances.found().size() * static_cast<std::size_t>(model.nv())));
              }),
              0);
  }
  EXPECT_GT(touching, 100U);
}

TEST(NoAllocation, InInverseDynamicsWithLoopsAndInTaskSpaces) {
  for (const char* const file : {"gough.toml", "delta.toml", "four_bar.toml", "five_bar_arm.toml"}) {
    const Model model = load(std::filesystem::path(AXODE_SOURCE_DIR "/examples/robots") / file);
    TaskSpace space(model, neutral(model));
    LoopWorkspace<double> loops(model);
    const std::vector<double> q = neutral(model), V(static_cast<std::size_t>(space.freedom()), 0.3);
    std::vector<double> v(static_cast<std::size_t>(model.nv())), a(v), tau(v), dV(V);
    double missing = 1;
    bool solved = true;
    EXPECT_EQ(memory_operations([&] {
                solved = space.velocities(q, V, v).ok() && space.accelerations(q, v, V, a).ok() &&
                         space.inverse_dynamics(q, v, V, tau).ok() &&
                         space.forward_dynamics(q, v, tau, dV).ok();
              }),
              0)
        << file;
    EXPECT_EQ(memory_operations([&] { missing = inverse_dynamics(model, loops, q, v, a, tau); }), 0) << file;
    EXPECT_TRUE(solved) << file;
    EXPECT_EQ(missing, 0) << file;
  }
}

/// Steps of mechanisms with drives of all kinds, through limits of the drives.
TEST(NoAllocation, InStepsWithDrives) {
  for_seeds(20, [](std::uint64_t seed) {
    const Driven at(seed);
    Workspace<> workspace(at.model);
    std::vector<double> tau(at.nv());
    DriveSteps steps(at.model, runge_kutta(4), DriveSystem(at.model));
    const auto rates = [&](double t, std::span<const double> q, std::span<const double> v,
                           std::span<const double> x, std::span<double> a, std::span<double> dx) {
      std::ranges::fill(tau, 0.0);
      steps.drives().evaluate(t, q, v, x, tau, dx);
      if (!at.model.springs().empty()) add_spring_forces(at.model, workspace, q, v, tau);
      return forward_dynamics(at.model, workspace, q, v, tau, a).ok();
    };
    steps.begin(0, at.q, at.v, {});
    bool solved = true;
    EXPECT_EQ(memory_operations([&] {
                for (int k = 1; k <= 40; ++k)
                  solved = solved && steps.advance(k * 5e-3, rates, [](auto, auto) { return true; }) ==
                                         DriveSteps::End::none;
              }),
              0);
    EXPECT_TRUE(solved);
  });
}

/// A body of each shape falls on a floor, tumbles, slides and comes to rest, some on each other.
TEST(NoAllocation, InStepsWithContact) {
  Description d{.name = "falling", .bodies = {}};
  d.shapes.push_back(collision_shape(ShapeKind::plane, {}, 0, 0));
  d.contact = ContactDescription{};
  Random<double> random(1);
  for (const ShapeKind kind : bounded_kinds) {
    d.bodies.push_back({.name = "body " + std::to_string(d.bodies.size()),
                        .joint = {.kind = JointKind::free},
                        .inertia = MassProperties{.mass = 1, .com = {}, .Theta = {0.1, 0.1, 0.1, 0, 0, 0}},
                        .shapes = {random_collision_shape(random, kind)}});
  }
  const Model model = ModelBuilder(std::move(d)).build();
  std::vector<double> q_0 = neutral(model);
  for (std::size_t k = 0; k < bounded_kinds.size(); ++k) {
    q_0[7 * k + 4] = 0.6 * static_cast<double>(k);
    q_0[7 * k + 6] = 0.8 + 0.1 * static_cast<double>(k);
  }
  const std::vector<double> v_0(static_cast<std::size_t>(model.nv()), 0.3);
  constexpr double h = 5e-3;
  const SimulationOptions options;
  ContactSimulationRun run(model, q_0, v_0, 10, options, false);
  ContactStep step(run, model, ContactShapes(model), false);
  Eigen::VectorXd q = run.q, v = run.v;
  int touched = 0;
  for (int k = 0; k < 300; ++k) {
    bool failed = false;
    const long operations = memory_operations([&] { failed = bool(step.run(k * h, h, q, v)); });
    ASSERT_FALSE(failed) << "step " << k;
    EXPECT_EQ(operations, 0) << "step " << k;
    EXPECT_LE(step.certificate, 1e-9) << "step " << k;
    touched += step.touched ? 1 : 0;
    q = step.q;
    v = step.v;
  }
  EXPECT_GT(touched, 100);
}

/// A hopper whose motor is fast, so that steps need Newton's matrix, and reaches its limits when it lands.
TEST(NoAllocation, InStepsWithContactAndDrives) {
  const Model model = ModelBuilder(hopper()).build();
  const std::vector<double> q_0{0.8, 0}, v_0{0, 0};
  const SimulationOptions options;
  ContactSimulationRun run(model, q_0, v_0, 10, options, false);
  ContactSteps steps(run, ContactShapes(model), false);
  ComputedContactStep end;
  int switches = 0;
  const auto take = [&](double t_1) {
    while (run.now() < t_1) {
      double t = t_1;
      if (steps.compute_up_to_switch(t, end)) return false;
      switches += t < t_1 ? 1 : 0;
      run.move_to(t, as_span(end.end.q), as_span(end.end.v), end.end.x);
      run.drives().switch_at(t, as_span(run.q), as_span(run.v));
    }
    return true;
  };
  for (int k = 1; k <= 500; ++k) {
    constexpr int landing = 100;
    bool solved = false;
    const long operations = memory_operations([&] { solved = take(k * 2e-3); });
    ASSERT_TRUE(solved) << "step " << k;
    if (k == landing) switches = 0;
    if (k > landing) {
      EXPECT_EQ(operations, 0) << "step " << k;
    }
  }
  EXPECT_GT(switches, 0);
}

}  // namespace
}  // namespace axode::test
