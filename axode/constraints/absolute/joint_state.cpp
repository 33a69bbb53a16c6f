#include "axode/constraints/absolute/joint_state.hpp"

#include "axode/constraints/absolute/absolute_system.hpp"
#include "axode/model/configuration.hpp"

namespace axode {

JointState joint_state(const Model& model, std::span<const SE3<>> C, std::span<const Twist<BodyFixed>> V,
                       std::span<const double> near) {
  const auto bodies = static_cast<std::size_t>(model.n_bodies()) + 1;
  check_size("C", C.size(), bodies, "n_bodies + 1");
  check_size("V", V.size(), bodies, "n_bodies + 1");
  if (!near.empty()) check_configuration(model, near);
  AbsoluteSystem system(model, BodyGroup::SE3);
  if (!near.empty()) system.set_reference_angles(near);
  JointState out;
  std::vector<double> q, v, rows;
  system.set_poses_and_twists(C, V, q, v);
  system.to_joint_state(q, v, out.q, out.v);
  system.position_residual(q, rows);
  out.position_residual = largest_of(rows);
  system.velocity_residual(q, v, rows);
  out.velocity_residual = largest_of(rows);
  return out;
}

}  // namespace axode
