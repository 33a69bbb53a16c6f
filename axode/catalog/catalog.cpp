#include "axode/catalog.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace axode::catalog {

template <class T> std::size_t Function<T>::size(const Model& model, std::size_t n_loads) const {
  return symbols.size() * catalog::numbers_of(*this, model, n_loads);
}

std::string_view name_here(std::string_view theirs) {
  // clang-format off
  static constexpr auto names = std::to_array<std::pair<std::string_view, std::string_view>>({
      {"forward_kinematics", "poses"}, {"fk", "poses"}, {"placements", "poses"}, {"frame_poses", "poses"},
      {"velocities", "twists"}, {"frame_velocities", "twists"}, {"spatial_velocities", "twists"},
      {"frame_accelerations", "accelerations"}, {"spatial_accelerations", "accelerations"},
      {"frame_jacobian", "jacobian"}, {"geometric_jacobian", "jacobian"}, {"jacobian_dot", "jacobian_rate"},
      {"jacobian_time_derivative", "jacobian_rate"}, {"jacobian_time_variation", "jacobian_rate"},
      {"com", "center_of_mass"}, {"centre_of_mass", "center_of_mass"},
      {"com_jacobian", "center_of_mass_jacobian"},
      {"jacobian_center_of_mass", "center_of_mass_jacobian"}, {"ccrba", "centroidal_momentum_matrix"},
      {"centroidal_map", "centroidal_momentum_matrix"}, {"dccrba", "centroidal_momentum_matrix_rate"},
      {"ik", "inverse_kinematics"},
      {"rnea", "inverse_dynamics"}, {"id", "inverse_dynamics"}, {"aba", "forward_dynamics"},
      {"fd", "forward_dynamics"}, {"crba", "mass_matrix"}, {"inertia_matrix", "mass_matrix"},
      {"joint_space_inertia", "mass_matrix"}, {"minverse", "inverse_mass_matrix"},
      {"reaction_wrenches", "joint_wrenches"}, {"constraint_wrenches", "joint_wrenches"},
      {"coriolis", "coriolis_matrix"}, {"coriolis_forces", "coriolis_vector"},
      {"christoffel_symbols", "christoffel"}, {"gravity", "gravity_torques"},
      {"gravity_vector", "gravity_torques"}, {"gravity_forces", "gravity_torques"},
      {"generalized_gravity", "gravity_torques"}, {"generalized_forces", "generalized_loads"},
      {"task_space_inertia", "operational_space_inertia"}, {"torque_regressor", "regressor"},
      {"joint_torque_regressor", "regressor"}, {"generalized_momenta", "momenta"},
      {"generalized_momentum", "momenta"}, {"total_momentum", "spatial_momentum"},
      {"mobility", "inverse_operational_space_inertia"},
  });
  // clang-format on
  const auto found = std::ranges::find(names, theirs, &decltype(names)::value_type::first);
  return found == names.end() ? "" : found->second;
}

template struct Function<double>;
template struct Function<float>;

}  // namespace axode::catalog
