#include "apps/quantities/written_motion.hpp"

#include <algorithm>
#include <utility>

#include "apps/files/contact_tables.hpp"
#include "apps/files/matrix_file.hpp"
#include "apps/quantities/components.hpp"
#include "axode/constraints/prescribed/prescribed_motion.hpp"
#include "axode/drives.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/view.hpp"

namespace axode::command {
namespace {

std::vector<std::string> motion_names(const Model& model) {
  std::vector<std::string> names;
  for (const MotionDescription& motion : model.motions()) names.push_back(motion_name(motion));
  return names;
}

/// Adds the wrench of each load to the six columns of its frame in row k; C has the poses of all frames.
void add_loads(std::span<const AppliedWrench<>> loads, const std::vector<SE3<>>& C, Eigen::Index k,
               WrittenMotion& rows) {
  for (const AppliedWrench<>& load : loads) {
    const auto on = std::ranges::lower_bound(rows.load_frames, load.frame) - rows.load_frames.begin();
    const Wrench<Hybrid> W = view::wrench_in<Hybrid>(load, C[static_cast<std::size_t>(load.frame)]);
    rows.loads.row(k).segment<6>(6 * on) += to_eigen(W).transpose();
  }
}

/// The names of the columns of loads: moments, then forces, of each frame.
std::vector<std::string> load_names(const Model& model, const std::vector<int>& frames) {
  std::vector<std::string> names;
  for (const int frame : frames)
    for (const char* what : {"load moment: ", "load force: "})
      for (const char* axis : {" x", " y", " z"}) names.push_back(what + model.frame(frame).name + axis);
  return names;
}

}  // namespace

WrittenMotion written_motion(const Trajectory& motion, const Drive& drive, const Loads<>& loads,
                             int samples) {
  const Model& model = motion.model();
  const bool stopped = !motion.certificates.empty() && has_hard_stops(model);
  const auto motions = static_cast<Eigen::Index>(stopped ? 0 : model.motions().size());
  std::vector<double> times(motion.t().begin(), motion.t().end());
  if (samples > 0) {
    times.clear();
    for (int k = 0; k <= samples; ++k)
      times.push_back(k == samples ? motion.t().back() : motion.t().back() * k / samples);
  }
  const auto N = static_cast<Eigen::Index>(times.size());
  const Eigen::Index nq = model.nq(), nv = model.nv();
  WrittenMotion rows{.t = Eigen::VectorXd(N),
                     .energy = Eigen::VectorXd(N),
                     .kinetic_energy = Eigen::VectorXd(N),
                     .q = Eigen::MatrixXd(N, nq),
                     .v = Eigen::MatrixXd(N, nv),
                     .a = Eigen::MatrixXd(N, nv),
                     .tau = Eigen::MatrixXd(N, nv),
                     .motion_forces = Eigen::MatrixXd(N, motions),
                     .drive_states = {motion.drive_states().begin(), motion.drive_states().end()},
                     .x = Eigen::MatrixXd(N, static_cast<Eigen::Index>(motion.nx())),
                     .load_frames = {},
                     .loads = {}};
  const std::vector<AppliedWrench<>> constant(loads.wrenches.begin(), loads.wrenches.end());
  rows.load_frames = view::loaded_frames({&constant, 1});
  rows.loads = Eigen::MatrixXd::Zero(N, 6 * std::ssize(rows.load_frames));
  std::vector<SE3<>> C(static_cast<std::size_t>(model.n_frames()));
  DriveSystem drives(model);
  std::vector<double> q(static_cast<std::size_t>(model.nq())), v(static_cast<std::size_t>(model.nv()));
  std::vector<double> a(v), tau(v), x(motion.nx()), dx(x);
  Workspace<> workspace(model);
  for (Eigen::Index k = 0; k < N; ++k) {
    const double t = times[static_cast<std::size_t>(k)];
    motion.at(t, q, v, a);
    drive(t, q, v, tau);
    if (!drives.empty()) {
      motion.drive_states_at(t, x);
      drives.set_state(t, q, v, x);
      drives.evaluate(t, q, v, x, tau, dx);
      rows.x.row(k) = as_eigen(std::span<const double>(x)).transpose();
    }
    rows.t[k] = t;
    for (const auto& [matrix, row] :
         {std::pair{&rows.q, &q}, {&rows.v, &v}, {&rows.a, &a}, {&rows.tau, &tau}})
      matrix->row(k) = as_eigen(std::span<const double>(*row)).transpose();
    rows.kinetic_energy[k] = kinetic_energy(model, workspace, std::span<const double>(q), v);
    rows.energy[k] = rows.kinetic_energy[k] + potential_energy(model, workspace, std::span<const double>(q)) +
                     elastic_energy(model, workspace, std::span<const double>(q));
    if (!rows.load_frames.empty()) {
      poses(model, workspace, std::span<const double>(q), C);
      add_loads(loads.wrenches, C, k, rows);
    }
    if (motions == 0) continue;
    add_spring_forces(model, workspace, q, v, tau);
    std::vector<AppliedWrench<>> acting = constant;
    for (const ContactForce& contact : motion.contacts_at(t)) {
      const Vec3<> m = cross(contact.point, contact.force) + contact.moment;
      acting.emplace_back(contact.body_a, Wrench<Spatial>{-m, -contact.force});
      acting.emplace_back(contact.body_b, Wrench<Spatial>{m, contact.force});
    }
    const DynamicsAtTime found = forward_dynamics_at(model, t, q, v, tau, {acting, loads.joint_losses});
    rows.motion_forces.row(k) = as_eigen(std::span<const double>(found.motion_forces)).transpose();
  }
  return rows;
}

std::string csv_of(const Model& model, const WrittenMotion& rows) {
  std::vector<std::string> names{"t"};
  const auto add = [&](const char* what, const std::vector<std::string>& all) {
    for (const std::string& name : all) names.push_back(what + name);
  };
  add("q ", coordinate_names(model));
  for (const char* what : {"v ", "a ", "tau "}) add(what, velocity_names(model));
  names.push_back("energy");
  add("x ", rows.drive_states);
  add("", load_names(model, rows.load_frames));
  Eigen::MatrixXd all(rows.t.size(), static_cast<Eigen::Index>(names.size()));
  all << rows.t, rows.q, rows.v, rows.a, rows.tau, rows.energy, rows.x, rows.loads;
  return as_csv(all, names);
}

Json json_of(const Trajectory& motion, const WrittenMotion& rows, const std::string& method,
             const std::string& coordinates) {
  const Model& model = motion.model();
  const auto list = [](const auto& numbers) {
    return Json(std::vector<double>(numbers.begin(), numbers.end()));
  };
  const auto lists = [&](const Eigen::MatrixXd& matrix) {
    Json all = Json::array();
    for (const auto& row : matrix.rowwise()) all.push_back(list(row));
    return all;
  };
  Json json{{"model", model.name()},
            {"method", method},
            {"computed_in", coordinates},
            {"coordinates", coordinate_names(model)},
            {"velocities", velocity_names(model)},
            {"steps", motion.steps},
            {"evaluations", motion.evaluations},
            {"certificates", motion.certificates},
            {"complete", motion.complete},
            {"stopped", motion.stop_reason},
            {"t", list(rows.t)},
            {"q", lists(rows.q)},
            {"v", lists(rows.v)},
            {"a", lists(rows.a)},
            {"tau", lists(rows.tau)},
            {"energy", list(rows.energy)}};
  if (!motion.contact_shapes.empty()) {
    json["contact_shapes"] = motion.contact_shapes;
    for (const double t : rows.t)
      json["contacts"].push_back(contacts_json(motion.contact_shapes, motion.contacts_at(t)));
  }
  for (const Trajectory::ContactEvent& event : motion.contact_events)
    json["contact_events"].push_back({{"kind", to_string(event.kind)},
                                      {"t", event.t},
                                      {"of", event.of},
                                      {"speed", event.speed},
                                      {"shortened", event.shortened}});
  if (rows.motion_forces.cols() > 0) {
    json["motions"] = motion_names(model);
    json["motion_forces"] = lists(rows.motion_forces);
  }
  if (rows.x.cols() > 0) {
    json["drive_states"] = rows.drive_states;
    json["x"] = lists(rows.x);
  }
  if (!rows.load_frames.empty()) {
    for (const int frame : rows.load_frames) json["load_frames"].push_back(model.frame(frame).name);
    json["loads"] = lists(rows.loads);
  }
  return json;
}

std::string npz_of(const WrittenMotion& rows) {
  std::vector<NamedArray> arrays{{"t", rows.t, true}, {"q", rows.q},     {"v", rows.v},
                                 {"a", rows.a},       {"tau", rows.tau}, {"energy", rows.energy, true}};
  if (rows.motion_forces.cols() > 0) arrays.push_back({"motion_forces", rows.motion_forces});
  if (rows.x.cols() > 0) arrays.push_back({"x", rows.x});
  if (!rows.load_frames.empty()) {
    const Eigen::Map<const Eigen::VectorXi> frames(rows.load_frames.data(), std::ssize(rows.load_frames));
    arrays.push_back({"load_frames", frames.cast<double>(), true});
    arrays.push_back({"loads", rows.loads});
  }
  return as_npz(arrays);
}

Chart chart_of(const Trajectory& motion, const WrittenMotion& rows) {
  const Model& model = motion.model();
  Chart chart{.title = model.name()};
  const std::vector<double> t(rows.t.begin(), rows.t.end());
  const auto add = [&](const std::string& symbol, const std::string& unit,
                       const std::vector<std::string>& names, const Eigen::MatrixXd& columns) {
    Panel panel{.y_axis = symbol + ", " + unit, .name = symbol};
    for (std::size_t k = 0; k < names.size(); ++k) {
      const auto column = columns.col(static_cast<Eigen::Index>(k));
      panel.curves.push_back({.name = names[k], .x = t, .y = {column.begin(), column.end()}});
    }
    chart.panels.push_back(panel);
  };
  const std::vector<Component> velocities = velocity_components(model);
  add_panels(chart, "q", coordinate_components(model), {"rad", "m"}, t, rows.q);
  add_panels(chart, "v", velocities, {"rad/s", "m/s"}, t, rows.v);
  if (!rows.tau.isZero(0)) add_panels(chart, "tau", velocities, {"N m", "N"}, t, rows.tau);
  if (rows.motion_forces.cols() > 0)
    add("force of motions", "N m, N", motion_names(model), rows.motion_forces);
  for (Panel& panel : contact_panels(motion, t)) chart.panels.push_back(std::move(panel));
  Eigen::MatrixXd energies(rows.t.size(), 3);
  energies << rows.kinetic_energy, rows.energy - rows.kinetic_energy, rows.energy;
  add("energy", "J", {"kinetic", "potential", "total"}, energies);
  chart.panels.back().x_axis = "t, s";
  return chart;
}

}  // namespace axode::command
