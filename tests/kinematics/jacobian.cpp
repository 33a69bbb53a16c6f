#include "tests/kinematics/derivatives.hpp"
#include "tests/support/refused_arguments.hpp"

/// A Jacobian times velocities is a twist.
namespace axode::test {
namespace {

class Jacobian : public Law {
 protected:
  const Representation in = GetParam().representation;
};
INSTANTIATE_TEST_SUITE_P(Kinematics, Jacobian, testing::ValuesIn(cases()), name_of);

const TreeRecipe large_trees{.most_bodies = 30};

std::vector<Six> jacobian_of(Trial& trial, const Place<>& place) {
  return sixes_of(trial.call("jacobian", {.q = trial.state.q, .place = place}));
}
Six times(const std::vector<Six>& J, const std::vector<double>& v) {
  Six V{};
  for (std::size_t c = 0; c < J.size(); ++c) V = V + Six{v[c] * J[c].a, v[c] * J[c].b};
  return V;
}

TEST_P(Jacobian, TimesTheVelocitiesIsTheTwistOfEveryFrame) {
  Comparison twist("twist", GetParam().agreement());
  for_seeds(100, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, large_trees);
    std::vector<Six> V;
    for (int f = 0; f < trial.model.n_frames(); ++f) V.push_back(times(jacobian_of(trial, f), trial.state.v));
    twist.expect_equal(V, trial.twists());
  });
}

/// The columns of the screws on the path to a frame, summed up for each velocity, and the number of these
/// columns.
struct SumOfColumns {
  std::vector<Six> J;
  std::size_t count;
};
template <class Rep, class T> std::vector<SumOfColumns> sums_of_columns(const Trial& trial) {
  const Model& model = trial.model;
  Workspace<T> workspace(model);
  const std::vector<T> q = cast<T>(trial.state.q);
  std::vector<JacobianColumn<Rep, T>> columns(static_cast<std::size_t>(model.n_screws()));
  std::vector<SumOfColumns> all;
  for (int f = 0; f < model.n_frames(); ++f) {
    SumOfColumns sum{std::vector<Six>(static_cast<std::size_t>(model.nv())),
                     jacobian_columns<Rep>(model, workspace, q, f, columns)};
    for (std::size_t k = 0; k < sum.count; ++k) {
      Six& J_c = sum.J[static_cast<std::size_t>(columns[k].c)];
      J_c = J_c + Six{axode::cast<double>(columns[k].J.w), axode::cast<double>(columns[k].J.v)};
    }
    all.push_back(std::move(sum));
  }
  return all;
}

TEST_P(Jacobian, IsTheSumOfItsColumnsAlongThePath) {
  Comparison column("column", GetParam().agreement());
  for_seeds(100, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, large_trees);
    const Model& model = trial.model;
    const std::vector<SumOfColumns> sums = with_representation(in, [&](auto rep) {
      using Rep = decltype(rep);
      return GetParam().single ? sums_of_columns<Rep, float>(trial) : sums_of_columns<Rep, double>(trial);
    });
    for (int f = 0; f < model.n_frames(); ++f) {
      const auto& [sum, count] = sums[static_cast<std::size_t>(f)];
      column.expect_equal(jacobian_of(trial, f), sum);
      std::size_t screws_on_path = 0;
      for (int i = model.frame(f).body; i > 0; i = model.body(i).predecessor)
        screws_on_path += model.body(i).X.size();
      EXPECT_EQ(count, screws_on_path);
    }
  });
}

/// The Jacobians of several places, from one call.
template <class Rep, class T>
std::vector<Six> jacobians_of(const Trial& trial, const std::vector<Place<>>& places) {
  const Model& model = trial.model;
  Workspace<T> workspace(model);
  const std::vector<T> q = cast<T>(trial.state.q);
  std::vector<Place<T>> in_T;
  for (const Place<>& place : places) in_T.emplace_back(place.frame, axode::cast<T>(place.offset));
  std::vector<Twist<Rep, T>> J(places.size() * static_cast<std::size_t>(model.nv()));
  jacobians<Rep>(model, workspace, q, in_T, J);
  std::vector<Six> all;
  for (const Twist<Rep, T>& column : J)
    all.push_back({axode::cast<double>(column.w), axode::cast<double>(column.v)});
  return all;
}

TEST_P(Jacobian, OfManyFramesAndPlacesInOneCallAreThoseOfEach) {
  Comparison frames("frames", GetParam().agreement()), somewhere("places", GetParam().agreement());
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), random_model(random, large_trees), random);
    const auto one_by_one = [&](const std::vector<Place<>>& places) {
      std::vector<Six> all;
      for (const Place<>& place : places)
        for (const Six& column : jacobian_of(trial, place)) all.push_back(column);
      return all;
    };
    std::vector<Place<>> every, some;
    for (int f = 0; f < trial.model.n_frames(); ++f) every.emplace_back(f);
    frames.expect_equal(sixes_of(trial.call("jacobians")), one_by_one(every));
    for (int k = 0; k < 5; ++k) some.push_back(random_place(trial.model, random));
    somewhere.expect_equal(with_representation(in,
                                               [&](auto rep) {
                                                 using Rep = decltype(rep);
                                                 return GetParam().single
                                                            ? jacobians_of<Rep, float>(trial, some)
                                                            : jacobians_of<Rep, double>(trial, some);
                                               }),
                           one_by_one(some));
  });
}

TEST_P(Jacobian, OfAPoseInAFrameIsThatOfAFrameThere) {
  Comparison pose("pose", GetParam().agreement()), point("point", GetParam().agreement());
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Description description = described(random_mechanism(random, large_trees), random);
    const std::string body = description.bodies.back().name;
    const SE3<> offset{random.rotation(), random.vector()};
    description.frames.push_back({.name = "place", .body = body, .pose = offset});
    description.frames.push_back({.name = "point", .body = body, .pose = {{}, offset.r}});
    Trial trial(GetParam(), ModelBuilder(description).build(), random);
    const int frame = trial.model.frame_index(body);
    pose.expect_equal(jacobian_of(trial, {frame, offset}),
                      jacobian_of(trial, trial.model.frame_index("place")));
    point.expect_equal(jacobian_of(trial, {frame, offset.r}),
                       jacobian_of(trial, trial.model.frame_index("point")));
  });
}

TEST_P(Jacobian, ChangesItsRepresentationLikeTwists) {
  Comparison column("column", GetParam().agreement());
  for_seeds(100, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, large_trees);
    const int frame = trial.model.n_frames() - 1;
    const SE3<> C = trial.poses().back();
    for (const Representation other : representations) {
      Trial in_other = trial.by(other);
      std::vector<Six> changed;
      for (const Six& J_c : jacobian_of(in_other, frame)) changed.push_back(changed_twist(in, other, C, J_c));
      column.expect_equal(jacobian_of(trial, frame), changed);
    }
  });
}

std::vector<Six> relative_jacobian_of(Trial& trial, const Place<>& place, const Place<>& base) {
  return sixes_of(trial.call("relative_jacobian", {.q = trial.state.q, .place = place, .base = base}));
}

TEST_P(Jacobian, OfOnePlaceRelativeToAnotherIsThatOfTheRelativePose) {
  using S = Taylor<double, 2>;
  Comparison rate("rate", GetParam().agreement());
  for_seeds(150, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), random_model(random, large_trees), random);
    const Place<> place = random_place(trial.model, random), base = random_place(trial.model, random);
    const Tree<S> tree = on<S>(trial.model);
    const std::vector<SE3<S>> frames =
        frame_poses(tree, moving<2>(tree, trial.state.q, trial.state.v, trial.zero()));
    const auto pose = [&](const Place<>& at) {
      return frames[static_cast<std::size_t>(at.frame)] * axode::cast<S>(at.offset);
    };
    const SE3<S> C_series = inverse(pose(base)) * pose(place);
    const SE3<> C = time_derivative(C_series, 0), dC = time_derivative(C_series, 1);

    const Six V = times(relative_jacobian_of(trial, place, base), trial.state.v);
    const auto [w, v] = changed_twist(Representation::body, in, C, V);
    const auto columns = [](const SE3<>& A) { return std::vector<Vec3<>>{A.R.x, A.R.y, A.R.z, A.r}; };
    const SE3<> C_V{{C.R * Vec3<>{0, w.z, -w.y}, C.R * Vec3<>{-w.z, 0, w.x}, C.R * Vec3<>{w.y, -w.x, 0}},
                    C.R * v};
    rate.expect_equal(columns(C_V), columns(dC), 1);
  });
}

TEST_P(Jacobian, RelativeToTheGroundIsTheJacobianAndRelativeToItselfIsZero) {
  Comparison to_ground("ground", GetParam().agreement()), to_itself("itself", GetParam().agreement());
  for_seeds(50, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, large_trees);
    const int frame = trial.model.n_frames() - 1;
    const std::vector<Six> J = jacobian_of(trial, frame);
    to_ground.expect_equal(relative_jacobian_of(trial, frame, 0), J);
    to_itself.expect_equal(relative_jacobian_of(trial, frame, frame), std::vector<Six>(J.size()), 1);
  });
}

class JointScrews : public Law {};
INSTANTIATE_TEST_SUITE_P(Kinematics, JointScrews, testing::ValuesIn(scalars()), name_of);

TEST_P(JointScrews, SumUpAlongEveryPathToTheSpatialTwist) {
  Comparison twist("twist", GetParam().agreement());
  for_seeds(200, [&](std::uint64_t seed) {
    Trial trial(in(Representation::spatial, GetParam()), seed, large_trees);
    const Model& model = trial.model;
    const std::vector<Six> J = sixes_of(trial.call("joint_screws"));
    std::vector<Six> V(trial.n_bodies() + 1);
    for (int i = 1; i <= model.n_bodies(); ++i) {
      Six& V_i = V[static_cast<std::size_t>(i)];
      V_i = V[static_cast<std::size_t>(model.body(i).predecessor)];
      const double ratio = model.joint(i).leader ? model.joint(i).leader->ratio : 1;
      for (std::size_t k = 0; k < model.body(i).X.size(); ++k) {
        const double v = ratio * trial.state.v[static_cast<std::size_t>(model.joint(i).iv) + k];
        const Six& J_k = J[static_cast<std::size_t>(model.first_screw(i)) + k];
        V_i = V_i + Six{v * J_k.a, v * J_k.b};
      }
    }
    std::vector<Six> expected = trial.twists();
    expected.resize(V.size());
    twist.expect_equal(V, expected);
  });
}

TEST_P(JointScrews, AreTheReferenceScrewsCarriedByTheirBodies) {
  Comparison screw_of("screw", GetParam().agreement());
  for_seeds(100, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, large_trees);
    const std::vector<SE3<>> C = trial.poses();
    std::vector<Six> expected;
    for (int i = 1; i <= trial.model.n_bodies(); ++i)
      for (const Screw<>& X : trial.model.body(i).X) {
        const Screw<> J = Ad(C[static_cast<std::size_t>(i)], X);
        expected.push_back({J.w, J.v});
      }
    screw_of.expect_equal(sixes_of(trial.call("joint_screws")), expected);
  });
}

TEST(JacobianErrors, OfManyPlacesNameTheArgumentAndTheRule) {
  Random<double> random(3);
  const Model model = random_model(random, {.most_bodies = 5});
  Workspace<> workspace(model);
  const std::vector<double> q = neutral(model);
  std::vector<Twist<BodyFixed>> J(static_cast<std::size_t>(model.nv()));
  const std::string nv = std::to_string(model.nv());
  const std::string frames =
      "; model \"random tree\" has frames 0 to " + std::to_string(model.n_frames() - 1);
  const auto several = [&](const std::vector<Place<>>& places, std::size_t columns) {
    std::vector<Twist<BodyFixed>> all(columns);
    return message_of([&] { jacobians(model, workspace, q, places, all); });
  };
  EXPECT_EQ(several({0, 1}, J.size()),
            "J has " + nv + " entries; expected nv for each place = " + std::to_string(2 * J.size()));
  EXPECT_EQ(several({0, -1}, 2 * J.size()), "frame is -1" + frames);
  EXPECT_EQ(several({}, 0), "no error");
  const std::span<double> in_place(reinterpret_cast<double*>(J.data()), q.size());
  std::copy(q.begin(), q.end(), in_place.begin());
  const std::vector<Place<>> last{model.n_frames() - 1};
  EXPECT_EQ(message_of([&] { jacobians(model, workspace, in_place, last, J); }),
            "J shares memory with q; this result needs memory of its own");
  std::vector<JacobianColumn<BodyFixed>> none;
  const std::string too_short = message_of([&] { jacobian_columns(model, workspace, q, 1, none); });
  EXPECT_EQ(too_short.substr(0, 40), "columns has 0 entries; the path to the p");
}

}  // namespace
}  // namespace axode::test
