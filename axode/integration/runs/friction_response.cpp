#include "axode/integration/runs/friction_response.hpp"

#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "axode/eigen.hpp"

namespace axode {

Solvability FrictionResponse::apply(const Model& model, Workspace<>& workspace, ClosedMotion* loops,
                                    DryFriction& friction, const EnergyNorm& norm, Span q, Span v,
                                    Span through_gears, std::span<double> a) {
  const std::vector<int>& resisting = friction.resisting();
  columns_.resize(model.nv(), static_cast<Eigen::Index>(resisting.size()));
  own_.resize(resisting.size());
  if (loops) {
    loops->factorize(q);
  } else {
    all_.resize(model.nv(), model.nv());
    static_cast<void>(inverse_mass_matrix(model, workspace, q, as_span(all_)));
  }
  Eigen::VectorXd column(model.nv());
  for (std::size_t k = 0; k < resisting.size(); ++k) {
    const int c = resisting[k];
    own_[k] = loops ? loops->unit_force_response(c, as_span(column)) : all_(c, c);
    if (!loops) column = all_.col(c);
    columns_.col(static_cast<Eigen::Index>(k)) = column;
  }
  const int locked = friction.apply_friction(columns_, own_, norm, v, through_gears, a);
  if (locked < 0) return {};
  return {.locked_body = body_of_velocity(model.topology(), locked)};
}

}  // namespace axode
