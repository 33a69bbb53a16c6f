#include "axode/dynamics.hpp"
#include "columns.hpp"
#include "commands.hpp"
#include "quantities.hpp"

/// Mass and Coriolis matrices, forward dynamics, momenta, energies, regressors and what a frame shows to a
/// wrench.
namespace axode::command {
namespace {

/// Everything here fails in one way: the mass matrix is singular.
void require(const Question& ask, const Solvability& solvability) {
  if (!solvability.ok()) throw InputError(to_string(ask.model, solvability));
}

Loads<> loads_of(const Question& ask) { return {ask.state.loads, ask.joint_losses}; }

Json rows_of(std::span<const double> entries, std::size_t width) {
  Json rows = Json::array();
  for (std::size_t at = 0; at < entries.size(); at += width)
    rows.push_back(std::vector<double>(entries.begin() + at, entries.begin() + at + width));
  return rows;
}
void tabulate(std::span<const double> entries, const std::vector<std::string>& names, Table& table) {
  for (std::size_t r = 0; r < names.size(); ++r) {
    std::vector<Cell> cells{names[r]};
    for (const double x : entries.subspan(r * names.size(), names.size())) cells.emplace_back(x);
    table.row(std::move(cells));
  }
}
std::vector<std::string> heading(const std::string& first, const std::vector<std::string>& names) {
  std::vector<std::string> headings{first};
  headings.insert(headings.end(), names.begin(), names.end());
  return headings;
}

/// A number for each velocity, filled by f(span).
template <class F>
Answer vector_answer(const Question& ask, std::string label, const char* symbol, const F& f) {
  std::vector<double> x(ask.model.nv());
  f(x);
  Answer answer{std::move(label), x, Table({"velocity", symbol})};
  const std::vector<std::string> names = velocity_names(ask.model);
  for (std::size_t c = 0; c < names.size(); ++c) answer.table.row({names[c], x[c]});
  return answer;
}
/// A number for each pair of velocities.
template <class F> Answer matrix_answer(const Question& ask, std::string label, const F& f) {
  const std::size_t nv = ask.model.nv();
  std::vector<double> M(nv * nv);
  f(M);
  const std::vector<std::string> names = velocity_names(ask.model);
  Answer answer{std::move(label), rows_of(M, std::max<std::size_t>(1, nv)),
                Table(heading("velocity", names))};
  tabulate(M, names, answer.table);
  return answer;
}
/// A number for each three velocities; a matrix for each value of the first.
template <class F>
Answer tensor_answer(const Question& ask, std::string label, const std::string& first, const F& f) {
  const std::size_t nv = ask.model.nv();
  std::vector<double> X(nv * nv * nv);
  f(X);
  const std::vector<std::string> names = velocity_names(ask.model);
  Answer answer{std::move(label), Json::array(), Table(heading(first, names))};
  for (std::size_t k = 0; k < nv; ++k) {
    const auto matrix = std::span<const double>(X).subspan(k * nv * nv, nv * nv);
    answer.value.push_back(rows_of(matrix, nv));
    for (std::size_t r = 0; r < nv; ++r) {
      std::vector<Cell> cells{r == 0 ? names[k] : ""};
      for (const double x : matrix.subspan(r * nv, nv)) cells.emplace_back(x);
      answer.table.row(std::move(cells));
    }
    answer.table.rule();
  }
  return answer;
}
Answer number_answer(std::string label, const char* symbol, double x) {
  Answer answer{std::move(label), x, Table({symbol})};
  answer.table.row({x});
  return answer;
}
template <class CoScrew> Answer momentum_answer(std::string label, const CoScrew& Pi) {
  Answer answer{std::move(label), to_json(Pi), Table({"l x", "l y", "l z", "p x", "p y", "p z"})};
  answer.table.row({Pi.l.x, Pi.l.y, Pi.l.z, Pi.p.x, Pi.p.y, Pi.p.z});
  return answer;
}

Answer mass_matrix_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return matrix_answer(ask, "M(q), armatures included; kg m^2, kg m, kg",
                       [&](auto& M) { mass_matrix(ask.model, workspace, ask.state.q, M); });
}
Answer inverse_mass_matrix_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return matrix_answer(ask, "of M(q)", [&](auto& M) {
    require(ask, inverse_mass_matrix(ask.model, workspace, ask.state.q, M));
  });
}
Answer mass_matrix_factors_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  MassMatrixFactor<> factor(ask.model);
  const std::size_t nv = ask.model.nv();
  std::vector<double> M(nv * nv), L, D;
  mass_matrix(ask.model, workspace, ask.state.q, M);
  require(ask, factor.factorize(M));
  for (int r = 0; r < ask.model.nv(); ++r) {
    D.push_back(factor.D(r));
    for (int c = 0; c < ask.model.nv(); ++c) L.push_back(factor.L(r, c));
  }
  const std::vector<std::string> names = velocity_names(ask.model);
  Answer answer{"M = L^T D L; the table has L",
                Json{{"L", rows_of(L, std::max<std::size_t>(1, nv))}, {"D", D}},
                Table(heading("velocity", names))};
  tabulate(L, names, answer.table);
  return answer;
}
Answer inverse_mass_matrix_partials_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return tensor_answer(ask, "d(M^-1)/dq_k, a matrix for each k", "k", [&](auto& dM) {
    require(ask, inverse_mass_matrix_partials(ask.model, workspace, ask.state.q, dM));
  });
}
Answer mass_matrix_partials_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return tensor_answer(ask, "dM/dq_k, a matrix for each k", "k",
                       [&](auto& dM) { mass_matrix_partials(ask.model, workspace, ask.state.q, dM); });
}
Answer forward_dynamics_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return vector_answer(
      ask, "accelerations that the drive forces tau make; rad/s^2, m/s^2", "a", [&](auto& a) {
        with_representation(ask.representation, [&](auto rep) {
          require(ask, forward_dynamics<decltype(rep)>(ask.model, workspace, ask.state.q, ask.state.v,
                                                       ask.state.tau, a, loads_of(ask)));
        });
      });
}

Answer coriolis_matrix_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return matrix_answer(ask, "C(q, v), C v being the Coriolis vector", [&](auto& C) {
    coriolis_matrix(ask.model, workspace, ask.state.q, ask.state.v, ask.coriolis, C);
  });
}
Answer coriolis_vector_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return vector_answer(ask, "C(q, v) v, without gravity and loads; N m, N", "C v",
                       [&](auto& x) { coriolis_vector(ask.model, workspace, ask.state.q, ask.state.v, x); });
}
Answer gravity_vector_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return vector_answer(ask, "drive forces that hold the system at rest; N m, N", "g",
                       [&](auto& x) { gravity_vector(ask.model, workspace, ask.state.q, x); });
}
Answer generalized_loads_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return vector_answer(ask, "generalised forces of the loads; N m, N", "Q", [&](auto& x) {
    generalized_loads(ask.model, workspace, ask.state.q, ask.state.v, loads_of(ask), x);
  });
}
Answer christoffel_symbols_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return tensor_answer(ask, "of the first kind, Gamma_ijk, a matrix over (j, k) for each i", "i",
                       [&](auto& Gamma) { christoffel_symbols(ask.model, workspace, ask.state.q, Gamma); });
}

std::vector<double> momenta_of(const Question& ask, Workspace<>& workspace) {
  if (!ask.state.p.empty()) return ask.state.p;
  std::vector<double> p(ask.model.nv());
  generalized_momenta(ask.model, workspace, ask.state.q, ask.state.v, p);
  return p;
}
Answer generalized_momenta_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return vector_answer(ask, "p = M v; N m s, N s", "p", [&](auto& p) {
    generalized_momenta(ask.model, workspace, ask.state.q, ask.state.v, p);
  });
}
Answer momentum_form_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  const std::vector<double> p = momenta_of(ask, workspace);
  std::vector<double> v(p.size()), dp(p.size());
  require(ask, momentum_form(ask.model, workspace, ask.state.q, p, ask.state.tau, v, dp, loads_of(ask)));
  Answer answer{
      "rates of the state (q, p) under the drive forces tau; p is the state's, or M v where it has none",
      Json{{"p", p}, {"v", v}, {"dp", dp}}, Table({"velocity", "p", "v", "p'"})};
  const std::vector<std::string> names = velocity_names(ask.model);
  for (std::size_t c = 0; c < names.size(); ++c) answer.table.row({names[c], p[c], v[c], dp[c]});
  return answer;
}
/// The rates of a state of which each body has six unknowns: v, and a rate of type Rate by body.
template <class Rate>
Answer body_rates_answer(const Question& ask, std::string label, std::vector<std::string> headings,
                         const char* key, const std::vector<double>& v, const std::vector<Rate>& rates) {
  Answer answer{std::move(label), Json{{"v", v}, {key, Json::object()}}, Table(std::move(headings))};
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
                                 v, dV, loads_of(ask)));
    return body_rates_answer(
        ask,
        headline("rates of the state (q, V) under the drive forces tau, V being the twists of "
                 "the bodies at the state's v",
                 ask.representation, twist_axes(ask.representation), "rad/s^2, m/s^2"),
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
          spatial_momentum_form(ask.model, workspace, ask.state.q, Pi, ask.state.tau, v, dPi, loads_of(ask)));
  return body_rates_answer(
      ask,
      "rates of the state (q, Pi) under the drive forces tau, Pi being the spatial momenta of "
      "the bodies at the state's v; N m, N",
      {"body", "l' x", "l' y", "l' z", "p' x", "p' y", "p' z"}, "dPi", v, dPi);
}
Answer body_momenta_answer(const Question& ask) {
  return with_representation(ask.representation, [&](auto rep) {
    Workspace<> workspace(ask.model);
    std::vector<Momentum<decltype(rep)>> Pi(ask.model.n_bodies());
    body_momenta<decltype(rep)>(ask.model, workspace, ask.state.q, ask.state.v, Pi);
    Answer answer{headline("momenta (l; p) of the bodies", ask.representation,
                           wrench_axes(ask.representation), "N m s, N s"),
                  Json::object(), Table({"body", "l x", "l y", "l z", "p x", "p y", "p z"})};
    for (int i = 1; i <= ask.model.n_bodies(); ++i) {
      const auto& [l, p] = Pi[i - 1];
      answer.value[ask.model.body(i).name] = to_json(Pi[i - 1]);
      answer.table.row({ask.model.body(i).name, l.x, l.y, l.z, p.x, p.y, p.z});
    }
    return answer;
  });
}
Answer spatial_momentum_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return momentum_answer("of the whole system, about the inertial origin; N m s, N s",
                         spatial_momentum(ask.model, workspace, ask.state.q, ask.state.v));
}
Answer centroidal_momentum_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return momentum_answer("of the whole system, about its centre of mass, in inertial axes; N m s, N s",
                         centroidal_momentum(ask.model, workspace, ask.state.q, ask.state.v));
}
Answer kinetic_energy_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return number_answer("of bodies and armatures; J", "T",
                       kinetic_energy(ask.model, workspace, ask.state.q, ask.state.v));
}
Answer potential_energy_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return number_answer("of gravity, 0 at the inertial origin; J", "U",
                       potential_energy(ask.model, workspace, ask.state.q));
}
Answer load_powers_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  std::vector<double> power(ask.state.loads.size());
  load_powers(ask.model, workspace, ask.state.q, ask.state.v, loads_of(ask), power);
  Answer answer{"that every load puts into the system; W", power, Table({"load on frame", "power"})};
  for (std::size_t k = 0; k < power.size(); ++k)
    answer.table.row({ask.model.frame(ask.state.loads[k].frame).name, power[k]});
  return answer;
}
Answer centroidal_inertia_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  const Inertia<> M = centroidal_inertia(ask.model, workspace, ask.state.q);
  Answer answer{
      "mass and rotational inertia of the whole about its centre of mass, in inertial axes; kg, kg m^2",
      Json{{"mass", M.m}, {"inertia", to_json(M.Theta)}},
      Table({"mass", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"})};
  answer.table.row({M.m, M.Theta.xx, M.Theta.yy, M.Theta.zz, M.Theta.xy, M.Theta.xz, M.Theta.yz});
  return answer;
}

/// Ten columns for each body.
std::vector<std::string> parameter_names(const Model& model) {
  std::vector<std::string> names;
  for (int i = 1; i <= model.n_bodies(); ++i)
    for (const char* parameter : {"m", "m cx", "m cy", "m cz", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"})
      names.push_back(model.body(i).name + " " + parameter);
  return names;
}
Answer torque_regressor_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  const std::size_t nv = ask.model.nv(), width = 10 * ask.model.n_bodies();
  std::vector<double> Y(nv * width);
  torque_regressor(ask.model, workspace, ask.state.q, ask.state.v, ask.state.a, Y);
  Answer answer{
      "Y in Y pi = M a + C v + g, with ten inertial parameters pi for each body, see inertial_parameters",
      rows_of(Y, std::max<std::size_t>(1, width)), Table(heading("parameter", velocity_names(ask.model)))};
  const std::vector<std::string> names = parameter_names(ask.model);
  for (std::size_t k = 0; k < width; ++k) {
    std::vector<Cell> cells{names[k]};
    for (std::size_t c = 0; c < nv; ++c) cells.emplace_back(Y[c * width + k]);
    answer.table.row(std::move(cells));
  }
  return answer;
}
Answer parameters_answer(const Question& ask, std::string label, const char* symbol,
                         const std::vector<double>& x) {
  Answer answer{std::move(label), x, Table({"parameter", symbol})};
  const std::vector<std::string> names = parameter_names(ask.model);
  for (std::size_t k = 0; k < names.size(); ++k) answer.table.row({names[k], x[k]});
  return answer;
}
Answer inertial_parameters_answer(const Question& ask) {
  return parameters_answer(ask, "of every body in its frame, with what is fixed to it; kg, kg m, kg m^2",
                           "pi", inertial_parameters(ask.model));
}
Answer kinetic_energy_regressor_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  std::vector<double> y(10 * ask.model.n_bodies());
  kinetic_energy_regressor(ask.model, workspace, ask.state.q, ask.state.v, y);
  return parameters_answer(ask, "y in y pi = kinetic energy of the bodies", "y", y);
}
Answer potential_energy_regressor_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  std::vector<double> y(10 * ask.model.n_bodies());
  potential_energy_regressor(ask.model, workspace, ask.state.q, y);
  return parameters_answer(ask, "y in y pi = potential energy", "y", y);
}

/// Six rows of six numbers for every frame asked for, filled by f(rep, frame, span).
template <class F> Answer six_by_six_each(const Question& ask, std::string label, const F& f) {
  Answer answer{std::move(label), Json::object(),
                Table({"frame", "angular x", "angular y", "angular z", "linear x", "linear y", "linear z"})};
  for (const int frame : frames_of(ask)) {
    std::array<double, 36> M{};
    with_representation(ask.representation, [&](auto rep) { f(rep, frame, std::span<double>(M)); });
    const std::string& name = ask.model.frame(frame).name;
    answer.value[name] = rows_of(M, 6);
    for (std::size_t r = 0; r < 6; ++r) {
      std::vector<Cell> cells{r == 0 ? name : ""};
      for (std::size_t c = 0; c < 6; ++c) cells.emplace_back(M[6 * r + c]);
      answer.table.row(std::move(cells));
    }
    answer.table.rule();
  }
  return answer;
}
Answer mobility_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return six_by_six_each(ask,
                         headline("J M^-1 J^T: the twist that a frame gets from an impulse",
                                  ask.representation, twist_axes(ask.representation), "per N m s, N s"),
                         [&](auto rep, int frame, std::span<double> M) {
                           require(ask, mobility<decltype(rep)>(ask.model, workspace, ask.state.q, frame, M));
                         });
}
Answer operational_space_inertia_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  return six_by_six_each(
      ask,
      headline("(J M^-1 J^T)^-1: the inertia that a frame shows to a wrench", ask.representation,
               wrench_axes(ask.representation), "kg m^2, kg m, kg"),
      [&](auto rep, int frame, std::span<double> M) {
        const OperationalSpace outcome =
            operational_space_inertia<decltype(rep)>(ask.model, workspace, ask.state.q, frame, M);
        require(ask, outcome.mass_matrix);
        if (!outcome.ok())
          throw InputError(
              "operational_space_inertia: frame \"" + ask.model.frame(frame).name + "\" can move in " +
              std::to_string(outcome.directions) +
              " directions only, so that it has none; ask for its mobility, or for another --frame");
      });
}
Answer impulse_response_answer(const Question& ask) {
  return with_representation(ask.representation, [&](auto rep) {
    using Rep = decltype(rep);
    Workspace<> workspace(ask.model);
    return columns_each<Twist<Rep>>(
        ask,
        headline("M^-1 J^T, a column for each velocity: its jump for a unit of impulse on the frame",
                 ask.representation, wrench_axes(ask.representation), "per N m s, N s"),
        [&](auto& Y, int frame) {
          require(ask, impulse_response<Rep>(ask.model, workspace, ask.state.q, frame, Y));
        });
  });
}

}  // namespace

std::vector<Quantity> dynamic_quantities() {
  return {
      {"forward_dynamics", "the accelerations that the drive forces tau make", forward_dynamics_answer},
      {"mass_matrix", "M(q)", mass_matrix_answer},
      {"inverse_mass_matrix", "its inverse", inverse_mass_matrix_answer},
      {"mass_matrix_partials", "its partial derivatives in the configuration", mass_matrix_partials_answer},
      {"inverse_mass_matrix_partials", "those of its inverse", inverse_mass_matrix_partials_answer},
      {"mass_matrix_factors", "L and D of M = L^T D L", mass_matrix_factors_answer},
      {"coriolis_matrix", "C(q, v) in the form --coriolis", coriolis_matrix_answer},
      {"coriolis_vector", "C(q, v) v", coriolis_vector_answer},
      {"gravity_vector", "what holds the system at rest", gravity_vector_answer},
      {"generalized_loads", "the generalised forces of the loads", generalized_loads_answer},
      {"christoffel_symbols", "of the first kind", christoffel_symbols_answer},
      {"generalized_momenta", "p = M v", generalized_momenta_answer},
      {"momentum_form", "the rates of (q, p) under the drive forces tau", momentum_form_answer},
      {"twist_form", "the rates of (q, V) under the drive forces tau", twist_form_answer},
      {"spatial_momentum_form", "the rates of (q, Pi) under the drive forces tau",
       spatial_momentum_form_answer},
      {"body_momenta", "of every body", body_momenta_answer},
      {"spatial_momentum", "of the whole system", spatial_momentum_answer},
      {"centroidal_momentum", "about the centre of mass", centroidal_momentum_answer},
      {"kinetic_energy", "of bodies and armatures", kinetic_energy_answer},
      {"potential_energy", "of gravity", potential_energy_answer},
      {"load_powers", "that the loads put into the system", load_powers_answer},
      {"centroidal_inertia", "of the whole about its centre of mass", centroidal_inertia_answer},
      {"inertial_parameters", "ten for every body", inertial_parameters_answer},
      {"torque_regressor", "drive forces, linear in the inertial parameters", torque_regressor_answer},
      {"kinetic_energy_regressor", "kinetic energy, linear in them", kinetic_energy_regressor_answer},
      {"potential_energy_regressor", "potential energy, linear in them", potential_energy_regressor_answer},
      {"mobility", "J M^-1 J^T of every frame, or of --frame", mobility_answer},
      {"operational_space_inertia", "its inverse", operational_space_inertia_answer},
      {"impulse_response", "M^-1 J^T of every frame, or of --frame", impulse_response_answer},
  };
}

}  // namespace axode::command
