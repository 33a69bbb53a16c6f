#include "apps/quantities/quantities.hpp"
#include "axode/contact.hpp"
#include "axode/view/mesh_hull.hpp"

/// The quantities of `axode eval` about collision shapes.
namespace axode::command {
namespace {

Answer distances_answer(const Question& ask) {
  Distances distances(ask.model, ContactShapes(ask.model, hull_of_mesh));
  const std::span<const ShapeDistance> found = distances.evaluate(ask.state.q);
  const std::size_t nv = static_cast<std::size_t>(ask.model.nv());
  std::vector<double> J(found.size() * nv);
  distances.jacobian(J);
  Answer answer{Json::array(), Table({"a", "b", "distance", "n x", "n y", "n z", "error at most"}), "m"};
  for (std::size_t k = 0; k < found.size(); ++k) {
    const ShapeDistance& d = found[k];
    const std::string &a = distances.shapes()[d.a].name, &b = distances.shapes()[d.b].name;
    answer.value.push_back({{"a", a},
                            {"b", b},
                            {"distance", d.distance},
                            {"normal", to_json(d.normal)},
                            {"point_a", to_json(d.point_a)},
                            {"point_b", to_json(d.point_b)},
                            {"residual", d.residual},
                            {"proved", d.proved},
                            {"jacobian", std::vector<double>(J.begin() + k * nv, J.begin() + (k + 1) * nv)}});
    answer.table.row({a, b, d.distance, d.normal.x, d.normal.y, d.normal.z, d.residual});
  }
  return answer;
}

}  // namespace

std::vector<Quantity> contact_quantities() {
  return {{"distances",
           "The signed distances are those of collision shapes that may touch, with normals n from a to b; "
           "JSON has nearest points and Jacobians, too.",
           distances_answer}};
}

}  // namespace axode::command
