#include "axode/batch.hpp"

#include <gmock/gmock.h>

#include "axode/derivatives.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// Many states at once give what they give one by one, whatever their number, their order and the number of
/// threads.
namespace axode::test {
namespace {

template <class T> class ManyStates : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(ManyStates, Scalars);

template <class T> struct States {
  Model model;
  std::size_t N, nq, nv;
  std::vector<T> q, v, x;  ///< x: accelerations or forces

  States(const Model& built, Random<double>& random, std::size_t count)
      : model(built),
        N(count),
        nq(static_cast<std::size_t>(built.nq())),
        nv(static_cast<std::size_t>(built.nv())) {
    for (std::size_t k = 0; k < N; ++k) {
      const State<T> state = cast<T>(random_state(built, random));
      q.insert(q.end(), state.q.begin(), state.q.end());
      v.insert(v.end(), state.v.begin(), state.v.end());
      x.insert(x.end(), state.a.begin(), state.a.end());
    }
  }
  std::span<const T> q_of(std::size_t k) const { return std::span(q).subspan(k * nq, nq); }
  std::span<const T> v_of(std::size_t k) const { return std::span(v).subspan(k * nv, nv); }
  std::span<const T> x_of(std::size_t k) const { return std::span(x).subspan(k * nv, nv); }
};

Model tree(Random<double>& random) {
  for (;;) {
    Model model = ModelBuilder(told(random_mechanism(random, {}), random)).build();
    if (model.nq() > 0) return model;
  }
}
std::size_t some_number(std::uint64_t seed) {
  const std::size_t numbers[]{1, 2, 3, 7, 8, 9, 16, 17, 31, 33};
  return numbers[seed % std::size(numbers)];
}
template <class T> std::vector<T> part(const std::vector<T>& all, std::size_t k, std::size_t n) {
  return {all.begin() + static_cast<std::ptrdiff_t>(k * n),
          all.begin() + static_cast<std::ptrdiff_t>((k + 1) * n)};
}

TYPED_TEST(ManyStates, GiveWhatTheyGiveOneByOne) {
  using T = TypeParam;
  Comparison force("force", agreement<T>), inertia("mass matrix", agreement<T>), pose("pose", agreement<T>);
  int singular = 0, regular = 0;
  for_seeds(300, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const States<T> states(tree(random), random, some_number(seed));
    const Model& model = states.model;
    const std::size_t N = states.N, nv = states.nv;
    const std::vector<T>&q = states.q, &v = states.v, &x = states.x;
    std::vector<T> tau(N * nv), a(N * nv), M(N * nv * nv), M_inverse(N * nv * nv);
    const std::size_t n_frames = static_cast<std::size_t>(model.n_frames()),
                      n_screws = static_cast<std::size_t>(model.n_screws());
    std::vector<SE3<T>> C(N * n_frames);
    std::vector<Twist<Spatial, T>> J(N * n_screws);
    EXPECT_TRUE(batch::run<T>(model, "inverse_dynamics", {.q = q, .v = v, .a = x}, tau).ok());
    const batch::Outcome solved = batch::run<T>(model, "forward_dynamics", {.q = q, .v = v, .tau = tau}, a);
    EXPECT_TRUE(batch::run<T>(model, "mass_matrix", {.q = q}, M).ok());
    const batch::Outcome inverted = batch::run<T>(model, "inverse_mass_matrix", {.q = q}, M_inverse);
    EXPECT_TRUE(batch::run<T>(model, "poses", {.q = q}, catalog::as_numbers<T>(std::span(C))).ok());
    EXPECT_TRUE(batch::run<T>(model, "joint_screws", {.q = q}, catalog::as_numbers<T>(std::span(J))).ok());
    Workspace<T> workspace(model);
    std::size_t singular_states = 0;
    for (std::size_t k = 0; k < N; ++k) {
      std::vector<T> one(nv);
      inverse_dynamics(model, workspace, states.q_of(k), states.v_of(k), states.x_of(k), one);
      force.expect_equal(part(tau, k, nv), one);
      const bool ok =
          forward_dynamics(model, workspace, states.q_of(k), states.v_of(k), part(tau, k, nv), one).ok();
      if (ok) {  // accelerations may be as ill-conditioned as M: compared by the forces that they need
        std::vector<T> back(nv);
        inverse_dynamics(model, workspace, states.q_of(k), states.v_of(k), part(a, k, nv), back);
        force.expect_equal(back, part(tau, k, nv));
      } else {
        if (singular_states++ == 0) {
          EXPECT_EQ(solved.first, k);
        }
        EXPECT_TRUE(std::isnan(a[k * nv]));
      }
      std::vector<T> matrix(nv * nv);
      mass_matrix(model, workspace, states.q_of(k), matrix);
      inertia.expect_equal(part(M, k, nv * nv), matrix);
      if (ok) {
        std::vector<T> inverse(nv * nv);
        EXPECT_TRUE(inverse_mass_matrix(model, workspace, states.q_of(k), inverse).ok());
        expect_same_inverse(part(M_inverse, k, nv * nv), inverse, matrix, agreement<T>);
      }
      std::vector<SE3<T>> C_k(n_frames);
      poses(model, workspace, states.q_of(k), C_k);
      for (std::size_t f = 0; f < n_frames; ++f) pose.expect_equal(C[k * n_frames + f], C_k[f]);
      std::vector<Twist<Spatial, T>> J_k(n_screws);
      joint_screws(model, workspace, states.q_of(k), J_k);
      for (std::size_t s = 0; s < n_screws; ++s) pose.expect_equal(J[k * n_screws + s], J_k[s]);
    }
    EXPECT_EQ(solved.singular_states, singular_states);
    EXPECT_EQ(inverted.singular_states, singular_states);
    (singular_states > 0 ? singular : regular) += 1;
  });
  EXPECT_GE(singular, (singular + regular) / 20);
  EXPECT_GE(regular, (singular + regular) / 20);
}

TYPED_TEST(ManyStates, HaveTheDerivativesThatTheyHaveOneByOne) {
  using T = TypeParam;
  Comparison inverse("inverse", agreement<T>), forward("forward", agreement<T>);
  int regular = 0;
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const States<T> states(tree(random), random, some_number(seed));
    const Model& model = states.model;
    const std::size_t N = states.N, nv = states.nv;
    const std::vector<T>&q = states.q, &v = states.v, &x = states.x;
    std::vector<T> w(x);  // another direction
    for (std::size_t k = 0; k < w.size(); ++k) w[k] = x[(k + 1) % w.size()] + T(0.25) * v[k];
    std::vector<T> dtau(3 * N * nv * nv), da(dtau), jvp(N * nv), forward_jvp(jvp), vjp(3 * N * nv),
        forward_vjp(vjp);
    EXPECT_EQ(batch::run<T>(model, "inverse_dynamics_derivatives", {.q = q, .v = v, .a = x}, dtau).done, N);
    EXPECT_EQ(
        batch::run<T>(model, "inverse_dynamics_jvp", {.q = q, .v = v, .a = x, .dq = w, .dv = x, .da = v}, jvp)
            .done,
        N);
    EXPECT_EQ(batch::run<T>(model, "inverse_dynamics_vjp", {.q = q, .v = v, .a = x, .w = w}, vjp).done, N);
    const batch::Outcome solved[]{
        batch::run<T>(model, "forward_dynamics_derivatives", {.q = q, .v = v, .tau = x}, da),
        batch::run<T>(model, "forward_dynamics_jvp", {.q = q, .v = v, .tau = x, .dq = w, .dv = x, .dtau = v},
                      forward_jvp),
        batch::run<T>(model, "forward_dynamics_vjp", {.q = q, .v = v, .tau = x, .w = w}, forward_vjp)};
    Workspace<T> workspace(model);
    std::size_t singular_states = 0;
    for (std::size_t k = 0; k < N; ++k) {
      const std::vector<T> w_k = part(w, k, nv);
      const std::span<const T> q_k = states.q_of(k), v_k = states.v_of(k), x_k = states.x_of(k);
      std::vector<T> matrices(3 * nv * nv), vectors(3 * nv), one(nv);
      const auto third = [](std::vector<T>& all, std::size_t j) {
        return std::span(all).subspan(j * all.size() / 3, all.size() / 3);
      };
      const auto of = [&](std::vector<T>& all) {
        return std::array{third(all, 0), third(all, 1), third(all, 2)};
      };
      const auto [m_q, m_v, m_a] = of(matrices);
      const auto [by_q, by_v, by_a] = of(vectors);
      inverse_dynamics_derivatives(model, workspace, q_k, v_k, x_k, {m_q, m_v, m_a});
      inverse.expect_equal(part(dtau, k, 3 * nv * nv), matrices);
      const double scale = std::max(largest(std::vector<double>(matrices.begin(), matrices.end())), 1e-6);
      inverse_dynamics_jvp<T>(model, workspace, q_k, v_k, x_k, w_k, x_k, v_k, one);
      inverse.expect_equal(part(jvp, k, nv), one, scale);
      inverse_dynamics_vjp<T>(model, workspace, q_k, v_k, x_k, w_k, {by_q, by_v, by_a});
      inverse.expect_equal(part(vjp, k, 3 * nv), vectors, scale);
      if (!forward_dynamics_derivatives(model, workspace, q_k, v_k, x_k, {m_q, m_v, m_a}).ok()) {
        ++singular_states;
        EXPECT_TRUE(std::isnan(da[k * 3 * nv * nv]) && std::isnan(forward_jvp[k * nv]) &&
                    std::isnan(forward_vjp[k * 3 * nv]));
        continue;
      }
      ++regular;
      if (std::same_as<T, float>) continue;  // M may be too ill-conditioned to compare
      std::vector<T> M(nv * nv);
      mass_matrix(model, workspace, q_k, M);
      const auto by_mass = [&](std::vector<T> all,
                               std::size_t columns) {  // the forces that make the accelerations
        std::vector<T> out(all.size());
        for (std::size_t r = 0; r < nv; ++r)
          for (std::size_t c = 0; c < columns; ++c)
            for (std::size_t i = 0; i < nv; ++i) out[r * columns + c] += M[r * nv + i] * all[i * columns + c];
        return out;
      };
      for (std::size_t j = 0; j < 3; ++j) {
        const std::vector<T> here = part(part(da, k, 3 * nv * nv), j, nv * nv),
                             alone = part(matrices, j, nv * nv);
        forward.expect_equal(by_mass(here, nv), by_mass(alone, nv), scale);
      }
      EXPECT_TRUE(forward_dynamics_jvp<T>(model, workspace, q_k, v_k, x_k, w_k, x_k, v_k, one).ok());
      forward.expect_equal(by_mass(part(forward_jvp, k, nv), 1), by_mass(one, 1), scale);
    }
    for (const batch::Outcome& outcome : solved) EXPECT_EQ(outcome.singular_states, singular_states);
  });
  EXPECT_GT(regular, 0);
}

TYPED_TEST(ManyStates, DependOnNeitherTheirPlaceNorTheThreads) {
  using T = TypeParam;
  for_seeds(60, [&](std::uint64_t seed) {
    Random<double> random(1000 + seed);
    const States<T> states(tree(random), random, 37);
    const Model& model = states.model;
    const std::size_t N = states.N, nq = states.nq, nv = states.nv;
    const std::vector<T>&q = states.q, &v = states.v, &x = states.x;
    const auto everything = [&](std::span<const T> q_, std::span<const T> v_, std::span<const T> x_,
                                int threads) {
      const std::size_t n = q_.size() / nq;
      std::vector<T> all(n * nv * 2 + n * nv * nv * 2);
      const std::span<T> out(all);
      EXPECT_TRUE(
          batch::run<T>(model, "inverse_dynamics", {.q = q_, .v = v_, .a = x_}, out.first(n * nv), threads)
              .ok());
      EXPECT_EQ(batch::run<T>(model, "forward_dynamics", {.q = q_, .v = v_, .tau = x_},
                              out.subspan(n * nv, n * nv), threads)
                    .done,
                n);
      EXPECT_TRUE(
          batch::run<T>(model, "mass_matrix", {.q = q_}, out.subspan(2 * n * nv, n * nv * nv), threads).ok());
      EXPECT_EQ(batch::run<T>(model, "inverse_mass_matrix", {.q = q_}, out.last(n * nv * nv), threads).done,
                n);
      return all;
    };
    const auto same = [](T a, T b) { return a == b || (std::isnan(a) && std::isnan(b)); };
    const std::vector<T> alone = everything(q, v, x, 1);
    for (const int threads : {2, 5}) {
      const std::vector<T> shared = everything(q, v, x, threads);
      EXPECT_TRUE(std::equal(alone.begin(), alone.end(), shared.begin(), same)) << threads << " threads";
    }
    for (std::size_t k = 0; k < N; k += 5) {
      const std::vector<T> one = everything(states.q_of(k), states.v_of(k), states.x_of(k), 1);
      EXPECT_TRUE(std::equal(one.begin(), one.begin() + static_cast<std::ptrdiff_t>(nv),
                             alone.begin() + static_cast<std::ptrdiff_t>(k * nv), same));
      EXPECT_TRUE(std::equal(one.end() - static_cast<std::ptrdiff_t>(nv * nv), one.end(),
                             alone.end() - static_cast<std::ptrdiff_t>((N - k) * nv * nv), same));
    }
  });
}

TYPED_TEST(ManyStates, MayBeNone) {
  using T = TypeParam;
  Random<double> random(1);
  const Model model = tree(random);
  std::vector<T> none;
  EXPECT_TRUE(batch::run<T>(model, "inverse_dynamics", {.q = none, .v = none, .a = none}, none).ok());
  EXPECT_TRUE(batch::run<T>(model, "forward_dynamics", {.q = none, .v = none, .tau = none}, none, 3).ok());
  EXPECT_TRUE(batch::run<T>(model, "mass_matrix", {.q = none}, none).ok());
  EXPECT_TRUE(batch::run<T>(model, "inverse_mass_matrix", {.q = none}, none).ok());
}

TEST(ManyStatesArguments, AreChecked) {
  const Model model = ModelBuilder("ball")
                          .add({.name = "ball",
                                .joint = {.kind = JointKind::spherical},
                                .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1, 0, 0, 0}}})
                          .build();
  const std::vector<double> q{0, 0, 0, 1, 0, 0, 0, 1}, v(6), a(5), off{0, 0, 0, 1, 0, 0, 0, 1.1};
  std::vector<double> tau(6);
  const auto call = [&](const std::vector<double>& q_, const std::vector<double>& v_,
                        const std::vector<double>& a_, int threads = 1) {
    return message_of([&] {
      EXPECT_TRUE(batch::run(model, "inverse_dynamics", {.q = q_, .v = v_, .a = a_}, tau, threads).ok());
    });
  };
  EXPECT_EQ(call(q, v, a), "a has 5 entries; expected nv N = 6");
  EXPECT_EQ(call(q, a, v), "v has 5 entries; expected nv N = 6");
  EXPECT_EQ(call({0, 0, 1}, v, v), "q has 3 entries; expected a multiple of nq = 4");
  EXPECT_EQ(call(q, v, v, 0), "threads is 0; expected 1 or more");
  EXPECT_THAT(call(off, v, v),
              testing::StartsWith("state 1: q: the quaternion of joint \"ball_joint\" has norm 1.1"));
}

}  // namespace
}  // namespace axode::test
