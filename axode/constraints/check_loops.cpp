#include "axode/constraints/check_loops.hpp"

#include <algorithm>
#include <stdexcept>

namespace axode {

void check_closed(LoopSystem<double>& system, Numbers<double> q, Numbers<double> v) {
  const Loops& loops = system.model().loops();
  Eigen::VectorXd r(std::max(loops.residuals, loops.rows));
  system.place(q.data());
  system.residual(q.data(), r.data());
  for (const Loop& loop : loops.all)
    if (const double open = r.segment(loop.first_residual, loop.residuals()).norm(); !(open <= closed_enough))
      throw std::invalid_argument("q leaves loop \"" + loop.name + "\" open by " + to_text(open) +
                                  " (rad and m); assemble() closes it");
  system.make_rows(LoopSystem<double>::Rows::velocities);
  system.times(v.data(), r.data());
  const double size = 1 + Eigen::Map<const Eigen::VectorXd>(v.data(), std::ssize(v)).norm();
  for (const Loop& loop : loops.all)
    if (const double slip = r.segment(loop.first_row, loop.rows()).norm(); !(slip <= closed_enough * size))
      throw std::invalid_argument("v tears loop \"" + loop.name + "\" open at " + to_text(slip) +
                                  " (rad/s and m/s); assemble() finds velocities that do not");
}

}  // namespace axode
