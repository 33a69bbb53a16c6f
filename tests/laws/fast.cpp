#include "tests/laws/law.hpp"

/// What is computed in the quickest frames is what is computed in the hybrid representation: on trees of all
/// kinds of joints, with couplings, loads and losses, and where the mass matrix is singular.
namespace axode::test {
namespace {

template <class T> class FastPath : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(FastPath, Scalars);

template <class T> std::vector<T> square(const Model& model) {
  return std::vector<T>(static_cast<std::size_t>(model.nv()) * static_cast<std::size_t>(model.nv()));
}

TYPED_TEST(FastPath, GivesTheSameForces) {
  using T = TypeParam;
  Comparison force("force", agreement<T>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const std::vector<T>&q = trial.state.q, &v = trial.state.v, &a = trial.state.a;
    Loads<T> loads = trial.state.loads();
    loads.joint_losses = seed % 2 == 0;
    const auto all = [&](auto rep) {
      using Rep = decltype(rep);
      std::vector<T> forces = trial.template inverse_dynamics<Rep>(v, a, loads), part = trial.zero();
      const auto append = [&] { forces.insert(forces.end(), part.begin(), part.end()); };
      coriolis_vector<Rep>(trial.model, trial.workspace, q, v, part), append();
      gravity_vector<Rep>(trial.model, trial.workspace, q, part), append();
      generalized_loads<Rep>(trial.model, trial.workspace, q, v, loads, part), append();
      return forces;
    };
    force.expect_equal(all(Fast{}), all(Hybrid{}));
  });
}

TYPED_TEST(FastPath, GivesTheSameMassMatrixAndJudgesItsInverseAlike) {
  using T = TypeParam;
  Comparison inertia("mass matrix", agreement<T>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const int nv = trial.model.nv();
    std::vector<T> one = square<T>(trial.model), other = one;
    mass_matrix<Fast>(trial.model, trial.workspace, trial.state.q, one);
    mass_matrix<Hybrid>(trial.model, trial.workspace, trial.state.q, other);
    inertia.expect_equal(one, other);
    for (int i = 0; i < nv && trial.model.n_screws() == nv; ++i)
      for (int j = 0; j < i; ++j) {
        const std::size_t ij = static_cast<std::size_t>(i * nv + j),
                          ji = static_cast<std::size_t>(j * nv + i);
        EXPECT_EQ(one[ij], one[ji]) << "symmetric to the last bit where no joints are coupled";
      }
    std::vector<T> inverse = square<T>(trial.model), judged = inverse;
    const Solvability fast = inverse_mass_matrix<Fast>(trial.model, trial.workspace, trial.state.q, inverse),
                      hybrid =
                          inverse_mass_matrix<Hybrid>(trial.model, trial.workspace, trial.state.q, judged);
    EXPECT_EQ(fast.singular_body, hybrid.singular_body);
    if (!fast.ok()) return;
    expect_same_inverse(inverse, judged, one);
  });
}

}  // namespace
}  // namespace axode::test
