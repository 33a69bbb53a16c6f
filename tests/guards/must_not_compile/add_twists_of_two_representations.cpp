// expect: bring one into that of the other with change<To>(C, x)
#include "axode/lie.hpp"

using namespace axode;

auto sum(Twist<Spatial> V, [[maybe_unused]] Twist<Hybrid> U) {
#ifdef AXODE_CONTROL
  return V + V;
#else
  return V + U;
#endif
}
