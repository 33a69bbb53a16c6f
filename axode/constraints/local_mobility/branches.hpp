#pragma once
#include <vector>

#include "axode/constraints/local_mobility/closure.hpp"
#include "axode/constraints/local_mobility/germs.hpp"

namespace axode::higher_order {

/// The branches that germs of the closure belong to, each once, traced by closed points. All lengths are in
/// characteristic lengths.
std::vector<MotionBranch> branches(const Closure& closure, const std::vector<Germ>& germs);

/// The distance from q, relative to that at a configuration far from singularities, to which the series of a
/// branch describes it: coefficient k of the series is at most 10 / reach^(k - 1).
double reach(const MotionBranch& branch);

/// Whether a closed point near q lies on a branch, to second order.
bool lies_on(const MotionBranch& branch, const Eigen::VectorXd& x);

}  // namespace axode::higher_order
