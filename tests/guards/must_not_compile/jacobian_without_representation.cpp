// expect: RecursionRepresentation
#include "axode/axode.hpp"

using namespace axode;

void fill(const Model& model, Workspace<>& workspace, std::span<const double> q, std::span<Twist<Hybrid>> J) {
#ifdef AXODE_CONTROL
  jacobian<Hybrid>(model, workspace, q, 1, J);
#else
  jacobian<Fast>(model, workspace, q, 1, J);
#endif
}
