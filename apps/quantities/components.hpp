#pragma once
#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/commands/chart.hpp"
#include "axode/model/model.hpp"

/// Makes panels of charts in which all curves have the same unit.
namespace axode::command {

/// A coordinate or a velocity of a joint that has a curve in a chart.
struct Component {
  enum Kind { angle, length, quaternion };
  std::string name;  ///< name of the joint, and of the direction if it has several numbers
  Kind kind;
  std::string joint, body;  ///< names by which --columns finds the curve
  int index;                ///< index of the body
};

std::vector<Component> coordinate_components(const Model& model);
std::vector<Component> velocity_components(const Model& model);

/// The quantity, the unit and the component of a column of `axode simulate`.
struct ColumnOfMotion {
  std::string symbol;                       ///< t, q, v, a, tau or energy
  std::string unit;                         ///< as "rad/s"
  std::optional<Component> component = {};  ///< of q, v, a and tau
};

/// The columns of `axode simulate` whose units are known, by their names.
std::map<std::string, ColumnOfMotion> columns_of_motion(const Model& model);

/// A curve without numbers that has the names and the body of a component.
Curve curve_of(const Component& component);

/// Appends to a chart a panel for each kind of the components (angles, lengths, quaternions), with a curve
/// for each component. The curve of component k has the abscissas `x` and the ordinates in column k of
/// `columns`. `units` are the units of angles and of lengths.
void add_panels(Chart& chart, const std::string& symbol, const std::vector<Component>& components,
                const std::vector<std::string_view>& units, const std::vector<double>& x,
                const Eigen::MatrixXd& columns);

/// Makes panels with the curves of a quantity, one panel for each unit in the list `units`, such as "N m, N"
/// or "kg m^2, kg m, kg". If the name of a curve ends with a component of a twist, wrench or momentum, the
/// curve has the first unit for an angular component, and the second one for a linear component. If the name
/// begins with names of velocities of which k are translational, the curve has unit k of the list, counted
/// from 0: "slide tau", the force of a prismatic joint, has unit 1.
std::vector<Panel> panels_by_unit(const Model& model, const std::string& quantity, const std::string& units,
                                  const std::vector<Curve>& curves);

}  // namespace axode::command
