// expect: bring one into that of the other with change<To>(C, x)
#include "axode/lie.hpp"

using namespace axode;

auto difference(Wrench<BodyFixed> W, [[maybe_unused]] Wrench<Mixed> F) {
#ifdef AXODE_CONTROL
  return W - W;
#else
  return W - F;
#endif
}
