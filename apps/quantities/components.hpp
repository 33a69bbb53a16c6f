#pragma once
#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "apps/commands/chart.hpp"
#include "axode/model/model.hpp"

/// Panels of charts in which all curves have one unit.
namespace axode::command {

/// A number of q or v in a chart.
struct Component {
  enum Kind { angle, length, quaternion };
  std::string name;  ///< that of the joint, with its direction if the joint has several numbers
  Kind kind;
  std::string joint, body;  ///< names by which --columns finds it
};

std::vector<Component> coordinate_components(const Model& model);
std::vector<Component> velocity_components(const Model& model);

/// Appends a panel for each kind of the components, with a column of numbers for each component. `units` are
/// those of angles and of lengths.
void add_panels(Chart& chart, const std::string& symbol, const std::vector<Component>& components,
                const std::vector<std::string_view>& units, const std::vector<double>& x,
                const Eigen::MatrixXd& columns);

/// Panels of the curves of a quantity, one for each unit. The names of curves are those of `axode eval`:
/// names of velocities in front, or the part of a twist, wrench or pose at the end. `units` is a list as
/// "N m, N", the angular unit first.
std::vector<Panel> panels_by_unit(const Model& model, const std::string& quantity, const std::string& units,
                                  const std::vector<Curve>& curves);

}  // namespace axode::command
