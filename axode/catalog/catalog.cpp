#include "axode/catalog.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace axode::catalog {

template <class T> std::span<const T>& numbers(Given<T>& given, Input input) {
  switch (input) {
    case Input::q: return given.q;
    case Input::v: return given.v;
    case Input::a: return given.a;
    case Input::tau: return given.tau;
    case Input::p: return given.p;
    case Input::dq: return given.dq;
    case Input::dv: return given.dv;
    case Input::da: return given.da;
    case Input::dtau: return given.dtau;
    default: return given.w;
  }
}
template std::span<const double>& numbers(Given<double>&, Input);
template std::span<const float>& numbers(Given<float>&, Input);

int numbers_of(Entry entry) {
  switch (entry) {
    case Entry::number: return 1;
    case Entry::vector: return 3;
    case Entry::pose: return 12;
    case Entry::inertia: return 10;
    default: return 6;
  }
}

std::size_t value_of(Extent extent, const Model& model, std::size_t n_loads) {
  const auto size = [](int n) { return static_cast<std::size_t>(n); };
  switch (extent) {
    case Extent::nv: return size(model.nv());
    case Extent::n_bodies:
    case Extent::n_joints: return size(model.n_bodies());
    case Extent::n_frames: return size(model.n_frames());
    case Extent::n_screws: return size(model.n_screws());
    case Extent::n_parameters: return 10 * size(model.n_bodies());
    case Extent::n_loads: return n_loads;
    case Extent::six: break;
  }
  return 6;
}

template <class T> std::size_t Function<T>::size(const Model& model, std::size_t n_loads) const {
  std::size_t n = static_cast<std::size_t>(numbers_of(entry)) * symbols.size();
  for (const Extent extent : shape) n *= value_of(extent, model, n_loads);
  return n;
}

std::string_view name_here(std::string_view theirs) {
  // clang-format off
  static constexpr auto names = std::to_array<std::pair<std::string_view, std::string_view>>({
      {"forward_kinematics", "poses"}, {"fk", "poses"}, {"placements", "poses"}, {"frame_poses", "poses"},
      {"velocities", "twists"}, {"frame_velocities", "twists"}, {"spatial_velocities", "twists"},
      {"frame_accelerations", "accelerations"}, {"spatial_accelerations", "accelerations"},
      {"frame_jacobian", "jacobian"}, {"geometric_jacobian", "jacobian"}, {"jacobian_dot", "jacobian_rate"},
      {"jacobian_time_derivative", "jacobian_rate"}, {"jacobian_time_variation", "jacobian_rate"},
      {"com", "center_of_mass"}, {"centre_of_mass", "center_of_mass"}, {"com_jacobian", "center_of_mass_jacobian"},
      {"jacobian_center_of_mass", "center_of_mass_jacobian"}, {"ccrba", "centroidal_momentum_matrix"},
      {"centroidal_map", "centroidal_momentum_matrix"}, {"dccrba", "centroidal_momentum_matrix_rate"},
      {"ik", "inverse_kinematics"},
      {"rnea", "inverse_dynamics"}, {"id", "inverse_dynamics"}, {"aba", "forward_dynamics"},
      {"fd", "forward_dynamics"}, {"crba", "mass_matrix"}, {"inertia_matrix", "mass_matrix"},
      {"joint_space_inertia", "mass_matrix"}, {"minverse", "inverse_mass_matrix"},
      {"reaction_wrenches", "joint_wrenches"}, {"constraint_wrenches", "joint_wrenches"},
      {"coriolis", "coriolis_matrix"}, {"coriolis_forces", "coriolis_vector"}, {"christoffel_symbols", "christoffel"},
      {"gravity", "gravity_torques"}, {"gravity_vector", "gravity_torques"}, {"gravity_forces", "gravity_torques"},
      {"generalized_gravity", "gravity_torques"}, {"generalized_forces", "generalized_loads"},
      {"task_space_inertia", "operational_space_inertia"}, {"torque_regressor", "regressor"},
      {"joint_torque_regressor", "regressor"}, {"generalized_momenta", "momenta"},
      {"generalized_momentum", "momenta"}, {"total_momentum", "spatial_momentum"},
  });
  // clang-format on
  const auto found = std::ranges::find(names, theirs, &decltype(names)::value_type::first);
  return found == names.end() ? "" : found->second;
}

template struct Function<double>;
template struct Function<float>;

}  // namespace axode::catalog
