#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <ostream>
#include <sstream>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "axode/io.hpp"
#include "axode/io/mjcf/mjcf_terms.hpp"
#include "axode/io/writing.hpp"
#include "axode/io/xml_text.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/model/kinds/shape_kinds.hpp"

namespace axode {
namespace {

using io::bounded, io::xml::text;
using io::mjcf::attribute, io::mjcf::has_words_for, io::mjcf::inertial_element, io::mjcf::pose_text,
    io::mjcf::unless_zero, io::mjcf::in_mjcf, io::mjcf::joint_unsaid, io::mjcf::said, io::mjcf::shapes_unsaid,
    io::mjcf::contact_unsaid, io::mjcf::size_text, io::mjcf::friction_text;
using io::mjcf::springs_and_couplings_unsaid;

/// The largest limit that the writer writes, because MuJoCo treats larger numbers as errors.
constexpr double no_limit = 1e10;
/// The largest number of joints that one body can have in MuJoCo.
constexpr std::size_t most_joints = 6;
constexpr std::size_t deepest_indent = 20;
constexpr double realisability_tolerance = 1e-9;

/// A set of taken names. free() appends `_` to a name until it is not taken, then adds and returns it.
class Names {
 public:
  explicit Names(std::initializer_list<std::string> taken) : taken_(taken) {}
  std::string free(std::string name) {
    while (!taken_.insert(name).second) name += '_';
    return name;
  }

 private:
  std::unordered_set<std::string> taken_;
};

class MjcfWriter {
 public:
  MjcfWriter(const Description& description, Strictness strictness)
      : d_(expand(description)),
        order_(depth_first_order(d_)),
        at_(reference_placements(d_, order_)),
        unsaid_("MJCF", strictness) {
    const auto n = d_.bodies.size();
    children_.resize(n);
    merged_.resize(n, 0);
    inherited_.resize(n);
    for (std::size_t i = 0; i < n; ++i) index_.emplace(d_.bodies[i].name, i);
    for (const int i : order_.order) {
      const int p = order_.predecessor[i];
      (p < 0 ? roots_ : children_[p]).push_back(i);
    }
  }

  std::vector<Fault> write(std::ostream& out) {
    hoist_free();
    merge_massless();
    find_faults();
    unsaid_.throw_errors(d_.name);
    name_bodies();
    for (const FrameDescription& frame : d_.frames) named_site(frame);
    for (std::size_t k = 0; k < d_.loops.size(); ++k)
      if (in_mjcf(d_.loops[k].kind)) write_loop(d_.loops[k], k);
    for (const SpringDescription& spring : d_.springs)
      if (has_words_for(spring)) write_spring(spring);
    write_couplings();
    if (has_passive_joints()) write_motors();

    std::ostringstream bodies;
    write_shapes(bodies, "    ", d_.shapes, /*on_ground=*/true);
    write_sites(bodies, "    ", "ground");
    for (const int i : roots_) write_tree(bodies, i);

    out << "<mujoco" << attribute("model", text(d_.name)) << ">\n";
    out << "  <compiler angle=\"radian\" inertiafromgeom=\"false\"/>\n  <option"
        << attribute("gravity", text(d_.gravity)) << "/>\n";
    section(out, "asset", assets_.str());
    section(out, "worldbody", bodies.str());
    section(out, "tendon", tendons_.str());
    section(out, "equality", equalities_.str());
    section(out, "actuator", motors_.str());
    out << "</mujoco>\n";
    return std::move(unsaid_).warnings();
  }

 private:
  static void section(std::ostream& out, const char* name, const std::string& content) {
    if (!content.empty()) out << "  <" << name << ">\n" << content << "  </" << name << ">\n";
  }
  static const Source& source_of(const BodyDescription& body) {
    return body.joint.source.line > 0 ? body.joint.source : body.source;
  }

  // ---------------------------------------------------------------- free bodies, and several joints of a
  // body

  /// Attaches free joints on bodies that are fixed to the world to the world itself, as MuJoCo requires.
  void hoist_free() {
    for (auto it = order_.order.rbegin(); it != order_.order.rend(); ++it) {
      const int i = *it;
      if (d_.bodies[i].joint.kind != JointKind::free || order_.predecessor[i] < 0) continue;
      int root = order_.predecessor[i];
      while (d_.bodies[root].joint.kind == JointKind::fixed && order_.predecessor[root] >= 0)
        root = order_.predecessor[root];
      if (d_.bodies[root].joint.kind != JointKind::fixed) continue;
      std::erase(children_[order_.predecessor[i]], i);
      order_.predecessor[i] = -1;
      at_[i].B = at_[i].A;
      roots_.insert(std::ranges::find(roots_, root) + 1, i);
    }
  }

  /// One of the joints that a body has in MJCF.
  struct Moves {
    int body;     ///< body of the description whose joint it is
    SE3<> frame;  ///< pose of the joint frame in the frame of the MJCF body
  };

  /// Removes moving massless bodies, which MuJoCo refuses, and gives their joints to their child in addition
  /// to its own joint. A body is removed only if it has exactly one child, which moves relative to it, if no
  /// shape, frame, spring or loop is attached to it, and if the child then has at most most_joints joints,
  /// none of them free. Any other moving massless body remains; it is an error unless a body with mass is
  /// fixed to it.
  void merge_massless() {
    std::unordered_set<std::string> asked;
    for (const FrameDescription& frame : d_.frames) asked.insert(frame.body);
    for (const SpringDescription& spring : d_.springs) {
      asked.insert(spring.between.begin(), spring.between.end());
      for (const SpringDescription::Point& it : spring.path) asked.insert(it.on);
    }
    for (const LoopDescription& loop : d_.loops) asked.insert(loop.between.begin(), loop.between.end());
    for (const int i : order_.order) {
      const BodyDescription& body = d_.bodies[i];
      std::vector<Moves>& moves = inherited_[i];
      if (body.joint.kind != JointKind::fixed) moves.push_back({i, at_[i].S_self});
      if (body.inertia || !body.shapes.empty() || asked.contains(body.name) || children_[i].size() != 1 ||
          moves.empty() || moves.size() >= most_joints)
        continue;
      const int child = children_[i][0];
      if (d_.bodies[child].joint.kind == JointKind::fixed || d_.bodies[child].joint.kind == JointKind::free ||
          body.joint.kind == JointKind::free)
        continue;
      merged_[i] = 1;
      const SE3<> into = inverse(at_[child].B);
      for (const Moves& it : moves) inherited_[child].push_back({it.body, into * it.frame});
      at_[child].B = at_[i].B * at_[child].B;
      order_.predecessor[child] = order_.predecessor[i];
    }
  }

  /// For each body whether it, or a body that is fixed to it, has mass.
  std::vector<char> with_mass() const {
    std::vector<char> has(d_.bodies.size(), 0);
    for (auto i = order_.order.rbegin(); i != order_.order.rend(); ++i) {
      if (d_.bodies[*i].inertia && d_.bodies[*i].inertia->mass > 0) has[*i] = 1;
      const int p = order_.predecessor[*i];
      if (has[*i] != 0 && p >= 0 && d_.bodies[*i].joint.kind == JointKind::fixed) has[p] = 1;
    }
    return has;
  }

  // ---------------------------------------------------------------- what MJCF has no words for

  void find_faults() {
    unsaid_.leave_out_motions(d_);
    const std::vector<char> has_mass = with_mass();
    shapes_unsaid(d_.shapes, "the ground", true, d_.source, unsaid_);
    contact_unsaid(d_.contact, unsaid_);
    springs_and_couplings_unsaid(d_, unsaid_);
    for (const int i : order_.order) {
      const BodyDescription& body = d_.bodies[i];
      const JointDescription& joint = body.joint;
      const std::string element = "joint \"" + joint.name + '"', its_body = "body \"" + body.name + '"';
      const Source& source = source_of(body);
      const bool known = in_mjcf(joint.kind) != nullptr;
      if (!known)
        unsaid_.refuse(element, "is " + std::string(to_string(joint.kind)) + "; MJCF has no such joint",
                       source);
      if (joint.kind == JointKind::free && order_.predecessor[i] >= 0)
        unsaid_.refuse(
            element, "is free and hangs on body \"" + body.predecessor + "\"; in MJCF it hangs on the world",
            source);
      if (joint.kind != JointKind::fixed && merged_[i] == 0 && has_mass[i] == 0)
        unsaid_.refuse(its_body, "moves and has no mass; MuJoCo refuses it", body.source);
      if (body.inertia && body.inertia->mass > 0 &&
          realisability(inertia_in({}, *body.inertia)) < -realisability_tolerance)
        unsaid_.refuse(its_body, "has an inertia that no density can produce; MuJoCo refuses it",
                       body.source);
      if (known) joint_unsaid(joint, element, source, unsaid_);
      shapes_unsaid(body.shapes, its_body, false, body.source, unsaid_);
    }
    if (has_passive_joints() &&
        std::ranges::none_of(d_.bodies, [&](const BodyDescription& body) { return has_drive(body.joint); }))
      for (const BodyDescription& body : d_.bodies)
        if (has_none(body.joint))
          unsaid_.leave_out("joint \"" + body.joint.name + '"', "is passive, as all joints are",
                            source_of(body));
    for (std::size_t k = 0; k < d_.loops.size(); ++k)
      if (!in_mjcf(d_.loops[k].kind))
        unsaid_.leave_out("loop \"" + loop_name(d_.loops[k], k) + '"',
                          "is " + std::string(to_string(d_.loops[k].kind)), d_.loops[k].source);
  }

  // ---------------------------------------------------------------- bodies

  /// Chooses the names of bodies. No body can be called `world`, which is the name of the ground in MuJoCo.
  void name_bodies() {
    Names names{"world"};
    for (const int i : order_.order)
      if (merged_[i] == 0) body_names_[d_.bodies[i].name] = names.free(d_.bodies[i].name);
  }

  void write_tree(std::ostream& out, int root) {
    struct Open {
      int body;
      std::size_t next_child;
    };
    std::vector<Open> open;
    const auto indent = [&] {
      return std::string(4 + 2 * std::min(open.size() - 1 - merged_above_, deepest_indent), ' ');
    };
    open.push_back({root, 0});
    begin_body(out, root, indent());
    while (!open.empty()) {
      const int body = open.back().body;
      if (open.back().next_child < children_[body].size()) {
        const int child = children_[body][open.back().next_child++];
        merged_above_ += merged_[body];
        open.push_back({child, 0});
        begin_body(out, child, indent());
      } else {
        if (merged_[body] == 0) out << indent() << "</body>\n";
        open.pop_back();
        if (!open.empty()) merged_above_ -= merged_[open.back().body];
      }
    }
  }

  void begin_body(std::ostream& out, int i, const std::string& indent) {
    if (merged_[i] != 0) return;
    const BodyDescription& body = d_.bodies[i];
    const std::string inner = indent + "  ";
    out << indent << "<body" << attribute("name", text(body_names_.at(body.name))) << pose_text(at_[i].B)
        << ">\n";
    for (const Moves& it : inherited_[i]) write_joint(out, inner, d_.bodies[it.body].joint, it.frame);
    if (body.inertia) out << inner << inertial_element(*body.inertia, at_[i].A);
    write_shapes(out, inner, body.shapes, false);
    write_sites(out, inner, body.name);
  }

  void write_joint(std::ostream& out, const std::string& indent, const JointDescription& joint,
                   const SE3<>& frame) {
    const std::vector<Dof> dof = said(joint);
    for (const auto& [type, ending, axis, d] : in_mjcf(joint.kind)->used_parts()) {
      const Dof& its = dof[static_cast<std::size_t>(d)];
      out << indent << "<joint" << attribute("name", text(joint.name + std::string(ending)))
          << attribute("type", std::string(type));
      if (type != "free" && norm(frame.r) > 0) out << attribute("pos", text(frame.r));
      if (type == "hinge" || type == "slide") out << attribute("axis", text(subgroup::axis(frame.R, axis)));
      if (bounded(its))
        out << attribute("range", text(std::clamp(its.lower, -no_limit, no_limit)) + " " +
                                      text(std::clamp(its.upper, -no_limit, no_limit)));
      if (std::isfinite(its.effort))
        out << attribute("actuatorfrcrange", text(-its.effort) + " " + text(its.effort));
      out << unless_zero("damping", its.damping) << unless_zero("frictionloss", its.friction)
          << unless_zero("armature", its.armature) << unless_zero("stiffness", its.stiffness)
          << unless_zero("springref", its.rest) << "/>\n";
    }
  }

  // ---------------------------------------------------------------- shapes and frames

  void write_shapes(std::ostream& out, const std::string& indent, const std::vector<ShapeDescription>& shapes,
                    bool on_ground) {
    for (const ShapeDescription& shape : shapes) {
      if (!has_words_for(shape, on_ground)) continue;
      out << indent << "<geom";
      if (!shape.name.empty()) out << attribute("name", text(geom_names_.free(shape.name)));
      if (shape.kind == ShapeKind::mesh)
        out << attribute("type", "mesh") << attribute("mesh", text(asset(shape)));
      else
        out << size_text(shape);
      out << pose_text(shape.pose) << friction_text(shape, d_.contact);
      if (const auto& c = shape.color)
        out << attribute("rgba",
                         text((*c)[0]) + " " + text((*c)[1]) + " " + text((*c)[2]) + " " + text((*c)[3]));
      out << (shape.role == ShapeDescription::Role::visual ? R"( contype="0" conaffinity="0" group="2")"
                                                           : R"( group="3")")
          << "/>\n";
    }
  }
  std::string asset(const ShapeDescription& shape) {
    const std::string key = shape.file + '\n' + text(shape.scale);
    if (const auto known = meshes_.find(key); known != meshes_.end()) return known->second;
    const std::string name = "mesh_" + std::to_string(meshes_.size() + 1);
    assets_ << "    <mesh" << attribute("name", name) << attribute("file", text(shape.file))
            << (norm(shape.scale - Vec3<>{1, 1, 1}) > 0 ? attribute("scale", text(shape.scale)) : "")
            << "/>\n";
    return meshes_[key] = name;
  }

  SE3<> pose_of(const std::string& body) const {
    const auto found = index_.find(body);
    return found == index_.end() ? SE3<>{} : at_[found->second].A;
  }
  /// Adds a site to a body, at a pose in the body frame, and returns its name, see Names::free().
  std::string site(const std::string& body, const std::string& wished, const SE3<>& pose) {
    const std::string name = site_names_.free(wished);
    sites_[body] += "<site" + attribute("name", text(name)) + pose_text(pose) + "/>\n";
    return name;
  }
  void named_site(const FrameDescription& frame) {
    const SE3<> pose = frame.in == GivenIn::body_frame
                           ? orthonormal(frame.pose)
                           : relative(pose_of(frame.body), orthonormal(frame.pose));
    on_body_.emplace(frame.name, std::pair{frame.body, pose});
    site(frame.body, frame.name, pose);
  }
  void write_sites(std::ostream& out, const std::string& indent, const std::string& body) {
    std::istringstream all(sites_[body]);
    for (std::string line; std::getline(all, line);) out << indent << line << '\n';
  }

  // ---------------------------------------------------------------- loops, springs, couplings

  /// Returns the name of a site (MJCF's word for a named frame) at a pose in the frame `carrier`, which is a
  /// body, the ground or a named frame. If the pose is that of a named frame, its site is used; otherwise a
  /// site is added, if possible with the name `wished`.
  std::string site_on(const std::string& carrier, const std::string& wished, const SE3<>& pose) {
    const auto named = on_body_.find(carrier);
    if (named == on_body_.end()) return site(carrier, wished, pose);
    const auto& [body, frame] = named->second;
    return pose_text(pose).empty() ? carrier : site(body, wished, frame * pose);
  }
  SE3<> pose_of_carrier(const std::string& carrier) const {
    const auto named = on_body_.find(carrier);
    return named == on_body_.end() ? pose_of(carrier) : pose_of(named->second.first) * named->second.second;
  }

  void write_loop(const LoopDescription& loop, std::size_t k) {
    std::array<SE3<>, 2> frames{};
    if (loop.frames) {
      frames = *loop.frames;
    } else {
      const DrawnLoop drawn = drawn_loop(loop);
      for (std::size_t e = 0; e < 2; ++e) frames[e] = relative(pose_of_carrier(loop.between[e]), drawn.C[e]);
    }
    const std::string name = loop_name(loop, k);
    const auto tie = [&](const char* how, const std::string& its_name, const SE3<>& offset) {
      const std::string first = site_on(loop.between[0], its_name + ".first", frames[0] * offset),
                        second = site_on(loop.between[1], its_name + ".second", frames[1] * offset);
      equalities_ << "    <" << how << attribute("name", text(its_name)) << attribute("site1", text(first))
                  << attribute("site2", text(second)) << "/>\n";
    };
    if (loop.kind == LoopKind::fixed) {
      tie("weld", name, {});
    } else {
      tie("connect", name, {});
      if (loop.kind == LoopKind::revolute)
        tie("connect", name + ".axis", {{}, {0, 0, 1}});  // a second point on the axis
    }
  }

  void write_spring(const SpringDescription& spring) {
    const std::string name = "spring_" + std::to_string(++springs_);
    tendons_ << "    <spatial" << attribute("name", name) << attribute("stiffness", text(spring.stiffness))
             << attribute("springlength", text(spring.rest)) << unless_zero("damping", spring.damping) << ">";
    const auto pass = [&](const std::string& on, const Vec3<>& given, const std::string& suffix) {
      const Vec3<> point =
          spring.in == GivenIn::body_frame ? given : relative(pose_of_carrier(on), {{}, given}).r;
      tendons_ << "<site" << attribute("site", text(site_on(on, name + suffix, {{}, point}))) << "/>";
    };
    if (spring.kind == SpringKind::line) {
      pass(spring.between[0], spring.points[0], ".first");
      pass(spring.between[1], spring.points[1], ".second");
    }
    for (std::size_t k = 0; k < spring.path.size(); ++k)
      pass(spring.path[k].on, spring.path[k].point, ".point_" + std::to_string(k + 1));
    tendons_ << "</spatial>\n";
  }

  void write_couplings() {
    for (const int i : order_.order)
      if (const JointDescription& joint = d_.bodies[i].joint; joint.coupling)
        write_equality(joint.name, &joint.coupling->leader, joint.coupling->offset, joint.coupling->ratio,
                       "");
    for (std::size_t k = 0; k < d_.couplings.size(); ++k) {
      const CouplingDescription& it = d_.couplings[k];
      if (it.play > 0) continue;
      const std::string name = coupling_name(it, k);
      const auto& [joint, factor] = it.terms[0];
      if (it.terms.size() <= 2) {
        const bool alone = it.terms.size() == 1;
        write_equality(joint, alone ? nullptr : &it.terms[1].first, it.offset / factor,
                       alone ? 0 : -it.terms[1].second / factor, attribute("name", text(name)));
        continue;
      }
      tendons_ << "    <fixed" << attribute("name", text(name)) << ">";
      for (const auto& [each, its_factor] : it.terms)
        tendons_ << "<joint" << attribute("joint", text(each)) << attribute("coef", text(its_factor)) << "/>";
      tendons_ << "</fixed>\n";
      equalities_ << "    <tendon" << attribute("name", text(name)) << attribute("tendon1", text(name))
                  << attribute("polycoef", text(it.offset) + " 0 0 0 0") << "/>\n";
    }
  }
  /// Writes the equality q = offset + ratio q_leader of a joint, or q = offset if `leader` is null.
  void write_equality(const std::string& joint, const std::string* leader, double offset, double ratio,
                      const std::string& name) {
    equalities_ << "    <joint" << name << attribute("joint1", text(joint));
    if (leader != nullptr) equalities_ << attribute("joint2", text(*leader));
    equalities_ << attribute("polycoef", text(offset) + " " + text(ratio) + " 0 0 0") << "/>\n";
  }

  // ---------------------------------------------------------------- drives

  static bool moves_on_its_own(const JointDescription& joint) {
    return joint.kind != JointKind::fixed && !joint.coupling;
  }
  bool has_drive(const JointDescription& joint) const {
    return moves_on_its_own(joint) && !is_passive(joint, d_);
  }
  bool has_none(const JointDescription& joint) const {
    return moves_on_its_own(joint) && is_passive(joint, d_);
  }
  /// Whether some joints have no drive. Then the others get actuators, by which readers recognise drives.
  bool has_passive_joints() const {
    return std::ranges::any_of(d_.bodies, [&](const BodyDescription& body) { return has_none(body.joint); });
  }
  /// Writes a motor for each velocity of the joints that have drives.
  void write_motors() {
    Names names{};
    const auto motor = [&](const std::string& joint, const std::string& suffix, const char* gear) {
      motors_ << "    <motor" << attribute("name", text(names.free(joint + suffix)))
              << attribute("joint", text(joint)) << (gear[0] == '\0' ? "" : attribute("gear", gear))
              << "/>\n";
    };
    constexpr std::array axes{"1 0 0 0 0 0", "0 1 0 0 0 0", "0 0 1 0 0 0",
                              "0 0 0 1 0 0", "0 0 0 0 1 0", "0 0 0 0 0 1"};
    for (const int i : order_.order) {
      const JointDescription& joint = d_.bodies[i].joint;
      if (!has_drive(joint)) continue;
      const std::size_t nv = static_cast<std::size_t>(traits(joint.kind).dof);
      const io::mjcf::JointInMjcf& in = *in_mjcf(joint.kind);
      if (nv == 1 || in.has_several_parts()) {
        for (const io::mjcf::JointPart& part : in.used_parts())
          motor(joint.name + std::string(part.ending), "", "");
      } else {
        for (std::size_t k = 0; k < nv; ++k) motor(joint.name, "." + std::to_string(k + 1), axes[k]);
      }
    }
  }

  Description d_;
  DepthFirstOrder order_;
  std::vector<Placement> at_;
  std::unordered_map<std::string, std::size_t> index_;
  std::vector<std::vector<int>> children_;
  std::vector<int> roots_;
  std::vector<char> merged_;
  std::vector<std::vector<Moves>> inherited_;
  io::Unsaid unsaid_;
  std::size_t merged_above_ = 0;
  std::unordered_map<std::string, std::string> body_names_;
  std::unordered_map<std::string, std::pair<std::string, SE3<>>> on_body_;  ///< body and pose of named frames
  std::unordered_map<std::string, std::string> sites_;                      ///< site elements by body
  std::map<std::string, std::string> meshes_;
  Names geom_names_{}, site_names_{};
  std::ostringstream assets_, tendons_, equalities_, motors_;
  int springs_ = 0;
};

}  // namespace

std::vector<Fault> write_mjcf(const Model& model, std::ostream& out, Strictness strictness) {
  return MjcfWriter(model.description(), strictness).write(out);
}

}  // namespace axode
