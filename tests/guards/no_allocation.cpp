#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/laws/law.hpp"

/// The algorithms allocate nothing once the workspace exists: every operator new and delete of this program
/// counts.
namespace {

std::atomic<long> allocations{0}, releases{0};

void* allocate(std::size_t size, std::size_t alignment) {
  ++allocations;
  void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void release(void* memory) noexcept {
  if (memory != nullptr) ++releases;
  std::free(memory);
}

}  // namespace

// The nothrow and array forms of the standard library call these.
void* operator new(std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }

namespace axode::test {
namespace {

/// How many times f() allocates and releases.
template <class F> long memory_operations(const F& f) {
  const long before = allocations + releases;
  f();
  return allocations + releases - before;
}

TEST(NoAllocation, IsWhatTheCounterWouldNotice) {
  volatile std::size_t size = 3;
  EXPECT_EQ(memory_operations([&] { std::vector<double> numbers(size); }), 2);
  const std::align_val_t line{64};
  EXPECT_EQ(memory_operations([&] { ::operator delete(::operator new(size, line), line); }), 2);
  EXPECT_GE(memory_operations([&] { std::string text(100 * size, 'x'); }), 2);
  EXPECT_EQ(memory_operations([] {}), 0);
}

template <class C> class NoAllocation : public testing::Test {};
TYPED_TEST_SUITE(NoAllocation, Cases, CaseNames);

TYPED_TEST(NoAllocation, InKinematicsAndDynamics) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const Model& model = trial.model;
    const State<T>& at = trial.state;
    Workspace<T>& workspace = trial.workspace;
    std::vector<SE3<T>> C(trial.n_frames());
    std::vector<Twist<Rep, T>> V(C.size());
    std::vector<TwistRate<Rep, T>> dV(C.size());
    std::vector<T> tau(at.v.size());
    std::vector<Wrench<Rep, T>> W(static_cast<std::size_t>(model.n_bodies()));
    const Loads<T> loads{.wrenches = at.wrenches, .joint_losses = true};

    EXPECT_EQ(memory_operations([&] { poses<T>(model, workspace, at.q, C); }), 0);
    EXPECT_EQ(memory_operations([&] { twists<Rep>(model, workspace, at.q, at.v, V); }), 0);
    EXPECT_EQ(memory_operations([&] { accelerations<Rep>(model, workspace, at.q, at.v, at.a, dV); }), 0);
    EXPECT_EQ(
        memory_operations([&] { inverse_dynamics<Rep>(model, workspace, at.q, at.v, at.a, tau, loads); }), 0);
    EXPECT_EQ(memory_operations([&] { joint_wrenches<Rep>(model, workspace, at.q, at.v, at.a, W, loads); }),
              0);
    if (model.total_mass() > 0) {
      EXPECT_EQ(memory_operations([&] { center_of_mass<T>(model, workspace, at.q); }), 0);
    }
  });
}

TYPED_TEST(NoAllocation, InJacobiansAndMotionOfHigherOrder) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const Model& model = trial.model;
    const std::vector<T>&q = trial.state.q, &v = trial.state.v;
    Workspace<T>& workspace = trial.workspace;
    const int tip = model.n_frames() - 1, order = 4;
    std::vector<Twist<Rep, T>> J(v.size());
    std::vector<JacobianColumn<Rep, T>> columns(static_cast<std::size_t>(model.n_screws()));
    std::vector<Twist<Spatial, T>> screws(columns.size());
    EXPECT_EQ(memory_operations([&] { jacobian<Rep>(model, workspace, q, tip, J); }), 0);
    EXPECT_EQ(memory_operations([&] { jacobian_columns<Rep>(model, workspace, q, tip, columns); }), 0);
    EXPECT_EQ(memory_operations([&] { relative_jacobian<Rep>(model, workspace, q, tip, 1, J); }), 0);
    EXPECT_EQ(memory_operations([&] { joint_screws(model, workspace, q, screws); }), 0);
    if (model.total_mass() > 0) {
      std::vector<Vec3<T>> J_com(v.size());
      std::vector<Momentum<Hybrid, T>> A(v.size());
      std::vector<Wrench<Hybrid, T>> dA(v.size());
      EXPECT_EQ(memory_operations([&] { center_of_mass_jacobian(model, workspace, q, J_com); }), 0);
      EXPECT_EQ(memory_operations([&] { centroidal_momentum_matrix(model, workspace, q, A); }), 0);
      EXPECT_EQ(memory_operations([&] { centroidal_momentum_matrix_rate(model, workspace, q, v, dA); }), 0);
    }

    HigherOrderMotion<T> motion(model, order);
    const std::vector<T> rates((order + 1) * v.size(), T(0.5));
    std::vector<TwistRate<Rep, T>> dJ(v.size());
    EXPECT_EQ(memory_operations([&] { motion.evaluate(q, rates); }), 0);
    EXPECT_EQ(memory_operations([&] { dJ[0] = motion.template twist_derivative<Rep>(tip, order); }), 0);
    EXPECT_EQ(memory_operations([&] { motion.template jacobian_derivative<Rep>(tip, order, dJ); }), 0);
  });
}

TYPED_TEST(NoAllocation, InTheEquationsOfMotion) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed), {.most_bodies = 20}};
    const Model& model = trial.model;
    const std::vector<T>&q = trial.state.q, &v = trial.state.v, &a = trial.state.a;
    Workspace<T>& workspace = trial.workspace;
    const std::size_t nv = v.size(), n = static_cast<std::size_t>(model.n_bodies());
    const int tip = model.n_frames() - 1;
    std::vector<T> x(nv), y(nv), M(nv * nv), tensor(nv * nv * nv), regressor(nv * 10 * n), energy(10 * n),
        six(36);
    std::vector<Twist<Rep, T>> Y(nv), V(n);
    std::vector<TwistRate<Rep, T>> dV(n);
    std::vector<Momentum<Rep, T>> Pi(n);
    std::vector<Momentum<Spatial, T>> Pi_s(n);
    std::vector<Wrench<Spatial, T>> dPi(n);
    const Loads<T> loads{.wrenches = trial.state.wrenches, .joint_losses = true};
    std::vector<T> power(loads.wrenches.size());
    MassMatrixFactor<T> factor(model);
    const auto counted = [&](const auto& f) {
      const long operations = memory_operations([&] { static_cast<void>(f()); });
      EXPECT_EQ(operations, 0);
    };
    const auto none = [](const auto& f) {
      return [&f] {
        f();
        return 0;
      };
    };
    counted([&] { return forward_dynamics<Rep>(model, workspace, q, v, a, x, loads); });
    counted(none([&] { mass_matrix<Rep>(model, workspace, q, M); }));
    counted([&] { return factor.factorize(M); });
    counted([&] { return inverse_mass_matrix<Rep>(model, workspace, q, M); });
    counted(none([&] { mass_matrix_partials(model, workspace, q, tensor); }));
    counted(none([&] { coriolis_vector<Rep>(model, workspace, q, v, x); }));
    counted(none([&] { gravity_vector<Rep>(model, workspace, q, x); }));
    counted(none([&] { generalized_loads<Rep>(model, workspace, q, v, loads, x); }));
    counted(none([&] { coriolis_matrix(model, workspace, q, v, CoriolisForm::christoffel, M); }));
    counted(none([&] { christoffel_symbols(model, workspace, q, tensor); }));
    counted([&] { return impulse_response<Rep>(model, workspace, q, tip, Y); });
    counted([&] { return mobility<Rep>(model, workspace, q, tip, six); });
    counted([&] { return operational_space_inertia<Rep>(model, workspace, q, tip, six); });
    counted(none([&] { generalized_momenta(model, workspace, q, v, x); }));
    counted([&] { return momentum_form(model, workspace, q, v, a, x, y, loads); });
    counted(none([&] { body_momenta<Rep>(model, workspace, q, v, Pi); }));
    counted([&] { return twist_form<Rep>(model, workspace, q, V, a, x, dV, loads); });
    counted([&] { return spatial_momentum_form(model, workspace, q, Pi_s, a, x, dPi, loads); });
    counted([&] { return kinetic_energy(model, workspace, q, v) + potential_energy(model, workspace, q); });
    counted([&] { return spatial_momentum(model, workspace, q, v).p.x; });
    counted(none([&] { load_powers(model, workspace, q, v, loads, power); }));
    counted(none([&] { torque_regressor(model, workspace, q, v, a, regressor); }));
    counted(none([&] { kinetic_energy_regressor(model, workspace, q, v, energy); }));
    counted(none([&] { potential_energy_regressor(model, workspace, q, energy); }));
  });
}

}  // namespace
}  // namespace axode::test
