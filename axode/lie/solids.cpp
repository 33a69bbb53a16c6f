#include "axode/lie/solids.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

namespace axode {
namespace {

/// A number in its shortest decimal form that reads back to the same double.
std::string shortest(double x) {
  std::array<char, 32> digits;
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr};
}

void check_positive(const char* what, double x) {
  if (!(x > 0) || !std::isfinite(x))
    throw std::invalid_argument(std::string(what) + " is " + shortest(x) +
                                "; it must be positive and finite");
}

Inertia<> about_center(double mass, double xx, double yy, double zz) {
  return {mass, {}, {xx, yy, zz, 0, 0, 0}};
}

/// Throws std::invalid_argument for vertices that are not finite, invalid faces, and an open mesh.
void check_closed(std::span<const Vec3<>> vertices, std::span<const std::array<int, 3>> faces) {
  for (const Vec3<>& x : vertices)
    if (!std::isfinite(x.x + x.y + x.z))
      throw std::invalid_argument("vertices: number " + std::to_string(&x - vertices.data()) +
                                  " is not finite");
  std::map<std::pair<int, int>, int> directed;  // number of faces that run from one vertex to the other
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = faces[f][k], to = faces[f][(k + 1) % 3];
      if (from < 0 || static_cast<std::size_t>(from) >= vertices.size())
        throw std::invalid_argument("faces: number " + std::to_string(f) + " has vertex " +
                                    std::to_string(from) + " of " + std::to_string(vertices.size()));
      ++directed[{from, to}];
    }
  for (const auto& [edge, times] : directed) {
    const auto back = directed.find({edge.second, edge.first});
    if (times != 1 || back == directed.end() || back->second != 1)
      throw std::invalid_argument("faces: the edge from vertex " + std::to_string(edge.first) + " to " +
                                  std::to_string(edge.second) +
                                  " is not shared by two faces that run through it in opposite directions; "
                                  "a mesh must be closed");
  }
}

/// The volume and the first and second moments of the solid that a closed mesh encloses, about a given point.
/// They are sums over tetrahedra, each of which is made of this point and a face of the mesh.
struct Moments {
  double volume = 0;
  Vec3<> first;
  Sym3<> second;  ///< the integral of x xᵀ
};
Moments moments(std::span<const Vec3<>> vertices, std::span<const std::array<int, 3>> faces,
                const Vec3<>& about) {
  const auto dyad = [](const Vec3<>& a) {
    return Sym3<>{a.x * a.x, a.y * a.y, a.z * a.z, a.x * a.y, a.x * a.z, a.y * a.z};
  };
  Moments sum;
  for (const std::array<int, 3>& face : faces) {
    const auto vertex = [&](std::size_t k) { return vertices[static_cast<std::size_t>(face[k])] - about; };
    const Vec3<> a = vertex(0), b = vertex(1), c = vertex(2), s = a + b + c;
    const double volume = dot(a, cross(b, c)) / 6;
    sum.volume += volume;
    sum.first = sum.first + (volume / 4) * s;
    sum.second = sum.second + (volume / 20) * (dyad(a) + dyad(b) + dyad(c) + dyad(s));
  }
  return sum;
}

/// The volume of a mesh and its first and second moments about its first vertex. Throws std::invalid_argument
/// unless the mesh is closed, valid and of positive volume.
Moments checked_moments(std::span<const Vec3<>> vertices, std::span<const std::array<int, 3>> faces) {
  check_closed(vertices, faces);
  const Moments sum = moments(vertices, faces, vertices.empty() ? Vec3<>{} : vertices[0]);
  if (!(sum.volume > 0))
    throw std::invalid_argument("faces: the mesh encloses " + shortest(sum.volume) +
                                " m³; its faces must run counterclockwise as seen from outside");
  return sum;
}

}  // namespace

Inertia<> box_inertia(double mass, const Vec3<>& size) {
  check_positive("mass", mass);
  for (const double edge : {size.x, size.y, size.z}) check_positive("size", edge);
  const Vec3<> s{size.x * size.x, size.y * size.y, size.z * size.z};
  return about_center(mass, mass / 12 * (s.y + s.z), mass / 12 * (s.x + s.z), mass / 12 * (s.x + s.y));
}

Inertia<> sphere_inertia(double mass, double radius) {
  check_positive("mass", mass);
  check_positive("radius", radius);
  const double Theta = 0.4 * mass * radius * radius;
  return about_center(mass, Theta, Theta, Theta);
}

Inertia<> cylinder_inertia(double mass, double radius, double length) {
  check_positive("mass", mass);
  check_positive("radius", radius);
  check_positive("length", length);
  const double across = mass * (radius * radius / 4 + length * length / 12);
  return about_center(mass, across, across, mass * radius * radius / 2);
}

Inertia<> capsule_inertia(double mass, double radius, double length) {
  check_positive("mass", mass);
  check_positive("radius", radius);
  check_positive("length", length);
  const double ball = 4 * radius / (3 * length + 4 * radius);  // share of the mass in the two half balls
  const double m = (1 - ball) * mass, m_ball = ball * mass, r2 = radius * radius;
  // A half ball has the moment 83/320 m r² about a transverse axis through its centre of mass, which is 3/8 r
  // from the flat side.
  const double d = length / 2 + 0.375 * radius;
  const double across = m * (r2 / 4 + length * length / 12) + m_ball * (83.0 / 320 * r2 + d * d);
  return about_center(mass, across, across, m * r2 / 2 + 0.4 * m_ball * r2);
}

double mesh_volume(std::span<const Vec3<>> vertices, std::span<const std::array<int, 3>> faces) {
  return checked_moments(vertices, faces).volume;
}

Inertia<> mesh_inertia(double mass, std::span<const Vec3<>> vertices,
                       std::span<const std::array<int, 3>> faces) {
  check_positive("mass", mass);
  const Moments about_vertex = checked_moments(vertices, faces);
  const Vec3<> center = vertices[0] + (1 / about_vertex.volume) * about_vertex.first;
  const Moments at_center = moments(vertices, faces, center);
  return inertia_from_com(mass, center, rotational_inertia((mass / at_center.volume) * at_center.second));
}

}  // namespace axode
