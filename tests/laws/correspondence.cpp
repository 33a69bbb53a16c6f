#include "tests/laws/correspondence.hpp"

namespace axode::test {

Correspondence::Correspondence(const Model& a, const Model& b, const NameOfOther& name_in_b) : a_(a), b_(b) {
  std::unordered_map<std::string, int> joints, frames;
  for (int i = 1; i <= b.n_bodies(); ++i) joints.emplace(b.joint(i).name, i);
  for (int f = 0; f < b.n_frames(); ++f) frames.emplace(b.frame(f).name, f);
  const auto find = [](const auto& map, const std::string& name) {
    const auto found = map.find(name);
    return found == map.end() ? -1 : found->second;
  };
  joint_.push_back(-1);
  for (const Joint& joint : a.joints()) joint_.push_back(find(joints, name_in_b(joint.name)));
  for (const Frame& frame : a.frames())
    frame_.push_back(frame.name == "ground" ? 0 : find(frames, name_in_b(frame.name)));
}

State<double> Correspondence::carry(const State<double>& state) const {
  const std::size_t nv = static_cast<std::size_t>(b_.nv());
  State<double> out{neutral(b_), std::vector<double>(nv), std::vector<double>(nv)};
  each_joint([&](const Joint& in_a, const Joint& in_b) {
    for (int k = 0; k < in_a.nq; ++k) out.q[in_b.iq + k] = state.q[in_a.iq + k];
    for (int k = 0; k < in_a.nv; ++k)
      out.v[in_b.iv + k] = state.v[in_a.iv + k], out.a[in_b.iv + k] = state.a[in_a.iv + k];
  });
  out.wrenches = state.wrenches;
  for (AppliedWrench<>& load : out.wrenches) load.frame = frame(load.frame);
  return out;
}

std::array<std::vector<double>, 2> Correspondence::common(const std::vector<double>& tau_a,
                                                          const std::vector<double>& tau_b) const {
  std::array<std::vector<double>, 2> out;
  each_joint([&](const Joint& in_a, const Joint& in_b) {
    for (int k = 0; k < in_a.nv; ++k)
      out[0].push_back(tau_a[in_a.iv + k]), out[1].push_back(tau_b[in_b.iv + k]);
  });
  return out;
}

std::vector<Six> Correspondence::of_frames(const std::vector<Six>& in_b) const {
  std::vector<Six> out;
  for (const int f : frame_) out.push_back(in_b.at(static_cast<std::size_t>(f)));
  return out;
}

Description with_parts_of(const Description& first, Description second, const Shift& shift) {
  std::unordered_map<std::string, const JointDescription*> joints;
  for (const BodyDescription& body : first.bodies) joints.emplace(body.joint.name, &body.joint);
  for (BodyDescription& body : second.bodies)
    if (const auto found = joints.find(body.joint.name); found != joints.end())
      body.joint.dof = found->second->dof, body.joint.passive = found->second->passive;

  second.springs = first.springs, second.loops = first.loops, second.couplings = first.couplings;
  for (SpringDescription& spring : second.springs) {
    const auto from = [&](const std::string& frame) {
      return spring.in == GivenIn::construction_frame ? shift.construction_frame : shift.of(frame);
    };
    for (std::size_t k = 0; k < 2; ++k) {
      const SE3<> D = from(spring.between[k]);
      spring.points[k] = D * spring.points[k], spring.frames[k] = D * spring.frames[k];
    }
    for (SpringDescription::Point& it : spring.path) it.point = from(it.on) * it.point;
  }
  for (LoopDescription& loop : second.loops)
    for (std::size_t k = 0; k < 2; ++k) loop.frames->at(k) = shift.of(loop.between[k]) * loop.frames->at(k);
  set_last_description(second);
  return second;
}

void make_loads_spatial(const Model& model, State<double>& state) {
  const std::vector<SE3<>> C = Trial(scalars()[0], model, state).poses();
  for (AppliedWrench<>& load : state.wrenches) {
    const auto& [m, f] = changed_wrench(Representation::spatial, load.representation,
                                        C[static_cast<std::size_t>(load.frame)], {load.m, load.f});
    load = AppliedWrench<>(load.frame, Representation::spatial, m, f);
  }
}

SE3<> displacement(Subgroup kind, double pitch, const double* q) {
  return with_subgroup(kind, pitch, [&](const auto& joint) { return joint.pose(SE3<>{}, q); });
}
std::vector<double> coordinates(Subgroup kind, const SE3<>& D) {
  return with_subgroup(kind, 0.0, [&](const auto& joint) {
    const auto near = joint.neutral();
    std::vector<double> q(near.size());
    joint.coordinates(D, near.data(), q.data());
    return q;
  });
}
Screw<> joint_screw(Subgroup kind, double pitch, const double* v) {
  return with_subgroup(kind, pitch, [&](const auto& joint) { return screw(joint.twist(v)); });
}
std::vector<double> components(Subgroup kind, double pitch, const Screw<>& X) {
  return with_subgroup(kind, pitch, [&](const auto& joint) {
    const auto parts = joint.project(Wrench<BodyFixed>{X.w, X.v});
    return std::vector<double>(parts.begin(), parts.end());
  });
}

}  // namespace axode::test
