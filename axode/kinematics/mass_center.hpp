#pragma once
#include <stdexcept>

#include "axode/model/model.hpp"

namespace axode {

/// What the functions about the centre of mass say of a model that has none.
inline std::domain_error no_mass(const Model& model) {
  return std::domain_error("model \"" + model.name() + "\" has no mass that moves, so no centre of mass");
}

/// The centre of mass of bodies with poses C.
template <class T> Vec3<T> mass_center(const Model& model, const Tree<T>& tree, const SE3<T>* C) {
  T m(0);
  Vec3<T> h;
  for (int i = 1; i <= tree.n; ++i) {
    m += tree.M[i].m;
    h += tree.M[i].m * C[i].r + C[i].R * tree.M[i].h;
  }
  if (!(m > T(0))) throw no_mass(model);
  return (T(1) / m) * h;
}

}  // namespace axode
