#include <algorithm>

#include "axode/workspace/largest_footprint.hpp"

/// Memory for algorithms that are compiled for the chosen instruction set, and for all others.
namespace axode {

template <>
Workspace<double>::Workspace(const Model& model)
    : Workspace(model.topology(), std::max(largest_footprint<double>(model.topology()),
                                           chosen_largest_footprint<double>(model.topology()))) {}
template <>
Workspace<float>::Workspace(const Model& model)
    : Workspace(model.topology(), largest_footprint<float>(model.topology())) {}

}  // namespace axode
