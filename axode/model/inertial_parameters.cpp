#include "axode/model/inertial_parameters.hpp"

namespace axode {

std::array<double, 10> inertial_parameters(const Inertia<double>& M) {
  const Sym3<double>& A = M.Theta;
  return {M.m, M.h.x, M.h.y, M.h.z, A.xx, A.yy, A.zz, A.xy, A.xz, A.yz};
}
Inertia<double> inertia_of(std::span<const double, 10> p) {
  return {p[0], {p[1], p[2], p[3]}, {p[4], p[5], p[6], p[7], p[8], p[9]}};
}
std::vector<double> inertial_parameters(const Model& model) {
  std::vector<double> all;
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const std::array<double, 10> own = inertial_parameters(model.body(i).M);
    all.insert(all.end(), own.begin(), own.end());
  }
  return all;
}
std::vector<std::string> parameter_names(const Model& model) {
  std::vector<std::string> names;
  for (int i = 1; i <= model.n_bodies(); ++i)
    for (const char* parameter : {"m", "m cx", "m cy", "m cz", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"})
      names.push_back(model.body(i).name + " " + parameter);
  return names;
}

}  // namespace axode
