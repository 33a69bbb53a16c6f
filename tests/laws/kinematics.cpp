#include "axode/kinematics/higher_order/product_of_exponentials.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/series.hpp"
#include "tests/support/units.hpp"

/// Poses, twists and accelerations of all frames: three ways to compute poses agree, and every rate equals
/// the time derivative of its quantity. These quantities are of the tree: they know neither springs nor
/// loops.
namespace axode::test {
namespace {

class Kinematics : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, Kinematics, testing::ValuesIn(cases()), name_of);

TEST_P(Kinematics, TwistsAreTheRatesOfPoses) {
  Comparison rate("rate", GetParam().agreement());
  for_seeds(250, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, elsewhere(seed));
    const std::vector<SE3<>> C = trial.poses();
    const std::vector<Six> V = trial.twists();
    std::vector<Vec3<>> dC;  // the columns of C V^b, with V^b as a matrix
    for (std::size_t f = 0; f < C.size(); ++f) {
      const auto& [w, v] = changed_twist(Representation::body, GetParam().representation, C[f], V[f]);
      for (const Vec3<>& e : {Vec3<>{1, 0, 0}, Vec3<>{0, 1, 0}, Vec3<>{0, 0, 1}})
        dC.push_back(C[f].R * cross(w, e));
      dC.push_back(C[f].R * v);
    }
    rate.expect_equal(dC, rates_of_poses(trial.model, trial.state));
  });
}

TEST_P(Kinematics, AccelerationsAreTheRatesOfTwists) {
  Comparison rate("rate", GetParam().agreement());
  for_seeds(250, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, elsewhere(seed));
    rate.expect_equal(trial.accelerations(),
                      rates_of_twists(GetParam().representation, trial.model, trial.state));
  });
}

TEST_P(Kinematics, TwistsAndAccelerationsChangeRepresentation) {
  Comparison twist("twist", GetParam().agreement()), acceleration("acceleration", GetParam().agreement());
  for_seeds(250, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, elsewhere(seed));
    const Representation from = GetParam().representation;
    const std::vector<SE3<>> C = trial.poses();
    const std::vector<Six> V = trial.twists(), dV = trial.accelerations();
    for (const Representation to : representations) {
      if (to == from) continue;
      std::vector<Six> V_to, dV_to;
      for (std::size_t f = 0; f < C.size(); ++f) {
        V_to.push_back(changed_twist(to, from, C[f], V[f]));
        dV_to.push_back(changed_rate(to, from, C[f], V[f], dV[f]));
      }
      Trial other = trial.by(to);
      twist.expect_equal(other.twists(), V_to);
      acceleration.expect_equal(other.accelerations(), dV_to);
    }
  });
}

class Poses : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, Poses, testing::ValuesIn(scalars()), name_of);

/// The poses from body screws and from spatial screws, computed in T.
template <class T> std::array<std::vector<SE3<>>, 2> by_screws(const Trial& trial) {
  const std::vector<T> q = cast<T>(trial.state.q);
  const auto as_double = [](const std::vector<SE3<T>>& C) {
    std::vector<SE3<>> out;
    for (const SE3<T>& C_i : C) out.push_back(axode::cast<double>(C_i));
    return out;
  };
  return {as_double(poses_by_body_screws(trial.model, q.data())),
          as_double(poses_by_spatial_screws(trial.model, q.data()))};
}

TEST_P(Poses, AreProductsOfExponentialsOfBodyAndOfSpatialScrews) {
  Comparison by_X("X", GetParam().agreement()), by_Y("Y", GetParam().agreement());
  for_seeds(1000, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, elsewhere(seed));
    std::vector<SE3<>> C = trial.poses();
    C.resize(trial.n_bodies() + 1);  // of the ground and the bodies
    const auto [C_X, C_Y] = GetParam().single ? by_screws<float>(trial) : by_screws<double>(trial);
    by_X.expect_equal(C_X, C);
    by_Y.expect_equal(C_Y, C);
  });
}

TEST_P(Poses, OfEveryJointAtZeroAreThoseDrawn) {
  Comparison pose("pose", GetParam().agreement());
  for_seeds(500, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const TreeRecipe recipe = elsewhere(seed, {.couplings = false});
    const Mechanism drawn = random_mechanism(random, recipe);
    const Description tree = with_springs(described(drawn, random), random);
    const Model model = ModelBuilder(in_units({.length = recipe.scale}, tree)).build();
    Trial trial(GetParam(), model, State<double>{neutral(model), {}, {}});
    const std::vector<SE3<>> C = trial.poses();
    const auto compare = [&](const std::string& name, SE3<> A) {
      A.r = recipe.scale * A.r;
      pose.expect_equal(C[static_cast<std::size_t>(model.frame_index(name))], A);
    };
    for (const DrawnBody& body : drawn.bodies) compare(body.name, body.A);
    for (const DrawnFrame& frame : drawn.frames) compare(frame.name, frame.pose);
  });
}

}  // namespace
}  // namespace axode::test
