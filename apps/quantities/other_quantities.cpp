#include "apps/quantities/quantities.hpp"
#include "apps/shell/commands.hpp"
#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/higher_order/constrained_rates.hpp"
#include "axode/derivatives/rates.hpp"
#include "axode/dynamics.hpp"
#include "axode/eigen.hpp"
#include "axode/kinematics.hpp"
#include "axode/kinematics/system_matrices.hpp"
#include "axode/model/inertial_parameters.hpp"

/// Quantities that `axode eval` computes by functions of their own: derivatives of a given order, inverse
/// kinematics with targets, factors of matrices, and equations of motion for the twists or momenta of the
/// bodies.
namespace axode::command {
namespace {

void require(const Question& ask, const Solvability& solvability) {
  if (!solvability.ok()) throw InputError(to_string(ask.model, solvability));
}

std::string components_of_twists(const Question& ask) {
  return components_in(ask.representation, twist_axes(ask.representation));
}
std::string of_order(int order, const Question& ask) {
  return "order " + std::to_string(order) + "; " + components_of_twists(ask);
}

/// The matrix with these columns of six numbers as JSON: six rows with an entry for each column.
template <class Column> Json rows_of(std::span<const Column> columns) {
  Json rows = Json::array();
  for (int r = 0; r < 6; ++r) rows.push_back(Json::array());
  for (const Column& column : columns) {
    const auto x = to_eigen(column);
    for (int r = 0; r < 6; ++r) rows[r].push_back(x[r]);
  }
  return rows;
}
/// The motion at the state of the question, with time derivatives of the twists up to the given order.
HigherOrderMotion<> motion_of(const Question& ask, int order) {
  std::vector<double> rates = rates_of(ask.state);
  rates.resize((order + 1) * ask.model.nv());  // derivatives that the state does not give are 0
  HigherOrderMotion<> motion(ask.model, order);
  motion.evaluate(ask.state.q, rates);
  return motion;
}

Answer jacobian_derivative_answer(const Question& ask) {
  return with_representation(ask.representation, [&](auto rep) {
    using Rep = decltype(rep);
    const HigherOrderMotion<> motion = motion_of(ask, ask.order);
    Answer answer{Json::object(), Table({"frame", "velocity", "w x", "w y", "w z", "v x", "v y", "v z"}),
                  "per unit of the velocity", of_order(ask.order, ask)};
    const std::vector<std::string> names = velocity_names(ask.model);
    std::vector<TwistRate<Rep>> columns(ask.model.nv());
    for (const int frame : frames_of(ask)) {
      motion.jacobian_derivative<Rep>(frame, ask.order, columns);
      const std::string& name = ask.model.frame(frame).name;
      answer.value[name] = rows_of(std::span<const TwistRate<Rep>>(columns));
      for (std::size_t c = 0; c < columns.size(); ++c) {
        const auto& [w, v] = columns[c];
        answer.table.row({c == 0 ? name : "", names[c], w.x, w.y, w.z, v.x, v.y, v.z});
      }
      answer.table.rule();
    }
    return answer;
  });
}

Answer twist_derivative(const Question& ask, int order) {
  return with_representation(ask.representation, [&](auto rep) {
    using Rep = decltype(rep);
    const HigherOrderMotion<> motion = motion_of(ask, order);
    Answer answer{Json::object(), Table({"frame", "w x", "w y", "w z", "v x", "v y", "v z"}), "rad, m and s",
                  of_order(order, ask)};
    for (const int frame : frames_of(ask)) {
      const TwistRate<Rep> V = motion.twist_derivative<Rep>(frame, order);
      answer.value[ask.model.frame(frame).name] = to_json(V);
      answer.table.row({ask.model.frame(frame).name, V.w.x, V.w.y, V.w.z, V.v.x, V.v.y, V.v.z});
    }
    return answer;
  });
}
Answer jerk_answer(const Question& ask) { return twist_derivative(ask, 2); }
Answer snap_answer(const Question& ask) { return twist_derivative(ask, 3); }
Answer twist_derivative_answer(const Question& ask) { return twist_derivative(ask, ask.order); }

/// Converts the partial derivatives of order `order` of a Jacobian (6 × nv) to nested lists. There is a level
/// of lists for each derivative, and the outermost level is that of the derivative that is taken last. The
/// innermost lists are the six rows of the Jacobian, with nv entries each.
template <class Column> Json nested(std::span<const Column> tensor, int order, int nv) {
  if (order == 0) return rows_of(tensor);
  Json list = Json::array();
  const std::size_t part = tensor.size() / nv;
  for (int k = 0; k < nv; ++k) list.push_back(nested(tensor.subspan(k * part, part), order - 1, nv));
  return list;
}

Answer jacobian_partials_answer(const Question& ask) {
  return with_representation(ask.representation, [&](auto rep) {
    using Rep = decltype(rep);
    const int nv = ask.model.nv();
    double size = nv;
    for (int k = 0; k < ask.order; ++k) size *= nv;
    if (size > 1e6)
      throw InputError("jacobian_partials: order " + std::to_string(ask.order) +
                       " has more than a million columns for " + std::to_string(nv) + " velocities");
    Answer answer{Json::object(), Table({"frame", "entries", "largest"}), "per unit of the velocity",
                  of_order(ask.order, ask)};
    Workspace<> workspace(ask.model);
    std::vector<Twist<Rep>> J(static_cast<std::size_t>(size));
    for (const int frame : frames_of(ask)) {
      jacobian_partials<Rep>(ask.model, workspace, ask.state.q, frame, ask.order, J);
      double largest = 0;
      for (const Twist<Rep>& column : J) largest = std::max(largest, to_eigen(column).cwiseAbs().maxCoeff());
      answer.value[ask.model.frame(frame).name] = nested(std::span<const Twist<Rep>>(J), ask.order, nv);
      answer.table.row({ask.model.frame(frame).name, std::to_string(6 * J.size()), largest});
    }
    return answer;
  });
}

Json dense(const SystemMatrix& M) {
  const Eigen::MatrixXd D(M);
  Json rows = Json::array();
  for (int r = 0; r < D.rows(); ++r) {
    rows.push_back(Json::array());
    for (int c = 0; c < D.cols(); ++c) rows.back().push_back(D(r, c));
  }
  return rows;
}
Answer system_matrices_answer(const Question& ask) {
  return with_representation(ask.representation, [&](auto rep) {
    const SystemMatrices system = system_matrices<decltype(rep)>(ask.model, ask.state.q);
    Answer answer{Json{{"A", dense(system.A)}, {"D", dense(system.D)}, {"X", dense(system.X)}},
                  Table({"matrix", "rows", "columns", "entries not zero"}), "", components_of_twists(ask)};
    for (const auto& [name, M] :
         {std::pair("A", &system.A), std::pair("D", &system.D), std::pair("X", &system.X)})
      answer.table.row({std::string(name), std::to_string(M->rows()), std::to_string(M->cols()),
                        std::to_string(M->nonZeros())});
    return answer;
  });
}

Answer inverse_kinematics_answer(const Question& ask) {
  if (ask.state.targets.empty())
    throw InputError(
        "inverse_kinematics: the state has no \"targets\"; give a list of {\"frame\", \"pose\"}");
  const InverseKinematicsResult result = inverse_kinematics(ask.model, ask.state.targets, ask.state.q);
  const std::string summary =
      std::string(to_string(result.status)) + ", error " + significant(result.residual);
  Answer answer{Json{{"status", to_string(result.status)},
                     {"q", result.q},
                     {"residual", result.residual},
                     {"iterations", result.iterations},
                     {"restarts", result.restarts}},
                Table({"coordinate", "q"}), "", summary};
  const std::vector<std::string> names = coordinate_names(ask.model);
  for (std::size_t k = 0; k < names.size(); ++k) answer.table.row({names[k], result.q[k]});
  return answer;
}

Answer mass_matrix_factors_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  MassMatrixFactor<> factor(ask.model);
  const int nv = ask.model.nv();
  std::vector<double> M(static_cast<std::size_t>(nv) * static_cast<std::size_t>(nv)), D;
  mass_matrix(ask.model, workspace, ask.state.q, M);
  require(ask, factor.factorize(M));
  const std::vector<std::string> names = velocity_names(ask.model);
  std::vector<std::string> headings{"velocity"};
  headings.insert(headings.end(), names.begin(), names.end());
  Answer answer{Json{{"L", Json::array()}}, Table(std::move(headings))};
  for (int r = 0; r < nv; ++r) {
    std::vector<double> row;
    for (int c = 0; c < nv; ++c) row.push_back(factor.L(r, c));
    std::vector<Cell> cells{names[static_cast<std::size_t>(r)]};
    cells.insert(cells.end(), row.begin(), row.end());
    answer.table.row(std::move(cells));
    answer.value["L"].push_back(std::move(row));
    D.push_back(factor.D(r));
  }
  answer.value["D"] = D;
  return answer;
}

/// Makes the Answer, the text and JSON that `axode eval` prints, for equations of motion whose unknowns are
/// the twists or the momenta of the bodies. It has the velocities v, and for each body the rates of the six
/// components of its twist or momentum.
template <class Rate>
Answer body_rates_answer(const Question& ask, std::string details, std::string units,
                         std::vector<std::string> headings, const char* key, const std::vector<double>& v,
                         const std::vector<Rate>& rates) {
  Answer answer{Json{{"v", v}, {key, Json::object()}}, Table(std::move(headings)), std::move(units),
                std::move(details)};
  for (int i = 1; i <= ask.model.n_bodies(); ++i) {
    const auto& [x, y] = rates[i - 1];
    answer.value[key][ask.model.body(i).name] = to_json(rates[i - 1]);
    answer.table.row({ask.model.body(i).name, x.x, x.y, x.z, y.x, y.y, y.z});
  }
  return answer;
}
Answer twist_form_answer(const Question& ask) {
  return with_representation(ask.representation, [&](auto rep) {
    using Rep = decltype(rep);
    Workspace<> workspace(ask.model);
    const std::size_t n = ask.model.n_bodies();
    std::vector<Twist<Rep>> V(ask.model.n_frames());
    twists<Rep>(ask.model, workspace, ask.state.q, ask.state.v, V);
    std::vector<double> v(ask.model.nv());
    std::vector<TwistRate<Rep>> dV(n);
    require(ask, twist_form<Rep>(ask.model, workspace, ask.state.q, std::span(V).subspan(1, n), ask.state.tau,
                                 v, dV, ask.loads()));
    return body_rates_answer(ask, components_of_twists(ask), "rad/s^2, m/s^2",
                             {"body", "w' x", "w' y", "w' z", "v' x", "v' y", "v' z"}, "dV", v, dV);
  });
}
Answer spatial_momentum_form_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  std::vector<Momentum<Spatial>> Pi(ask.model.n_bodies());
  body_momenta<Spatial>(ask.model, workspace, ask.state.q, ask.state.v, Pi);
  std::vector<double> v(ask.model.nv());
  std::vector<Wrench<Spatial>> dPi(Pi.size());
  require(ask,
          spatial_momentum_form(ask.model, workspace, ask.state.q, Pi, ask.state.tau, v, dPi, ask.loads()));
  return body_rates_answer(ask, "", "N m, N", {"body", "l' x", "l' y", "l' z", "p' x", "p' y", "p' z"}, "dPi",
                           v, dPi);
}
Answer inverse_dynamics_rates_answer(const Question& ask) {
  const std::vector<double> rates = rates_of(ask.state);
  std::vector<double> tau(3 * ask.state.v.size());
  if (ask.model.loops().empty()) {
    InverseDynamicsRates<>(ask.model, 2).evaluate(ask.state.q, rates, tau, ask.loads());
  } else {
    LoopWorkspace<> workspace(ask.model);
    check_driven(inverse_dynamics_rates(ask.model, workspace, ask.state.q, rates, tau, {}, ask.loads()),
                 "make this motion");
  }
  Answer answer{Json::array(), Table({"joint", "tau", "tau'", "tau\""})};
  const std::vector<std::string> names = velocity_names(ask.model);
  const std::size_t nv = names.size();
  for (std::size_t order = 0; order < 3; ++order)
    answer.value.push_back(std::vector(tau.begin() + order * nv, tau.begin() + (order + 1) * nv));
  for (std::size_t k = 0; k < nv; ++k) answer.table.row({names[k], tau[k], tau[nv + k], tau[2 * nv + k]});
  return answer;
}
Answer inertial_parameters_answer(const Question& ask) {
  const std::vector<double> pi = inertial_parameters(ask.model);
  Answer answer{pi, Table({"parameter", "pi"}), "kg, kg m, kg m^2"};
  const std::vector<std::string> names = parameter_names(ask.model);
  for (std::size_t k = 0; k < names.size(); ++k) answer.table.row({names[k], pi[k]});
  return answer;
}

}  // namespace

std::vector<Quantity> other_quantities() {
  return {
      {"jacobian_derivative",
       "The time derivative of --order of the Jacobian of a frame has a column for each velocity.",
       jacobian_derivative_answer},
      {"jacobian_partials",
       "The partial derivatives of --order of the Jacobian of a frame by the configuration have a column "
       "for each velocity, and the outermost derivative comes first.",
       jacobian_partials_answer},
      {"jerk", "The jerks are the second time derivatives of the components of the twists.", jerk_answer},
      {"snap", "The snaps are the third time derivatives of the components of the twists.", snap_answer},
      {"twist_derivative", "The rates are the time derivatives of --order of the components of the twists.",
       twist_derivative_answer},
      {"system_matrices",
       "The sparse matrices A, D and X satisfy V = A X v and (I - D) A = I for the twists V of all bodies, "
       "six rows for each body.",
       system_matrices_answer},
      {"inverse_kinematics",
       "The configuration q puts frames into the poses of the state's \"targets\", and is sought from the "
       "state's q.",
       inverse_kinematics_answer},
      {"mass_matrix_factors",
       "The factors L, which the table has, and D of the mass matrix satisfy M = L^T D L.",
       mass_matrix_factors_answer},
      {"twist_form",
       "The rates of the state (q, V) under the drive forces tau are those with the twists V of the bodies "
       "at the state's v.",
       twist_form_answer},
      {"spatial_momentum_form",
       "The rates of the state (q, Pi) under the drive forces tau are those with the spatial momenta Pi of "
       "the bodies at the state's v.",
       spatial_momentum_form_answer},
      {"inverse_dynamics_rates",
       "The drive forces tau and their first two time derivatives follow from a, jerk and snap.",
       inverse_dynamics_rates_answer},
      {"inertial_parameters",
       "The ten inertial parameters pi of each body are given in its frame, with what is fixed to it.",
       inertial_parameters_answer},
  };
}

}  // namespace axode::command
