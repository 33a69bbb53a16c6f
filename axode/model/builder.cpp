#include "axode/model/builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "axode/model/nearest_name.hpp"
#include "axode/model/placement.hpp"
#include "axode/model/velocity_parents.hpp"

namespace axode {

std::string_view to_string(JointKind kind) {
  switch (kind) {
    case JointKind::fixed: return "fixed";
    case JointKind::revolute: return "revolute";
    case JointKind::prismatic: return "prismatic";
    case JointKind::helical: return "helical";
    case JointKind::cylindrical: return "cylindrical";
    case JointKind::universal: return "universal";
    case JointKind::spherical: return "spherical";
    case JointKind::planar: return "planar";
    case JointKind::free: return "free";
  }
  return "unknown";
}

namespace {

constexpr double rotation_tolerance = 1e-6;
constexpr double realisability_tolerance = 1e-9;

std::string quoted(std::string_view name) { return '"' + std::string(name) + '"'; }

bool finite(double x) { return std::isfinite(x); }
bool finite(const Vec3<>& a) { return finite(a.x) && finite(a.y) && finite(a.z); }
bool finite(const SO3<>& R) { return finite(R.x) && finite(R.y) && finite(R.z); }
bool finite(const SE3<>& C) { return finite(C.R) && finite(C.r); }
bool finite(const Sym3<>& A) { return finite(Vec3<>{A.xx, A.yy, A.zz}) && finite(Vec3<>{A.xy, A.xz, A.yz}); }
bool finite(const Inertia<>& M) { return finite(M.m) && finite(M.h) && finite(M.Theta); }

int degrees_of_freedom(JointKind kind) {
  switch (kind) {
    case JointKind::fixed: return 0;
    case JointKind::cylindrical:
    case JointKind::universal: return 2;
    case JointKind::spherical:
    case JointKind::planar: return 3;
    case JointKind::free: return 6;
    case JointKind::revolute:
    case JointKind::prismatic:
    case JointKind::helical: break;
  }
  return 1;
}

Subgroup subgroup_of(JointKind kind) {
  switch (kind) {
    case JointKind::prismatic: return Subgroup::prismatic;
    case JointKind::helical: return Subgroup::helical;
    case JointKind::spherical: return Subgroup::spherical;
    case JointKind::planar: return Subgroup::planar;
    case JointKind::free: return Subgroup::free;
    default: return Subgroup::revolute;
  }
}

/// Walks through a description and notes every fault.
class Inspection {
 public:
  Inspection(const Description& description, Physics physics)
      : description_(description), physics_(physics) {}

  std::vector<Fault> run() {
    faults_ = description_.warnings;
    if (!finite(description_.gravity))
      error(Rule::non_finite_number, "gravity", "a component is not finite; give three numbers in m/s²",
            description_.source);
    names();
    predecessors();
    for (const BodyDescription& body : description_.bodies) {
      if (numbers(body)) {
        joint(body);
        inertia(body);
      }
    }
    for (const FrameDescription& frame : description_.frames) {
      const std::string element = "frame " + quoted(frame.name);
      if (frame.body != "ground" && !bodies_.contains(frame.body))
        error(Rule::unknown_frame_body, element,
              "sits on body " + quoted(frame.body) + ", which is not described" + nearest(frame.body, ""),
              frame.source);
      rotation(element, "pose", frame.pose, frame.source);
    }
    couplings();
    return std::move(faults_);
  }

 private:
  void note(Severity severity, Rule rule, std::string element, std::string message, const Source& source) {
    faults_.push_back({severity, rule, std::move(element), std::move(message),
                       source.file.empty() ? Source{description_.source.file, source.line} : source});
  }
  void error(Rule rule, std::string element, std::string message, const Source& source) {
    note(Severity::error, rule, std::move(element), std::move(message), source);
  }
  void physical(Rule rule, std::string element, std::string message, const Source& source) {
    note(physics_ == Physics::strict ? Severity::error : Severity::warning, rule, std::move(element),
         std::move(message), source);
  }
  /// A suggestion for the name of a body that is not described, where anybody will still read it.
  std::string nearest(std::string_view name, std::string_view asked_by) const {
    if (faults_.size() > 100) return "";
    std::vector<std::string_view> names{"ground"};
    for (const BodyDescription& body : description_.bodies)
      if (body.name != asked_by) names.push_back(body.name);
    return did_you_mean(name, names, [](std::string_view n) { return n; });
  }

  void names() {
    std::unordered_set<std::string> joints;
    const auto joint_is_named = [&](const std::string& name, const Source& source) {
      if (!joints.insert(name).second)
        error(Rule::duplicate_name, "joint " + quoted(name), "the name is taken; names of joints must differ",
              source);
    };
    const auto body_name = [&](const std::string& name, const std::string& element, const Source& source) {
      if (name.empty()) {
        error(Rule::missing_name, element, "has no name; every body and frame needs one", source);
      } else if (name == "ground") {
        error(Rule::duplicate_name, element, "\"ground\" names the inertial frame; choose another name",
              source);
      } else if (!taken_.insert(name).second) {
        error(Rule::duplicate_name, element, "the name is taken; names of bodies and frames must differ",
              source);
      }
    };
    for (const BodyDescription& body : description_.bodies) {
      const auto [same, is_new] = bodies_.emplace(body.name, &body);
      if (!is_new && !body.name.empty() && same->second->predecessor != body.predecessor) {
        error(Rule::two_predecessors, "body " + quoted(body.name),
              "has two predecessors, " + quoted(same->second->predecessor) + " and " +
                  quoted(body.predecessor) + "; in a tree every body has one",
              body.source);
      } else {
        body_name(body.name, "body " + quoted(body.name), body.source);
      }
      if (body.joint.name.empty() && (body.name.empty() || !is_new)) continue;
      joint_is_named(joint_name(body), joint_source(body));
      const std::vector<BodyDescription> parts = expand({.bodies = {body}}).bodies;
      if (parts.size() == 1) continue;
      body_name(parts[0].name, "body " + quoted(parts[0].name) + " of joint " + quoted(joint_name(body)),
                joint_source(body));
      for (const BodyDescription& part : parts) joint_is_named(part.joint.name, joint_source(body));
    }
    for (const FrameDescription& frame : description_.frames)
      body_name(frame.name, "frame " + quoted(frame.name), frame.source);
  }

  void predecessors() {
    for (const BodyDescription& body : description_.bodies)
      if (body.predecessor != "ground" && !bodies_.contains(body.predecessor))
        error(Rule::unknown_predecessor, "body " + quoted(body.name),
              "hangs on body " + quoted(body.predecessor) + ", which is not described" +
                  nearest(body.predecessor, body.name),
              body.source);
    cycles();
  }

  /// Follows predecessors from every body; a body met again on the same walk closes a cycle.
  void cycles() {
    std::unordered_map<std::string_view, const BodyDescription*> seen;  // body -> where its walk started
    for (const BodyDescription& start : description_.bodies) {
      const BodyDescription* at = &start;
      while (at != nullptr && !seen.contains(at->name)) {
        seen.emplace(at->name, &start);
        const auto next = at->predecessor == "ground" ? bodies_.end() : bodies_.find(at->predecessor);
        at = next == bodies_.end() ? nullptr : next->second;
      }
      if (at == nullptr || seen.at(at->name) != &start) continue;
      std::string chain = quoted(at->name);
      const BodyDescription* member = at;
      constexpr int most_shown = 8;
      int count = 0;
      do {
        member = bodies_.at(member->predecessor);
        if (++count < most_shown || member == at)
          chain += (count > most_shown ? " on ... on " : " on ") + quoted(member->name);
      } while (member != at);
      error(Rule::cycle, "body " + quoted(at->name),
            "closes a cycle: " + chain + "; every body must hang on the ground in the end", at->source);
    }
  }

  bool rotation(const std::string& element, const char* what, const SE3<>& C, const Source& source) {
    if (!finite(C)) {
      error(Rule::non_finite_number, element, std::string(what) + " is not finite", source);
      return false;
    }
    const SO3<> G = transpose(C.R) * C.R;
    const double off = std::max({std::abs(G.x.x - 1), std::abs(G.y.y - 1), std::abs(G.z.z - 1),
                                 std::abs(G.x.y), std::abs(G.x.z), std::abs(G.y.z)});
    const double handed = dot(cross(C.R.x, C.R.y), C.R.z);
    if (off <= rotation_tolerance && handed > 0) return true;
    error(Rule::not_a_rotation, element,
          handed >= 0 ? std::string(what) + " is off a rotation by " + to_text(off) +
                            "; RᵀR must be the identity to 1e-6"
                      : std::string(what) + " mirrors; a rotation has determinant +1",
          source);
    return false;
  }

  /// Whether every number of the body is finite and every pose one.
  bool numbers(const BodyDescription& body) {
    const std::string element = "body " + quoted(body.name), joint = "joint " + quoted(joint_name(body));
    bool good = true;
    const auto need = [&](bool is_finite, const std::string& where, const char* what) {
      if (is_finite) return;
      error(Rule::non_finite_number, where, std::string(what) + " is not finite",
            where == joint ? joint_source(body) : body.source);
      good = false;
    };
    need(finite(body.joint.axis), joint, "axis");
    need(finite(body.joint.second_axis), joint, "second axis");
    need(finite(body.joint.point), joint, "point");
    need(finite(body.joint.pitch), joint, "pitch");
    for (const Dof& dof : body.joint.dof) {
      need(!std::isnan(dof.lower) && !std::isnan(dof.upper), joint, "a limit");
      need(!std::isnan(dof.velocity) && !std::isnan(dof.effort), joint, "a limit");
      need(finite(dof.damping) && finite(dof.friction) && finite(dof.armature), joint,
           "damping, friction or armature");
    }
    if (body.joint.coupling)
      need(finite(body.joint.coupling->ratio) && finite(body.joint.coupling->offset), joint, "the coupling");
    if (const auto* drawn = std::get_if<InConstructionFrame>(&body.geometry)) {
      good &= rotation(element, "A", drawn->A, body.source);
    } else if (const auto* in_body = std::get_if<InBodyFrame>(&body.geometry)) {
      good &= rotation(element, "B", in_body->B, body.source);
    } else {
      const auto& frames = std::get<InJointFrames>(body.geometry);
      good &= rotation(joint, "S_prev", frames.S_prev, joint_source(body));
      good &= rotation(joint, "S_self", frames.S_self, joint_source(body));
    }
    if (body.inertia) {
      need(finite(body.inertia->mass), element, "mass");
      need(finite(body.inertia->com), element, "centre of mass");
      need(finite(body.inertia->Theta), element, "rotational inertia");
      good &= rotation(element, "the axes of the inertia", {body.inertia->axes, {}}, body.source);
    }
    for (const MeshReference& mesh : body.meshes) {
      good &= rotation(element, "the pose of a mesh", mesh.pose, body.source);
      need(finite(mesh.scale), element, "the scale of a mesh");
    }
    return good;
  }

  static std::string joint_name(const BodyDescription& body) {
    return body.joint.name.empty() ? body.name + "_joint" : body.joint.name;
  }
  static const Source& joint_source(const BodyDescription& body) {
    return body.joint.source.line > 0 ? body.joint.source : body.source;
  }

  void joint(const BodyDescription& body) {
    const JointDescription& joint = body.joint;
    const std::string element = "joint " + quoted(joint_name(body));
    const bool has_axis =
        joint.kind != JointKind::fixed && joint.kind != JointKind::spherical && joint.kind != JointKind::free;
    const auto zero = [](const Vec3<>& axis) { return axis.x == 0 && axis.y == 0 && axis.z == 0; };
    if ((has_axis && zero(joint.axis)) || (joint.kind == JointKind::universal && zero(joint.second_axis))) {
      error(Rule::zero_axis, element, "an axis is (0, 0, 0); an axis needs a direction", joint_source(body));
    } else if (joint.kind == JointKind::universal) {
      const double sine = norm(cross(direction(joint.axis), direction(joint.second_axis)));
      if (sine < 1e-6)
        error(Rule::parallel_axes, element,
              "its two axes are parallel; those of a universal joint must not be", joint_source(body));
    }
    if (joint.pitch != 0 && joint.kind != JointKind::helical)
      error(Rule::pitch_without_helix, element,
            "has a pitch of " + to_text(joint.pitch) + " m/rad but is " + std::string(to_string(joint.kind)) +
                "; only helical joints have a pitch",
            joint_source(body));
    const int n = degrees_of_freedom(joint.kind);
    if (!joint.dof.empty() && static_cast<int>(joint.dof.size()) != n)
      error(Rule::degrees_of_freedom, element,
            "describes " + std::to_string(joint.dof.size()) + " degrees of freedom; a " +
                std::string(to_string(joint.kind)) + " joint has " + std::to_string(n),
            joint_source(body));
    for (const Dof& dof : joint.dof) {
      if (dof.lower > dof.upper)
        error(Rule::limits_crossed, element,
              "lower limit " + to_text(dof.lower) + " is above upper limit " + to_text(dof.upper),
              joint_source(body));
      constexpr double infinity = std::numeric_limits<double>::infinity();
      if (dof.lower <= dof.upper && (dof.lower == infinity || dof.upper == -infinity))
        error(Rule::limits_crossed, element,
              "limits " + to_text(dof.lower) + " and " + to_text(dof.upper) + " leave no place to be",
              joint_source(body));
      const std::array<std::pair<const char*, double>, 5> not_negative{{{"velocity limit", dof.velocity},
                                                                        {"effort limit", dof.effort},
                                                                        {"damping", dof.damping},
                                                                        {"friction", dof.friction},
                                                                        {"armature", dof.armature}}};
      for (const auto& [what, value] : not_negative)
        if (value < 0)
          error(Rule::negative_value, element,
                std::string(what) + " is " + to_text(value) + "; it must not be negative",
                joint_source(body));
    }
  }

  void inertia(const BodyDescription& body) {
    if (!body.inertia) return;
    const MassProperties& given = *body.inertia;
    const std::string element = "body " + quoted(body.name);
    if (given.mass < 0) {
      error(Rule::mass_not_positive, element,
            "mass is " + to_text(given.mass) + " kg; a mass must be positive", body.source);
    } else if (given.mass == 0) {
      physical(Rule::mass_not_positive, element,
               "mass is 0; a mass must be positive, and a massless body needs no mass at all", body.source);
    } else {
      // The axes and the choice of frame do not matter to what a density can produce.
      const double worst = realisability(body_inertia(given, {}));
      if (worst < -realisability_tolerance)
        physical(
            Rule::inertia_not_realisable, element,
            "no density can produce its inertia: a principal moment about the centre of mass exceeds the sum "
            "of the other two by " +
                to_text(std::round(-2e4 * worst) / 100) + " % of the largest, or is negative",
            body.source);
    }
  }

  void couplings() {
    std::unordered_map<std::string, const BodyDescription*> joints;
    const Description expanded = expand(description_);
    for (const BodyDescription& body : expanded.bodies) joints.emplace(body.joint.name, &body);
    std::unordered_map<const BodyDescription*, bool> ends_in_loop;
    const auto follows_a_loop = [&](const BodyDescription* at) {
      std::vector<const BodyDescription*> walk;
      bool loop = false;
      while (at != nullptr && at->joint.coupling) {
        const auto [known, is_new] = ends_in_loop.emplace(at, true);  // true until the walk finds its end
        if (!is_new) {
          loop = known->second;
          break;
        }
        walk.push_back(at);
        const auto next = joints.find(at->joint.coupling->leader);
        at = next == joints.end() ? nullptr : next->second;
      }
      for (const BodyDescription* body : walk) ends_in_loop[body] = loop;
      return loop;
    };
    const auto one_dof = [](JointKind kind) {
      return kind == JointKind::revolute || kind == JointKind::prismatic || kind == JointKind::helical;
    };
    for (const BodyDescription& body : description_.bodies) {
      if (!body.joint.coupling) continue;
      const std::string element = "joint " + quoted(joint_name(body));
      const std::string& leader = body.joint.coupling->leader;
      if (!one_dof(body.joint.kind)) {
        error(Rule::coupling_kind, element,
              "is " + std::string(to_string(body.joint.kind)) +
                  " and coupled; only revolute, prismatic and helical joints can follow another joint",
              joint_source(body));
        continue;
      }
      const auto found = joints.find(leader);
      if (found == joints.end()) {
        error(
            Rule::coupling_unknown_joint, element,
            "follows joint " + quoted(leader) + ", which is not described" +
                did_you_mean(leader, expanded.bodies, [](const BodyDescription& b) { return b.joint.name; }),
            joint_source(body));
      } else if (!one_dof(found->second->joint.kind)) {
        error(Rule::coupling_kind, element,
              "follows joint " + quoted(leader) + ", which is " +
                  std::string(to_string(found->second->joint.kind)) +
                  "; only revolute, prismatic and helical joints can lead",
              joint_source(body));
      } else if (follows_a_loop(found->second)) {
        error(Rule::coupling_loop, element,
              "follows joint " + quoted(leader) + " in a loop; one joint must have a coordinate of its own",
              joint_source(body));
      }
    }
  }

  const Description& description_;
  Physics physics_;
  std::vector<Fault> faults_;
  std::unordered_map<std::string, const BodyDescription*> bodies_;
  std::unordered_set<std::string> taken_;
};

bool has_error(const std::vector<Fault>& faults) {
  return std::any_of(faults.begin(), faults.end(),
                     [](const Fault& f) { return f.severity == Severity::error; });
}

/// The parts of a model while they are put together from a description without errors.
struct Compilation {
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<Frame> frames;
  Tree<double> tree;
  std::vector<int> described;  ///< body of the model -> body of the expanded description, -1 for the ground
  std::vector<Fault> faults;
};

/// A pivot of the mass matrix is looked at more closely where it is below 1e-8 of a bound of the inertia that
/// the joint moves, with every joint at zero: trace of the rotational inertia about the joint's origin, or
/// the mass.
void set_pivot_floors(Tree<double>& tree) {
  constexpr double small = 1e-8;
  std::vector<Inertia<>> composite(tree.M);
  for (int i = tree.n; i > 0; --i) composite[tree.parent[i]] += transform(tree.B[i], composite[i]);
  for (int i = 1; i <= tree.n; ++i)
    with_joint(tree, i, [&](const auto& joint) {
      for (int k = 0; k < joint.nv; ++k) {
        const Screw<> X = joint.column(k);
        const double armature = tree.coupled[i] ? 0 : tree.armature[tree.iv[i] + k];
        tree.pivot_floor.push_back(
            small * (dot(X.w, X.w) * trace(composite[i].Theta) + dot(X.v, X.v) * composite[i].m + armature));
      }
    });
}

/// What kernels would otherwise work out in every call.
void prepare_sweeps(Tree<double>& tree) {
  constexpr std::size_t most_lanes = 16;
  tree.angle.assign(tree.iq.begin() + 1, tree.iq.end());
  tree.angle.resize((tree.angle.size() + most_lanes - 1) / most_lanes * most_lanes);
  for (int i = 1; i <= tree.n; ++i)
    if (tree.coupled[i])
      tree.coupled_bodies.push_back(i);
    else if (tree.kind[i] == Subgroup::spherical || tree.kind[i] == Subgroup::free)
      tree.quaternion_bodies.push_back(i);
  for (int i = 0; i <= tree.n; ++i) tree.packed.body.emplace_back(tree.B[i], tree.M[i]);
  tree.inertia_stride = static_cast<int>((tree.n + 2 * most_lanes) / most_lanes * most_lanes);
  tree.inertia_arrays.resize(10 * static_cast<std::size_t>(tree.inertia_stride));
  for (int i = 1; i <= tree.n; ++i) {
    const Inertia<>& M = tree.M[i];
    const Sym3<>& A = M.Theta;
    int k = i;
    for (const double x : {M.h.x, M.h.y, M.h.z, A.xx, A.yy, A.zz, A.xy, A.xz, A.yz, M.m})
      tree.inertia_arrays[std::exchange(k, k + tree.inertia_stride)] = x;
  }
  tree.hinges.resize(tree.n + 2);
  for (int i = tree.n; i > 0; --i)
    tree.hinges[i] = tree.kind[i] == Subgroup::revolute && !tree.coupled[i] ? tree.hinges[i + 1] + 1 : 0;
  tree.branches.resize(tree.n + 1), tree.subtree_end.resize(tree.n + 1);
  for (int i = tree.n; i >= 0; --i) {
    tree.subtree_end[i] = std::max(tree.subtree_end[i], i + 1);
    const int p = tree.parent[i];
    if (p != i - 1) tree.branches[p] = 1;
    tree.subtree_end[p] = std::max(tree.subtree_end[p], tree.subtree_end[i]);
  }
  for (int i = 1; i <= tree.n; ++i)
    for (int s = tree.first_screw[i]; s < tree.first_screw[i + 1] && !tree.coupled[i]; ++s)
      tree.velocity_end.push_back(tree.subtree_end[i] <= tree.n ? tree.iv[tree.subtree_end[i]] : tree.nv);
  std::vector<int> depth(tree.velocity_parent.size());
  for (std::size_t c = 0; c < depth.size(); ++c) {
    depth[c] = tree.velocity_parent[c] < 0 ? 1 : depth[tree.velocity_parent[c]] + 1;
    tree.depth = std::max(tree.depth, depth[c]);
  }
}

/// Merges runs of bodies of one kind; coupled joints last.
void sort_by_kind(const std::vector<Joint>& joints, Tree<double>& tree) {
  tree.by_kind.resize(tree.n);
  std::iota(tree.by_kind.begin(), tree.by_kind.end(), 1);
  const auto key = [&](int i) { return std::pair(joints[i].leader.has_value(), joints[i].kind); };
  std::stable_sort(tree.by_kind.begin(), tree.by_kind.end(), [&](int i, int j) { return key(i) < key(j); });
  for (int begin = 0; begin < tree.n;) {
    int end = begin;
    while (end < tree.n && key(tree.by_kind[end]) == key(tree.by_kind[begin])) ++end;
    const auto [coupled, kind] = key(tree.by_kind[begin]);
    tree.runs.push_back({kind, coupled, begin, end});
    begin = end;
  }
}

/// Resolves q_i = ratio q_leader + offset through chains of couplings.
void couple(const Description& expanded, Compilation& out) {
  std::unordered_map<std::string_view, int> index;
  for (int i = 1; i <= out.tree.n; ++i) index.emplace(out.joints[i].name, i);
  const auto coupling_of = [&](int i) -> const std::optional<Coupling>& {
    return expanded.bodies[out.described[i]].joint.coupling;
  };
  for (int i = 1; i <= out.tree.n; ++i) {
    std::vector<int> chain;
    int at = i;
    while (coupling_of(at) && !out.joints[at].leader) {
      chain.push_back(at);
      at = index.at(coupling_of(at)->leader);
    }
    for (; !chain.empty(); chain.pop_back()) {
      const Coupling& own = *coupling_of(chain.back());
      const Joint::Leader next = out.joints[at].leader.value_or(Joint::Leader{at, 1, 0});
      at = chain.back();
      out.joints[at].leader =
          Joint::Leader{next.joint, own.ratio * next.ratio, own.ratio * next.offset + own.offset};
    }
  }
}

/// Coordinates and velocities in the order of the bodies, and the terms that belong to velocities.
void number_coordinates(Compilation& out) {
  Tree<double>& tree = out.tree;
  tree.iq.assign(tree.n + 1, 0), tree.iv.assign(tree.n + 1, 0);
  tree.ratio.assign(tree.n + 1, 1), tree.offset.assign(tree.n + 1, 0);
  tree.kind = {Subgroup::free}, tree.coupled = {0}, tree.first_screw = {0, 0};
  for (int i = 1; i <= tree.n; ++i) {
    Joint& joint = out.joints[i];
    joint.iq = tree.nq, joint.iv = tree.nv;
    with_subgroup(joint.kind, joint.pitch, [&](const auto& s) { joint.nq = s.nq, joint.nv = s.nv; });
    tree.kind.push_back(joint.kind), tree.coupled.push_back(joint.leader.has_value());
    tree.first_screw.push_back(tree.n_screws += joint.nv);
    if (joint.leader) {
      joint.nq = 0, joint.nv = 0;
      continue;
    }
    tree.nq += joint.nq, tree.nv += joint.nv;
    tree.iq[i] = joint.iq, tree.iv[i] = joint.iv;
  }
  tree.armature.assign(tree.nv, 0), tree.damping.assign(tree.nv, 0), tree.friction.assign(tree.nv, 0);
  for (int i = 1; i <= tree.n; ++i) {
    Joint& joint = out.joints[i];
    if (joint.leader) {
      const Joint& leader = out.joints[joint.leader->joint];
      joint.iq = leader.iq, joint.iv = leader.iv;
      tree.iq[i] = leader.iq, tree.iv[i] = leader.iv;
      tree.ratio[i] = joint.leader->ratio, tree.offset[i] = joint.leader->offset;
    }
    const double k = tree.ratio[i];  // power: a coupled joint moves k times as fast
    for (std::size_t d = 0; d < joint.dof.size(); ++d) {
      tree.armature[joint.iv + d] += k * k * joint.dof[d].armature;
      tree.damping[joint.iv + d] += k * k * joint.dof[d].damping;
      tree.friction[joint.iv + d] += std::abs(k) * joint.dof[d].friction;
    }
  }
  tree.velocity_parent = velocity_parents(tree);
}

/// A fault of body i of the model.
Fault fault_of(const Description& expanded, const Compilation& out, int i, Severity severity, Rule rule,
               std::string element, const char* message) {
  const Source& source = i > 0 ? expanded.bodies[out.described[i]].source : expanded.source;
  return {severity, rule, std::move(element), message,
          source.file.empty() ? Source{expanded.source.file, source.line} : source};
}

void warn_of_massless_subtrees(const Description& expanded, Compilation& out) {
  std::vector<double> mass(out.tree.n + 1);
  for (int i = out.tree.n; i > 0; --i) {
    mass[i] += out.tree.M[i].m;
    mass[out.tree.parent[i]] += mass[i];
  }
  std::vector<bool> moves_mass(out.tree.n + 1);  // itself or through the joints that follow it
  for (int i = 1; i <= out.tree.n; ++i) {
    const Joint& joint = out.joints[i];
    const bool armature =
        std::any_of(joint.dof.begin(), joint.dof.end(), [](const Dof& d) { return d.armature > 0; });
    if (mass[i] > 0 || armature)
      moves_mass[joint.leader && joint.leader->ratio != 0 ? joint.leader->joint : i] = true;
  }
  for (int i = 1; i <= out.tree.n; ++i) {
    const Joint& joint = out.joints[i];
    if (moves_mass[i] || joint.leader) continue;
    out.faults.push_back(fault_of(expanded, out, i, Severity::warning, Rule::moves_no_mass,
                                  "joint " + quoted(joint.name),
                                  "moves no mass; the mass matrix is singular"));
  }
}

/// Finite numbers can be so large that what follows from them is not.
void report_overflow(const Description& expanded, Compilation& out) {
  for (int i = 0; i <= out.tree.n; ++i) {
    const Body& body = out.bodies[i];
    const bool good = finite(body.A) && finite(body.B) && finite(body.M) && finite(out.tree.B[i]) &&
                      finite(out.tree.M[i]) && finite(out.tree.ratio[i]) && finite(out.tree.offset[i]);
    if (!good)
      out.faults.push_back(fault_of(expanded, out, i, Severity::error, Rule::non_finite_number,
                                    "body " + quoted(body.name),
                                    "its numbers are so large that its pose, inertia or coupling overflows"));
  }
  for (std::size_t f = 0; f < out.frames.size(); ++f)
    if (!finite(out.tree.frame_offset[f]) && finite(out.bodies[out.frames[f].body].A))
      out.faults.push_back(fault_of(expanded, out, out.frames[f].body, Severity::error,
                                    Rule::non_finite_number, "frame " + quoted(out.frames[f].name),
                                    "its numbers are so large that its pose overflows"));
}

Compilation compile(const Description& description) {
  const Description expanded = expand(description);
  const DepthFirstOrder order = depth_first_order(expanded);
  const std::vector<Placement> placements = place(expanded, order);

  Compilation out;
  Tree<double>& tree = out.tree;
  tree.g = description.gravity;
  tree.parent = {0};
  tree.B = {SE3<>{}}, tree.M = {Inertia<>{}}, tree.pitch = {0};
  Body ground;
  ground.name = "ground";
  out.bodies = {ground}, out.joints = {Joint{}}, out.frames = {Frame{"ground", 0, {}}}, out.described = {-1};
  std::vector<int> carrier(expanded.bodies.size());       // body of the description -> body of the model
  std::vector<SE3<>> on_carrier(expanded.bodies.size());  // its frame in the internal frame of that body
  std::vector<SE3<>> offset{SE3<>{}};                     // user's frame in the internal frame, by body
  std::vector<Frame> extra;

  for (const int d : order.order) {
    const BodyDescription& from = expanded.bodies[d];
    const Placement& at = placements[d];
    const int p = order.predecessor[d], parent = p < 0 ? 0 : carrier[p];
    const SE3<> in_parent =
        (p < 0 ? SE3<>{} : on_carrier[p]) * at.B;  // body frame at q = 0, parent's internal frame
    const Inertia<> M = from.inertia ? body_inertia(*from.inertia, at.A) : Inertia<>{};
    if (from.joint.kind == JointKind::fixed) {
      carrier[d] = parent, on_carrier[d] = in_parent;
      tree.M[parent] += transform(in_parent, M);
      extra.push_back({from.name, parent, inverse(offset[parent]) * in_parent});
      continue;
    }
    const int i = ++tree.n;
    carrier[d] = i, on_carrier[d] = inverse(at.S_self);
    offset.push_back(on_carrier[d]);
    out.described.push_back(d);
    tree.parent.push_back(parent);
    tree.B.push_back(in_parent * at.S_self);
    tree.M.push_back(transform(on_carrier[d], M));
    tree.pitch.push_back(from.joint.pitch);

    Joint joint;
    joint.name = from.joint.name, joint.kind = subgroup_of(from.joint.kind), joint.pitch = from.joint.pitch;
    joint.dof = from.joint.dof;
    joint.dof.resize(degrees_of_freedom(from.joint.kind));
    out.joints.push_back(std::move(joint));

    Body body;
    body.name = from.name, body.predecessor = parent, body.A = at.A, body.S_self = at.S_self;
    body.B = inverse(offset[parent]) * in_parent;
    body.S_prev = body.B * at.S_self;
    with_subgroup(subgroup_of(from.joint.kind), from.joint.pitch, [&](const auto& s) {
      for (int k = 0; k < s.nv; ++k) body.X.push_back(Ad(at.S_self, s.column(k)));
    });
    out.bodies.push_back(std::move(body));
  }
  std::unordered_map<std::string_view, int> index;
  for (const int d : order.order) index.emplace(expanded.bodies[d].name, d);
  for (const FrameDescription& frame : description.frames) {
    const bool on_ground = frame.body == "ground";
    const int d = on_ground ? -1 : index.at(frame.body), body = on_ground ? 0 : carrier[d];
    const SE3<> A = on_ground ? SE3<>{} : placements[d].A, internal = on_ground ? SE3<>{} : on_carrier[d];
    const SE3<> pose = orthonormal(frame.pose);
    const SE3<> on_body = frame.in == GivenIn::body_frame ? pose : inverse(A) * pose;
    extra.push_back({frame.name, body, inverse(offset[body]) * internal * on_body});
  }

  couple(expanded, out);
  number_coordinates(out);
  sort_by_kind(out.joints, tree);
  warn_of_massless_subtrees(expanded, out);
  for (int i = 1; i <= tree.n; ++i) out.frames.push_back({out.bodies[i].name, i, {}});
  out.frames.insert(out.frames.end(), extra.begin(), extra.end());
  for (const Frame& frame : out.frames) {
    tree.frame_body.push_back(frame.body);
    tree.frame_offset.push_back(offset[frame.body] * frame.pose);
  }
  for (int i = 0; i <= tree.n; ++i) out.bodies[i].M = transform(inverse(offset[i]), tree.M[i]);
  prepare_sweeps(tree);
  set_pivot_floors(tree);
  report_overflow(expanded, out);
  return out;
}

}  // namespace

ModelBuilder& ModelBuilder::add(BodyDescription body) {
  description_.bodies.push_back(std::move(body));
  return *this;
}
ModelBuilder& ModelBuilder::add(FrameDescription frame) {
  description_.frames.push_back(std::move(frame));
  return *this;
}
ModelBuilder& ModelBuilder::gravity(const Vec3<>& g) {
  description_.gravity = g;
  return *this;
}

BodyDescription& ModelBuilder::body(std::string_view name) {
  for (BodyDescription& body : description_.bodies)
    if (body.name == name) return body;
  throw std::invalid_argument(
      "ModelBuilder::body: model " + quoted(description_.name) + " has no body " + quoted(name) +
      did_you_mean(name, description_.bodies, [](const BodyDescription& b) { return b.name; }));
}

std::vector<Fault> ModelBuilder::check(Physics physics) const {
  std::vector<Fault> faults = Inspection(description_, physics).run();
  if (!has_error(faults)) {
    const std::vector<Fault> more = compile(description_).faults;
    faults.insert(faults.end(), more.begin(), more.end());
  }
  return faults;
}

Model ModelBuilder::build(Physics physics) const {
  std::vector<Fault> faults = Inspection(description_, physics).run();
  if (has_error(faults)) throw ModelError(description_.name, std::move(faults));
  Compilation out = compile(description_);
  faults.insert(faults.end(), out.faults.begin(), out.faults.end());
  if (has_error(faults)) throw ModelError(description_.name, std::move(faults));
  auto data = std::make_shared<Model::Data>();
  data->description = description_;
  data->bodies = std::move(out.bodies);
  data->joints = std::move(out.joints);
  data->frames = std::move(out.frames);
  data->warnings = std::move(faults);
  data->tree_float = cast<float>(out.tree);
  data->tree = std::move(out.tree);
  return Model(std::move(data));
}

Description with_free_base(Description description) {
  std::vector<BodyDescription*> roots;
  for (BodyDescription& body : description.bodies)
    if (body.predecessor == "ground" && body.joint.kind == JointKind::fixed) roots.push_back(&body);
  if (roots.size() != 1)
    throw ModelError(description.name,
                     {{Severity::error, Rule::no_base, "model " + quoted(description.name),
                       std::to_string(roots.size()) +
                           " bodies are fixed to the ground; a free base needs exactly one to set free",
                       description.source}});
  roots[0]->joint = {.name = "free_base", .kind = JointKind::free};
  return description;
}

}  // namespace axode
