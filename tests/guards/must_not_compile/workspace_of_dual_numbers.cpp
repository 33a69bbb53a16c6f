// expect: GenericDynamics
#include "axode/axode.hpp"
#include "axode/dynamics/generic_dynamics.hpp"
#include "axode/scalar/dual.hpp"

using namespace axode;
using D = Dual<double, 2>;

void fill(const Model& model, std::span<const D> q, std::span<D> tau) {
#ifdef AXODE_CONTROL
  GenericDynamics<D>(model).inverse_dynamics(q, q, q, tau);
#else
  Workspace<D> workspace(model);
  inverse_dynamics(model, workspace, q, q, q, tau);
#endif
}
