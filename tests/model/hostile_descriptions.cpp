#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "axode/dynamics.hpp"
#include "axode/model/kinds/shape_kinds.hpp"
#include "tests/model/random_mechanism.hpp"
#include "tests/support/smallest_failure.hpp"

/// The builder turns every description, whatever it holds, into a consistent model or refuses it with at
/// least one fault.
namespace axode::test {
namespace {

/// Draws parts of descriptions; most of them are valid and some are nonsense.
class Nonsense {
 public:
  explicit Nonsense(std::uint64_t seed, double share) : random_(seed), share_(share) {}

  Description description() {
    const int n = whole(0, 9);
    Description d = random_tree(random_, std::max(n, 1), all_kinds);
    if (n == 0) d.bodies.clear();
    for (BodyDescription& body : d.bodies) spoil(body);
    for (int k = whole(0, 3); k > 0; --k) d.frames.push_back(frame(d));
    if (bad()) d.gravity = vector();
    return d;
  }
  Random<double>& random() { return random_; }
  int whole(int low, int high) { return low + static_cast<int>(random_.number(0, high - low + 1)); }

 private:
  bool bad() { return random_.number(0, 1) < share_; }
  template <class Choices> auto any(const Choices& choices) {
    return *(std::begin(choices) + whole(0, static_cast<int>(std::size(choices)) - 1));
  }
  /// A name that may clash with other such names, with names of the tree, and with names that the library
  /// gives to parts of joints.
  std::string name() {
    static const std::vector<std::string> names{"",          "ground",    "b0",
                                                "b1",        "b2",        "b3",
                                                "j0",        "j1",        "j2",
                                                "b0_joint",  "_joint",    "j1.sleeve",
                                                "j1.cross",  "j2.sleeve", "j0.rotation",
                                                "j1.first",  "j2.second", "j1.translation",
                                                "free_base", "no such",   std::string(300, 'x')};
    return any(names);
  }
  double number() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    static const std::vector<double> numbers{
        0,      -0.0,    1,        -1,        0.1,
        -7,     1e-8,    1e-200,   5e-324,    1e200,
        -1e200, 1.7e308, infinity, -infinity, std::numeric_limits<double>::quiet_NaN()};
    return any(numbers);
  }
  Vec3<> vector() { return {number(), number(), number()}; }
  SO3<> rotation() {
    SO3<> R = random_.rotation();
    switch (whole(0, 4)) {
      case 0: return {vector(), vector(), vector()};
      case 1: return {R.x, R.y, -R.z};
      case 2: return {R.x + 1e-8 * R.y, R.y, R.z};
      case 3: return {R.x, R.y, 2.0 * R.z};
      default: return R;
    }
  }
  SE3<> pose() { return {rotation(), bad() ? vector() : random_.vector()}; }
  ShapeDescription shape() {
    return {.name = name(),
            .kind = any(shape_kinds).kind,
            .pose = pose(),
            .size = vector(),
            .radius = number(),
            .length = number(),
            .file = name(),
            .scale = vector(),
            .color = std::array{number(), number(), number(), number()}};
  }
  Geometry geometry() {
    switch (whole(0, 2)) {
      case 0: return InConstructionFrame{pose()};
      case 1: return InBodyFrame{pose()};
      default: return InJointFrames{pose(), pose()};
    }
  }
  FrameDescription frame(const Description& d) {
    return {.name = bad() ? name() : numbered('f', static_cast<int>(d.frames.size())),
            .body = bad()              ? name()
                    : d.bodies.empty() ? "ground"
                                       : any(d.bodies).name,
            .pose = bad() ? pose() : random_.pose(),
            .in = whole(0, 1) ? GivenIn::body_frame : GivenIn::construction_frame};
  }
  void spoil(BodyDescription& body) {
    JointDescription& joint = body.joint;
    if (bad()) body.name = name();
    if (bad()) body.predecessor = name();
    if (bad()) joint.name = name();
    if (bad()) joint.kind = any(all_kinds);
    if (bad()) joint.axis = vector();
    if (bad()) joint.second_axis = vector();
    if (bad()) joint.point = vector();
    if (bad()) joint.pitch = number();
    if (bad()) joint.coupling = Coupling{bad() ? name() : numbered('j', whole(0, 9)), number(), number()};
    if (bad()) joint.dof.resize(static_cast<std::size_t>(whole(0, 7)));
    for (Dof& dof : joint.dof)
      if (bad()) dof = {number(), number(), number(), number(), number(), number(), number()};
    if (bad()) body.geometry = geometry();
    if (bad()) body.shapes.push_back(shape());
    if (bad()) body.inertia.reset();
    if (!body.inertia) return;
    if (bad()) body.inertia->mass = number();
    if (bad()) body.inertia->com = vector();
    if (bad()) body.inertia->Theta = {number(), number(), number(), number(), number(), number()};
    if (bad()) body.inertia->axes = rotation();
    if (bad()) body.inertia->in = GivenIn::construction_frame;
    if (bad()) body.inertia->about = InertiaAbout::frame_origin;
  }

  Random<double> random_;
  double share_;
};

/// Expects the properties that every model has, whatever it was built from.
void expect_consistent(const Model& model) {
  const Tree<double>& tree = model.tree<double>();
  const int n = model.n_bodies();
  ASSERT_EQ(tree->parent.size(), static_cast<std::size_t>(n) + 1);
  ASSERT_EQ(model.bodies().size(), static_cast<std::size_t>(n) + 1);
  ASSERT_EQ(model.joints().size(), static_cast<std::size_t>(n));
  ASSERT_EQ(tree->by_kind.size(), static_cast<std::size_t>(n));
  std::set<std::string> joints, frames;
  int nq = 0, nv = 0;
  for (int i = 1; i <= n; ++i) {
    const Joint& joint = model.joint(i);
    EXPECT_LT(tree->parent[i], i);
    EXPECT_EQ(model.body(i).predecessor, tree->parent[i]);
    EXPECT_EQ(model.frame(i).name, model.body(i).name);
    EXPECT_TRUE(joints.insert(joint.name).second) << joint.name;
    if (!joint.leader) {
      EXPECT_EQ(joint.iq, nq);
      EXPECT_EQ(joint.iv, nv);
    } else {
      const Joint& leader = model.joint(joint.leader->joint);
      EXPECT_FALSE(leader.leader) << "couplings are resolved";
      EXPECT_EQ(joint.iq, leader.iq);
      EXPECT_EQ(joint.iv, leader.iv);
    }
    nq += joint.nq, nv += joint.nv;
  }
  EXPECT_EQ(nq, model.nq());
  EXPECT_EQ(nv, model.nv());
  for (const Frame& frame : model.frames()) {
    EXPECT_FALSE(frame.name.empty());
    EXPECT_TRUE(frames.insert(frame.name).second) << frame.name;
    EXPECT_GE(frame.body, 0);
    EXPECT_LE(frame.body, n);
  }
  std::vector<int> kinds = tree->by_kind;
  std::ranges::sort(kinds);
  for (int i = 1; i <= n; ++i) EXPECT_EQ(kinds[i - 1], i);
}

/// Calls every function that takes a model. Their results may be any numbers.
void expect_usable(const Model& model, Nonsense& nonsense) {
  Workspace<double> workspace(model);
  const std::vector<double> q = clamp(model, random_configuration(model, 7)), v(model.nv(), 0.5);
  EXPECT_EQ(integrate(model, q, difference(model, q, neutral(model))).size(), q.size());
  std::vector<SE3<>> C(model.n_frames());
  std::vector<double> tau(model.nv());
  poses(model, workspace, q, C);
  inverse_dynamics(model, workspace, q, v, v, tau);
  std::vector<std::string_view> locked;
  for (const Joint& joint : model.joints())
    if (!joint.leader && nonsense.whole(0, 2) == 0) locked.push_back(joint.name);
  try {
    const Model less = reduced(model, locked, q);
    expect_consistent(less);
    EXPECT_EQ(less.n_frames(), model.n_frames());
  } catch (const ModelError& error) {  // huge numbers may overflow when joints are displaced
    for (const Fault& fault : error.faults())
      if (fault.severity == Severity::error) {
        EXPECT_EQ(fault.rule, Rule::non_finite_number) << error.what();
      }
  }
  EXPECT_EQ(ModelBuilder(model).build().n_bodies(), model.n_bodies());
}

/// Builds random descriptions of `count` seeds, and returns the share of them that was valid.
double build_all(int count, double share_of_nonsense) {
  int built = 0, tried = 0;
  for_seeds(count, [&](std::uint64_t seed) {
    ++tried;
    Nonsense nonsense(seed, share_of_nonsense);
    const Description description = nonsense.description();
    const Strictness strictness = nonsense.whole(0, 1) ? Strictness::strict : Strictness::lenient;
    const std::vector<Fault> checked = ModelBuilder(description).check(strictness);
    const auto errors = std::ranges::count(checked, Severity::error, &Fault::severity);
    try {
      const Model model = ModelBuilder(description).build(strictness);
      ++built;
      EXPECT_EQ(errors, 0);
      EXPECT_EQ(model.warnings().size(), checked.size());
      expect_consistent(model);
      expect_usable(model, nonsense);
    } catch (const ModelError& error) {
      EXPECT_GE(errors, 1) << error.what();
      EXPECT_EQ(error.faults().size(), checked.size());
      for (const Fault& fault : error.faults()) {
        EXPECT_FALSE(fault.element.empty() || fault.message.empty());
        if (fault.severity == Severity::error) {
          EXPECT_THAT(error.what(), testing::HasSubstr(to_string(fault)));
        }
      }
    }
    try {
      with_free_base(description);
    } catch (const ModelError& error) {
      EXPECT_EQ(error.faults().size(), 1u);
    }
  });
  return built / static_cast<double>(tried);
}

TEST(HostileDescriptions, SoundOnesAreBuilt) { EXPECT_EQ(build_all(200, 0.0), 1); }

TEST(HostileDescriptions, OnesWithAGrainOfNonsenseAreBuiltOrRefused) {
  const double built = build_all(2000, 0.01);
  EXPECT_GT(built, 0.2) << "many are only odd";
  EXPECT_LT(built, 0.8) << "many are wrong";
}

TEST(HostileDescriptions, OnesWithMuchNonsenseAreBuiltOrRefused) { build_all(2000, 0.05); }

TEST(HostileDescriptions, PureNonsenseIsRefused) { build_all(1500, 0.5); }

/// Names and predecessors are drawn from three letters, which makes cycles, duplicate names and missing
/// predecessors of every shape.
TEST(HostileDescriptions, EveryTangleOfThreeNamesIsBuiltOrRefused) {
  const std::array<std::string, 5> names{"a", "b", "c", "ground", ""};
  int built = 0;
  for (int code = 0; code < 15'625; ++code) {  // three bodies, five names, five predecessors
    Description tangle;
    for (int k = 0, rest = code; k < 3; ++k, rest /= 25)
      tangle.bodies.push_back({.name = names[rest % 5], .predecessor = names[rest / 5 % 5]});
    try {
      built += ModelBuilder(tangle).build().n_frames() == 4;
    } catch (const ModelError& error) {
      EXPECT_FALSE(error.faults().empty());
    }
  }
  EXPECT_EQ(built, 6 * 16) << "labelled trees on the ground and three bodies (Cayley), in any order";
}

}  // namespace
}  // namespace axode::test
