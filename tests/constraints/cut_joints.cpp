#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/dynamics.hpp"
#include "axode/kinematics.hpp"
#include "axode/lie/six.hpp"
#include "tests/laws/law.hpp"

/// If one joint of a tree is cut and replaced by a loop, the mechanism moves as the tree does, and the loop
/// transmits the wrench of the joint.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;

LoopKind as_loop(JointKind kind) {
  for (const LoopTraits& loop : loop_kinds)
    if (loop.name == to_string(kind)) return loop.kind;
  ADD_FAILURE() << "no loop of kind " << to_string(kind);
  return LoopKind::fixed;
}

/// A random tree, and the same tree with the joint of one body cut: that body then moves freely relative to
/// the ground, and a loop takes the place of its joint.
class CutTree {
 public:
  CutTree(std::uint64_t seed, JointKind kind) {
    Random<double> random(seed);
    Mechanism drawn = random_mechanism(random, {.most_bodies = 12, .always_mass = true});
    const auto at = static_cast<std::size_t>(random.number(0, static_cast<double>(drawn.bodies.size())));
    DrawnBody& body = drawn.bodies[at];
    name = body.name;
    for (DrawnBody& other : drawn.bodies)
      if (other.coupling && (&other == &body || leads(body.joint, other.coupling->leader)))
        other.coupling.reset();
    body.kind = kind, body.dof.clear(), body.pitch = kind == JointKind::helical ? 0.2 : 0;
    if (kind == JointKind::spherical || kind == JointKind::planar) body.J.R = body.A.R;
    if (kind == JointKind::universal) body.second_axis = body.J.R * Vec3<>{1, 0.3, -0.4};
    joint = body.joint;
    Random<double> telling(seed + 1), telling_again(seed + 1);
    whole = ModelBuilder(described(drawn, telling)).build();
    LoopDescription loop{.name = "cut",
                         .between = {drawn.name(body.predecessor), body.name},
                         .kind = as_loop(kind),
                         .axis = body.J.R.z,
                         .second_axis = body.second_axis,
                         .point = body.J.r,
                         .pitch = body.pitch};
    body.predecessor = -1, body.kind = JointKind::free, body.J = body.A, body.joint = "free of cut";
    body.pitch = 0;
    Description description = described(drawn, telling_again);
    description.loops.push_back(loop);
    cut = ModelBuilder(description).build();

    state = random_state(*whole, random);
    std::erase_if(state.wrenches, [&](const AppliedWrench<>& W) {  // loads on the body between the two parts
                                                                   // of a universal joint, which the other
                                                                   // mechanism lacks
      return whole->frame(W.frame).name.starts_with(joint + ".");
    });
    tau = random_numbers(*whole, random);
    each_shared_joint([&](const Joint&, const Joint&) {});
  }

  /// Calls f(joint of the tree, joint of the other mechanism) for each joint that has coordinates in both.
  template <class F> void each_shared_joint(const F& f) {
    for (const Joint& own : whole->joints()) {
      const bool is_cut = own.name == joint || own.name.starts_with(joint + ".");
      if (!is_cut && !own.leader) f(own, cut->joint(cut->joint_index(own.name)));
      if (is_cut)
        for (int k = 0; k < own.nv; ++k) tau[static_cast<std::size_t>(own.iv + k)] = 0;
    }
  }

  std::string name, joint;
  std::optional<Model> whole, cut;
  State<double> state;
  Numbers tau;

 private:
  static bool leads(const std::string& joint, const std::string& leader) {
    return leader == joint || leader.starts_with(joint + ".");
  }
  static Numbers random_numbers(const Model& model, Random<double>& random) {
    return test::random_numbers(random, model.nv(), 10);
  }
};

void copy(const Numbers& from, int at, int n, Numbers& to, int where) {
  std::copy_n(from.begin() + at, n, to.begin() + where);
}

class CutJoints : public testing::TestWithParam<JointKind> {
 protected:
  template <class T> void moves_as_the_tree(std::uint64_t seed, double tolerance) {
    CutTree trees(seed, GetParam());
    const Model &whole = *trees.whole, &cut = *trees.cut;
    Workspace<double> workspace(whole);
    const Numbers &q = trees.state.q, &v = trees.state.v;
    Numbers a(v.size());
    const Loads<double> loads{trees.state.wrenches, true};
    ASSERT_TRUE(forward_dynamics(whole, workspace, q, v, trees.tau, a, loads).ok());

    Numbers q_cut = neutral(cut), v_cut(static_cast<std::size_t>(cut.nv())), a_cut = v_cut, tau_cut = v_cut;
    trees.each_shared_joint([&](const Joint& own, const Joint& other) {
      copy(q, own.iq, own.nq, q_cut, other.iq);
      copy(v, own.iv, own.nv, v_cut, other.iv), copy(a, own.iv, own.nv, a_cut, other.iv);
      copy(trees.tau, own.iv, own.nv, tau_cut, other.iv);
    });
    const int f = whole.frame_index(trees.name);
    std::vector<SE3<>> C(static_cast<std::size_t>(whole.n_frames()));
    std::vector<Twist<BodyFixed>> V(C.size());
    std::vector<TwistRate<BodyFixed>> dV(C.size());
    poses(whole, workspace, q, C);
    twists<BodyFixed>(whole, workspace, q, v, V);
    accelerations<BodyFixed>(whole, workspace, q, v, a, dV);
    const Joint& base = cut.joint(cut.joint_index("free of cut"));
    const SE3<> moved = inverse(cut.body(cut.body_index(trees.name)).A) * C[static_cast<std::size_t>(f)];
    const Quaternion<> turn = quaternion(moved.R);
    const Numbers place{turn.x, turn.y, turn.z, turn.w, moved.r.x, moved.r.y, moved.r.z};
    std::ranges::copy(place, q_cut.begin() + base.iq);
    std::ranges::copy(six(V[static_cast<std::size_t>(f)].w, V[static_cast<std::size_t>(f)].v),
                      v_cut.begin() + base.iv);
    std::ranges::copy(six(dV[static_cast<std::size_t>(f)].w, dV[static_cast<std::size_t>(f)].v),
                      a_cut.begin() + base.iv);

    LoopWorkspace<T> loops(cut);
    const auto in_T = [](const Numbers& x) { return cast<T>(x); };
    std::vector<T> r(static_cast<std::size_t>(cut.loops().residuals));
    loop_residual(cut, loops, in_T(q_cut), r);
    for (const T& x : r) EXPECT_NEAR(static_cast<double>(x), 0, tolerance * 10);
    std::vector<T> got(a_cut.size()), lambda(static_cast<std::size_t>(cut.loops().rows));
    State<T> in_other = cast<T>(trees.state);
    for (auto& W : in_other.wrenches) W.frame = cut.frame_index(whole.frame(W.frame).name);
    const Loads<T> loads_T{in_other.wrenches, true};
    ASSERT_TRUE(
        forward_dynamics(cut, loops, in_T(q_cut), in_T(v_cut), in_T(tau_cut), got, lambda, loads_T).ok());
    double size = 1;
    for (const double x : a_cut) size = std::max(size, std::abs(x));
    for (std::size_t c = 0; c < a_cut.size(); ++c)
      EXPECT_NEAR(static_cast<double>(got[c]), a_cut[c], tolerance * size * condition(whole, q)) << c;

    if constexpr (std::same_as<T, double>)
      transmits_as_the_tree(trees, a, {q_cut, v_cut, a_cut}, loads, loads_T,
                            tolerance * 100 * condition(whole, q));
    if (std::same_as<T, double> && GetParam() != JointKind::fixed) {
      std::vector<Wrench<BodyFixed>> W(static_cast<std::size_t>(whole.n_bodies())), on_body(1);
      joint_wrenches<BodyFixed>(whole, workspace, q, v, a, W, loads);
      LoopWorkspace<double> again(cut);
      loop_wrenches<BodyFixed>(cut, again, q_cut, cast<double>(lambda), on_body);
      const Wrench<BodyFixed>& expected = W[static_cast<std::size_t>(whole.body_index(trees.name)) - 1];
      const double forces = 1 + norm(expected.m) + norm(expected.f);
      const double bound = tolerance * forces * 100 * condition(whole, q);
      EXPECT_LT(norm(on_body[0].m - expected.m), bound);
      EXPECT_LT(norm(on_body[0].f - expected.f), bound);
    }
  }
  /// Compares the wrenches of all joints that both mechanisms have. The joint that was cut has no drive.
  static void transmits_as_the_tree(const CutTree& trees, const Numbers& a,
                                    const std::array<Numbers, 3>& motion, const Loads<>& loads,
                                    const Loads<>& loads_cut, double tolerance) {
    const Model &whole = *trees.whole, &cut = *trees.cut;
    Workspace<double> workspace(whole);
    LoopWorkspace<double> loops(cut);
    const Joint& base = cut.joint(cut.joint_index("free of cut"));
    std::vector<int> drives;
    for (int c = 0; c < cut.nv(); ++c)
      if (c < base.iv || c >= base.iv + base.nv) drives.push_back(c);
    if (drives.empty()) return;
    const Numbers &q = motion[0], &v = motion[1], &a_cut = motion[2];
    const std::size_t n = static_cast<std::size_t>(whole.n_bodies());
    std::vector<Wrench<BodyFixed>> W(n), found(static_cast<std::size_t>(cut.n_bodies()));
    joint_wrenches<BodyFixed>(whole, workspace, trees.state.q, trees.state.v, a, W, loads);
    EXPECT_LT(joint_wrenches<BodyFixed>(cut, loops, q, v, a_cut, found, drives, loads_cut), tolerance);
    double size = 1;
    for (const Wrench<BodyFixed>& W_i : W) size += norm(W_i.m) + norm(W_i.f);
    for (int i = 1; i <= whole.n_bodies(); ++i) {
      const std::string& joint = whole.joint(i).name;
      if (joint == trees.joint || joint.starts_with(trees.joint + ".")) continue;
      const Wrench<BodyFixed>& expected = W[static_cast<std::size_t>(i - 1)];
      const Wrench<BodyFixed>& W_i = found[static_cast<std::size_t>(cut.joint_index(joint) - 1)];
      EXPECT_LT(norm(W_i.m - expected.m), tolerance * size) << joint;
      EXPECT_LT(norm(W_i.f - expected.f), tolerance * size) << joint;
    }
    std::vector<SE3<>> C(static_cast<std::size_t>(whole.n_frames())),
        C_cut(static_cast<std::size_t>(cut.n_frames()));
    Workspace<double> of_cut(cut);
    poses(whole, workspace, trees.state.q, C), poses(cut, of_cut, q, C_cut);
    for (const Representation representation : representations)
      with_representation(representation, [&]<class Rep>(Rep) {
        for (const WrenchPoint at : {WrenchPoint::body, WrenchPoint::joint}) {
          std::vector<Wrench<Rep>> of_whole(W.size()), of_loops(found.size());
          joint_wrenches<Rep>(whole, workspace, trees.state.q, trees.state.v, a, of_whole, loads, at);
          static_cast<void>(joint_wrenches<Rep>(cut, loops, q, v, a_cut, of_loops, drives, loads_cut, at));
          expect_same(whole, C, W, of_whole, at, 1e-10 * size);
          expect_same(cut, C_cut, found, of_loops, at, 1e-10 * size);
        }
      });
  }
  /// Expects that wrenches in a representation and about a point equal those about the origins of the bodies
  /// after the change.
  template <class Rep>
  static void expect_same(const Model& model, const std::vector<SE3<>>& C,
                          const std::vector<Wrench<BodyFixed>>& W, const std::vector<Wrench<Rep>>& moved,
                          WrenchPoint at, double tolerance) {
    for (int i = 1; i <= model.n_bodies(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Vec3<> r = at == WrenchPoint::joint ? model.body(i).S_self.r : Vec3<>{};
      const Wrench<BodyFixed>& W_i = W[k - 1];
      const Wrench<BodyFixed> about_r{W_i.m - cross(r, W_i.f), W_i.f};
      const Wrench<Rep> expected = change<Rep>(C[k] * SE3<>{{}, r}, about_r);
      EXPECT_LT(norm(moved[k - 1].m - expected.m), tolerance) << model.joint(i).name;
      EXPECT_LT(norm(moved[k - 1].f - expected.f), tolerance) << model.joint(i).name;
    }
  }
  /// The condition of the mass matrix, by which errors of accelerations grow.
  static double condition(const Model& model, const Numbers& q) {
    Workspace<double> workspace(model);
    const auto n = static_cast<Eigen::Index>(model.nv());
    if (n == 0) return 1;
    Numbers M(static_cast<std::size_t>(n * n)), inverse(M.size());
    mass_matrix(model, workspace, q, M);
    if (!inverse_mass_matrix(model, workspace, q, inverse).ok()) return 1e9;
    const auto largest = [](const Numbers& x) {
      return std::abs(*std::ranges::max_element(x, {}, [](double y) { return std::abs(y); }));
    };
    return std::max(1.0, 1e-2 * largest(M) * largest(inverse));
  }
};

TEST_P(CutJoints, MoveAsTheTreeDoes) {
  for_seeds(60, [&](std::uint64_t seed) { moves_as_the_tree<double>(seed, 1e-11); });
}
TEST_P(CutJoints, MoveAsTheTreeDoesInFloat) {
  for_seeds(30, [&](std::uint64_t seed) { moves_as_the_tree<float>(seed, 2e-3); });
}

INSTANTIATE_TEST_SUITE_P(, CutJoints,
                         testing::Values(JointKind::fixed, JointKind::revolute, JointKind::prismatic,
                                         JointKind::helical, JointKind::cylindrical, JointKind::universal,
                                         JointKind::spherical, JointKind::planar),
                         [](const auto& info) { return std::string(to_string(info.param)); });

}  // namespace
}  // namespace axode::test
