#include "axode/kinematics.hpp"
#include "axode/kinematics/system_matrices.hpp"
#include "columns.hpp"
#include "commands.hpp"
#include "quantities.hpp"

/// Jacobians, their derivatives, and the motion of higher order.
namespace axode::command {
namespace {

std::string columns_label(const std::string& what, const Question& ask) {
  return headline(what + ", a column for each velocity", ask.representation, twist_axes(ask.representation),
                  "per unit of the velocity");
}

Answer jacobian_answer(const Question& ask) {
  return with_representation(ask.representation, [&](auto rep) {
    using Rep = decltype(rep);
    Workspace<> workspace(ask.model);
    return columns_each<Twist<Rep>>(ask, columns_label("V = J v", ask), [&](auto& J, int frame) {
      jacobian<Rep>(ask.model, workspace, ask.state.q, frame, J);
    });
  });
}

Answer relative_jacobian_answer(const Question& ask) {
  return with_representation(ask.representation, [&](auto rep) {
    using Rep = decltype(rep);
    Workspace<> workspace(ask.model);
    const std::string label =
        columns_label("motion relative to frame \"" + ask.model.frame(ask.relative_to).name +
                          "\", which takes the place of the inertial frame",
                      ask);
    return columns_each<Twist<Rep>>(ask, label, [&](auto& J, int frame) {
      relative_jacobian<Rep>(ask.model, workspace, ask.state.q, frame, ask.relative_to, J);
    });
  });
}

/// The motion at the state, up to an order of twist derivatives.
HigherOrderMotion<> motion_of(const Question& ask, int order) {
  std::vector<double> rates = ask.state.v;
  for (const std::vector<double>* next : {&ask.state.a, &ask.state.jerk, &ask.state.snap})
    rates.insert(rates.end(), next->begin(), next->end());
  rates.resize((order + 1) * ask.model.nv());  // nothing further is given: zero
  HigherOrderMotion<> motion(ask.model, order);
  motion.evaluate(ask.state.q, rates);
  return motion;
}

Answer jacobian_derivative(const Question& ask, int order) {
  return with_representation(ask.representation, [&](auto rep) {
    using Rep = decltype(rep);
    const HigherOrderMotion<> motion = motion_of(ask, order);
    const std::string label =
        columns_label("time derivative of order " + std::to_string(order) + " of the Jacobian", ask);
    return columns_each<TwistRate<Rep>>(
        ask, label, [&](auto& J, int frame) { motion.jacobian_derivative<Rep>(frame, order, J); });
  });
}
Answer jacobian_rate_answer(const Question& ask) { return jacobian_derivative(ask, 1); }
Answer jacobian_derivative_answer(const Question& ask) { return jacobian_derivative(ask, ask.order); }

Answer twist_derivative(const Question& ask, const std::string& name, int order) {
  return with_representation(ask.representation, [&](auto rep) {
    using Rep = decltype(rep);
    const HigherOrderMotion<> motion = motion_of(ask, order);
    Answer answer{
        headline(name + ": time derivative of order " + std::to_string(order) + " of the twists' components",
                 ask.representation, twist_axes(ask.representation), "rad, m and s"),
        Json::object(), Table({"frame", "w x", "w y", "w z", "v x", "v y", "v z"})};
    for (const int frame : frames_of(ask)) {
      const TwistRate<Rep> V = motion.twist_derivative<Rep>(frame, order);
      answer.value[ask.model.frame(frame).name] = to_json(V);
      answer.table.row({ask.model.frame(frame).name, V.w.x, V.w.y, V.w.z, V.v.x, V.v.y, V.v.z});
    }
    return answer;
  });
}
Answer jerk_answer(const Question& ask) { return twist_derivative(ask, "jerk", 2); }
Answer snap_answer(const Question& ask) { return twist_derivative(ask, "snap", 3); }
Answer twist_derivative_answer(const Question& ask) { return twist_derivative(ask, "twist", ask.order); }

/// The tensor as nested lists: an index for each derivative, the outermost first, then six rows of nv
/// entries.
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
    Answer answer{columns_label("partial derivatives of order " + std::to_string(ask.order) +
                                    " of the Jacobian; outermost derivative first",
                                ask),
                  Json::object(), Table({"frame", "entries", "largest"})};
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

Answer joint_screws_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  std::vector<Twist<Spatial>> J(ask.model.n_screws());
  joint_screws(ask.model, workspace, ask.state.q, J);
  Answer answer{"instantaneous joint screws in inertial axes about the inertial origin", Json::object(),
                Table({"joint", "w x", "w y", "w z", "v x", "v y", "v z"})};
  for (int i = 1; i <= ask.model.n_bodies(); ++i) {
    Json& screws = answer.value[ask.model.joint(i).name] = Json::array();
    for (int s = ask.model.first_screw(i); s < ask.model.first_screw(i + 1); ++s) {
      screws.push_back(to_json(J[s]));
      answer.table.row({ask.model.joint(i).name, J[s].w.x, J[s].w.y, J[s].w.z, J[s].v.x, J[s].v.y, J[s].v.z});
    }
  }
  return answer;
}

Answer center_of_mass_jacobian_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  std::vector<Vec3<>> J(ask.model.nv());
  center_of_mass_jacobian(ask.model, workspace, ask.state.q, J);
  Answer answer{"velocity of the centre of mass for a unit of each velocity, in inertial axes",
                Json{Json::array(), Json::array(), Json::array()}, Table({"velocity", "x", "y", "z"})};
  const std::vector<std::string> names = velocity_names(ask.model);
  for (std::size_t c = 0; c < J.size(); ++c) {
    const double x[3] = {J[c].x, J[c].y, J[c].z};
    for (int r = 0; r < 3; ++r) answer.value[r].push_back(x[r]);
    answer.table.row({names[c], x[0], x[1], x[2]});
  }
  return answer;
}

template <class Column, class F> Answer momentum_columns(const Question& ask, std::string label, F&& f) {
  Workspace<> workspace(ask.model);
  std::vector<Column> columns(ask.model.nv());
  f(workspace, columns);
  Answer answer{std::move(label), rows_of(columns),
                Table({"", "velocity", "l x", "l y", "l z", "p x", "p y", "p z"})};
  tabulate(ask.model, "", columns, answer.table);
  return answer;
}
Answer centroidal_momentum_matrix_answer(const Question& ask) {
  return momentum_columns<Momentum<Hybrid>>(
      ask, "momentum about the centre of mass for a unit of each velocity, in inertial axes",
      [&](auto& workspace, auto& A) { centroidal_momentum_matrix(ask.model, workspace, ask.state.q, A); });
}
Answer centroidal_momentum_matrix_rate_answer(const Question& ask) {
  return momentum_columns<Wrench<Hybrid>>(
      ask, "time derivative of the centroidal momentum matrix", [&](auto& workspace, auto& dA) {
        centroidal_momentum_matrix_rate(ask.model, workspace, ask.state.q, ask.state.v, dA);
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
    Answer answer{headline("V = A X v of all bodies, (I - D) A = I", ask.representation,
                           twist_axes(ask.representation), "six rows for each body in the model's order"),
                  Json{{"A", dense(system.A)}, {"D", dense(system.D)}, {"X", dense(system.X)}},
                  Table({"matrix", "rows", "columns", "entries not zero"})};
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
  Answer answer{"a configuration in which the frames take the poses of the targets, from q; " +
                    std::string(to_string(result.status)) + ", error " + significant(result.residual),
                Json{{"status", to_string(result.status)},
                     {"q", result.q},
                     {"residual", result.residual},
                     {"iterations", result.iterations},
                     {"restarts", result.restarts}},
                Table({"coordinate", "q"})};
  const std::vector<std::string> names = coordinate_names(ask.model);
  for (std::size_t k = 0; k < names.size(); ++k) answer.table.row({names[k], result.q[k]});
  return answer;
}

}  // namespace

std::vector<Quantity> kinematic_quantities() {
  return {
      {"jacobian", "of every frame, or of --frame", jacobian_answer},
      {"jacobian_rate", "its time derivative", jacobian_rate_answer},
      {"jacobian_derivative", "its time derivative of --order", jacobian_derivative_answer},
      {"jacobian_partials", "its partial derivatives of --order in the configuration",
       jacobian_partials_answer},
      {"relative_jacobian", "of frames relative to the frame --relative-to", relative_jacobian_answer},
      {"joint_screws", "the instantaneous screws of all joints", joint_screws_answer},
      {"jerk", "the second time derivatives of the twists", jerk_answer},
      {"snap", "the third time derivatives of the twists", snap_answer},
      {"twist_derivative", "the time derivatives of --order of the twists", twist_derivative_answer},
      {"center_of_mass_jacobian", "of all moving bodies", center_of_mass_jacobian_answer},
      {"centroidal_momentum_matrix", "momentum about the centre of mass", centroidal_momentum_matrix_answer},
      {"centroidal_momentum_matrix_rate", "its time derivative", centroidal_momentum_matrix_rate_answer},
      {"system_matrices", "the sparse factors A, D and X of the system Jacobian", system_matrices_answer},
      {"inverse_kinematics", "joint coordinates for the poses in the state's \"targets\"",
       inverse_kinematics_answer},
  };
}

}  // namespace axode::command
