#pragma once
#include <nanobind/nanobind.h>

#include "axode/io.hpp"

/// Descriptions of mechanisms as Python objects.
namespace axode::python {

namespace nb = nanobind;

/// Every field of a description as nested tuples, for pickle. unpacked() is the inverse.
nb::tuple packed(const Description& description);
Description unpacked(nb::handle tuple);

/// The strictness for the argument `strict` of Python.
inline Strictness strictness(bool strict) { return strict ? Strictness::strict : Strictness::lenient; }

/// Builds a mechanism from a dict with the keys of the drawing format (docs/drawing-format.md). Throws
/// ModelError with every fault, and nb::type_error for objects that a drawing cannot contain. The dict may
/// come from a file of another format, with warnings of its reader.
Model from_dict(const nb::dict& drawing, Base base, Strictness strictness, const std::string& file = "",
                const std::vector<Fault>& warnings = {});
nb::dict to_dict(const Model& model);
/// A joint from a dict with the keys of a drawing, with axis and point in the frame to which it is attached;
/// a fixed joint if `joint` is None.
JointDescription joint_of(nb::handle joint);

}  // namespace axode::python
