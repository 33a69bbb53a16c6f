// expect: no match for or invalid operands
#include "axode/lie.hpp"

using namespace axode;

double power(Wrench<Spatial> W, [[maybe_unused]] Twist<Spatial> V, [[maybe_unused]] Twist<BodyFixed> U) {
#ifdef AXODE_CONTROL
  return W | V;
#else
  return W | U;
#endif
}
