#include "axode/workspace/largest_footprint.hpp"

#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T> std::size_t chosen_largest_footprint(const Topology& t) { return largest_footprint<T>(t); }

template AXODE_ENTRY std::size_t chosen_largest_footprint<AXODE_T>(const Topology&);

}  // namespace axode
