#pragma once
#include <vector>

#include "axode/constraints/local_mobility/closure.hpp"
#include "axode/constraints/local_mobility/germs.hpp"

namespace axode::higher_order {

/// Makes the branches of the configuration space from germs of solutions of the closure equations. Every
/// branch occurs once and is traced by closed points. All lengths are in characteristic lengths.
std::vector<MotionBranch> branches(const Closure& closure, const std::vector<Germ>& germs);

/// The distance from q up to which the series of a branch describes it, relative to that at a configuration
/// far from singularities, at most 1: coefficient k of the series is at most 10 / reach^(k - 1).
double reach(const MotionBranch& branch);

/// Whether a closed point x near q lies on a branch, to second order in x.
bool lies_on(const MotionBranch& branch, const Eigen::VectorXd& x);

}  // namespace axode::higher_order
