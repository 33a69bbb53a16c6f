#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <ostream>
#include <sstream>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "axode/io.hpp"
#include "axode/io/xml_text.hpp"
#include "axode/lie/quaternion.hpp"
#include "axode/model/placement.hpp"
#include "axode/model/shape_kinds.hpp"

namespace axode {
namespace {

using io::xml::text;

/// MuJoCo takes larger numbers for an error.
constexpr double no_limit = 1e10;
/// Of one body, in MuJoCo.
constexpr std::size_t most_joints = 6;
constexpr std::size_t deepest_indent = 20;
constexpr double realisability_tolerance = 1e-9;

std::string attribute(const char* name, const std::string& value) {
  return " " + std::string(name) + "=\"" + value + "\"";
}
std::string unless_zero(const char* name, double x) { return x == 0 ? "" : attribute(name, text(x)); }
bool bounded(const Dof& dof) { return std::isfinite(dof.lower) || std::isfinite(dof.upper); }

/// Position and rotation where they are not those of the frame that holds them.
std::string pose_text(const SE3<>& pose) {
  const Quaternion<> a = quaternion(pose.R);
  const bool turned = norm(Vec3<>{a.x, a.y, a.z}) > 0;
  return (norm(pose.r) > 0 ? attribute("pos", text(pose.r)) : "") +
         (turned ? attribute("quat", text(a.w) + " " + text(a.x) + " " + text(a.y) + " " + text(a.z)) : "");
}

/// Names that differ, made of those that were wished for.
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
  explicit MjcfWriter(const Description& description)
      : d_(expand(description)), order_(depth_first_order(d_)), at_(place(d_, order_)) {
    const auto n = d_.bodies.size();
    children_.resize(n), merged_.resize(n, 0), inherited_.resize(n);
    for (std::size_t i = 0; i < n; ++i) index_.emplace(d_.bodies[i].name, i);
    for (const int i : order_.order) {
      const int p = order_.predecessor[i];
      (p < 0 ? roots_ : children_[p]).push_back(i);
    }
  }

  void write(std::ostream& out) {
    hoist_free();
    merge_massless();
    find_faults();
    if (!faults_.empty()) throw ModelError(d_.name, std::move(faults_));
    name_bodies();
    for (const FrameDescription& frame : d_.frames) named_site(frame);
    for (std::size_t k = 0; k < d_.loops.size(); ++k) write_loop(d_.loops[k], k);
    for (const SpringDescription& spring : d_.springs) write_spring(spring);
    write_couplings();

    std::ostringstream bodies;
    write_shapes(bodies, "    ", d_.shapes);
    write_sites(bodies, "    ", "ground");
    for (const int i : roots_) write_tree(bodies, i);

    out << "<mujoco" << attribute("model", text(d_.name)) << ">\n";
    for (const std::string& what : left_out_) out << "  <!-- " << what << " -->\n";
    out << "  <compiler angle=\"radian\" inertiafromgeom=\"false\"/>\n  <option"
        << attribute("gravity", text(d_.gravity)) << "/>\n";
    section(out, "asset", assets_.str());
    section(out, "worldbody", bodies.str());
    section(out, "tendon", tendons_.str());
    section(out, "equality", equalities_.str());
    out << "</mujoco>\n";
  }

 private:
  static void section(std::ostream& out, const char* name, const std::string& content) {
    if (!content.empty()) out << "  <" << name << ">\n" << content << "  </" << name << ">\n";
  }
  void error(std::string element, std::string message, const Source& source) {
    faults_.push_back({Severity::error, Rule::wrong_value, std::move(element), std::move(message), source});
  }
  static const Source& source_of(const BodyDescription& body) {
    return body.joint.source.line > 0 ? body.joint.source : body.source;
  }

  // ---------------------------------------------------------------- free bodies, and several joints of a body

  /// MuJoCo has free joints of bodies on the world alone: one on what stands still is placed on it.
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

  /// A joint in the frame of the body that it moves together with others.
  struct Moves {
    int body;     ///< whose joint it is in the description
    SE3<> frame;  ///< the joint frame
  };

  /// MuJoCo has no massless bodies that move, but several joints of one body: a massless body that carries one other and
  /// that nobody asks about is left out, and its joints become those of the one that it carries.
  void merge_massless() {
    std::unordered_set<std::string> asked;
    for (const FrameDescription& frame : d_.frames) asked.insert(frame.body);
    for (const SpringDescription& spring : d_.springs)
      asked.insert(spring.between.begin(), spring.between.end());
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

  /// Whether bodies, with what is fixed to them, have mass.
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
    const std::vector<char> has_mass = with_mass();
    for (const int i : order_.order) {
      const BodyDescription& body = d_.bodies[i];
      const JointDescription& joint = body.joint;
      const std::string element = "joint \"" + joint.name + '"';
      const Source& source = source_of(body);
      if (joint.kind == JointKind::helical) error(element, "is helical; MJCF has no such joint", source);
      if (joint.kind == JointKind::free && order_.predecessor[i] >= 0)
        error(element,
              "is free and hangs on body \"" + body.predecessor + "\"; in MJCF it hangs on the world",
              source);
      if (joint.kind != JointKind::fixed && merged_[i] == 0 && has_mass[i] == 0)
        error("body \"" + body.name + '"', "moves and has no mass; MuJoCo refuses it", body.source);
      if (body.inertia && body.inertia->mass > 0 &&
          realisability(inertia_in({}, *body.inertia)) < -realisability_tolerance)
        error("body \"" + body.name + '"', "has an inertia that no density can produce; MuJoCo refuses it",
              body.source);
      joint_faults(joint, element, source);
    }
    for (std::size_t k = 0; k < d_.loops.size(); ++k)
      if (const LoopKind kind = d_.loops[k].kind;
          kind != LoopKind::fixed && kind != LoopKind::spherical && kind != LoopKind::revolute)
        error("loop \"" + loop_name(d_.loops[k], k) + '"',
              "is " + std::string(to_string(kind)) + "; MJCF has no such loop", d_.loops[k].source);
  }

  void joint_faults(const JointDescription& joint, const std::string& element, const Source& source) {
    if (std::ranges::any_of(joint.dof, [](const Dof& dof) { return dof.stop_stiffness != 0; }))
      error(element, "has elastic stops; MJCF has no word for them", source);
    if (joint.dof.size() < 2) return;
    if (std::ranges::any_of(joint.dof, bounded))
      error(element, "has several degrees of freedom with limits; MJCF has no word for them", source);
    const bool ball = joint.kind == JointKind::spherical;
    const Dof& first = joint.dof[0];
    for (std::size_t k = 1; k < joint.dof.size(); ++k) {
      const Dof &dof = joint.dof[k], &like = joint.kind == JointKind::planar ? joint.dof[1] : first;
      if (dof.damping != like.damping || dof.friction != like.friction || dof.armature != like.armature ||
          (ball && dof.stiffness != like.stiffness)) {
        error(element,
              "has degrees of freedom that differ; MJCF has one damping, friction, armature and "
              "stiffness for all of them",
              source);
        return;
      }
    }
    if (!ball && std::ranges::any_of(joint.dof, [](const Dof& dof) { return dof.stiffness != 0; }))
      error(element,
            "is " + std::string(to_string(joint.kind)) + " and has a spring; MJCF has another law for it",
            source);
  }

  // ---------------------------------------------------------------- bodies

  /// `world` is the name of MuJoCo's ground.
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
    if (body.inertia) write_inertial(out, inner, *body.inertia, at_[i].A);
    write_shapes(out, inner, body.shapes);
    write_sites(out, inner, body.name);
  }

  /// About the centre of mass, in the axes of the body.
  static void write_inertial(std::ostream& out, const std::string& indent, const MassProperties& given,
                             const SE3<>& A) {
    const MassProperties seen = seen_from(given.in == GivenIn::body_frame ? SE3<>{} : A, given);
    Sym3<> Theta = rotate(seen.axes, seen.Theta);
    if (given.about == InertiaAbout::frame_origin && given.mass > 0)
      Theta = inertia_about_com(Inertia<>{seen.mass, seen.mass * seen.com, Theta});
    // MuJoCo refuses principal moments below 1e-14, and one that is the sum of the others but for rounding.
    const EigenvalueRange moments = eigenvalue_range(Theta);
    const double least = 2e-14 + 1e-12 * moments.largest;
    const double more =
        std::max({0.0, least - moments.smallest, least - (trace(Theta) - 2 * moments.largest)});
    Theta.xx += more, Theta.yy += more, Theta.zz += more;
    out << indent << "<inertial" << attribute("pos", text(seen.com)) << attribute("mass", text(seen.mass));
    if (Theta.xy == 0 && Theta.xz == 0 && Theta.yz == 0) {
      out << attribute("diaginertia", text(Vec3<>{Theta.xx, Theta.yy, Theta.zz}));
    } else {
      out << attribute("fullinertia", text(Vec3<>{Theta.xx, Theta.yy, Theta.zz}) + " " +
                                          text(Vec3<>{Theta.xy, Theta.xz, Theta.yz}));
    }
    out << "/>\n";
  }

  void write_joint(std::ostream& out, const std::string& indent, const JointDescription& joint,
                   const SE3<>& frame) {
    const auto dof = [&](std::size_t k) { return k < joint.dof.size() ? joint.dof[k] : Dof{}; };
    const auto one = [&](const std::string& name, const char* type, const Vec3<>* axis, const Dof& its) {
      out << indent << "<joint" << attribute("name", text(name)) << attribute("type", type);
      if (type != std::string_view("free") && norm(frame.r) > 0) out << attribute("pos", text(frame.r));
      if (axis != nullptr) out << attribute("axis", text(*axis));
      if (bounded(its))
        out << attribute("range", text(std::clamp(its.lower, -no_limit, no_limit)) + " " +
                                      text(std::clamp(its.upper, -no_limit, no_limit)));
      const bool says_effort = axis != nullptr && its.effort > 0;
      if (std::isfinite(its.effort) && says_effort)
        out << attribute("actuatorfrcrange", text(-its.effort) + " " + text(its.effort));
      out << unless_zero("damping", its.damping) << unless_zero("frictionloss", its.friction)
          << unless_zero("armature", its.armature) << unless_zero("stiffness", its.stiffness)
          << unless_zero("springref", its.rest) << "/>\n";
      if (std::isfinite(its.velocity)) leave_out("velocity limits of joints");
      if (std::isfinite(its.effort) && !says_effort)
        leave_out("efforts of 0, and those of free and spherical joints");
    };
    switch (joint.kind) {
      case JointKind::revolute: return one(joint.name, "hinge", &frame.R.z, dof(0));
      case JointKind::prismatic: return one(joint.name, "slide", &frame.R.z, dof(0));
      case JointKind::spherical: return one(joint.name, "ball", nullptr, dof(0));
      case JointKind::free: return one(joint.name, "free", nullptr, dof(0));
      case JointKind::planar:
        one(joint.name + ".x", "slide", &frame.R.x, dof(1));
        one(joint.name + ".y", "slide", &frame.R.y, dof(2));
        return one(joint.name + ".angle", "hinge", &frame.R.z, dof(0));
      default: return;  // fixed
    }
  }

  // ---------------------------------------------------------------- shapes and frames

  void write_shapes(std::ostream& out, const std::string& indent,
                    const std::vector<ShapeDescription>& shapes) {
    for (const ShapeDescription& shape : shapes) {
      const bool mesh = shape.kind == ShapeKind::mesh;
      if (mesh && !opens(shape.file)) {
        leave_out("meshes that MuJoCo does not open");
        continue;
      }
      const bool ball =
          shape.kind == ShapeKind::sphere || (shape.kind == ShapeKind::capsule && shape.length == 0);
      out << indent << "<geom";
      if (!shape.name.empty()) out << attribute("name", text(geom_names_.free(shape.name)));
      out << attribute("type", ball ? "sphere" : std::string(to_string(shape.kind)));
      if (mesh) {
        out << attribute("mesh", text(asset(shape)));
      } else if (shape.kind == ShapeKind::box) {
        out << attribute("size", text(0.5 * shape.size));
      } else if (shape.kind == ShapeKind::ellipsoid) {
        out << attribute("size", text(shape.size));
      } else {
        out << attribute("size", text(shape.radius) + (ball ? "" : " " + text(0.5 * shape.length)));
      }
      out << pose_text(shape.pose);
      if (const auto& c = shape.color)
        out << attribute("rgba",
                         text((*c)[0]) + " " + text((*c)[1]) + " " + text((*c)[2]) + " " + text((*c)[3]));
      out << (shape.role == ShapeDescription::Role::visual ? R"( contype="0" conaffinity="0" group="2")"
                                                           : R"( group="3")")
          << "/>\n";
    }
  }
  /// Whether MuJoCo reads a file of that kind, from a folder.
  static bool opens(const std::string& file) {
    if (file.find("://") != std::string::npos) return false;
    const std::size_t dot = file.rfind('.');
    std::string ending = dot == std::string::npos ? "" : file.substr(dot);
    std::ranges::transform(ending, ending.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
    return ending == ".stl" || ending == ".obj" || ending == ".msh";
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
  /// A site on a body, at a pose in its frame.
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

  /// A site at a pose in the frame of a body, of a named frame, which is one itself, or of the ground.
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
      const DrawnLoop drawn = place(loop);
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
        tie("connect", name + ".axis", {{}, {0, 0, 1}});  // a second point on it
    }
  }

  void write_spring(const SpringDescription& spring) {
    const std::string name = "spring_" + std::to_string(++springs_);
    tendons_ << "    <spatial" << attribute("name", name) << attribute("stiffness", text(spring.stiffness))
             << attribute("springlength", text(spring.rest)) << unless_zero("damping", spring.damping) << ">";
    for (std::size_t e = 0; e < 2; ++e) {
      const Vec3<> point = spring.in == GivenIn::body_frame
                               ? spring.points[e]
                               : relative(pose_of_carrier(spring.between[e]), {{}, spring.points[e]}).r;
      tendons_ << "<site"
               << attribute("site", text(site_on(spring.between[e], name + (e == 0 ? ".first" : ".second"),
                                                 {{}, point})))
               << "/>";
    }
    tendons_ << "</spatial>\n";
  }

  void write_couplings() {
    for (const int i : order_.order)
      if (const JointDescription& joint = d_.bodies[i].joint; joint.coupling)
        write_equality(joint.name, &joint.coupling->leader, joint.coupling->offset, joint.coupling->ratio,
                       "");
    for (std::size_t k = 0; k < d_.couplings.size(); ++k) {
      const CouplingDescription& it = d_.couplings[k];
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
  /// q = offset + ratio q_leader.
  void write_equality(const std::string& joint, const std::string* leader, double offset, double ratio,
                      const std::string& name) {
    equalities_ << "    <joint" << name << attribute("joint1", text(joint));
    if (leader != nullptr) equalities_ << attribute("joint2", text(*leader));
    equalities_ << attribute("polycoef", text(offset) + " " + text(ratio) + " 0 0 0") << "/>\n";
  }

  void leave_out(const char* what) {
    const std::string sentence = std::string("Left out, for want of words: ") + what + ".";
    if (std::ranges::find(left_out_, sentence) == left_out_.end()) left_out_.push_back(sentence);
  }

  Description d_;
  DepthFirstOrder order_;
  std::vector<Placement> at_;
  std::unordered_map<std::string, std::size_t> index_;
  std::vector<std::vector<int>> children_;
  std::vector<int> roots_;
  std::vector<char> merged_;
  std::vector<std::vector<Moves>> inherited_;
  std::vector<Fault> faults_;
  std::size_t merged_above_ = 0;
  std::unordered_map<std::string, std::string> body_names_;
  std::unordered_map<std::string, std::pair<std::string, SE3<>>> on_body_;  ///< named frames
  std::unordered_map<std::string, std::string> sites_;                      ///< of each body
  std::map<std::string, std::string> meshes_;
  Names geom_names_{}, site_names_{};
  std::vector<std::string> left_out_;
  std::ostringstream assets_, tendons_, equalities_;
  int springs_ = 0;
};

}  // namespace

void write_mjcf(const Model& model, std::ostream& out) { MjcfWriter(model.description()).write(out); }

}  // namespace axode
