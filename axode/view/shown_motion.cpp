#include "axode/view/shown_motion.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>

#include "axode/constraints.hpp"
#include "axode/dynamics.hpp"
#include "axode/dynamics/spring_elements.hpp"
#include "axode/model/configuration.hpp"
#include "axode/scalar/text.hpp"
#include "axode/view/mesh_hull.hpp"

namespace axode {
namespace {

using Row = std::span<const double>;

/// Row k of an array that is stored row by row; `width` is the length of a row.
Row row(const std::vector<double>& rows, std::size_t k, int width) {
  return Row(rows).subspan(k * static_cast<std::size_t>(width), static_cast<std::size_t>(width));
}

/// Appends the forces of one spring between frames to `loads`, as spatial wrenches on these frames (in
/// inertial axes about the inertial origin). If the spring acts along a path of points, appends the tension
/// in each straight segment of the path to `tensions`. C has the poses and V the spatial twists of all
/// frames.
struct AppendSpring {
  const Model& model;
  const ForceLaw& law;
  Row q, v;
  const std::vector<SE3<>>& C;
  const std::vector<Twist<Spatial>>& V;
  std::vector<AppliedWrench<>>& loads;
  std::vector<double>& tensions;

  void operator()(const Spring::Path& path) const {
    const auto place = [&](std::size_t k) { return C[path.points[k].frame] * path.points[k].point; };
    const auto velocity = [&](std::size_t k) {
      const Twist<Spatial>& of_frame = V[path.points[k].frame];
      return of_frame.v + cross(of_frame.w, place(k));
    };
    double length = 0, rate = 0;
    std::vector<Vec3<>> u;
    for (std::size_t k = 1; k < path.points.size(); ++k) {
      const Vec3<> r = place(k) - place(k - 1);
      const double distance = norm(r);
      u.push_back(distance == 0 ? Vec3<>{} : (1 / distance) * r);
      length += distance;
      rate += dot(u.back(), velocity(k) - velocity(k - 1));
    }
    const double F = tension(law, length, rate).f;
    for (std::size_t k = 1; k < path.points.size(); ++k) {
      tensions.push_back(F);
      const Vec3<> pull = F * u[k - 1];  // force on the first end of the segment
      loads.emplace_back(path.points[k - 1].frame, Wrench<Spatial>{cross(place(k - 1), pull), pull});
      loads.emplace_back(path.points[k].frame, Wrench<Spatial>{-cross(place(k), pull), -pull});
    }
  }
  void operator()(const Spring::JointSum&) const {}
  template <class Geometry> void operator()(const Geometry& between) const {
    const RelativePose<double> at(between.ends, model.tree<double>(), q.data(), v.data(),
                                  [](std::size_t, int, int, const auto&) {});
    const Six<double> W = wrench_of(between, law, at, false).W;
    const auto& [first, second] = between.ends;
    const SE3<> on = C[second.frame] * second.pose;
    const Vec3<> f = on.R * Vec3<>{W[3], W[4], W[5]}, m = on.R * Vec3<>{W[0], W[1], W[2]} + cross(on.r, f);
    loads.emplace_back(first.frame, Wrench<Spatial>{-m, -f});
    loads.emplace_back(second.frame, Wrench<Spatial>{m, f});
  }
};

/// Appends the forces of all springs between frames to `loads`, as spatial wrenches on these frames (in
/// inertial axes about the inertial origin). For springs along paths of points, appends the tension in each
/// straight segment of the paths to `tensions`. C has the poses and V the spatial twists of all frames.
void append_springs(const Model& model, Row q, Row v, const std::vector<SE3<>>& C,
                    const std::vector<Twist<Spatial>>& V, std::vector<AppliedWrench<>>& loads,
                    std::vector<double>& tensions) {
  for (const Spring& spring : model.springs().elements)
    std::visit(AppendSpring{model, spring.law, q, v, C, V, loads, tensions}, spring.geometry);
}

/// Computes the constraint forces of the loops, the Lagrange multipliers `lambda`, under the drive forces
/// tau, the forces of springs, loads and the model's prescribed motions at time t. Returns false if the mass
/// matrix is singular or a number is not finite.
bool find_multipliers(const Model& model, double t, Row q, Row v, Row tau,
                      std::span<const AppliedWrench<>> loads, Workspace<>& workspace,
                      LoopWorkspace<>& of_loops, std::vector<double>& lambda) {
  std::vector<double> forces(tau.begin(), tau.end()), a(forces);
  add_spring_forces<double>(model, workspace, q, v, forces);
  if (!model.motions().empty()) {
    DynamicsAtTime found = forward_dynamics_at(model, t, q, v, forces, {.wrenches = loads});
    lambda = std::move(found.lambda);
    return found.solvability.ok();
  }
  return forward_dynamics<double>(model, of_loops, q, v, forces, a, lambda, {.wrenches = loads}).ok();
}

/// Appends the six numbers of each screw (angular, linear) to `out`.
template <class Screws> void append(const Screws& screws, std::vector<double>& out) {
  for (const auto& [angular, linear] : screws)
    out.insert(out.end(), {angular.x, angular.y, angular.z, linear.x, linear.y, linear.z});
}

/// Appends the sum of the loads on each of the frames to `out`, as spatial wrenches; C has the poses of all
/// frames.
void append_loads(std::span<const AppliedWrench<>> loads, const std::vector<int>& frames,
                  const std::vector<SE3<>>& C, std::vector<double>& out) {
  std::vector<Wrench<Spatial>> sums(frames.size());
  for (const AppliedWrench<>& load : loads) {
    const auto on = std::ranges::lower_bound(frames, load.frame) - frames.begin();
    sums[static_cast<std::size_t>(on)] +=
        view::wrench_in<Spatial>(load, C[static_cast<std::size_t>(load.frame)]);
  }
  append(sums, out);
}

/// The bodies of the shapes that a motion with contacts names, or nothing if the model lacks one of them.
std::optional<std::vector<int>> bodies_in_contact(const Model& model, const ShownMotion& motion) {
  std::vector<int> bodies;
  if (motion.contacts.empty()) return bodies;
  std::map<std::string, int> body_of;
  const ContactShapes shapes(model, hull_of_mesh);
  for (int i = 0; i < shapes.size(); ++i) body_of.emplace(shapes[i].name, shapes[i].body);
  for (const std::string& name : motion.contact_shapes) {
    const auto found = body_of.find(name);
    if (found == body_of.end()) return {};
    bodies.push_back(found->second);
  }
  return bodies;
}

/// Appends the forces of contacts to `loads`, as wrenches on the bodies that touch; `bodies` has the body of
/// each shape.
void append_contacts(std::span<const ContactForce> contacts, const std::vector<int>& bodies,
                     std::vector<AppliedWrench<>>& loads) {
  for (const ContactForce& contact : contacts) {
    const Vec3<> m = cross(contact.point, contact.force) + contact.moment;
    loads.emplace_back(bodies[static_cast<std::size_t>(contact.a)], Wrench<Spatial>{-m, -contact.force});
    loads.emplace_back(bodies[static_cast<std::size_t>(contact.b)], Wrench<Spatial>{m, contact.force});
  }
}

/// The normal forces of a motion with contacts, N: a number for each time and each pair of shapes, which is
/// the sum over the points of contact of the pair. Pairs without a force at any time are left out.
view::MotionNumbers::Series contact_series(const ShownMotion& motion) {
  std::map<std::pair<int, int>, std::size_t> columns;
  for (const std::vector<ContactForce>& at_once : motion.contacts)
    for (const ContactForce& contact : at_once)
      if (contact.branch != LawBranch::open) columns.try_emplace({contact.a, contact.b});
  view::MotionNumbers::Series series{"normal forces of contacts", "N", {}, {}};
  for (auto& [pair, column] : columns) {
    column = series.labels.size();
    const auto& [a, b] = pair;
    series.labels.push_back(motion.contact_shapes[static_cast<std::size_t>(a)] + " and " +
                            motion.contact_shapes[static_cast<std::size_t>(b)]);
  }
  for (const std::vector<ContactForce>& at_once : motion.contacts) {
    const std::size_t row = series.values.size();
    series.values.resize(row + columns.size());
    for (const ContactForce& contact : at_once)
      if (contact.branch != LawBranch::open)
        series.values[row + columns.at({contact.a, contact.b})] += contact.normal_force();
  }
  return series;
}

}  // namespace

void check(const Model& model, const ShownMotion& motion) {
  const std::size_t N = motion.t.size();
  const auto sized = [&](const char* name, const std::vector<double>& rows, int width, const char* meaning) {
    check_size(name, rows.size(), N * static_cast<std::size_t>(width), meaning);
    const auto bad = std::ranges::find_if_not(rows, [](double x) { return std::isfinite(x); });
    if (bad != rows.end())
      throw std::invalid_argument(std::string(name) + ": number " + std::to_string(bad - rows.begin()) +
                                  " is " + to_text(*bad) + "; it must be finite");
  };
  sized("motion.t", motion.t, 1, "one for each time");
  sized("motion.q", motion.q, model.nq(), "nq for each time");
  sized("motion.v", motion.v, model.nv(), "nv for each time");
  if (!motion.a.empty()) sized("motion.a", motion.a, model.nv(), "nv for each time");
  if (!motion.tau.empty()) sized("motion.tau", motion.tau, model.nv(), "nv for each time");
  if (!motion.contacts.empty())
    check_size("motion.contacts", motion.contacts.size(), N, "a list for each time");
  const int shapes = static_cast<int>(motion.contact_shapes.size());
  for (const std::vector<ContactForce>& at_once : motion.contacts)
    for (const ContactForce& contact : at_once) {
      if (std::min(contact.a, contact.b) < 0 || std::max(contact.a, contact.b) >= shapes)
        throw std::invalid_argument("motion.contacts: there is no shape " +
                                    std::to_string(std::max(contact.a, contact.b)));
      const Vec3<> sum = contact.point + contact.normal + contact.force + contact.moment;
      if (!std::isfinite(sum.x + sum.y + sum.z + contact.gap + contact.friction))
        throw std::invalid_argument("motion.contacts: a number is not finite");
    }
  if (!motion.loads.empty()) check_size("motion.loads", motion.loads.size(), N, "a list for each time");
  for (const std::vector<AppliedWrench<>>& at_once : motion.loads)
    for (const AppliedWrench<>& load : at_once) {
      if (load.frame < 0 || load.frame >= model.n_frames())
        throw std::invalid_argument("motion.loads: there is no frame " + std::to_string(load.frame));
      if (const Vec3<> sum = load.m + load.f; !std::isfinite(sum.x + sum.y + sum.z))
        throw std::invalid_argument("motion.loads: a number is not finite");
    }
  for (std::size_t k = 0; k < N; ++k) {
    if (k > 0 && !(motion.t[k] > motion.t[k - 1]))
      throw std::invalid_argument("motion.t: time " + std::to_string(k) + " is " + to_text(motion.t[k]) +
                                  " after " + to_text(motion.t[k - 1]) + "; times must increase");
    check_configuration(model, row(motion.q, k, model.nq()), "motion.q");
  }
}

std::vector<int> view::loaded_frames(std::span<const std::vector<AppliedWrench<>>> loads) {
  std::set<int> frames;
  for (const std::vector<AppliedWrench<>>& at_once : loads)
    for (const AppliedWrench<>& load : at_once) frames.insert(load.frame);
  return {frames.begin(), frames.end()};
}

view::MotionNumbers view::numbers_of(const Model& model, const ShownMotion& motion) {
  MotionNumbers out;
  const bool elastic = !model.springs().empty(), loops = !model.loops().empty();
  out.series.push_back({"energy", "J", {"kinetic", "potential", "total"}, {}});
  if (elastic) out.series[0].labels.insert(out.series[0].labels.begin() + 2, "elastic");
  out.series.push_back({"angular momentum", "N m s", {"x", "y", "z"}, {}});
  out.series.push_back({"linear momentum", "N s", {"x", "y", "z"}, {}});
  Workspace<> workspace(model);
  std::optional<LoopWorkspace<>> of_loops;
  if (loops) of_loops.emplace(model);
  out.load_frames = loaded_frames(motion.loads);
  const bool with_places = model.springs().between_frames() || !out.load_frames.empty();
  std::vector<Twist<Spatial>> V(static_cast<std::size_t>(model.n_frames()));
  std::vector<SE3<>> C(V.size());
  std::vector<Wrench<Spatial>> W(static_cast<std::size_t>(model.n_bodies()));
  std::vector<Momentum<Spatial>> Pi(W.size());
  std::vector<double> lambda(static_cast<std::size_t>(model.loops().rows));
  std::vector<Wrench<Spatial>> of_loops_and_couplings(model.loops().all.size());
  const std::optional<std::vector<int>> touching = bodies_in_contact(model, motion);
  bool with_wrenches = touching && !motion.a.empty() && (!loops || !motion.tau.empty());
  for (std::size_t k = 0; k < motion.t.size(); ++k) {
    const Row q = row(motion.q, k, model.nq()), v = row(motion.v, k, model.nv());
    const double T = kinetic_energy<double>(model, workspace, q, v),
                 U = potential_energy<double>(model, workspace, q),
                 E = elastic ? elastic_energy<double>(model, workspace, q) : 0;
    std::vector<double>& energy = out.series[0].values;
    energy.insert(energy.end(), {T, U});
    if (elastic) energy.push_back(E);
    energy.push_back(T + U + E);
    const auto& [angular, linear] = spatial_momentum<double>(model, workspace, q, v);
    out.series[1].values.insert(out.series[1].values.end(), {angular.x, angular.y, angular.z});
    out.series[2].values.insert(out.series[2].values.end(), {linear.x, linear.y, linear.z});
    twists<Spatial, double>(model, workspace, q, v, V);
    append(std::span(V).subspan(1, W.size()), out.twists);
    body_momenta<Spatial, double>(model, workspace, q, v, Pi);
    append(Pi, out.momenta);
    if (with_places) poses<double>(model, workspace, q, C);
    std::vector<AppliedWrench<>> loads;
    if (!motion.loads.empty()) loads = motion.loads[k];
    append_loads(loads, out.load_frames, C, out.loads);
    if (touching && !motion.contacts.empty()) append_contacts(motion.contacts[k], *touching, loads);
    const std::size_t given = loads.size();
    append_springs(model, q, v, C, V, loads, out.tensions);
    if (!with_wrenches) continue;
    const Row a = row(motion.a, k, model.nv());
    if (loops) {
      with_wrenches = find_multipliers(model, motion.t[k], q, v, row(motion.tau, k, model.nv()),
                                       std::span(loads).first(given), workspace, *of_loops, lambda);
      joint_wrenches<Spatial, double>(model, *of_loops, q, v, a, lambda, W, {.wrenches = loads});
      loop_wrenches<Spatial, double>(model, *of_loops, q, lambda, of_loops_and_couplings);
      append(std::span(of_loops_and_couplings).first(model.loops().joints.size()), out.loop_wrenches);
    } else {
      joint_wrenches<Spatial, double>(model, workspace, q, v, a, W, {.wrenches = loads});
    }
    append(W, out.wrenches);
  }
  if (!with_wrenches) {
    out.wrenches.clear();
    out.loop_wrenches.clear();
  }
  if (view::MotionNumbers::Series contacts = contact_series(motion); !contacts.labels.empty())
    out.series.push_back(std::move(contacts));
  return out;
}

}  // namespace axode
