#include "axode/model/building/compilation.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>
#include <utility>

#include "axode/model/building/placement.hpp"
#include "axode/model/building/spring_laws.hpp"
#include "axode/model/finite.hpp"
#include "axode/model/kinds/joint_kinds.hpp"

namespace axode {
namespace {

/// Compiles a description into a model. Bodies that are fixed to others are merged and become named frames.
///
/// The relative pose of two neighbours is computed from the difference of their positions, so that no digits
/// are lost if they are far from the origin.
class Compiler {
 public:
  explicit Compiler(const Description& description)
      : description_(description),
        expanded_(expand(description)),
        order_(depth_first_order(expanded_)),
        placements_(reference_placements(expanded_, order_)),
        on_(expanded_.bodies.size()) {
    for (std::size_t d = 0; d < expanded_.bodies.size(); ++d) index_.emplace(expanded_.bodies[d].name, d);
    Body ground;
    ground.name = "ground";
    bodies_.push_back(std::move(ground));
    connections_.frame_body = {0};
    add_body(0, Subgroup::free, {});
    joints_.emplace_back();
    frames_.push_back({"ground", 0, {}});
  }

  Compilation run() {
    for (const int d : order_.order)
      if (expanded_.bodies[d].joint.kind == JointKind::fixed)
        merge(d);
      else
        add(d);
    for (const FrameDescription& frame : description_.frames) add(frame);
    couple();
    for (int i = 1; i < n_bodies(); ++i) add_frame({bodies_[i].name, i, {}}, offset_[i]);
    for (auto& [frame, offset] : extra_) add_frame(std::move(frame), offset);
    const auto topology = std::make_shared<const Topology>(std::move(connections_));
    number_joints(*topology);
    index_names();
    Springs springs;
    std::vector<Fault> faults;
    for (std::size_t k = 0; k < description_.springs.size(); ++k)
      springs.elements.push_back(spring(k, *topology, faults));
    for (const DriveDescription& drive : description_.drives)
      if (drive.line) springs.drive_lines.push_back(line_of(*drive.line));
    for (int i = 1; i <= topology->n; ++i)
      if (std::ranges::any_of(joints_[i].dof,
                              [](const Dof& dof) { return dof.stiffness > 0 || dof.stop_stiffness > 0; }))
        springs.joints.push_back(i);
    Loops loops = closed_loops(*topology);
    for (int i = 0; i <= topology->n; ++i) bodies_[i].M = transform(inverse(offset_[i]), numbers_.M[i]);
    Compilation out{std::move(bodies_), std::move(joints_), std::move(frames_),
                    std::move(springs), std::move(loops),   Tree<double>(topology, std::move(numbers_)),
                    std::move(faults)};
    report_loops_within_bodies(out);
    report_massless_subtrees(out);
    report_overflow(out);
    return out;
  }

 private:
  /// Where a body of the description is in the model. `carrier` is the index of the moving body into which
  /// the described body is merged (0 for the ground) or, if it is not merged, its own index. The joint frame
  /// of the carrier has the pose S F in the frame of the described body. If the described body is merged and
  /// its pose is given in the inertial frame, S is this whole pose and F is the identity. Otherwise S is the
  /// pose of the body's own joint frame in the body frame, and F the pose of the carrier's joint frame in
  /// that joint frame. S and F are stored separately, because S F may be a short displacement while S and F
  /// are long ones, so that digits would be lost.
  struct Carried {
    int carrier = 0;
    SE3<> S, F;
  };
  /// The pose in the joint frame of the carrier, F⁻¹ S⁻¹ C, of a pose C in the frame of the described body.
  static SE3<> in_carrier(const Carried& on, const SE3<>& C) { return relative(on.F, relative(on.S, C)); }

  int n_bodies() const { return static_cast<int>(bodies_.size()); }

  /// The inertia of body d in the internal frame of its carrier, which has pose J in the construction frame.
  Inertia<> inertia_of(int d, const SE3<>& J) const {
    const BodyDescription& from = expanded_.bodies[d];
    if (!from.inertia) return {};
    const MassProperties& given = *from.inertia;
    if (given.in == GivenIn::construction_frame) return inertia_in(J, given);
    return is_drawn(from) ? inertia_in(J, placements_[d].A, given)
                          : inertia_in(on_[d].F, expressed_in(on_[d].S, given));
  }

  void merge(int d) {
    const int p = order_.predecessor[d];
    const Placement& at = placements_[d];
    const Carried on = p < 0 ? Carried{} : on_[p];
    const SE3<>& J = internal_[on.carrier];
    SE3<> offset;
    if (is_drawn(expanded_.bodies[d])) {
      offset = relative(J, at.A);
      on_[d] = {on.carrier, relative(at.A, J), {}};
    } else {
      const SE3<> joint = in_carrier(on, at.S_prev);
      offset = joint * inverse(at.S_self);
      on_[d] = {on.carrier, at.S_self, inverse(joint)};
    }
    numbers_.M[on.carrier] += inertia_of(d, J);
    extra_.push_back({{expanded_.bodies[d].name, on.carrier, inverse(offset_[on.carrier]) * offset}, offset});
  }

  void add(int d) {
    const int p = order_.predecessor[d];
    const Placement& at = placements_[d];
    const BodyDescription& from = expanded_.bodies[d];
    const Carried on = p < 0 ? Carried{} : on_[p];
    const int parent = on.carrier;
    const bool drawn = is_drawn(from);
    const SE3<> B = drawn ? relative(internal_[parent], at.J) : in_carrier(on, at.S_prev);
    const SE3<> J = drawn ? at.J : internal_[parent] * B;
    const SE3<> offset = drawn ? relative(J, at.A) : inverse(at.S_self);
    on_[d] = {n_bodies(), at.S_self, {}};
    internal_.push_back(J);
    connections_.parent.push_back(parent);
    add_body(from.joint.pitch, traits(from.joint.kind).subgroup, offset, B);
    numbers_.M.back() = inertia_of(d, J);
    described_.push_back(d);

    Joint joint;
    joint.name = from.joint.name;
    joint.kind = connections_.kind.back();
    joint.pitch = from.joint.pitch;
    joint.dof = from.joint.dof;
    joint.passive = is_passive(from.joint, description_);
    joint.dof.resize(static_cast<std::size_t>(traits(from.joint.kind).dof));
    Body body;
    body.name = from.name;
    body.predecessor = parent;
    body.A = at.A;
    body.S_self = at.S_self;
    body.S_prev = inverse(offset_[parent]) * B;
    body.B = body.S_prev * inverse(at.S_self);
    with_subgroup(joint.kind, joint.pitch, [&](const auto& s) {
      for (int k = 0; k < s.nv; ++k) body.X.push_back(Ad(at.S_self, s.column(k)));
    });
    joints_.push_back(std::move(joint));
    bodies_.push_back(std::move(body));
  }

  void add_body(double pitch, Subgroup kind, const SE3<>& offset, const SE3<>& B = {}) {
    connections_.kind.push_back(kind);
    numbers_.pitch.push_back(pitch);
    numbers_.B.push_back(B);
    numbers_.M.emplace_back();
    offset_.push_back(offset);
  }

  void add(const FrameDescription& frame) {
    const SE3<> pose = orthonormal(frame.pose);
    const Carried on = frame.body == "ground" ? Carried{} : on_[index_.at(frame.body)];
    const SE3<> offset =
        frame.in == GivenIn::body_frame ? in_carrier(on, pose) : relative(internal_[on.carrier], pose);
    extra_.push_back({{frame.name, on.carrier, inverse(offset_[on.carrier]) * offset}, offset});
  }

  void add_frame(Frame frame, const SE3<>& offset) {
    connections_.frame_body.push_back(frame.body);
    numbers_.frame_offset.push_back(offset);
    frames_.push_back(std::move(frame));
  }

  /// Fills the maps from names to indices, after all frames and joints were added.
  void index_names() {
    for (std::size_t f = 0; f < frames_.size(); ++f) frame_.emplace(frames_[f].name, static_cast<int>(f));
    for (int i = 1; i < n_bodies(); ++i) joint_.emplace(joints_[i].name, i);
  }

  /// The pose in frame f of a pose C that is given in frame f or in the construction frame, as `in` says.
  SE3<> in_frame(int f, GivenIn in, const SE3<>& C) const {
    if (in == GivenIn::body_frame) return C;
    return relative(numbers_.frame_offset[f], relative(internal_[frames_[f].body], C));
  }
  /// The pose in the construction frame at q = 0 of a pose C in frame f.
  SE3<> drawn(int f, const SE3<>& C) const {
    return internal_[frames_[f].body] * (numbers_.frame_offset[f] * C);
  }

  std::array<Spring::End, 2> ends_of(const SpringDescription& from) const {
    std::array<Spring::End, 2> ends;
    for (std::size_t e = 0; e < 2; ++e) {
      const int f = frame_.at(from.between[e]);
      ends[e] = {f, in_frame(f, from.in, orthonormal(from.frames[e]))};
    }
    return ends;
  }
  Spring::Path path_of(const SpringDescription& from) const {
    Spring::Path path;
    const auto add = [&](const std::string& on, const Vec3<>& point) {
      const int f = frame_.at(on);
      path.points.push_back({f, in_frame(f, from.in, {{}, point}).r});
    };
    for (const SpringDescription::Point& it : from.path) add(it.on, it.point);
    if (from.kind == SpringKind::line)
      for (std::size_t e = 0; e < 2; ++e) add(from.between[e], from.points[e]);
    return path;
  }
  Spring::JointSum sum_of(const SpringDescription& from, const Topology& topology) const {
    Spring::JointSum sum;
    for (const auto& [name, factor] : from.terms) {
      const int i = joint_.at(name);
      const Joint::Leader own = joints_[i].leader.value_or(Joint::Leader{i, 1, 0});
      sum.terms.push_back({topology.iq[i], topology.iv[i], factor * own.ratio});
      sum.offset += factor * own.offset;
    }
    return sum;
  }

  /// The coordinate of a spring at q = 0, which is a length, an angle or a sum of joint coordinates.
  double drawn_coordinate(const Spring::Path& path) const {
    double length = 0;
    for (std::size_t k = 1; k < path.points.size(); ++k) {
      const Spring::Path::Point &a = path.points[k - 1], &b = path.points[k];
      length += norm(drawn(b.frame, {{}, b.point}).r - drawn(a.frame, {{}, a.point}).r);
    }
    return length;
  }
  double drawn_coordinate(const Spring::Torsion& torsion) const {
    const auto& [a, b] = torsion.ends;
    const Quaternion<> D = quaternion(transpose(drawn(a.frame, a.pose).R) * drawn(b.frame, b.pose).R);
    return 2 * std::atan2(D.z, D.w);
  }
  double drawn_coordinate(const Spring::JointSum& joints) const { return joints.offset; }
  double drawn_coordinate(const Spring::Bushing&) const { return 0; }

  /// Compiles spring k. If it has a preload, its length or angle of rest is computed from it, such that the
  /// spring has this force at q = 0 (D16.4); it is a fault if there is no such length or angle.
  Spring spring(std::size_t k, const Topology& topology, std::vector<Fault>& faults) const {
    const SpringDescription& from = description_.springs[k];
    Spring out{.name = spring_name(from, k), .geometry = Spring::Path{}, .law = {}};
    switch (from.kind) {
      case SpringKind::line:
      case SpringKind::tendon: out.geometry = path_of(from); break;
      case SpringKind::torsion: out.geometry = Spring::Torsion{ends_of(from)}; break;
      case SpringKind::joints: out.geometry = sum_of(from, topology); break;
      case SpringKind::bushing:
        out.geometry = Spring::Bushing{ends_of(from), orthonormal(from.rest_pose), from.K, from.C};
        return out;
    }
    out.law = force_law(from);
    if (!from.preload) return out;
    const double x = std::visit([&](const auto& it) { return drawn_coordinate(it); }, out.geometry);
    const double size = std::holds_alternative<Spring::Path>(out.geometry) ? std::abs(x) : 1;
    const auto deflection = deflection_at(out.law, *from.preload, size > 0 ? size : 1);
    if (deflection && finite(x - *deflection)) {
      out.law.rest = x - *deflection;
      return out;
    }
    faults.push_back(
        {Severity::error, Rule::wrong_value, spring_element(from, k),
         "has a preload of " + to_text(*from.preload) +
             ", which its law reaches at no deflection; give it a rest",
         from.source.file.empty() ? Source{expanded_.source.file, from.source.line} : from.source});
    return out;
  }

  /// The line of a drive as a path of two points, each given in the frame on which it is.
  Spring::Path line_of(const DriveDescription::Line& from) const {
    Spring::Path path;
    for (std::size_t e = 0; e < 2; ++e) {
      const int f = frame_.at(from.between[e]);
      path.points.push_back({f, in_frame(f, from.in, {{}, from.points[e]}).r});
    }
    return path;
  }

  /// Assigns the next free rows of the loop Jacobian and residuals to a loop joint or coupling.
  static void number(LoopRows& next, Loops& loops) {
    next.first_row = loops.rows;
    next.first_residual = loops.residuals;
    loops.rows += next.rows;
    loops.residuals += next.residuals;
    loops.all.push_back(next);
  }

  /// The loop joints, with their frames in the internal frames of bodies, and the couplings.
  Loops closed_loops(const Topology& topology) const {
    Loops loops;
    for (std::size_t k = 0; k < description_.loops.size(); ++k) {
      const LoopDescription& from = description_.loops[k];
      Loop loop;
      loop.name = loop_name(from, k);
      loop.kind = from.kind;
      loop.rows = traits(from.kind).rows;
      loop.residuals = traits(from.kind).residuals;
      loop.pitch = from.pitch;
      loop.wheel = from.wheel_axis.has_value();
      loop.radii = from.radii;
      const DrawnLoop drawn = from.frames ? DrawnLoop{*from.frames, size_of(from)} : drawn_loop(from);
      loop.size = drawn.size;
      for (std::size_t e = 0; e < 2; ++e) {
        const int f = frame_.at(from.between[e]), body = frames_[f].body;
        loop.ends[e] = {body, from.frames ? numbers_.frame_offset[f] * orthonormal(drawn.C[e])
                                          : relative(internal_[body], drawn.C[e])};
      }
      number(loop, loops);
      loops.joints.push_back(std::move(loop));
    }
    for (std::size_t k = 0; k < description_.couplings.size(); ++k) {
      const CouplingDescription& from = description_.couplings[k];
      double offset = from.offset;
      std::vector<LoopCoupling::Term> terms;
      for (const auto& [name, factor] : from.terms) {
        const int i = joint_.at(name);
        const Joint::Leader own = joints_[i].leader.value_or(Joint::Leader{i, 1, 0});
        terms.push_back({topology.iq[i], topology.iv[i], factor * own.ratio});
        offset -= factor * own.offset;
      }
      if (from.play > 0) {
        loops.backlashes.push_back(
            {coupling_name(from, k), std::move(terms), offset, from.play, from.restitution});
        continue;
      }
      LoopCoupling coupling;
      coupling.name = coupling_name(from, k);
      coupling.offset = offset;
      coupling.terms = std::move(terms);
      number(coupling, loops);
      loops.couplings.push_back(std::move(coupling));
    }
    loops.driven.assign(static_cast<std::size_t>(topology.nv), 0);
    for (int i = 1; i <= topology.n; ++i)
      if (!joints_[i].passive && !joints_[i].leader)
        with_subgroup(joints_[i].kind, joints_[i].pitch,
                      [&](const auto& s) { std::fill_n(loops.driven.begin() + topology.iv[i], s.nv, 1); });
    return loops;
  }

  /// Resolves chains of couplings: the ratio and the offset of each coupled joint, q = ratio q_leader +
  /// offset, become those for the last leader in the chain, which has a coordinate of its own.
  void couple() {
    std::unordered_map<std::string_view, int> index;
    for (int i = 1; i < n_bodies(); ++i) index.emplace(joints_[i].name, i);
    const auto coupling_of = [&](int i) -> const std::optional<Coupling>& {
      return expanded_.bodies[described_[i - 1]].joint.coupling;
    };
    for (int i = 1; i < n_bodies(); ++i) {
      std::vector<int> chain;
      int at = i;
      while (coupling_of(at) && !joints_[at].leader) {
        chain.push_back(at);
        at = index.at(coupling_of(at)->leader);
      }
      for (; !chain.empty(); chain.pop_back()) {
        const Coupling& own = *coupling_of(chain.back());
        const Joint::Leader next = joints_[at].leader.value_or(Joint::Leader{at, 1, 0});
        at = chain.back();
        joints_[at].leader =
            Joint::Leader{next.joint, own.ratio * next.ratio, own.ratio * next.offset + own.offset};
      }
    }
    for (const Joint& joint : joints_) {
      const Joint::Leader own = joint.leader.value_or(Joint::Leader{0, 1, 0});
      connections_.leader.push_back(own.joint);
      numbers_.ratio.push_back(own.ratio);
      numbers_.offset.push_back(own.offset);
    }
  }

  /// Numbers the coordinates and velocities of the joints, and adds up the armature, damping and friction of
  /// each velocity. A coupled joint shares the velocity of its leader and moves k times as fast, with the
  /// ratio k of the coupling. Its armature and damping are multiplied by k² and its friction by |k|, so that
  /// energy and power are the same.
  void number_joints(const Topology& topology) {
    numbers_.g = description_.gravity;
    for (std::vector<double>* terms : {&numbers_.armature, &numbers_.damping, &numbers_.friction})
      terms->assign(static_cast<std::size_t>(topology.nv), 0);
    for (int i = 1; i <= topology.n; ++i) {
      Joint& joint = joints_[i];
      joint.iq = topology.iq[i];
      joint.iv = topology.iv[i];
      if (!joint.leader)
        with_subgroup(joint.kind, joint.pitch, [&](const auto& s) {
          joint.nq = s.nq;
          joint.nv = s.nv;
        });
      const double k = numbers_.ratio[i];  // the coupled joint moves k times as fast as its leader; the sums
                                           // have equal energy and power
      for (std::size_t d = 0; d < joint.dof.size(); ++d) {
        const std::size_t c = static_cast<std::size_t>(joint.iv) + d;
        numbers_.armature[c] += k * k * joint.dof[d].armature;
        numbers_.damping[c] += k * k * joint.dof[d].damping;
        numbers_.friction[c] += std::abs(k) * joint.dof[d].friction;
      }
    }
  }

  /// Adds a fault about body i of the model; i = 0 stands for the mechanism.
  const Source& source_of(int i) const {
    return i > 0 ? expanded_.bodies[described_[i - 1]].source : expanded_.source;
  }
  void note(Compilation& out, const Source& at, Severity severity, Rule rule, std::string what,
            const char* says) const {
    const Source source = at.file.empty() ? Source{expanded_.source.file, at.line} : at;
    out.faults.push_back({severity, rule, std::move(what), says, source});
  }

  void report_loops_within_bodies(Compilation& out) const {
    for (std::size_t k = 0; k < description_.loops.size(); ++k) {
      const Loop& loop = out.loops.joints[k];
      if (loop.ends[0].body != loop.ends[1].body) continue;
      const LoopDescription& from = description_.loops[k];
      out.faults.push_back(
          {Severity::error, Rule::loop_within_body, "loop \"" + loop.name + '"',
           "is between \"" + from.between[0] + "\" and \"" + from.between[1] +
               "\", which do not move against each other",
           from.source.file.empty() ? Source{expanded_.source.file, from.source.line} : from.source});
    }
  }

  void report_massless_subtrees(Compilation& out) const {
    const Tree<double>& tree = out.tree;
    std::vector<double> mass(static_cast<std::size_t>(tree->n + 1));
    for (int i = tree->n; i > 0; --i) {
      mass[i] += tree.M[i].m;
      mass[tree->parent[i]] += mass[i];
    }
    std::vector<bool> moves_mass(mass.size());  // whether the joint, or a joint that follows it, moves
                                                // mass or has an armature
    for (int i = 1; i <= tree->n; ++i) {
      const Joint& joint = out.joints[i];
      const bool armature =
          std::any_of(joint.dof.begin(), joint.dof.end(), [](const Dof& d) { return d.armature > 0; });
      if (mass[i] > 0 || armature)
        moves_mass[joint.leader && joint.leader->ratio != 0 ? joint.leader->joint : i] = true;
    }
    const bool cut = !out.loops.empty();
    for (int i = 1; i <= tree->n; ++i)
      if (!moves_mass[i] && !out.joints[i].leader)
        note(out, source_of(i), cut ? Severity::error : Severity::warning, Rule::moves_no_mass,
             "joint \"" + out.joints[i].name + '"',
             cut ? "moves no mass when the loops are cut; cut them at another joint, or describe the body "
                   "that it moves as a rod"
                 : "moves no mass; the mass matrix is singular: give the body that it moves a mass, or the "
                   "joint an armature, or lock the joint, see reduced");
  }

  /// Reports finite numbers of the description that are so large that poses, inertias or points overflow.
  void report_overflow(Compilation& out) const {
    const Tree<double>& tree = out.tree;
    for (int i = 0; i <= tree->n; ++i) {
      const Body& body = out.bodies[i];
      if (!(finite(body.A) && finite(body.B) && finite(body.M) && finite(tree.B[i]) && finite(tree.M[i]) &&
            finite(tree.ratio[i]) && finite(tree.offset[i])))
        note(out, source_of(i), Severity::error, Rule::non_finite_number, "body \"" + body.name + '"',
             "its numbers are so large that its pose, inertia or coupling overflows");
    }
    for (std::size_t f = 0; f < out.frames.size(); ++f)
      if (!(finite(tree.frame_offset[f]) && finite(out.frames[f].pose)) &&
          finite(out.bodies[out.frames[f].body].A))
        note(out, source_of(out.frames[f].body), Severity::error, Rule::non_finite_number,
             "frame \"" + out.frames[f].name + '"', "its numbers are so large that its pose overflows");
    const std::vector<SpringDescription>& from = description_.springs;
    for (std::size_t k = 0; k < from.size(); ++k)
      if (const auto* path = std::get_if<Spring::Path>(&out.springs.elements[k].geometry))
        for (const Spring::Path::Point& it : path->points)
          if (!finite(it.point) && finite(tree.frame_offset[it.frame]))
            note(out, from[k].source, Severity::error, Rule::non_finite_number, spring_element(from[k], k),
                 "its numbers are so large that a point overflows");
    const auto fits = [](const Loop::End& end) { return finite(end.F) && finite(dot(end.F.r, end.F.r)); };
    for (std::size_t k = 0; k < out.loops.joints.size(); ++k)
      if (const Loop& loop = out.loops.joints[k]; !finite(loop.size) || !std::ranges::all_of(loop.ends, fits))
        note(out, description_.loops[k].source, Severity::error, Rule::non_finite_number,
             "loop \"" + loop.name + '"', "its numbers are so large that its frames overflow");
  }

  const Description& description_;
  const Description expanded_;
  const DepthFirstOrder order_;
  const std::vector<Placement> placements_;
  std::unordered_map<std::string_view, std::size_t> index_;
  std::unordered_map<std::string_view, int> frame_, joint_;  ///< indices in the model by names
  std::vector<Carried> on_;                                  ///< carrier of each body of the description
  std::vector<int> described_;  ///< indices in expanded_ of the bodies 1, 2, ... of the model
  // The vectors below have an entry for each body of the model, from the ground on, but for frames_ and
  // extra_.
  Connections connections_{.parent = {0}};
  TreeNumbers<double> numbers_{.frame_offset = {SE3<>{}}};
  std::vector<SE3<>> internal_{SE3<>{}};  ///< pose of the internal frame in the construction frame, q = 0
  std::vector<SE3<>> offset_;             ///< pose of the body frame in the internal frame
  std::vector<Body> bodies_;
  std::vector<Joint> joints_;
  std::vector<Frame> frames_;
  std::vector<std::pair<Frame, SE3<>>>
      extra_;  ///< named frames other than those of moving bodies, and their poses in internal frames
};

}  // namespace

Compilation compile(const Description& description) { return Compiler(description).run(); }

}  // namespace axode
