#pragma once
#include <vector>

#include "axode/constraints/local_mobility/closure.hpp"
#include "axode/constraints/local_mobility/germs.hpp"

namespace axode::higher_order {

/// Makes the branches of the configuration space, the smooth sets of configurations with closed loops, from
/// the power series of the solutions of the loop equations. Each branch is traced by points at which Newton's
/// method has closed the loops. All lengths are divided by a characteristic length.
std::vector<MotionBranch> branches(const Closure& closure, const std::vector<Germ>& germs);

/// The distance from q, at most 1, up to which the power series of a branch, a smooth set of configurations
/// through q with closed loops, is used: the largest number `reach` such that coefficient k is at most 10 /
/// reach^(k - 1) for all k.
double reach(const MotionBranch& branch);

/// Whether a closed point x near q lies on a branch, to second order in x.
bool lies_on(const MotionBranch& branch, const Eigen::VectorXd& x);

}  // namespace axode::higher_order
