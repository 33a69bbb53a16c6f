#pragma once
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "axode/contact/law/velocity_problem.hpp"
#include "axode/lie/so3.hpp"

/// Velocity problems of free bodies, from easy ones to those at which solvers fail.
namespace axode::test {

/// A free body: mass, principal inertia, centre of mass, rotation and body-fixed twist.
struct RigidBody {
  double mass = 1;
  Vec3<> inertia{1, 1, 1};
  Vec3<> p;
  SO3<> R;
  Vec3<> w, v;  ///< in body axes
};
inline RigidBody brick(double mass, const Vec3<>& half, const Vec3<>& p) {
  const Vec3<> s{half.x * half.x, half.y * half.y, half.z * half.z};
  return {.mass = mass, .inertia = mass / 3 * Vec3<>{s.y + s.z, s.x + s.z, s.x + s.y}, .p = p};
}

/// Bodies i and j, -1 for the ground, touch at a point with a normal from i to j.
struct RigidContact {
  int i = -1, j = 0;
  Vec3<> point, normal{0, 0, 1};
  double mu = 0.5;
};

struct RigidProblem {
  std::string name;
  std::vector<RigidBody> bodies;
  std::vector<RigidContact> contacts;
  double h = 1e-3;
  std::vector<std::pair<int, Vec3<>>> pushes = {};  ///< forces on bodies in body axes

  VelocityProblem build() const {
    VelocityProblem problem(6 * static_cast<int>(bodies.size()));
    for (const RigidContact& c : contacts) {
      std::vector<int> support;
      for (const int b : {std::min(c.i, c.j), std::max(c.i, c.j)})
        for (int k = 0; b >= 0 && k < 6; ++k) support.push_back(6 * b + k);
      double* Y = problem.add(ContactLaw::contact, 3, support);
      const std::size_t row = problem.r.size() - 3;
      problem.c[row + 1] = problem.c[row + 2] = c.mu;
      const Vec3<> a = std::abs(c.normal.x) > 0.7 ? Vec3<>{0, 1, 0} : Vec3<>{1, 0, 0};
      const Vec3<> t = cross(c.normal, a), t1 = (1 / norm(t)) * t;
      for (const Vec3<>& e : {c.normal, t1, cross(c.normal, t1)})
        for (const int b : {std::min(c.i, c.j), std::max(c.i, c.j)}) {
          if (b < 0) continue;
          const RigidBody& B = bodies[static_cast<std::size_t>(b)];
          const double side = b == c.j ? 1 : -1, mass = side / std::sqrt(B.mass);
          const Vec3<> m = transpose(B.R) * cross(c.point - B.p, e), f = transpose(B.R) * e;
          for (const double x : {side * m.x / std::sqrt(B.inertia.x), side * m.y / std::sqrt(B.inertia.y),
                                 side * m.z / std::sqrt(B.inertia.z), mass * f.x, mass * f.y, mass * f.z})
            *Y++ = x;
        }
    }
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const RigidBody& B = bodies[b];
      const Vec3<> L{B.inertia.x * B.w.x, B.inertia.y * B.w.y, B.inertia.z * B.w.z};
      Vec3<> f = transpose(B.R) * Vec3<>{0, 0, -9.81 * B.mass} - B.mass * cross(B.w, B.v);
      for (const auto& [on, push] : pushes)
        if (on == static_cast<int>(b)) f += push;
      const Vec3<> m = -cross(B.w, L), p = B.mass * B.v;
      const double mass = std::sqrt(B.mass);
      problem.w.segment<6>(6 * static_cast<Eigen::Index>(b)) << (L.x + h * m.x) / std::sqrt(B.inertia.x),
          (L.y + h * m.y) / std::sqrt(B.inertia.y), (L.z + h * m.z) / std::sqrt(B.inertia.z),
          (p.x + h * f.x) / mass, (p.y + h * f.y) / mass, (p.z + h * f.z) / mass;
    }
    problem.finish();
    return problem;
  }
};

/// A box on n × n points of its lower face.
inline RigidProblem box_on_plane(int n, const Vec3<>& w, const Vec3<>& v) {
  const Vec3<> half{0.5, 0.4, 0.3};
  RigidProblem problem{"box on " + std::to_string(n * n) + " points", {brick(1, half, {0, 0, half.z})}, {}};
  problem.bodies[0].w = w;
  problem.bodies[0].v = v;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      problem.contacts.push_back(
          {.point = {half.x * (2.0 * i / (n - 1) - 1), half.y * (2.0 * j / (n - 1) - 1), 0}});
  return problem;
}

/// Cubes on each other; the top one is pushed.
inline RigidProblem stack(const std::vector<double>& masses, double push = 0) {
  RigidProblem problem{"stack of " + std::to_string(masses.size()), {}, {}};
  for (std::size_t k = 0; k < masses.size(); ++k) {
    const double height = static_cast<double>(k);
    problem.bodies.push_back(brick(masses[k], {0.5, 0.5, 0.5}, {0, 0, 0.5 + height}));
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.5, 0.5})
        problem.contacts.push_back({static_cast<int>(k) - 1, static_cast<int>(k), {x, y, height}});
  }
  problem.pushes.push_back({static_cast<int>(masses.size()) - 1, {push, 0, 0}});
  return problem;
}

/// Bricks in running bond; the middle one of the top is pushed along the wall.
inline RigidProblem wall(int rows, int columns, double push) {
  const double a = 0.5, b = 0.25, c = 0.25, mu = 0.6;
  RigidProblem problem{"wall " + std::to_string(rows) + " x " + std::to_string(columns), {}, {}};
  const auto place = [&](int r, int k) { return 2 * a * k + (r % 2 != 0 ? a : 0); };
  for (int r = 0; r < rows; ++r)
    for (int k = 0; k < columns; ++k) {
      const double x = place(r, k), z = 2 * c * r;
      const int j = r * columns + k;
      problem.bodies.push_back(brick(2, {a, b, c}, {x, 0, c + z}));
      const auto touch = [&](int i, double low, double high) {
        for (const double e : {low, high})
          for (const double y : {-b, b}) problem.contacts.push_back({i, j, {e, y, z}, {0, 0, 1}, mu});
      };
      if (r == 0) touch(-1, x - a, x + a);
      for (int l = 0; r > 0 && l < columns; ++l) {
        const double low = std::max(x, place(r - 1, l)) - a, high = std::min(x, place(r - 1, l)) + a;
        if (high - low > 1e-9) touch((r - 1) * columns + l, low, high);
      }
    }
  problem.pushes.push_back({(rows - 1) * columns + columns / 2, {push, 0, 0}});
  return problem;
}

/// A wedge pushed down between two walls that lean by 0.3 rad.
inline RigidProblem wedge(double mu) {
  const double c = std::cos(0.3), s = std::sin(0.3);
  RigidProblem problem{"wedge", {brick(1, {0.2, 0.2, 0.2}, {})}, {}};
  for (const double side : {-1.0, 1.0})
    for (const double y : {-0.2, 0.2})
      for (const double z : {-0.1, 0.1})
        problem.contacts.push_back({-1, 0, {side * (0.2 + z * std::tan(0.3)), y, z}, {-side * c, 0, s}, mu});
  problem.pushes.push_back({0, {0, 0, -50}});
  return problem;
}

/// The voussoirs of a half circle of radius 1, with four points in each joint.
inline RigidProblem arch(int n, double thickness, double mu) {
  const double inner = 1 - thickness / 2, outer = 1 + thickness / 2, depth = 0.3, pi = std::acos(-1.0);
  const double angle = pi / n, area = (outer * outer - inner * inner) / 2 * angle;
  const double place = 2.0 / 3 * (std::pow(outer, 3) - std::pow(inner, 3)) / (outer * outer - inner * inner) *
                       std::sin(angle / 2) / (angle / 2);
  const auto radial = [](double a) { return Vec3<>{std::cos(a), 0, std::sin(a)}; };
  const auto along = [](double a) { return Vec3<>{-std::sin(a), 0, std::cos(a)}; };
  RigidProblem problem{"arch " + std::to_string(thickness), {}, {}};
  for (int k = 0; k < n; ++k) {
    const Vec3<> u = radial((k + 0.5) * angle), t = along((k + 0.5) * angle), I{0.1, 0.1, 0.1};
    problem.bodies.push_back({.mass = area, .inertia = area * I, .p = place * u, .R = {u, cross(t, u), t}});
  }
  for (int k = 0; k <= n; ++k) {
    const Vec3<> u = radial(k * angle), t = along(k * angle);
    for (const double r : {inner, outer})
      for (const double y : {-depth / 2, depth / 2}) {
        const Vec3<> point = r * u + Vec3<>{0, y, 0};
        problem.contacts.push_back(k < n ? RigidContact{k - 1, k, point, t, mu}
                                         : RigidContact{-1, n - 1, point, -t, mu});
      }
  }
  return problem;
}

/// A slender rod of length 2 that leans on its lower end and slides.
inline RigidProblem painleve(double mu) {
  const double c = std::cos(1.2), s = std::sin(1.2);
  const SO3<> R{{c, 0, s}, {0, 1, 0}, {-s, 0, c}};
  RigidBody rod{.mass = 1, .inertia = {1e-3, 1.0 / 3, 1.0 / 3}, .p = {c, 0, s}, .R = R};
  rod.v = transpose(R) * Vec3<>{-1, 0, 0};
  return {"Painleve", {rod}, {{.mu = mu}}, 1e-4};
}

/// Bodies and contacts at random: nothing keeps these contacts from fighting each other.
inline RigidProblem pile(int bodies, int contacts, unsigned seed, double least_mu, double most_mu) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto uniform = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  const auto vector = [&] {
    const double x = normal(random), y = normal(random), z = normal(random);
    return Vec3<>{x, y, z};
  };
  const auto unit = [&] {
    const Vec3<> x = vector();
    return (1 / norm(x)) * x;
  };
  const auto inertia = [&] { return std::pow(10, uniform(-2, 0)) + 0.02; };
  RigidProblem problem{"pile " + std::to_string(contacts) + " seed " + std::to_string(seed), {}, {}, 1e-2};
  for (int k = 0; k < bodies; ++k) {
    RigidBody body{.mass = std::pow(10, uniform(-1, 1))};
    body.inertia.x = inertia();
    body.inertia.y = inertia();
    body.inertia.z = inertia();
    const Vec3<> z = unit(), x = cross(z, unit()), e = (1 / norm(x)) * x;
    body.R = {e, cross(z, e), z};
    body.p = vector();
    body.w = vector();
    body.v = vector();
    problem.bodies.push_back(body);
  }
  for (int k = 0; k < contacts; ++k) {
    const int j = std::uniform_int_distribution<>(0, bodies - 1)(random);
    int i = j;
    while (i == j) i = std::uniform_int_distribution<>(-1, bodies - 1)(random);
    const Vec3<> point = problem.bodies[static_cast<std::size_t>(j)].p + 0.5 * vector();
    problem.contacts.push_back({i, j, point, unit(), uniform(least_mu, most_mu)});
  }
  return problem;
}

}  // namespace axode::test
