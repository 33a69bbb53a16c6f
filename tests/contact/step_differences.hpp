#pragma once
#include <gtest/gtest.h>

#include <cmath>

#include "axode/integration/contact_sensitivities.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/model/building/edited.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/inertial_parameters.hpp"
#include "tests/contact/reference_contacts.hpp"
#include "tests/support/random_tree.hpp"

/// Derivatives of steps with contact against differences of fourth order, along states, forces and
/// parameters.
namespace axode::test {

using Matrix = Eigen::MatrixXd;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;

/// A state and a step of it.
struct Start {
  std::vector<double> q, v, tau;
  double step = 5e-3;
};
/// The end of a step and its derivatives by displacements, velocities and forces.
struct Step {
  std::vector<double> q, v;
  Rows A, B;
  ContactSensitivity result;
};
inline Step step_of(const Model& model, const ContactShapes& shapes, const Start& start) {
  const std::size_t nq = start.q.size(), nv = start.v.size();
  Step out{
      std::vector<double>(2 * nq), std::vector<double>(2 * nv), Rows(2 * nv, 2 * nv), Rows(2 * nv, nv), {}};
  out.result = contact_rollout_derivatives(model, shapes, start.q, start.v, start.tau, start.step,
                                           {out.q, out.v, as_span(out.A), as_span(out.B)});
  out.q.erase(out.q.begin(), out.q.begin() + static_cast<std::ptrdiff_t>(nq));
  out.v.erase(out.v.begin(), out.v.begin() + static_cast<std::ptrdiff_t>(nv));
  return out;
}

/// The end of a step as displacements from `from`, and velocities.
inline Vector end_of(const Model& model, const Start& start, const std::vector<double>& from) {
  SimulationOptions options;
  options.joint_losses = true;
  options.drive = [&](double, std::span<const double>, std::span<const double>, std::span<double> tau) {
    std::ranges::copy(start.tau, tau.begin());
  };
  const Trajectory motion = simulate_contact(model, start.q, start.v, start.step, start.step, options);
  EXPECT_TRUE(motion.complete) << motion.stop_reason;
  const Eigen::Index nv = model.nv();
  Vector out(2 * nv);
  const std::size_t last = motion.size() - 1;
  const std::vector<double> by = difference(model, from, motion.q(last));
  out.head(nv) = as_eigen(std::span<const double>(by));
  out.tail(nv) = as_eigen(motion.v(last));
  return out;
}

/// Differences of fourth order along the directions of the state and the forces; `along` (3nv × directions).
inline Matrix differences(const Model& model, const Start& start, const Step& step, const Matrix& along,
                          double size) {
  const Eigen::Index nv = model.nv();
  Matrix out(2 * nv, along.cols());
  for (Eigen::Index k = 0; k < along.cols(); ++k) {
    const auto at = [&](double by) {
      Start moved = start;
      const Vector x = by * along.col(k);
      moved.q = integrate(model, start.q, std::span(x.data(), static_cast<std::size_t>(nv)));
      for (Eigen::Index c = 0; c < nv; ++c) {
        moved.v[static_cast<std::size_t>(c)] += x[nv + c];
        moved.tau[static_cast<std::size_t>(c)] += x[2 * nv + c];
      }
      return end_of(model, moved, step.q);
    };
    out.col(k) = (8 * (at(size) - at(-size)) - (at(2 * size) - at(-2 * size))) / (12 * size);
  }
  return out;
}

/// Changes of all parameters of a mechanism.
struct Parameters {
  std::vector<double> surfaces, placement, inertia, geometry;
  ContactParameters<const double> spans() const { return {surfaces, placement, inertia, geometry}; }
};
inline bool has_thickness(ShapeKind kind) {
  return kind == ShapeKind::sphere || kind == ShapeKind::capsule || kind == ShapeKind::plane;
}
/// A random direction in which only one of the four kinds of parameters changes. Restitutions change alike,
/// because that of a pair is the largest one.
inline Parameters one_kind(const Model& model, const ContactShapes& shapes, int kind) {
  Random<double> random(7);
  const int n = shapes.size(), b = model.n_bodies();
  Parameters x{std::vector<double>(3 * static_cast<std::size_t>(n)), {}, {}, {}};
  if (kind == 0)
    for (int i = 0; i < n; ++i) {
      const std::size_t k = static_cast<std::size_t>(i), size = static_cast<std::size_t>(n);
      x.surfaces[k] = shapes[i].surface.friction.value_or(0) * random.number(-1, 1);
      x.surfaces[size + k] = shapes[i].surface.restitution > 0 ? 0.5 : 0;
      x.surfaces[2 * size + k] = has_thickness(shapes[i].kind) ? random.number(-1, 1) : 0;
    }
  x.placement = random_numbers(random, 6 * n, kind == 1 ? 1 : 0);
  x.inertia = random_numbers(random, 10 * b, kind == 2 ? 0.01 : 0);
  if (model.loops().empty() && model.motions().empty())
    x.geometry = random_numbers(random, 6 * b, kind == 3 ? 1 : 0);
  return x;
}
/// The model with other parameters.
inline Model changed(const Model& model, const Parameters& x, double by) {
  Description description = model.description();
  std::size_t k = 0;
  const std::size_t n = x.surfaces.size() / 3;
  const auto displacement = [by](const double* six) {
    return exp(Screw<>{by * Vec3<>{six[0], six[1], six[2]}, by * Vec3<>{six[3], six[4], six[5]}});
  };
  const auto change = [&](ShapeDescription& shape) {
    if (shape.contact.friction) *shape.contact.friction += by * x.surfaces[k];
    shape.contact.restitution += by * x.surfaces[n + k];
    const double thickness = by * x.surfaces[2 * n + k];
    shape.radius += thickness;
    shape.pose = shape.pose * displacement(&x.placement[6 * k++]);
    if (shape.kind == ShapeKind::plane) shape.pose.r += thickness * shape.pose.R.z;
  };
  for (ShapeDescription& shape : description.shapes) change(shape);
  std::size_t i = 0;
  for (BodyDescription& body : description.bodies) {
    for (ShapeDescription& shape : body.shapes) change(shape);
    if (x.geometry.empty()) continue;
    InBodyFrame& at = std::get<InBodyFrame>(body.geometry);
    at.B = at.B * displacement(&x.geometry[6 * i++]);
  }
  const Model moved = ModelBuilder(description).build();
  std::vector<double> pi = inertial_parameters(moved);
  for (std::size_t c = 0; c < pi.size(); ++c) pi[c] += by * x.inertia[c];
  return with_parameters(moved, pi);
}
/// Checks the derivatives of a step along changes of each kind of parameters.
inline void expect_parameter_derivatives(const Model& model, const Start& start, const Step& step,
                                         double tolerance, double size) {
  const ContactShapes shapes(model);
  const std::size_t nq = start.q.size(), nv = start.v.size(), n = 3 * static_cast<std::size_t>(shapes.size()),
                    b = 2 * static_cast<std::size_t>(model.n_bodies());
  std::vector<double> q(2 * nq), v(2 * nv), none(nv), dq(2 * nv), dv(2 * nv);
  const auto rows = [nv](std::size_t columns) { return Rows(2 * nv, columns); };
  Rows A = rows(2 * nv), B = rows(nv), C = rows(n), by_placement = rows(2 * n), by_inertia = rows(5 * b),
       by_geometry = rows(3 * b);
  const bool tree = model.loops().empty() && model.motions().empty();
  if (!tree) by_geometry = rows(0);
  const ContactSensitivity all =
      contact_rollout_derivatives(model, shapes, start.q, start.v, start.tau, start.step,
                                  {q,
                                   v,
                                   as_span(A),
                                   as_span(B),
                                   as_span(C),
                                   {{}, as_span(by_placement), as_span(by_inertia), as_span(by_geometry)}});
  ASSERT_TRUE(all.ok()) << all.failure.why;
  EXPECT_EQ(A, step.A);
  for (int kind = 0; kind < (tree ? 4 : 3); ++kind) {
    const Parameters x = one_kind(model, shapes, kind);
    const ContactSensitivity found = contact_rollout_jvp(model, shapes, start.q, start.v, start.tau,
                                                         start.step, none, none, none, dq, dv, {}, x.spans());
    ASSERT_TRUE(found.ok()) << found.failure.why;
    Vector exact(2 * nv);
    exact << as_eigen(std::span<const double>(dq).last(nv)), as_eigen(std::span<const double>(dv).last(nv));
    const auto vector = [](const std::vector<double>& y) { return as_eigen(std::span<const double>(y)); };
    Vector product =
        C * vector(x.surfaces) + by_placement * vector(x.placement) + by_inertia * vector(x.inertia);
    if (tree) product += by_geometry * vector(x.geometry);
    EXPECT_LE((product - exact).norm(), 1e-9 * (1 + exact.norm())) << "kind " << kind;
    const auto at = [&](double by) { return end_of(changed(model, x, by), start, step.q); };
    const Vector expected = (8 * (at(size) - at(-size)) - (at(2 * size) - at(-2 * size))) / (12 * size);
    EXPECT_LE((exact - expected).lpNorm<Eigen::Infinity>(),
              tolerance * (1 + expected.lpNorm<Eigen::Infinity>()))
        << "kind " << kind << "\nexact\n"
        << exact.transpose() << "\ndifferences\n"
        << expected.transpose();
  }
}

/// Checks the derivatives of a step in all directions and by all parameters, or along some directions.
inline void expect_derivatives(const Model& model, const Start& start, double tolerance = 1e-7,
                               double size = 3e-5, Matrix along = {}) {
  const ContactShapes shapes(model);
  const Step step = step_of(model, shapes, start);
  ASSERT_TRUE(step.result.ok()) << step.result.failure.why;
  EXPECT_TRUE(step.result.unique);
  EXPECT_LE(step.result.certificate, 1e-9);
  const Eigen::Index nv = model.nv();
  const Vector end = end_of(model, start, step.q);
  EXPECT_LE(end.head(nv).norm(), 1e-13);
  for (Eigen::Index c = 0; c < nv; ++c) EXPECT_EQ(end[nv + c], step.v[static_cast<std::size_t>(c)]);
  if (along.size() == 0) {
    along = Matrix::Identity(3 * nv, 3 * nv);
    // Second derivatives jump at a kink, so that differences must be small there.
    expect_parameter_derivatives(model, start, step, tolerance, step.result.at_kink ? size / 10 : size / 3);
  }
  Matrix by(2 * nv, 3 * nv);
  by << step.A, step.B;
  const Matrix exact = by * along, expected = differences(model, start, step, along, size);
  EXPECT_LE((exact - expected).lpNorm<Eigen::Infinity>(),
            tolerance * (1 + expected.lpNorm<Eigen::Infinity>()))
      << "exact\n"
      << exact << "\ndifferences\n"
      << expected;
}

inline ShapeDescription shape_of(ShapeKind kind, const Vec3<>& size, double friction,
                                 double restitution = 0) {
  ShapeDescription shape{.role = ShapeDescription::Role::collision, .kind = kind, .size = size};
  shape.radius = size.x;
  shape.length = size.y;
  shape.contact = {.friction = friction, .restitution = restitution};
  return shape;
}

/// A leaning floor, and free bodies with one shape each.
struct Bodies {
  Description description;

  explicit Bodies(double friction) {
    ShapeDescription plane = shape_of(ShapeKind::plane, {}, friction);
    plane.name = "floor";
    const double c = std::cos(0.2), s = std::sin(0.2);
    plane.pose.R = {{c, 0, -s}, {0, 1, 0}, {s, 0, c}};
    description.shapes.push_back(plane);
    description.contact = ContactDescription{.threshold = 0.01};
  }
  Bodies& add(const ShapeDescription& shape) {
    BodyDescription body{.name = "body " + std::to_string(description.bodies.size())};
    body.joint = {.kind = JointKind::free};
    body.geometry = InBodyFrame{};
    body.inertia = MassProperties{
        .mass = 1.3, .com = {0.01, -0.02, 0.015}, .Theta = {0.02, 0.025, 0.03, 0.001, -0.002, 0.003}};
    body.shapes.push_back(shape);
    description.bodies.push_back(body);
    return *this;
  }
  Model build() const { return ModelBuilder(description).build(); }
};
inline Vec3<> up() { return {std::sin(0.2), 0, std::cos(0.2)}; }

/// A pose of a free joint with a rotation about an axis and then a height of its lowest point over the floor.
inline std::vector<double> posed(const Vec3<>& turn, const Vec3<>& r) {
  const double angle = norm(turn), s = angle > 0 ? std::sin(angle / 2) / angle : 0;
  return {s * turn.x, s * turn.y, s * turn.z, std::cos(angle / 2), r.x, r.y, r.z};
}
/// Moves a single free body along the normal of the floor until its least gap is `gap`.
inline std::vector<double> lowered(const Model& model, std::vector<double> q, double gap) {
  Distances distances(model);
  const double d = distances.evaluate(q)[0].distance;
  const Vec3<> n = up();
  q[4] += (gap - d) * n.x;
  q[5] += (gap - d) * n.y;
  q[6] += (gap - d) * n.z;
  return q;
}
/// The velocity of a free body that moves with a velocity in space and turns with one in its own axes.
inline std::vector<double> moving(const std::vector<double>& q, const Vec3<>& w, const Vec3<>& velocity) {
  const SO3<> R = rotation(Quaternion<>{q[0], q[1], q[2], q[3]});
  const Vec3<> v = transpose(R) * velocity;
  return {w.x, w.y, w.z, v.x, v.y, v.z};
}

inline const std::vector<double> push{0.02, -0.01, 0.03, 0.2, -0.1, 0.3};

}  // namespace axode::test
