#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "axode/constraints/assembly.hpp"
#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/constraints/mobility.hpp"
#include "commands.hpp"
#include "quantities.hpp"

/// What is asked about closed loops.
namespace axode::command {
namespace {

Answer loop_residual_answer(const Question& ask) {
  const std::vector<Loop>& loops = ask.model.loops().all;
  LoopWorkspace<> workspace(ask.model);
  std::vector<double> r(static_cast<std::size_t>(ask.model.loops().residuals));
  loop_residual(ask.model, workspace, ask.state.q, r);
  Answer answer{"how far the loops are from closed; rad, m", Json::object(), Table({"loop", "open by"})};
  for (const Loop& loop : loops) {
    const std::vector<double> own(r.begin() + loop.first_residual,
                                  r.begin() + loop.first_residual + loop.residuals());
    double squares = 0;
    for (const double x : own) squares += x * x;
    answer.value[loop.name] = own;
    answer.table.row({loop.name, std::sqrt(squares)});
  }
  return answer;
}

Answer loop_wrenches_answer(const Question& ask) {
  const std::vector<Loop>& loops = ask.model.loops().all;
  const State& state = ask.state;
  LoopWorkspace<> workspace(ask.model);
  std::vector<double> a(state.v.size()), lambda(static_cast<std::size_t>(ask.model.loops().rows));
  const Solvability found =
      forward_dynamics(ask.model, workspace, state.q, state.v, state.tau, a, lambda, ask.loads());
  if (!found.ok()) throw InputError(to_string(ask.model, found));
  Answer answer{headline("wrenches of the loops on their second bodies under the drive forces tau",
                         ask.representation, "of that body's frame", "N m, N"),
                Json::object(), Table({"loop", "m x", "m y", "m z", "f x", "f y", "f z"})};
  with_representation(ask.representation, [&](auto rep) {
    using Rep = decltype(rep);
    std::vector<Wrench<Rep>> W(loops.size());
    loop_wrenches<Rep>(ask.model, workspace, state.q, lambda, std::span(W));
    for (std::size_t k = 0; k < W.size(); ++k) {
      const auto& [m, f] = W[k];
      answer.value[loops[k].name] = std::vector{m.x, m.y, m.z, f.x, f.y, f.z};
      answer.table.row({loops[k].name, m.x, m.y, m.z, f.x, f.y, f.z});
    }
  });
  return answer;
}

Answer loop_mobility_answer(const Question& ask) {
  const LoopMobility found = loop_mobility(ask.model, ask.state.q);
  Answer answer{
      fmt::format("{} degrees of freedom ({}), {} rows of rank {}; rows that others imply",
                  found.degrees_of_freedom, to_string(found.mobility), ask.model.loops().rows, found.rank),
      {{"degrees_of_freedom", found.degrees_of_freedom},
       {"rank", found.rank},
       {"mobility", std::string(to_string(found.mobility))},
       {"redundant", Json::array()}},
      Table({"row", "loop", "what the loops carry by themselves"})};
  for (const RedundantRow& row : found.redundant) {
    answer.value["redundant"].push_back({{"row", row.row}, {"loop", row.loop}, {"wrench", row.wrench}});
    answer.table.row({std::to_string(row.row), row.loop, row.wrench});
  }
  return answer;
}

Answer assembly_answer(const Question& ask) {
  const AssemblyResult found = assemble(ask.model, ask.state.q, ask.state.v);
  if (found.status != AssemblyStatus::closed) throw InputError(to_string(ask.model, found));
  Answer answer{"q and v near the state with all loops closed",
                {{"q", found.q}, {"v", found.v}},
                Table({"joint", "q", "v"})};
  const std::vector<std::string> names = velocity_names(ask.model);
  for (const Joint& joint : ask.model.joints())
    for (int k = 0; k < std::max(joint.nq, joint.nv); ++k)
      answer.table.row({k < joint.nv ? names[static_cast<std::size_t>(joint.iv + k)] : "",
                        k < joint.nq ? Cell(found.q[static_cast<std::size_t>(joint.iq + k)]) : Cell(""),
                        k < joint.nv ? Cell(found.v[static_cast<std::size_t>(joint.iv + k)]) : Cell("")});
  return answer;
}

}  // namespace

std::vector<Quantity> loop_quantities() {
  return {{"loop_residual", "how far loops are from closed", loop_residual_answer},
          {"assembly", "q and v near the state with all loops closed", assembly_answer},
          {"loop_mobility", "degrees of freedom and redundant rows of the loops", loop_mobility_answer},
          {"constraint_wrenches", "wrenches of the loops under the drive forces tau", loop_wrenches_answer}};
}

}  // namespace axode::command
