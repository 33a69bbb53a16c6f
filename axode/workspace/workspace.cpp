#include <algorithm>

#include "axode/workspace/largest_footprint.hpp"

/// A workspace has memory for the kernels in the code for the chosen instruction set as well as for the
/// kernels that are compiled once.
namespace axode {

template <>
Workspace<double>::Workspace(const Model& model)
    : Workspace(model.topology(), std::max(largest_footprint<double>(model.topology()),
                                           chosen_largest_footprint<double>(model.topology()))) {}
template <>
Workspace<float>::Workspace(const Model& model)
    : Workspace(model.topology(), largest_footprint<float>(model.topology())) {}

}  // namespace axode
