// expect: no match for or invalid operands
#include "axode/lie.hpp"

using namespace axode;

double power(Wrench<Spatial> W, [[maybe_unused]] Twist<Spatial> V, [[maybe_unused]] TwistRate<Spatial> dV) {
#ifdef AXODE_CONTROL
  return W | V;
#else
  return W | dV;
#endif
}
