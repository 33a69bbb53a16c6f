#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <array>
#include <cstdio>
#include <string>

#include "axode/model/kinds/joint_kinds.hpp"
#include "python/bindings/model/model.hpp"
#include "python/bindings/support/conversions.hpp"

namespace axode::python {
namespace {

/// An array with one number of each degree of freedom of a joint.
template <double Dof::*number> Array of_each_dof(const BoundJoint& joint) {
  NewArray out({static_cast<nb::ssize_t>((*joint).dof.size())});
  double* to = out.data();
  for (const Dof& dof : (*joint).dof) *to++ = dof.*number;
  return out.array();
}

}  // namespace

std::string rounded(double x) {
  std::array<char, 32> text;
  return {text.data(), static_cast<std::size_t>(std::snprintf(text.data(), text.size(), "%.6g", x))};
}

std::string indices(int first, int n) {
  if (n == 0) return "-";
  return n == 1 ? std::to_string(first) : std::to_string(first) + ":" + std::to_string(first + n);
}

/// "revolute, ..., planar or free.", in the order of the table.
std::string kinds_of_single_joints() {
  std::string list;
  for (const JointTraits& t : joint_kinds)
    if (t.dof > 0 && to_string(t.subgroup) == t.name)
      list += (list.empty() ? "" : ", ") + std::string(t.name);
  const std::size_t last = list.rfind(", ");
  return list.replace(last, 2, " or ") + ".";
}

void add_joint_and_body(nb::module_& module) {
  nb::class_<BoundJoint>(module, "Joint", "The joint that moves a body; read only.")
      .def_prop_ro("name", [](const BoundJoint& j) { return (*j).name; })
      .def_prop_ro(
          "kind", [](const BoundJoint& j) { return std::string(to_string((*j).kind)); },
          kinds_of_single_joints().c_str())
      .def_prop_ro(
          "pitch", [](const BoundJoint& j) { return (*j).pitch; }, "Pitch of a helical joint, m/rad.")
      .def_prop_ro(
          "q", [](const BoundJoint& j) { return nb::slice((*j).iq, (*j).iq + (*j).nq, 1); },
          nb::sig("def q(self) -> slice[int, int, int]"),
          "Slice of its coordinates in q: `q[m.joint(name).q]`. Empty for a coupled joint.")
      .def_prop_ro(
          "v", [](const BoundJoint& j) { return nb::slice((*j).iv, (*j).iv + (*j).nv, 1); },
          nb::sig("def v(self) -> slice[int, int, int]"), "Slice of its velocities in v, a and tau.")
      .def_prop_ro("nq", [](const BoundJoint& j) { return (*j).nq; })
      .def_prop_ro("nv", [](const BoundJoint& j) { return (*j).nv; })
      .def_prop_ro(
          "leader",
          [](const BoundJoint& j) -> std::optional<std::tuple<std::string, double, double>> {
            if (!(*j).leader) return std::nullopt;
            return std::tuple((*j.model)->joint((*j).leader->joint).name, (*j).leader->ratio,
                              (*j).leader->offset);
          },
          "(name, ratio, offset) if its coordinate is ratio * the coordinate of joint `name` + offset, else "
          "None.")
      .def_prop_ro("lower", &of_each_dof<&Dof::lower>,
                   "Lower limit of each degree of freedom, rad or m; may be -inf.")
      .def_prop_ro("upper", &of_each_dof<&Dof::upper>,
                   "Upper limit of each degree of freedom, rad or m; may be inf.")
      .def_prop_ro("velocity", &of_each_dof<&Dof::velocity>, "Largest speed, rad/s or m/s; may be inf.")
      .def_prop_ro("effort", &of_each_dof<&Dof::effort>, "Largest drive force, N m or N; may be inf.")
      .def_prop_ro("damping", &of_each_dof<&Dof::damping>,
                   "Viscous damping, N m s/rad or N s/m; counted if `joint_losses` is set.")
      .def_prop_ro("friction", &of_each_dof<&Dof::friction>,
                   "Coulomb friction, N m or N; counted if `joint_losses` is set.")
      .def_prop_ro("armature", &of_each_dof<&Dof::armature>,
                   "Inertia of the drive at the joint, kg m^2 or kg.")
      .def_prop_ro("gear_loss", &of_each_dof<&Dof::gear_loss>,
                   "Part of the force that its gear transmits and loses in addition while the drive drives; "
                   "counted if `joint_losses` is set.")
      .def_prop_ro(
          "gear_loss_back",
          [](const BoundJoint& j) {
            NewArray out({static_cast<nb::ssize_t>((*j).dof.size())});
            double* to = out.data();
            for (const Dof& dof : (*j).dof) *to++ = dof.gear_loss_back.value_or(dof.gear_loss);
            return out.array();
          },
          "Losses of the gears of its degrees of freedom while the joint drives the drive back; from 1 on a "
          "gear locks itself.")
      .def_prop_ro(
          "passive", [](const BoundJoint& j) { return (*j).passive; },
          "Whether it has no drive; this matters in mechanisms with loops.")
      .def("__repr__", [](const BoundJoint& j) {
        return "Joint(\"" + (*j).name + "\": " + std::string(to_string((*j).kind)) + ", q " +
               indices((*j).iq, (*j).nq) + ", v " + indices((*j).iv, (*j).nv) + ")";
      });
  nb::class_<BoundBody>(module, "Body", "A body that moves, in the frame in which it was placed; read only.")
      .def_prop_ro("name", [](const BoundBody& b) { return (*b).name; })
      .def_prop_ro(
          "predecessor", [](const BoundBody& b) { return (*b.model)->body((*b).predecessor).name; },
          "The body that carries it, or \"ground\".")
      .def_prop_ro(
          "A", [](const BoundBody& b) { return to_array((*b).A); },
          "C_i(0), pose at q = 0 in the inertial frame, (4, 4), m.")
      .def_prop_ro(
          "B", [](const BoundBody& b) { return to_array((*b).B); },
          "Pose at q = 0 in the predecessor's frame, (4, 4), m.")
      .def_prop_ro(
          "S_self", [](const BoundBody& b) { return to_array((*b).S_self); },
          "Pose of the joint frame in the body frame, (4, 4), m; its z-axis is the joint axis.")
      .def_prop_ro(
          "X", [](const BoundBody& b) { return columns(std::span<const Screw<>>((*b).X)); },
          "Joint screws in the body frame, (6, d), angular before linear; a column for each velocity.")
      .def_prop_ro(
          "M", [](const BoundBody& b) { return to_array((*b).M); },
          "Inertia matrix [[Theta, h~], [-h~, m I]] in the body frame, (6, 6), with all that is fixed to it "
          "(eq. Mb).")
      .def_prop_ro(
          "mass", [](const BoundBody& b) { return (*b).M.m; }, "kg.")
      .def("__repr__", [](const BoundBody& b) {
        return "Body(\"" + (*b).name + "\" on \"" + (*b.model)->body((*b).predecessor).name + "\", " +
               rounded((*b).M.m) + " kg)";
      });
}

}  // namespace axode::python
