#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/quantities/quantities.hpp"
#include "apps/shell/commands.hpp"
#include "axode/constraints/assembly.hpp"
#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/constrained_derivatives.hpp"
#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/constraints/independent/independent_equations.hpp"
#include "axode/constraints/mobility.hpp"

/// The quantities of `axode eval` about closed loops.
namespace axode::command {
namespace {

enum class Rows { velocities, residuals };

std::size_t number_of(const Model& model, Rows kind) {
  return static_cast<std::size_t>(kind == Rows::velocities ? model.loops().rows : model.loops().residuals);
}

/// Makes the Answer, the text and JSON that `axode eval` prints, from the array x. For each constraint
/// equation of the loops, x has a number for each name in `columns`. `kind` says whether the equations are
/// those for velocities or for positions.
Answer answer_by_rows(const Question& ask, std::string units, Rows kind, const std::vector<double>& x,
                      const std::vector<std::string>& columns) {
  std::vector<std::string> headings{"loop"};
  headings.insert(headings.end(), columns.begin(), columns.end());
  Answer answer{Json::object(), Table(std::move(headings)), std::move(units)};
  for (const LoopRows& loop : ask.model.loops().all) {
    const int first = kind == Rows::velocities ? loop.first_row : loop.first_residual;
    const int n = kind == Rows::velocities ? loop.rows : loop.residuals;
    Json& rows = answer.value[loop.name] = Json::array();
    for (int r = first; r < first + n; ++r) {
      const auto begin = x.begin() + r * std::ssize(columns);
      const std::vector<double> row(begin, begin + std::ssize(columns));
      rows.push_back(columns.size() == 1 ? Json(row[0]) : Json(row));
      std::vector<Cell> cells{r == first ? loop.name : ""};
      cells.insert(cells.end(), row.begin(), row.end());
      answer.table.row(std::move(cells));
    }
  }
  return answer;
}

/// Makes the Answer, the text and JSON that `axode eval` prints, from a matrix that `write` computes. It has
/// a row for each constraint equation of the loops and a column for each velocity.
template <class F> Answer matrix_answer(const Question& ask, Rows kind, const F& write) {
  LoopWorkspace<> workspace(ask.model);
  std::vector<double> matrix(number_of(ask.model, kind) * ask.state.v.size());
  write(ask.model, workspace, ask.state.q, matrix);
  return answer_by_rows(ask, "", kind, matrix, velocity_names(ask.model));
}
Answer loop_jacobian_answer(const Question& ask) {
  return matrix_answer(ask, Rows::velocities, [](auto&... x) { loop_jacobian(x...); });
}
Answer loop_residual_jacobian_answer(const Question& ask) {
  return matrix_answer(ask, Rows::residuals, [](auto&... x) { loop_residual_jacobian(x...); });
}
Answer loop_bias_answer(const Question& ask) {
  LoopWorkspace<> workspace(ask.model);
  std::vector<double> gamma(number_of(ask.model, Rows::velocities));
  loop_bias(ask.model, workspace, ask.state.q, ask.state.v, gamma);
  return answer_by_rows(ask, "rad/s^2, m/s^2", Rows::velocities, gamma, {"gamma"});
}

/// Computes the multipliers of the loops under the drive forces of the state.
std::vector<double> multipliers(const Question& ask) {
  const State& state = ask.state;
  LoopWorkspace<> workspace(ask.model);
  std::vector<double> a(state.v.size()), lambda(number_of(ask.model, Rows::velocities));
  const Solvability found =
      forward_dynamics(ask.model, workspace, state.q, state.v, state.tau, a, lambda, ask.loads());
  if (!found.ok()) throw InputError(to_string(ask.model, found));
  return lambda;
}
Answer loop_multipliers_answer(const Question& ask) {
  return answer_by_rows(ask, "N m, N", Rows::velocities, multipliers(ask), {"lambda"});
}

Answer loop_multiplier_derivatives_answer(const Question& ask) {
  const State& state = ask.state;
  const std::size_t nv = state.v.size(), n = number_of(ask.model, Rows::velocities) * nv;
  LoopWorkspace<> workspace(ask.model);
  std::vector<double> a(3 * nv * nv), lambda(3 * n);
  const auto part = [](std::vector<double>& x, std::size_t k) {
    return std::span(x).subspan(k * x.size() / 3, x.size() / 3);
  };
  const ClosedDynamicsDerivatives<double> d{part(a, 0),      part(a, 1),      part(a, 2),
                                            part(lambda, 0), part(lambda, 1), part(lambda, 2)};
  const Solvability found =
      forward_dynamics_derivatives(ask.model, workspace, state.q, state.v, state.tau, d, ask.loads());
  if (!found.ok()) throw InputError(to_string(ask.model, found));
  std::vector<double> by_row;
  std::vector<std::string> columns;
  for (const char* by : {"q ", "v ", "tau "})
    for (const std::string& name : velocity_names(ask.model)) columns.push_back(by + name);
  for (std::size_t row = 0; row < n; row += nv)
    for (const std::span<double> of : {d.lambda_q, d.lambda_v, d.lambda_tau})
      by_row.insert(by_row.end(), of.begin() + row, of.begin() + row + nv);
  return answer_by_rows(ask, "", Rows::velocities, by_row, columns);
}

Answer independent_equations_answer(const Question& ask) {
  const IndependentEquations found =
      independent_equations(ask.model, ask.state.q, ask.state.v, {}, ask.loads());
  const std::vector<std::string> names = velocity_names(ask.model);
  Answer answer{{{"velocities", Json::array()}}, Table({"velocity", "h"})};
  for (const int k : found.velocities) {
    answer.value["velocities"].push_back(names[k]);
    answer.table.row({names[k], found.h[std::ssize(answer.value["velocities"]) - 1]});
  }
  const auto rows = [](const Eigen::MatrixXd& x) {
    Json all = Json::array();
    for (const auto& row : x.rowwise()) all.push_back(std::vector<double>(row.begin(), row.end()));
    return all;
  };
  answer.value.update({{"M", rows(found.M)}, {"N", rows(found.N)}});
  answer.value["h"] = std::vector<double>(found.h.begin(), found.h.end());
  answer.value["c"] = std::vector<double>(found.c.begin(), found.c.end());
  return answer;
}

Answer impact_answer(const Question& ask) {
  LoopWorkspace<> workspace(ask.model);
  std::vector<double> v(ask.state.v.size()), impulses(number_of(ask.model, Rows::velocities));
  const Solvability found = impact(ask.model, workspace, ask.state.q, ask.state.v, 0.0, v, impulses);
  if (!found.ok()) throw InputError(to_string(ask.model, found));
  Answer answer{{{"v", v}, {"impulses", impulses}}, Table({"joint", "v"})};
  const std::vector<std::string> names = velocity_names(ask.model);
  for (std::size_t k = 0; k < v.size(); ++k) answer.table.row({names[k], v[k]});
  return answer;
}

Answer loop_residual_answer(const Question& ask) {
  const std::vector<LoopRows>& loops = ask.model.loops().all;
  LoopWorkspace<> workspace(ask.model);
  std::vector<double> r(static_cast<std::size_t>(ask.model.loops().residuals));
  loop_residual(ask.model, workspace, ask.state.q, r);
  Answer answer{Json::object(), Table({"loop", "open by"}), "rad, m"};
  for (const LoopRows& loop : loops) {
    const std::vector<double> own(r.begin() + loop.first_residual,
                                  r.begin() + loop.first_residual + loop.residuals);
    double squares = 0;
    for (const double x : own) squares += x * x;
    answer.value[loop.name] = own;
    answer.table.row({loop.name, std::sqrt(squares)});
  }
  return answer;
}

Answer loop_wrenches_answer(const Question& ask) {
  const std::vector<LoopRows>& loops = ask.model.loops().all;
  LoopWorkspace<> workspace(ask.model);
  const std::vector<double> lambda = multipliers(ask);
  Answer answer{Json::object(), Table({"loop", "m x", "m y", "m z", "f x", "f y", "f z"}), "N m, N",
                components_in(ask.representation, "of that body's frame")};
  with_representation(ask.representation, [&](auto rep) {
    using Rep = decltype(rep);
    std::vector<Wrench<Rep>> W(loops.size());
    loop_wrenches<Rep>(ask.model, workspace, ask.state.q, lambda, std::span(W));
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
  Answer answer{{{"degrees_of_freedom", found.degrees_of_freedom},
                 {"rank", found.rank},
                 {"mobility", std::string(to_string(found.mobility))},
                 {"redundant", Json::array()}},
                Table({"row", "loop", "what the loops carry by themselves"}),
                "",
                fmt::format("{} degrees of freedom ({}), {} rows of rank {}", found.degrees_of_freedom,
                            to_string(found.mobility), ask.model.loops().rows, found.rank)};
  for (const RedundantRow& row : found.redundant) {
    answer.value["redundant"].push_back({{"row", row.row}, {"loop", row.loop}, {"wrench", row.wrench}});
    answer.table.row({std::to_string(row.row), row.loop, row.wrench});
  }
  return answer;
}

Answer assembly_answer(const Question& ask) {
  const AssemblyResult found = assemble(ask.model, ask.state.q, ask.state.v);
  if (found.status != AssemblyStatus::closed) throw InputError(to_string(ask.model, found));
  Answer answer{{{"q", found.q}, {"v", found.v}}, Table({"joint", "q", "v"})};
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
  return {
      {"loop_residual", "The residuals r say how far the loops are from closed.", loop_residual_answer},
      {"loop_jacobian", "The matrix A of the loops has A v = 0 for velocities v that keep them closed.",
       loop_jacobian_answer},
      {"loop_residual_jacobian", "The matrix R gives the rates r' = R v of the residuals r of the loops.",
       loop_residual_jacobian_answer},
      {"loop_bias",
       "The bias gamma of the loops satisfies (A v)' = A a + gamma for the matrix A of loop_jacobian.",
       loop_bias_answer},
      {"loop_multipliers",
       "The multipliers lambda of the loops satisfy M a + h - A^T lambda = tau under the drive forces tau.",
       loop_multipliers_answer},
      {"loop_multiplier_derivatives",
       "The partial derivatives of the multipliers lambda of the loops by q, v and tau have a column for "
       "each.",
       loop_multiplier_derivatives_answer},
      {"independent_equations",
       "The equations M y' + h = N^T tau are those of independent velocities y, with v = N y and "
       "a = N y' + c.",
       independent_equations_answer},
      {"impact", "The velocities v are those after the loops close without rebound.", impact_answer},
      {"assembly", "The state (q, v) is near the given one and closes all loops.", assembly_answer},
      {"loop_mobility",
       "The degrees of freedom are those that the loops leave; the table has the rows that others imply.",
       loop_mobility_answer},
      {"constraint_wrenches",
       "The wrenches are those of the loops on their second bodies under the drive forces tau.",
       loop_wrenches_answer}};
}

}  // namespace axode::command
