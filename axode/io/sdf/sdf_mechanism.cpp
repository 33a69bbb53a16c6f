#include "axode/io/sdf/sdf_mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

#include "axode/model/building/placement.hpp"
#include "axode/model/kinds/joint_kinds.hpp"

namespace axode::io {

/// Finds the link to which frame `name` of an SDF file is fixed, and returns its index, or -1 for the world
/// and for static models. Joint c names this frame as its parent, child or reference body, which `role` says
/// in messages. The result is empty if the name is empty or, with a fault, if there is no such frame.
std::optional<int> SdfMechanism::link_meant(const Connection& c, const std::string& name, const char* role) {
  if (name.empty()) return std::nullopt;
  const int model = frames_[c.frame].model, frame = frames_.find(model, name);
  if (frame < 0) {
    error(Rule::unknown_predecessor, "joint \"" + c.name + '"',
          std::string("its ") + role + " is " + in_quotes(name) + ", which is not described" +
              frames_.nearest(model, name),
          c.line);
    return std::nullopt;
  }
  const auto link = link_of_frame_.find(frames_[frame].moves_with);
  return link == link_of_frame_.end() || links_[static_cast<std::size_t>(link->second)].is_static
             ? -1
             : link->second;
}

void SdfMechanism::assemble() {
  for (Link& it : links_) it.body.name = named_here(it.body.name, it.body.source.line);
  std::erase_if(connections_, [this](const Connection& c) {
    if (c.is_static) ignore("joint of a static model", c.line);
    return c.is_static;
  });
  std::erase_if(connections_, [this](Connection& c) { return !connect(c); });
  for (std::size_t k = 0; k < connections_.size(); ++k)
    connection_of_frame_.emplace(connections_[k].frame, k);
  const std::vector<std::size_t> roots = grow_tree();
  for (std::size_t k = 0; k < connections_.size(); ++k)
    if (const Connection& c = connections_[k]; c.in_tree && c.kind->kind == JointKind::revolute)
      hinges_.emplace(std::minmax(c.from, c.to), k);
  add_roots(roots);
  for (const Connection& c : connections_)
    if (c.in_tree) add_body(c);
  for (const Connection& c : connections_) {
    if (c.kind->type == "gearbox") {
      add_gearbox(c);
    } else if (!c.in_tree) {
      add_loop(c);
    }
    add_couplings(c);
  }
  for (const int k : named_frames_) add_frame(k);
}

/// The name of a body or frame; `ground`, the inertial frame here, is replaced, with a warning.
std::string SdfMechanism::named_here(const std::string& name, int line) {
  if (name != "ground") return name;
  std::string other = name;
  for (int k = 2; other == name || frames_.find(0, (models_at_top_ == 1 ? top_ : "") + other) >= 0; ++k)
    other = name + "_" + std::to_string(k);
  note(Severity::warning, Rule::duplicate_name, in_quotes(name),
       "is called " + in_quotes(other) + " here, where \"ground\" is the inertial frame", line);
  return other;
}

/// Finds the parent and child links of a joint. Returns false, and adds a fault, if they cannot be connected.
bool SdfMechanism::connect(Connection& c) {
  const std::string owner = "joint \"" + c.name + '"';
  const auto parent = link_meant(c, c.parent, "parent"), child = link_meant(c, c.child, "child");
  if (!parent || !child) return false;
  c.from = *parent;
  c.to = *child;
  if (c.to < 0) {
    error(Rule::unknown_predecessor, owner,
          "its child is the world, or fixed to it; the world must be the parent", c.line);
  } else if (c.from == c.to) {
    error(Rule::cycle, owner, "its parent and its child are both link \"" + link(c.to).body.name + '"',
          c.line);
  }
  return c.to >= 0 && c.from != c.to;
}

/// Chooses the joints of the spanning tree and returns its root links, one for each group of links that no
/// joint connects to the world. The tree grows from the world and the roots by one joint and one link at a
/// time. Of the joints from a parent link in the tree to a child link outside it, the first one in the file
/// is taken. Only if there is none, a joint with its child in the tree and its parent outside is taken, and
/// is reversed. All other joints close loops, except gearboxes, which couple two joints.
std::vector<std::size_t> SdfMechanism::grow_tree() {
  std::vector<std::vector<std::size_t>> joints_at(links_.size() + 1);  // the last entry is the world
  const auto at = [&](int k) { return k < 0 ? links_.size() : static_cast<std::size_t>(k); };
  std::vector<char> is_child(links_.size(), 0), reached(links_.size() + 1, 0);
  for (std::size_t k = 0; k < connections_.size(); ++k) {
    const Connection& c = connections_[k];
    if (c.kind->type == "gearbox") continue;
    joints_at[at(c.from)].push_back(k);
    joints_at[at(c.to)].push_back(k);
    is_child[at(c.to)] = 1;
  }
  using Step = std::pair<bool, std::size_t>;  // whether the joint is reversed, and its number
  std::priority_queue<Step, std::vector<Step>, std::greater<>> ahead;
  const auto reach = [&](std::size_t k) {
    reached[k] = 1;
    for (const std::size_t j : joints_at[k]) ahead.emplace(at(connections_[j].to) == k, j);
  };
  const auto follow = [&] {
    while (!ahead.empty()) {
      const auto [reversed, j] = ahead.top();
      ahead.pop();
      Connection& c = connections_[j];
      const std::size_t next = at(reversed ? c.from : c.to);
      if (reached[next] != 0) continue;
      c.in_tree = true;
      c.reversed = reversed;
      reach(next);
    }
  };
  std::vector<std::size_t> roots;
  reach(links_.size());
  follow();
  for (const bool with_parent : {false, true})
    for (std::size_t k = 0; k < links_.size(); ++k)
      if (reached[k] == 0 && !links_[k].is_static && (is_child[k] != 0) == with_parent) {
        roots.push_back(k);
        reach(k);
        follow();
      }
  return roots;
}

/// Adds the root links with free joints on the ground, and static models as named frames and ground shapes.
void SdfMechanism::add_roots(const std::vector<std::size_t>& roots) {
  const bool name_is_free =
      std::ranges::none_of(connections_, [](const Connection& c) { return c.name == "free_base"; });
  for (const std::size_t k : roots) {
    Link& root = links_[k];
    root.body.joint = {.name = roots.size() == 1 && name_is_free ? "free_base" : "",
                       .kind = JointKind::free,
                       .source = root.body.source};
    root.body.geometry = InBodyFrame{frames_[root.frame].pose};
    add(root);
  }
  for (Link& it : links_) {
    if (!it.is_static) continue;
    const SE3<>& A = frames_[it.frame].pose;
    description().frames.push_back(
        {.name = it.body.name, .body = "ground", .pose = A, .source = it.body.source});
    for (ShapeDescription& shape : it.body.shapes) {
      shape.pose = A * shape.pose;
      description().shapes.push_back(std::move(shape));
    }
  }
}

void SdfMechanism::add(Link& link) {
  const std::string name = link.body.name;
  description().bodies.push_back(std::move(link.body));
  link.body.name = name;
}

/// The components of axis `number` of a joint in world axes. If the frame in which the axis is expressed does
/// not exist, a fault is added.
Vec3<> SdfMechanism::axis_of(const Connection& c, std::size_t number) {
  const Axis& axis = c.axes[number];
  int in = c.frame;
  if (!axis.expressed_in.empty()) {
    const int model = frames_[c.frame].model;
    in = frames_.find(model, axis.expressed_in);
    if (in < 0) {
      error(Rule::unknown_frame_body, "joint \"" + c.name + '"',
            "an axis is expressed in " + in_quotes(axis.expressed_in) + ", which is not described" +
                frames_.nearest(model, axis.expressed_in),
            c.line);
      in = c.frame;
    }
  }
  return frames_[in].pose.R * axis.xyz;
}

void SdfMechanism::add_body(const Connection& c) {
  const int moved = c.reversed ? c.from : c.to, carrier = c.reversed ? c.to : c.from;
  Link& it = link(moved);
  const SE3<>& A = frames_[it.frame].pose;
  const SE3<> A_carrier = carrier < 0 ? SE3<>{} : frames_[link(carrier).frame].pose;
  it.body.predecessor = carrier < 0 ? "ground" : link(carrier).body.name;
  it.body.geometry = InBodyFrame{relative(A_carrier, A)};
  JointDescription& joint = it.body.joint;
  joint = {.name = c.name, .kind = c.kind->kind, .pitch = c.pitch, .source = {file_, c.line}};
  const int dof = traits(joint.kind).dof;
  joint.point = relative(A, frames_[c.frame].pose).r;
  if (traits(joint.kind).has("axis")) {
    // In a reversed joint the order of the two axes is exchanged, and the axes have the opposite directions.
    const auto in_body = [&](std::size_t k) {
      const Vec3<> axis = transpose(A.R) * axis_of(c, k);
      return c.reversed ? -axis : axis;
    };
    const std::size_t first = c.reversed && dof == 2 ? 1 : 0;
    joint.axis = in_body(first);
    joint.dof = {c.axes[first].dof};
    if (dof == 2) {
      joint.second_axis = in_body(1 - first);
      joint.dof.push_back(c.axes[1 - first].dof);
    }
  }
  if (dof == 1 && c.axes[0].mimic)
    joint.coupling =
        Coupling{coordinate_of(c, *c.axes[0].mimic), c.axes[0].mimic->ratio, c.axes[0].mimic->offset};
  add(it);
}

void SdfMechanism::add_loop(const Connection& c) {
  LoopDescription loop{.name = c.name, .kind = c.kind->loop, .pitch = c.pitch, .source = {file_, c.line}};
  loop.between = {c.from < 0 ? "ground" : link(c.from).body.name, link(c.to).body.name};
  loop.point = frames_[c.frame].pose.r;
  if (traits(c.kind->kind).has("axis")) loop.axis = axis_of(c, 0);
  if (traits(loop.kind).has("second_axis")) loop.second_axis = axis_of(c, 1);
  const auto says_more = [](const Axis& axis) {
    const Dof& d = axis.dof;
    return std::isfinite(d.lower) || std::isfinite(d.upper) || d.damping != 0 || d.friction != 0 ||
           d.stiffness != 0 || axis.mimic;
  };
  if (std::ranges::any_of(c.axes, says_more))
    note(Severity::warning, Rule::unknown_element, "joint \"" + c.name + '"',
         "closes a loop and has no coordinate; its limits, dynamics and mimics are not carried over", c.line);
  description().loops.push_back(std::move(loop));
}

/// The name of the joint of the description about the first or the second axis of a joint c that is a chain.
std::string SdfMechanism::name_about_axis(const Connection& c, bool second) {
  const JointChain& chain = *traits(c.kind->kind).chain;
  return c.name + "." + std::string(second != c.reversed ? chain.second_name : chain.first_name);
}

/// The name of the joint of the description whose coordinate the mimic of joint c follows.
std::string SdfMechanism::coordinate_of(const Connection& c, const Mimic& mimic) {
  const auto found = connection_of_frame_.find(frames_.find(frames_[c.frame].model, mimic.leader));
  if (found == connection_of_frame_.end()) return mimic.leader;
  const Connection& leader = connections_[found->second];
  return traits(leader.kind->kind).chain ? name_about_axis(leader, mimic.axis == "axis2") : leader.name;
}

/// Adds a coupling for each axis with a mimic of a joint c that is a chain. Does nothing for other joints.
void SdfMechanism::add_couplings(const Connection& c) {
  if (!traits(c.kind->kind).chain || !c.in_tree) return;
  for (std::size_t k = 0; k < 2; ++k) {
    if (!c.axes[k].mimic) continue;
    const Mimic& mimic = *c.axes[k].mimic;
    CouplingDescription coupling{.offset = mimic.offset, .source = {file_, mimic.line}};
    coupling.terms = {{name_about_axis(c, k == 1), 1}, {coordinate_of(c, mimic), -mimic.ratio}};
    description().couplings.push_back(std::move(coupling));
  }
}

/// Adds a gearbox: relative to the reference body the child turns by -ratio times the angle of the parent.
void SdfMechanism::add_gearbox(const Connection& c) {
  const auto reference = link_meant(c, c.gear_reference, "reference body");
  if (!reference) return;
  CouplingDescription gears{.name = c.name, .source = {file_, c.line}};
  const std::array<std::pair<int, double>, 2> sides{{{c.from, c.gear_ratio}, {c.to, 1.0}}};
  for (std::size_t k = 0; k < 2; ++k) {
    const auto& [turning, factor] = sides[k];
    const Vec3<> axis = axis_of(c, k);
    const auto found = hinges_.find(std::minmax(*reference, turning));
    const Connection* hinge = found == hinges_.end() ? nullptr : &connections_[found->second];
    const Vec3<> its = hinge == nullptr ? Vec3<>{} : axis_of(*hinge, 0);
    if (hinge == nullptr || !(norm(cross(its, axis)) <= 1e-6 * norm(its) * norm(axis))) {
      error(Rule::coupling_kind, "joint \"" + c.name + '"',
            "is a gearbox; its " + std::string(k == 0 ? "parent" : "child") +
                " needs a revolute joint of the same axis to the reference body",
            c.line);
      return;
    }
    const double along = (dot(its, axis) < 0) == (hinge->from == *reference) ? -1 : 1;
    gears.terms.emplace_back(hinge->name, along * factor);
  }
  description().couplings.push_back(std::move(gears));
}

void SdfMechanism::add_frame(int number) {
  const SdfFrames::Frame& frame = frames_[number];
  const auto carrier = link_of_frame_.find(frame.moves_with);
  FrameDescription named{
      .name = named_here(shown(frame.path), frame.line), .body = "ground", .source = {file_, frame.line}};
  named.pose = frame.pose;
  if (carrier != link_of_frame_.end() && !link(carrier->second).is_static) {
    named.body = link(carrier->second).body.name;
    named.pose = relative(frames_[link(carrier->second).frame].pose, frame.pose);
  }
  description().frames.push_back(std::move(named));
}

void SdfMechanism::finish_shapes() {
  for (Link& link : links_)
    for (std::size_t k = 0; k < link.body.shapes.size(); ++k) {
      const std::string& other = link.shape_frames[k];
      if (other.empty()) continue;
      const int model = frames_[link.frame].model, found = frames_.find(model, other);
      if (found < 0) {
        error(Rule::unknown_frame_body, "link \"" + link.body.name + '"',
              "the pose of a shape is relative to " + in_quotes(other) + ", which is not described" +
                  frames_.nearest(model, other),
              link.body.source.line);
        continue;
      }
      SE3<>& X = link.body.shapes[k].pose;
      X = relative(frames_[link.frame].pose, frames_[found].pose) * X;
    }
}

}  // namespace axode::io
