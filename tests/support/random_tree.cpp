#include "tests/support/random_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tests/support/kinds.hpp"
#include "tests/support/units.hpp"

namespace axode::test {
namespace {

thread_local int most_bodies = std::numeric_limits<int>::max();
thread_local LastMechanism last;

/// A tensor with principal second moments of mass between `thin` and 1 times the largest, in random axes.
Sym3<> random_theta(Random<double>& random, double mass, double size, double thin = 0.1) {
  const double k = mass * size * size;
  const Sym3<> binet{
      k * random.number(thin, 1), k * random.number(thin, 1), k * random.number(thin, 1), 0, 0, 0};
  return rotate(random.rotation(), rotational_inertia(binet));
}

/// The axes of the joint frame that a description implies by an axis along the z-axis of R, or by a point alone.
SO3<> implied_axes(JointKind kind, const SO3<>& R) {
  return traits(kind).has("axis") ? rotation_to(R.z) : SO3<>{};
}

}  // namespace

bool has_one_velocity(JointKind kind) { return traits(kind).dof == 1; }

Mechanism random_mechanism(Random<double>& random, const TreeRecipe& recipe) {
  using enum JointKind;
  const auto chance = [&](double p) { return random.number(0, 1) < p; };
  const auto below = [&](int n) { return std::min(n - 1, static_cast<int>(random.number(0, n))); };
  const auto nearby = [&] { return SE3<>{random.rotation(), random.vector(recipe.length)}; };
  std::vector<JointKind> kinds{revolute, revolute};
  kinds.insert(kinds.end(), moving_kinds.begin(), moving_kinds.end());
  kinds.insert(kinds.end(), {fixed, revolute, prismatic});

  Mechanism mechanism{.gravity = random.vector(10), .bodies = {}};
  const int size =
      std::min(most_bodies, 1 + static_cast<int>(recipe.most_bodies * std::pow(random.number(0, 1), 2)));
  last.bodies = size;
  const double chain = random.number(0, 1), new_root = chance(0.3) ? 0.2 : 0;
  std::vector<std::string> leaders;
  for (int moving = 0, i = 0; moving < size; ++i) {
    DrawnBody body;
    body.name = "body " + std::to_string(i), body.joint = "joint " + std::to_string(i);
    if (i > 0 && !chance(recipe.one_free_root ? 0 : new_root))
      body.predecessor = chance(chain) ? i - 1 : below(i);
    body.kind = kinds[below(static_cast<int>(kinds.size()))];
    if (recipe.one_free_root && i == 0) body.kind = free;
    if (traits(body.kind).chain && (!recipe.composite || moving + 2 > size)) body.kind = revolute;
    moving += body.kind == fixed ? 0 : traits(body.kind).chain ? 2 : 1;

    const SE3<> A_p = mechanism.A(body.predecessor);
    body.J = A_p * nearby();
    body.A = A_p * nearby();
    if (has_oriented_frame(body.kind) && chance(0.4)) body.J.R = implied_axes(body.kind, body.J.R);
    if (has_oriented_frame(body.kind) && chance(0.4)) body.A.R = body.J.R;
    if (is_at_body_frame(body.kind) && body.kind != fixed) body.J = body.A;
    if (traits(body.kind).has("pitch")) body.pitch = random.number(-0.2, 0.2);
    if (traits(body.kind).has("second_axis"))
      body.second_axis = body.J.R * Vec3<>{1, random.number(-1, 1), random.number(-1, 1)};
    if (chance(0.3) || recipe.friction) {
      body.dof.resize(static_cast<std::size_t>(traits(body.kind).dof));
      for (Dof& dof : body.dof)
        dof.damping = random.number(0, 1), dof.friction = random.number(0, 1),
        dof.armature = random.number(0, 0.1);
    }
    if (recipe.couplings && has_one_velocity(body.kind) && !leaders.empty() && chance(0.15))
      body.coupling = Coupling{leaders[static_cast<std::size_t>(below(static_cast<int>(leaders.size())))],
                               random.number(-1.5, 1.5), random.number(-0.5, 0.5)};
    if (has_one_velocity(body.kind)) leaders.push_back(body.joint);
    if (body.kind == universal)
      leaders.push_back(body.joint + ".first"), leaders.push_back(body.joint + ".second");
    if (recipe.always_mass || chance(0.85)) {
      const double mass = random.number(0.1, 5);
      body.matter = {mass, body.A * random.vector(recipe.length),
                     random_theta(random, mass, recipe.length / 3)};
    }
    mechanism.bodies.push_back(std::move(body));
    if (chance(0.1))
      mechanism.frames.push_back({"tool " + std::to_string(i), below(i + 2) - 1, body.A * nearby()});
  }
  if (recipe.far > 0) mechanism = displaced({random.rotation(), recipe.far * random.direction()}, mechanism);
  return mechanism;
}

namespace {

/// Whether a body whose geometry is given in this way gets the joint frame that was drawn, in the same
/// orientation. This matters for the joints whose velocities are components in that frame.
bool can_tell(const DrawnBody& body, Way way) {
  if (!has_oriented_frame(body.kind) || way == Way::joint_frames) return true;
  const SO3<> R = way == Way::body_frame ? transpose(body.A.R) * body.J.R : body.J.R;
  const SO3<> implied = implied_axes(body.kind, R);
  return norm(implied.x - R.x) + norm(implied.y - R.y) < 1e-12;
}

}  // namespace

BodyDescription described(const Mechanism& mechanism, const DrawnBody& body, Way way,
                          Random<double>& random) {
  const SE3<> A_p = mechanism.A(body.predecessor), B = inverse(A_p) * body.A;
  const SE3<> S_self =
      has_oriented_frame(body.kind) ? inverse(body.A) * body.J : SE3<>{random.rotation(), random.vector(0.3)};
  const SE3<> F = way == Way::construction_frame ? SE3<>{}
                  : way == Way::body_frame       ? body.A
                                                 : body.A * S_self;
  const SE3<> in_F = inverse(F) * body.J;
  const bool anywhere = traits(body.kind).has("axis") && !traits(body.kind).has("second_axis") &&
                        !has_oriented_frame(body.kind);

  BodyDescription description{.name = body.name, .predecessor = mechanism.name(body.predecessor)};
  description.joint = {.name = body.joint,
                       .kind = body.kind,
                       .axis = random.number(0.2, 3) * in_F.R.z,
                       .second_axis = random.number(0.2, 3) * (transpose(F.R) * body.second_axis),
                       .point = in_F.r + (anywhere ? random.number(-0.3, 0.3) : 0) * in_F.R.z,
                       .pitch = body.pitch,
                       .dof = body.dof,
                       .coupling = body.coupling};
  if (!traits(body.kind).has("second_axis")) description.joint.second_axis = {1, 0, 0};
  if (way == Way::construction_frame) description.geometry = InConstructionFrame{body.A};
  if (way == Way::body_frame) description.geometry = InBodyFrame{B};
  if (way == Way::joint_frames) description.geometry = InJointFrames{B * S_self, S_self};
  return description;
}

namespace {

/// The mass properties in a random one of the forms that the library accepts: in the body frame or in the
/// construction frame, about the centre of mass or the origin, along axes of the frame or turned ones.
MassProperties described(const DrawnBody::Matter& matter, const SE3<>& A, Random<double>& random) {
  MassProperties told{.mass = matter.mass};
  told.in = random.number(0, 1) < 0.5 ? GivenIn::construction_frame : GivenIn::body_frame;
  told.about = random.number(0, 1) < 0.5 ? InertiaAbout::center_of_mass : InertiaAbout::frame_origin;
  if (random.number(0, 1) < 0.5) told.axes = random.rotation();
  const SE3<> F = told.in == GivenIn::body_frame ? A : SE3<>{};
  told.com = inverse(F) * matter.com;
  const Sym3<> Theta_c = rotate(transpose(F.R), matter.Theta_c);
  const Sym3<> Theta = told.about == InertiaAbout::center_of_mass
                           ? Theta_c
                           : inertia_from_com(matter.mass, told.com, Theta_c).Theta;
  told.Theta = rotate(transpose(told.axes), Theta);
  return told;
}

}  // namespace

Mechanism displaced(const SE3<>& D, Mechanism mechanism) {
  mechanism.gravity = D.R * mechanism.gravity;
  for (DrawnBody& body : mechanism.bodies) {
    body.A = D * body.A, body.J = D * body.J, body.second_axis = D.R * body.second_axis;
    if (body.matter)
      body.matter->com = D * body.matter->com, body.matter->Theta_c = rotate(D.R, body.matter->Theta_c);
  }
  for (DrawnFrame& frame : mechanism.frames) frame.pose = D * frame.pose;
  return mechanism;
}

Description described(const Mechanism& mechanism, Random<double>& random) {
  Description description{.name = "random tree", .gravity = mechanism.gravity, .bodies = {}, .frames = {}};
  for (const DrawnBody& body : mechanism.bodies) {
    const Way way = static_cast<Way>(std::min(2, static_cast<int>(random.number(0, 3))));
    description.bodies.push_back(
        described(mechanism, body, can_tell(body, way) ? way : Way::joint_frames, random));
    if (body.matter) description.bodies.back().inertia = described(*body.matter, body.A, random);
  }
  for (const DrawnFrame& frame : mechanism.frames) {
    const bool in_body = random.number(0, 1) < 0.5;
    description.frames.push_back(
        {.name = frame.name,
         .body = mechanism.name(frame.body),
         .pose = in_body ? inverse(mechanism.A(frame.body)) * frame.pose : frame.pose,
         .in = in_body ? GivenIn::body_frame : GivenIn::construction_frame});
  }
  set_last_description(description);
  return description;
}

namespace {

/// Adds springs of the other kinds with curved laws. They have a random generator of their own, so that
/// they do not change what is drawn after them.
void add_springs_of_every_kind(Description& tree, const std::vector<std::string>& names, bool losses) {
  Random<double> random(static_cast<std::uint64_t>(1e12 * tree.springs[0].stiffness));
  const auto chance = [&](double p) { return random.number(0, 1) < p; };
  const auto any = [&] {
    return names[static_cast<std::size_t>(random.number(0, static_cast<double>(names.size())))];
  };
  const auto loss = [&](double most) { return losses ? random.number(0, most) : 0; };
  const GivenIn in = chance(0.5) ? GivenIn::body_frame : GivenIn::construction_frame;
  if (chance(0.5)) {
    SpringDescription tendon{.name = "tendon", .kind = SpringKind::tendon, .in = in, .damping = loss(1)};
    for (int k = 0; k < 4; ++k) tendon.path.push_back({any(), random.vector()});
    tendon.rest = random.number(0, 2);
    tendon.curve = TableCurve{{-1, 0, 0.5, 2, 5}, {-3, 0, 4, 9, 40}};
    if (chance(0.5)) tendon.acts = chance(0.7) ? Acts::in_tension : Acts::in_compression;
    tree.springs.push_back(tendon);
  }
  if (chance(0.5)) {
    SpringDescription torsion{.kind = SpringKind::torsion, .between = {any(), any()}, .in = in};
    torsion.frames = {random.pose(), random.pose()};
    torsion.rest = random.number(-1, 1), torsion.damping = loss(1);
    torsion.curve = PolynomialCurve{{random.number(-1, 1), random.number(0, 5), 0, random.number(0, 2)}};
    tree.springs.push_back(torsion);
  }
  if (chance(0.5)) {
    SpringDescription bushing{
        .name = "bushing", .kind = SpringKind::bushing, .between = {any(), any()}, .in = in};
    bushing.frames = {random.pose(), random.pose()};
    bushing.rest_pose = random.pose();
    SixBySix L{}, D{};
    for (std::size_t k = 0; k < 6; ++k)
      for (std::size_t l = 0; l <= k; ++l) L[k][l] = random.number(-2, 2), D[k][l] = loss(0.5);
    for (std::size_t k = 0; k < 6; ++k)
      for (std::size_t l = 0; l < 6; ++l)
        for (std::size_t m = 0; m < 6; ++m)
          bushing.K[k][l] += L[k][m] * L[l][m], bushing.C[k][l] += D[k][m] * D[l][m];
    tree.springs.push_back(bushing);
  }
  if (chance(0.5)) {
    SpringDescription gear{
        .name = "of joints", .kind = SpringKind::joints, .stiffness = random.number(0, 20)};
    gear.rest = random.number(-1, 1), gear.damping = loss(1);
    for (const BodyDescription& body : tree.bodies)
      if (can_couple(body.joint.kind) && gear.terms.size() < 3)
        gear.terms.emplace_back(joint_name(body), random.number(0.2, 2));
    if (!gear.terms.empty()) tree.springs.push_back(gear);
  }
}

}  // namespace

Description with_springs(Description tree, Random<double>& random, bool losses) {
  const auto chance = [&](double p) { return random.number(0, 1) < p; };
  std::vector<std::string> names{"ground"};
  for (BodyDescription& body : tree.bodies) {
    names.push_back(body.name);
    const int n = traits(body.joint.kind).dof;
    if (n == 0) continue;
    body.joint.dof.resize(static_cast<std::size_t>(n));
    for (Dof& dof : body.joint.dof) {
      if (chance(0.7)) dof.stiffness = random.number(0, 20);
      if (n > 2) continue;  // cylindrical and universal joints become two joints with one velocity each
      if (dof.stiffness > 0) dof.rest = random.number(-1, 1);
      if (chance(0.5)) continue;
      dof.lower = random.number(-0.6, 0);
      if (chance(0.7)) dof.upper = random.number(0, 0.6);
      dof.stop_stiffness = random.number(20, 50);
      if (losses) dof.stop_damping = random.number(0, 0.5);
    }
  }
  for (const FrameDescription& frame : tree.frames) names.push_back(frame.name);
  const auto any = [&] {
    return names[static_cast<std::size_t>(random.number(0, static_cast<double>(names.size())))];
  };
  for (int k = 0; k < 3; ++k)
    tree.springs.push_back({.between = {any(), any()},
                            .points = {random.vector(), random.vector()},
                            .in = chance(0.5) ? GivenIn::body_frame : GivenIn::construction_frame,
                            .stiffness = random.number(0, 30),
                            .rest = chance(0.3) ? 0 : random.number(0, 1),
                            .damping = losses ? random.number(0, 2) : 0});
  add_springs_of_every_kind(tree, names, losses);
  set_last_description(tree);
  return tree;
}

Description random_description(Random<double>& random, const TreeRecipe& recipe) {
  Description tree = described(random_mechanism(random, recipe), random);
  const bool springs = recipe.springs > 0 && random.number(0, 1) < recipe.springs;
  if (springs) tree = with_springs(std::move(tree), random);
  if (recipe.scale != 1) tree = in_units({.length = recipe.scale}, std::move(tree));
  set_last_description(tree);
  return tree;
}

AtMostBodies::AtMostBodies(int bodies) : before_(std::exchange(most_bodies, bodies)) {}
AtMostBodies::~AtMostBodies() { most_bodies = before_; }
int AtMostBodies::limit() { return most_bodies; }
const LastMechanism& last_mechanism() { return last; }
void set_last_mechanism(const LastMechanism& mechanism) { last = mechanism; }
void set_last_description(const Description& description) {
  last.description = std::make_shared<const Description>(description);
}

std::vector<double> random_numbers(Random<double>& random, int n, double size) {
  std::vector<double> numbers(static_cast<std::size_t>(n));
  for (double& x : numbers) x = random.number(-size, size);
  return numbers;
}

State<double> random_state(const Model& model, Random<double>& random) {
  State<double> state{random_configuration(model, static_cast<std::uint64_t>(random.number(0, 1e15))),
                      random_numbers(random, model.nv()), random_numbers(random, model.nv())};
  for (int n = static_cast<int>(random.number(0, 5)); n > 0; --n) {
    const Vec3<> f = random.vector(10), m = random.vector(10);
    const auto representation = static_cast<Representation>(static_cast<int>(random.number(0, 4)));
    state.wrenches.emplace_back(static_cast<int>(random.number(0, model.n_frames())), representation, m, f);
  }
  return state;
}

std::vector<SE3<>> poses_of(const Model& model, const std::vector<double>& q) {
  Workspace<double> workspace(model);
  std::vector<SE3<>> C(model.n_frames());
  poses(model, workspace, q, C);
  return C;
}

}  // namespace axode::test
