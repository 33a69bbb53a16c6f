#include "tests/support/random_loops.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/dynamics.hpp"
#include "axode/eigen.hpp"
#include "axode/model/configuration.hpp"

namespace axode::test {
namespace {

/// Draws loops at a configuration of a tree.
class LoopDrawing {
 public:
  LoopDrawing(const Model& tree, const std::vector<double>& q, double length, Random<double>& random)
      : tree_(tree), q_(q), C_(poses_of(tree, q)), length_(length), random_(random) {}

  /// A loop of the kind that is closed at the configuration, between frames on two bodies; nothing if the two
  /// frames that were drawn are on one body.
  std::optional<LoopDescription> between_frames(LoopKind kind) {
    const int one = below(tree_.n_frames()), other = below(tree_.n_frames());
    if (tree_.frame(one).body == tree_.frame(other).body) return {};
    LoopDescription loop{.name = std::string(to_string(kind)),
                         .between = {tree_.frame(one).name, tree_.frame(other).name},
                         .kind = kind};
    if (kind == LoopKind::helical) loop.pitch = random_.number(0.3, 1) * length_;
    const SE3<> second = pose(other) * SE3<>{random_.rotation(), random_.vector(length_)};
    const SE3<> first = second * inverse(relative_pose(loop));
    loop.frames = {inverse(pose(one)) * first, inverse(pose(other)) * second};
    return loop;
  }

  /// A loop joint between the bodies of a joint of the tree that is of the same kind as that joint and so
  /// adds no constraint; nothing if the joint that was drawn does not have exactly one velocity.
  std::optional<LoopDescription> restated_joint() {
    if (tree_.n_bodies() == 0) return {};
    const int i = 1 + below(tree_.n_bodies());
    const Joint& joint = tree_.joint(i);
    if (joint.nv != 1 || joint.leader) return {};
    const Body& body = tree_.body(i);
    const SE3<> second = pose(i) * body.S_self;
    const SE3<> first =
        second * inverse(with_subgroup<double>(joint.kind, joint.pitch, [&](const auto& of_kind) {
          return of_kind.pose(SE3<>{}, &q_[static_cast<std::size_t>(joint.iq)]);
        }));
    LoopDescription loop{.name = "restated " + joint.name,
                         .between = {tree_.body(body.predecessor).name, body.name},
                         .kind = joint.kind == Subgroup::revolute    ? LoopKind::revolute
                                 : joint.kind == Subgroup::prismatic ? LoopKind::prismatic
                                                                     : LoopKind::helical,
                         .pitch = joint.pitch};
    loop.frames = {inverse(pose(body.predecessor)) * first, body.S_self};
    return loop;
  }

  /// A coupling Σ factor q = offset of some joints that have one velocity each; nothing if none was drawn.
  std::optional<CouplingDescription> coupling() {
    CouplingDescription coupling{.name = "gear"};
    for (const Joint& joint : tree_.joints())
      if (joint.dof.size() == 1 && !joint.leader && chance(0.4)) {
        coupling.terms.emplace_back(joint.name, random_.number(0.2, 2));
        coupling.offset += coupling.terms.back().second * q_[static_cast<std::size_t>(joint.iq)];
      }
    if (coupling.terms.empty()) return {};
    return coupling;
  }

  /// A second loop that is redundant because it repeats this one. Where the loop joint commutes with
  /// translations along its axis, the frames of the second loop are moved along that axis.
  LoopDescription again(LoopDescription loop) {
    loop.name += " again";
    const LoopTraits& kind = traits(loop.kind);
    if (!kind.free[0] && !kind.has("points") && !kind.has("center"))
      for (SE3<>& F : *loop.frames) F = F * SE3<>{{}, {0, 0, length_}};
    return loop;
  }

  bool chance(double p) { return random_.number(0, 1) < p; }

 private:
  int below(int n) { return std::min(n - 1, static_cast<int>(random_.number(0, n))); }
  SE3<> pose(int frame) const { return C_[static_cast<std::size_t>(frame)]; }

  /// A pose of the second frame of a loop in the first frame at which the loop is closed. Where the kind of
  /// the loop has a length, an angle or radii, this also sets them.
  SE3<> relative_pose(LoopDescription& loop) {
    const auto about_z = [&] { return exp_SO3(Vec3<>{0, 0, random_.number(-3, 3)}); };
    switch (loop.kind) {
      case LoopKind::rod: {
        const SE3<> D{random_.rotation(), random_.number(0.5, 2) * length_ * random_.direction()};
        loop.length = norm(D.r);
        return D;
      }
      case LoopKind::rolling: {  // the axis of a wheel is at least 0.1 rad from the normal and the plane
        const double tilt = random_.number(0.1, 1.4), radius = random_.number(0.5, 1) * length_;
        const SO3<> R = about_z() * exp_SO3(Vec3<>{tilt, 0, 0}) * about_z();
        loop.radius = radius;
        const bool wheel = chance(0.5);
        if (wheel) loop.wheel_axis = Vec3<>{0, 0, 1};
        return {R,
                {random_.number(-length_, length_), random_.number(-length_, length_),
                 wheel ? radius * std::sin(tilt) : radius}};
      }
      case LoopKind::belt:  // pulleys that are smaller than the distance of their axes
        loop.radii = {0.2 * random_.number(0.5, 1) * length_, 0.2 * random_.number(-1, -0.5) * length_};
        if (chance(0.5)) loop.radii[1] = -loop.radii[1];
        return {about_z(), about_z() * Vec3<>{random_.number(0.6, 2) * length_, 0, 0}};
      case LoopKind::universal:
        loop.angle = random_.number(0.6, 2.5);
        return {about_z() * exp_SO3(Vec3<>{*loop.angle, 0, 0}) * about_z(), {}};
      default: break;
    }
    const std::array<bool, 6>& is_free = traits(loop.kind).free;
    if (is_free[0]) return {random_.rotation(), {}};
    SE3<> D;
    const double theta = random_.number(-3, 3);
    if (is_free[2]) D.R = exp_SO3(Vec3<>{0, 0, theta});
    const Vec3<> shift = random_.vector(length_);
    D.r = {is_free[3] ? shift.x : 0, is_free[4] ? shift.y : 0,
           loop.kind == LoopKind::helical ? loop.pitch * theta
           : is_free[5]                   ? shift.z
                                          : 0};
    return D;
  }

  const Model& tree_;
  const std::vector<double>& q_;
  const std::vector<SE3<>> C_;
  const double length_;
  Random<double>& random_;
};

}  // namespace

Description with_closed_loops(Description tree, const std::vector<double>& q, double length,
                              Random<double>& random) {
  const Model bare = ModelBuilder(tree).build();
  LoopDrawing drawing(bare, q, length, random);
  std::vector<std::optional<LoopKind>> kinds;
  for (const LoopTraits& kind : loop_kinds)
    if (kind.kind != LoopKind::belt) kinds.emplace_back(kind.kind);
  kinds.emplace_back();  // a coupling
  for (std::size_t k = kinds.size(); k > 1; --k)
    std::swap(kinds[k - 1], kinds[std::min(k - 1, static_cast<std::size_t>(random.number(0, double(k))))]);
  int to_spare = bare.nv() - 1;
  for (const std::optional<LoopKind> kind : kinds) {
    const int rows = kind ? traits(*kind).rows : 1;
    if (rows > to_spare || drawing.chance(0.3)) continue;
    if (!kind) {
      if (const auto coupling = drawing.coupling()) {
        tree.couplings.push_back(*coupling);
        to_spare -= rows;
      }
    } else if (const auto loop = drawing.between_frames(*kind)) {
      tree.loops.push_back(*loop);
      to_spare -= rows;
    }
  }
  const std::vector<LoopDescription> once = tree.loops;
  for (const LoopDescription& loop : once)
    if (drawing.chance(0.2)) tree.loops.push_back(drawing.again(loop));
  if (drawing.chance(0.3))
    if (const auto loop = drawing.restated_joint()) tree.loops.push_back(*loop);
  // Belts have a random generator of their own, so that they do not change what else is drawn.
  Random<double> of_belts(static_cast<std::uint64_t>(1e6 * std::abs(q.empty() ? 0 : q[0])));
  LoopDrawing belts(bare, q, length, of_belts);
  if (to_spare > 0 && belts.chance(0.5))
    if (const auto loop = belts.between_frames(LoopKind::belt)) tree.loops.push_back(*loop);
  for (BodyDescription& body : tree.bodies)
    body.joint.passive = body.joint.kind != JointKind::fixed && drawing.chance(0.3);
  set_last_description(tree);
  return tree;
}

namespace {

/// Whether one can tell clearly which rows of the loops are independent, and whether they leave the mechanism
/// a motion: each eigenvalue of A M⁻¹ Aᵀ, scaled to a unit diagonal, is either well above 0 or 0 to rounding.
bool well_conditioned(const Model& model, const std::vector<double>& q) {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const int nv = model.nv(), m = model.loops().rows;
  Workspace<double> workspace(model, cut_tree);
  LoopWorkspace<double> loops(model);
  Matrix M_inverse(nv, nv), A(m, nv);
  if (!inverse_mass_matrix(model, workspace, q, as_span(M_inverse)).ok()) return false;
  loop_jacobian(model, loops, q, as_span(A));
  Eigen::MatrixXd G = A * M_inverse * A.transpose();
  const double none = 1e-20 * G.diagonal().maxCoeff();  // below this a row is taken for zero, as those of
                                                        // restated joints are
  const Eigen::VectorXd d =
      G.diagonal().unaryExpr([&](double x) { return x > none ? 1 / std::sqrt(x) : 0.0; });
  G = (d.asDiagonal() * G * d.asDiagonal()).eval();
  const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(G).eigenvalues();
  int rank = 0;
  for (const double lambda : eigenvalues) {
    if (lambda > 1e-12 && lambda < 1e-4) return false;
    rank += lambda >= 1e-4;
  }
  return rank < nv;
}

}  // namespace

std::optional<ClosedMechanism> closed(const Description& tree, double length, Random<double>& random) {
  State<double> state = random_state(ModelBuilder(tree).build(), random);
  Description description = with_closed_loops(tree, state.q, length, random);
  Model model = ModelBuilder(description).build();
  std::vector<double> tau = random_numbers(random, model.nv(), 10);
  if (model.loops().empty() || !well_conditioned(model, state.q)) return {};
  for (std::size_t c = 0; c < tau.size(); ++c)
    if (!model.loops().driven[c]) tau[c] = 0;
  LoopWorkspace<double> loops(model);
  if (!impact(model, loops, state.q, state.v, 0.0, state.v).ok() ||
      !forward_dynamics(model, loops, state.q, state.v, tau, state.a, {}, state.loads()).ok())
    return {};
  return ClosedMechanism{{std::move(description), std::move(model), std::move(state)}, std::move(tau)};
}

MechanismAtAState in_units(const Units& units, const MechanismAtAState& drawn) {
  Description description = in_units(units, drawn.description);
  set_last_description(description);
  Model model = ModelBuilder(description).build();
  State<double> state = in_units(units, model, drawn.state);
  return {std::move(description), std::move(model), std::move(state)};
}

ClosedMechanism closed_mechanism(Random<double>& random, TreeRecipe recipe) {
  const Units units{.length = std::exchange(recipe.scale, 1)};
  recipe.always_mass = true;
  std::optional<ClosedMechanism> drawn;
  while (!drawn) drawn = closed(random_description(random, recipe), recipe.length, random);
  if (units.length == 1) return *std::move(drawn);
  return {in_units(units, *drawn), in_units(units, drawn->model, Ask{.tau = drawn->tau}).tau};
}

MechanismAtAState mechanism_at_a_state(Random<double>& random, TreeRecipe recipe) {
  if (recipe.loops > 0 && random.number(0, 1) < recipe.loops) return closed_mechanism(random, recipe);
  const Units units{.length = std::exchange(recipe.scale, 1)};
  Description description = random_description(random, recipe);
  Model model = ModelBuilder(description).build();
  State<double> state = random_state(model, random);
  const MechanismAtAState drawn{std::move(description), std::move(model), std::move(state)};
  return units.length == 1 ? drawn : in_units(units, drawn);
}

}  // namespace axode::test
